// Two hundred logs as people have them, drawn at random: units, clocks, delimiters, decimal marks, encodings, orders of columns, headers, one file or
// two. Each is understood, or asked about; never understood wrongly.
// ctest: once
#include "imulab/formats/recording/signals.hpp"
#include "imulab/inspection/inspection.hpp"
#include "imulab/inspection/join.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/simulated_session.hpp"
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace imulab {
namespace {

struct LogUnit {
  const char* unit;
  Output output;
  double per_si;     // what one SI unit reads, of an increment a second of it
  int integer_bits;  // 0: decimals
};

const std::array<LogUnit, 8> accel_log_units{{{"m/s^2", Output::rate, 1, 0},
                                              {"g", Output::rate, 1 / unit::g, 0},
                                              {"mg", Output::rate, 1e3 / unit::g, 0},
                                              {"ug", Output::rate, 1e6 / unit::g, 0},
                                              {"m/s", Output::increment, 1, 0},
                                              {"g*s", Output::increment, 1 / unit::g, 0},
                                              {"count", Output::rate, 4096 / unit::g, 16},
                                              {"count", Output::rate, 300000 / unit::g, 24}}};
const std::array<LogUnit, 8> gyro_log_units{{{"rad/s", Output::rate, 1, 0},
                                             {"deg/s", Output::rate, 1 / unit::deg, 0},
                                             {"mdeg/s", Output::rate, 1e3 / unit::deg, 0},
                                             {"deg/h", Output::rate, 3600 / unit::deg, 0},
                                             {"rad", Output::increment, 1, 0},
                                             {"deg", Output::increment, 1 / unit::deg, 0},
                                             {"count", Output::rate, 65.5 / unit::deg, 16},
                                             {"count", Output::rate, 4000 / unit::deg, 24}}};
enum class LogClock { s, ms, us, ns, unix_s, unix_ms, unix_ns, us_wrapped, s_and_ns, none, xsens, bosch, iso_date, slashed_date, count };
enum class LogHeader { none, names, units, unit_row, count };
enum class LogEncoding { plain, bom, utf16le, utf16be, crlf, cr, count };

struct LogShape {
  LogUnit accel, gyro;
  LogClock clock;
  LogHeader header;
  LogEncoding encoding;
  char delimiter;
  bool decimal_comma, quoted, z_first, gyro_first, time_last, two_files, wrong_sign, extras;
};

template <class E>
E any_of_enum(std::mt19937& random) {
  return static_cast<E>(random() % static_cast<unsigned>(E::count));
}

/// Every second log in plain UTF-8 with points; what excludes another feature of a log is left out.
LogShape shape_of_log(unsigned number) {
  std::mt19937 random(number);
  random.discard(10);
  const auto one_in = [&](unsigned n) { return random() % n == 0; };
  LogShape s{accel_log_units[random() % 8],
             gyro_log_units[random() % 8],
             any_of_enum<LogClock>(random),
             any_of_enum<LogHeader>(random),
             one_in(2) ? LogEncoding::plain : any_of_enum<LogEncoding>(random),
             ",;\t "[random() % 4],
             one_in(3),
             one_in(6),
             one_in(5),
             one_in(2),
             one_in(5),
             one_in(4),
             one_in(2),
             one_in(4)};
  if (s.delimiter == ',' || s.delimiter == ' ') s.decimal_comma = false;
  if (s.delimiter == ' ') s.quoted = false;
  if (s.delimiter == ' ' && (s.clock == LogClock::iso_date || s.clock == LogClock::slashed_date)) s.clock = LogClock::s;  // a date has a blank
  if (s.two_files) {
    s.header = s.header == LogHeader::none ? LogHeader::names : s.header;
    s.extras = s.time_last = false;
    if (s.clock == LogClock::none) s.clock = LogClock::s;
  }
  const bool by_name = s.clock == LogClock::xsens || s.clock == LogClock::bosch;
  if (by_name && s.header == LogHeader::none) s.header = LogHeader::names;
  if (s.header == LogHeader::none) s.z_first = false;  // nothing would tell
  return s;
}

const char* clock_name(LogClock clock) {
  constexpr std::array names{"s",          "ms",       "us",   "ns",          "unix s",      "unix ms",  "unix ns",
                             "us wrapped", "s and ns", "none", "Xsens ticks", "Bosch ticks", "ISO date", "slashed date"};
  return names[static_cast<std::size_t>(clock)];
}

std::string name_of_log(const LogShape& s) {
  return fmt::format("accel {}{} gyro {}{} clock {} header {} encoding {} delimiter '{}'{}{}{}{}{}{}{}", s.accel.unit, s.accel.integer_bits,
                     s.gyro.unit, s.gyro.integer_bits, clock_name(s.clock), static_cast<int>(s.header), static_cast<int>(s.encoding), s.delimiter,
                     s.decimal_comma ? ", decimal comma" : "", s.quoted ? ", quoted" : "", s.z_first ? ", z first" : "",
                     s.gyro_first ? ", gyro first" : "", s.time_last ? ", time last" : "", s.two_files ? ", two files" : "",
                     s.wrong_sign ? ", wrong sign" : "");
}

constexpr double log_rate_hz = 40;  // at 50 Hz a degree a sample and a radian per second are alike

const Recording& short_motion() {
  static const Recording cached = simulate_session({.poses = 14, .first_rest = 10, .rest = 2.5, .move = 1.5, .rate_hz = log_rate_hz}, 7).recording;
  return cached;
}

std::string reading_text(double value, const LogUnit& unit, bool wrong_sign) {
  const double reading = value * unit.per_si * (unit.output == Output::increment ? 1 / log_rate_hz : 1);
  if (unit.integer_bits == 0) return fmt::format("{:.9g}", reading);
  const auto integer = static_cast<std::int64_t>(std::llround(reading));
  return fmt::format("{}", wrong_sign && integer < 0 ? integer + (std::int64_t{1} << unit.integer_bits) : integer);
}

/// The fields of a stamp, in the columns that clock_names gives.
std::vector<std::string> stamp_fields(LogClock clock, std::int64_t ns) {
  const double s = 1e-9 * static_cast<double>(ns);
  const auto date = [&](const char* pattern) {  // 2025-07-08 10:00:00 and what the log has run
    const std::int64_t ms = ns / 1'000'000, seconds = ms / 1000;
    return fmt::format(fmt::runtime(pattern), seconds / 60, seconds % 60, ms % 1000);
  };
  switch (clock) {
    case LogClock::ms:
      return {fmt::format("{}", ns / 1'000'000)};
    case LogClock::us:
      return {fmt::format("{}", ns / 1000)};
    case LogClock::ns:
      return {fmt::format("{}", ns)};
    case LogClock::unix_s:
      return {fmt::format("{:.4f}", 1.7e9 + s)};
    case LogClock::unix_ms:
      return {fmt::format("{}", 1'700'000'000'000 + ns / 1'000'000)};
    case LogClock::unix_ns:
      return {fmt::format("{}", 1'700'000'000'000'000'000 + ns)};
    case LogClock::us_wrapped:
      return {fmt::format("{}", (ns / 1000 + 4'294'000'000) % 4'294'967'296)};
    case LogClock::s_and_ns:
      return {fmt::format("{}", 1'700'000'000 + ns / 1'000'000'000), fmt::format("{}", ns % 1'000'000'000)};
    case LogClock::xsens:
      return {fmt::format("{}", ns / 100'000)};
    case LogClock::bosch:
      return {fmt::format("{}", (1000 + ns * 16 / 625'000) % (1 << 24))};
    case LogClock::iso_date:
      return {date("2025-07-08T10:{:02}:{:02}.{:03}Z")};
    case LogClock::slashed_date:
      return {date("2025/07/08 10:{:02}:{:02}.{:03}")};
    case LogClock::none:
      return {};
    default:
      return {fmt::format("{:.4f}", s)};
  }
}

std::vector<std::string> clock_columns(LogClock clock) {
  if (clock == LogClock::none) return {};
  if (clock == LogClock::s_and_ns) return {"sec", "nanosec"};
  if (clock == LogClock::xsens) return {"SampleTimeFine"};
  if (clock == LogClock::bosch) return {"sensortime"};
  return {"time"};
}

std::string clock_unit(LogClock clock) {
  const std::string name = clock_name(clock);
  if (clock == LogClock::xsens || clock == LogClock::bosch || clock == LogClock::iso_date || clock == LogClock::slashed_date) return "";
  return name.starts_with("unix ") ? name.substr(5) : name.substr(0, name.find(' '));
}

std::string encoded(const std::string& text, LogEncoding encoding) {
  std::string bytes;
  const auto put = [&](unsigned char c, bool big) {
    bytes += big ? '\0' : static_cast<char>(c);
    bytes += big ? static_cast<char>(c) : '\0';
  };
  switch (encoding) {
    case LogEncoding::bom:
      return "\xEF\xBB\xBF" + text;
    case LogEncoding::utf16le:
    case LogEncoding::utf16be: {
      const bool big = encoding == LogEncoding::utf16be;
      bytes = big ? "\xFE\xFF" : "\xFF\xFE";
      for (const char c : text) put(static_cast<unsigned char>(c), big);
      return bytes;
    }
    case LogEncoding::cr:
    case LogEncoding::crlf:
      for (const char c : text) bytes += c == '\n' ? (encoding == LogEncoding::cr ? "\r" : "\r\n") : std::string(1, c);
      return bytes;
    default:
      return text;
  }
}

/// What a column of a file is: "time", "time.fraction", "gyro.x", "temperature".
struct FileColumn {
  std::string meaning, name, unit;
};

std::vector<FileColumn> columns_of_file(const LogShape& s, bool gyro, bool accel) {
  std::vector<FileColumn> columns;
  const auto add_time = [&] {
    const std::string stated = s.header == LogHeader::units || s.header == LogHeader::unit_row ? clock_unit(s.clock) : "";
    for (const std::string& name : clock_columns(s.clock))
      columns.push_back({name == "nanosec" ? "fraction" : "time", name, name == "nanosec" ? "" : stated});
  };
  const auto add_triad = [&](const std::string& triad, const LogUnit& unit) {
    for (const char axis : s.z_first ? "zyx" : "xyz")
      if (axis != '\0')
        columns.push_back(
            {triad + "." + axis, s.two_files ? std::string(1, axis) : triad.substr(0, triad == "gyro" ? 4 : 3) + "_" + axis, unit.unit});
  };
  if (!s.time_last) add_time();
  if (gyro && s.gyro_first) add_triad("gyro", s.gyro);
  if (accel) add_triad("accel", s.accel);
  if (gyro && !s.gyro_first) add_triad("gyro", s.gyro);
  if (s.extras) columns.push_back({"temperature", "temp", "degC"});
  if (s.time_last) add_time();
  return columns;
}

std::string file_text(const LogShape& s, const std::vector<FileColumn>& columns) {
  const Recording& r = short_motion();
  std::string text;
  const auto add_row = [&](auto field_of) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
      std::string field = field_of(c);
      if (s.quoted) field = "\"" + field + "\"";
      text += (c > 0 ? std::string(1, s.delimiter) : "") + field;
    }
    text += '\n';
  };
  const bool in_names = s.header == LogHeader::units;
  if (s.header != LogHeader::none)
    add_row([&](std::size_t c) {
      return columns[c].name + (in_names && !columns[c].unit.empty() ? (s.delimiter == ' ' ? "[" : " [") + columns[c].unit + "]" : "");
    });
  if (s.header == LogHeader::unit_row) add_row([&](std::size_t c) { return columns[c].unit.empty() ? "-" : columns[c].unit; });
  for (std::size_t i = 0; i < r.size(); ++i)
    add_row([&](std::size_t c) {
      const std::string& meaning = columns[c].meaning;
      std::string field;
      if (meaning == "time" || meaning == "fraction") {
        field = stamp_fields(s.clock, r.time_ns[i])[meaning == "fraction"];
        if (s.clock == LogClock::iso_date || s.clock == LogClock::slashed_date) return field;
      } else if (meaning == "temperature") {
        field = fmt::format("{:.2f}", 25 + 1e-3 * static_cast<double>(i));
      } else {
        const bool gyro = meaning.starts_with("gyro");
        field = reading_text((gyro ? r.gyro : r.accel)[static_cast<std::size_t>(meaning.back() - 'x')][i], gyro ? s.gyro : s.accel, s.wrong_sign);
      }
      if (s.decimal_comma && field.find('.') != std::string::npos) field[field.find('.')] = ',';
      return field;
    });
  return encoded(text, s.encoding);
}

/// Faults of what was understood; empty where all is right.
std::string mistake_about(const LogShape& s, const SignalTable& table, const std::vector<std::vector<FileColumn>>& files, const Inspection& found) {
  std::string wrong;
  const auto check = [&](const char* triad, const TriadSource& source, const LogUnit& unit) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string meaning = std::string(triad) + "." + "xyz"[axis];
      bool right = false;
      for (const std::vector<FileColumn>& file : files)
        for (std::size_t c = 0; c < file.size(); ++c)
          if (file[c].meaning == meaning && source.columns.size() == 3) {
            const std::string own = std::holds_alternative<int>(source.columns[axis]) ? "" : std::get<std::string>(source.columns[axis]);
            const bool by_name = own.substr(0, own.find(" [")) == file[c].name || own.substr(0, own.find('[')) == file[c].name;
            right = own.empty() ? std::get<int>(source.columns[axis]) == static_cast<int>(c) + 1 : by_name;
          }
      if (!right) wrong += " " + meaning;
    }
    if (source.unit != unit.unit || source.output != unit.output) wrong += fmt::format(" {} unit {}", triad, source.unit);
    const bool integers = source.integers != Integers::as_written;
    if (unit.integer_bits == 0 && integers) wrong += fmt::format(" {} integers", triad);
    if (unit.integer_bits > 0 && s.wrong_sign && to_string(source.integers) != fmt::format("int{}", unit.integer_bits))
      wrong += fmt::format(" {} sign", triad);
  };
  check("gyro", found.source.gyro, s.gyro);
  check("accel", found.source.accel, s.accel);
  if (s.two_files) {
    const auto file_of = [&](const TriadSource& source) { return source.file.value_or(found.source.file); };
    if (file_of(found.source.gyro) != "Gyroscope.csv" || file_of(found.source.accel) != "TotalAcceleration.csv") wrong += " files";
  }
  if (std::abs(found.rate_hz.value_or(0) / log_rate_hz - 1) > 1e-3) wrong += fmt::format(" rate {}", found.rate_hz.value_or(0));
  if (table.rows() < short_motion().size() * 9 / 10) wrong += " rows";
  return wrong;
}

TEST(InspectManyLogs, AreUnderstoodOrAskedAboutAndNeverWrong) {
  constexpr unsigned logs = 224;
  unsigned asked = 0;
  std::map<std::string, unsigned> questions;
  for (unsigned i = 0; i < logs; ++i) {
    const LogShape shape = shape_of_log(i);
    SCOPED_TRACE(fmt::format("log {}: {}", i, name_of_log(shape)));
    std::vector<std::vector<FileColumn>> files{columns_of_file(shape, true, !shape.two_files)};
    if (shape.two_files) files.push_back(columns_of_file(shape, false, true));
    std::vector<SignalTable> tables;
    for (std::size_t f = 0; f < files.size(); ++f)
      tables.push_back(signals_of_text(!shape.two_files ? "log.csv"
                                       : f == 0         ? "Gyroscope.csv"
                                                        : "TotalAcceleration.csv",
                                       file_text(shape, files[f])));
    const Declarations declared = shape.clock == LogClock::none ? Declarations{{"rate_hz", "40"}} : Declarations{};
    const SignalTable table = inspection::joined(std::move(tables), declared);
    const Inspection found = inspect(table, declared);
    EXPECT_TRUE(found.problems().empty()) << fmt::format("{}", fmt::join(found.problems(), "; "));
    if (!found.complete()) {
      ++asked;
      for (const std::string& question : found.ambiguous()) ++questions[question.substr(0, question.find(':'))];
      if (found.ambiguous().size() > 1) fmt::print("{}: {}\n", name_of_log(shape), fmt::join(found.ambiguous(), "; "));
      continue;
    }
    EXPECT_EQ(mistake_about(shape, table, files, found), "") << fmt::format("{}", fmt::join(found.evidence(), "\n"));
  }
  for (const auto& [key, count] : questions) fmt::print("asked for {}: {}\n", key, count);
  EXPECT_LE(asked, logs / 4) << "asking is right, but not about everything";
}

}  // namespace
}  // namespace imulab
