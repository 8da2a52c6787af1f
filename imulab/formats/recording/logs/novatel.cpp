// NovAtel's raw IMU logs, in ASCII and binary: RAWIMU and RAWIMUS, which hold counts, and RAWIMUX and RAWIMUSX, which also say which IMU it is
// (https://docs.novatel.com/OEM7/Content/SPAN_Logs/RAWIMUSX.htm; scale factors also in NovAtel's driver for ROS, novatel_oem7_driver).
//
// The counts are increments over the IMU's own interval, whatever the rate at which they are logged: times its rate they are rates. The second of the
// three axes is logged with the other sign.
#include "imulab/error.hpp"
#include "imulab/formats/recording/format.hpp"
#include "imulab/formats/recording/logs/binary.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/reading_meter.hpp"
#include "imulab/formats/text/take_until.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

namespace imulab::recording_io {
namespace {

constexpr double foot = 0.3048;

/// What one count is, and how often the IMU gives increments.
struct NovatelImu {
  int type;
  double gyro_rad, accel_mps, rate_hz;
};
constexpr double two_to(int power) { return power == 0 ? 1 : power > 0 ? 2 * two_to(power - 1) : two_to(power + 1) / 2; }
constexpr double epson_mg = 1e-3 * unit::g;  // of whose readings a count is a rate
constexpr std::array<NovatelImu, 18> novatel_imus{{
    {1, two_to(-33), foot* two_to(-27), 100},                                                  // HG1700-AG11
    {4, two_to(-33), foot* two_to(-26), 100},                                                  // HG1700-AG17
    {5, two_to(-33), foot* two_to(-27), 100},                                                  // HG1900-CA29
    {8, two_to(-19), two_to(-14), 200},                                                        // LN-200
    {11, two_to(-33), foot* two_to(-27), 100},                                                 // HG1700-AG58
    {12, two_to(-33), foot* two_to(-26), 100},                                                 // HG1700-AG62
    {13, 0.1 * two_to(-8) * unit::arcsec, 0.05 * two_to(-15), 200},                            // iIMU-FSAS
    {20, two_to(-33), foot* two_to(-27), 100},                                                 // HG1930-AA99
    {26, 1e-9, 2e-8, 200},                                                                     // ISA-100C
    {27, two_to(-33), foot* two_to(-27), 100},                                                 // HG1900-CA50
    {28, two_to(-33), foot* two_to(-27), 100},                                                 // HG1930-CA50
    {31, 720 * two_to(-31) * unit::deg, 200 * two_to(-31), 200},                               // ADIS16488
    {32, two_to(-21) * unit::deg, two_to(-22), 125},                                           // STIM300
    {33, 0.1 / (3600 * 256.0), 0.05 * two_to(-15), 200},                                       // KVH 1750
    {41, 0.008 * two_to(-16) / 125 * unit::deg, 0.2 * two_to(-16) / 125 * epson_mg, 125},      // Epson G320
    {52, 1e-9, 2e-8, 200},                                                                     // Litef uIMU
    {58, two_to(-33), two_to(-29), 100},                                                       // HG4930-AN01
    {61, 0.0151515 * two_to(-16) / 200 * unit::deg, 0.4 * two_to(-16) / 200 * epson_mg, 200},  // Epson G370
}};

const NovatelImu* novatel_imu(int type) {
  const auto found = std::find_if(novatel_imus.begin(), novatel_imus.end(), [type](const NovatelImu& imu) { return imu.type == type; });
  return found != novatel_imus.end() ? &*found : nullptr;
}

struct NovatelSample {
  std::int64_t time_ns = 0;              ///< of GPS
  std::array<std::int32_t, 6> counts{};  ///< gyro x, y, z, accelerometer x, y, z
  int type = -1;                         ///< of the IMU; -1: the log does not say
};

/// The four logs: the number in binary, the name in ASCII, and whether the type of the IMU stands in them.
struct NovatelLog {
  std::uint16_t id;
  std::string_view name;
  bool has_type;
};
constexpr std::array<NovatelLog, 4> novatel_logs{
    {{1462, "RAWIMUSX", true}, {325, "RAWIMUS", false}, {1461, "RAWIMUX", true}, {268, "RAWIMU", false}}};

/// Seconds of a week as they are printed, or as a double of that many, in nanoseconds since the beginning of GPS time.
std::optional<std::int64_t> gps_time_ns(std::uint32_t week, double seconds) {
  constexpr std::uint32_t most_weeks = 10'000;
  constexpr double week_s = 604800;
  if (week > most_weeks || !(seconds >= 0 && seconds <= week_s)) return std::nullopt;
  return static_cast<std::int64_t>(week) * 604'800'000'000'000 + std::llround(1e9 * seconds);
}

/// The counts in their order in a log: accelerometers z, -y, x, then gyros.
std::array<std::int32_t, 6> in_axes(const std::array<std::int32_t, 6>& logged) {
  const auto reversed = [](std::int32_t v) { return static_cast<std::int32_t>(-static_cast<std::int64_t>(v)); };
  return {logged[5], reversed(logged[4]), logged[3], logged[2], reversed(logged[1]), logged[0]};
}

/// NovAtel's checksum: CRC-32 that begins with zero and is not inverted.
std::uint32_t novatel_crc(std::string_view bytes) { return ~crc32(bytes, ~std::uint32_t{0}); }

template <class T>
bool take_number(std::string_view& fields, T& value, int base = 10) {
  const std::string_view field = text::take_until(fields, ',');
  const char *const first = field.data(), *const last = first + field.size();
  std::from_chars_result read{};
  if constexpr (std::is_floating_point_v<T>)
    read = std::from_chars(first, last, value);
  else
    read = std::from_chars(first, last, value, base);
  return read.ec == std::errc() && read.ptr == last;
}

/// The fields of a line behind its header.
std::optional<NovatelSample> sample_of_line(std::string_view fields, bool has_type) {
  NovatelSample sample;
  std::uint32_t info = 0, week = 0, status = 0;
  double seconds = 0;
  if (has_type && !(take_number(fields, info, 16) && take_number(fields, sample.type))) return std::nullopt;
  if (!take_number(fields, week) || !take_number(fields, seconds) || !take_number(fields, status, 16)) return std::nullopt;
  std::array<std::int32_t, 6> logged;
  for (std::int32_t& count : logged)
    if (!take_number(fields, count)) return std::nullopt;
  const auto time_ns = gps_time_ns(week, seconds);
  if (!time_ns) return std::nullopt;
  sample.time_ns = *time_ns;
  sample.counts = in_axes(logged);
  return sample;
}

constexpr std::size_t body_bytes = 40;  // of all four

std::optional<NovatelSample> sample_of_body(const char* body, bool has_type) {
  NovatelSample sample;
  if (has_type) sample.type = load<std::uint8_t>(body + 1);
  const std::uint32_t week = has_type ? load<std::uint16_t>(body + 2) : load<std::uint32_t>(body);
  const auto time_ns = gps_time_ns(week, load<double>(body + 4));
  if (!time_ns) return std::nullopt;
  sample.time_ns = *time_ns;
  std::array<std::int32_t, 6> logged;
  for (std::size_t k = 0; k < 6; ++k) logged[k] = load<std::int32_t>(body + 16 + 4 * k);
  sample.counts = in_axes(logged);
  return sample;
}

/// What a file's logs come to.
struct NovatelTable {
  std::vector<NovatelSample> samples;  ///< none where they are only counted
  std::size_t rows = 0, damaged = 0;
  int type = -1;
  bool several_types = false;

  void add(const std::optional<NovatelSample>& sample, bool kept) {
    if (!sample) {
      ++damaged;
      return;
    }
    several_types = several_types || (rows > 0 && type != sample->type);
    type = sample->type;
    ++rows;
    if (kept) samples.push_back(*sample);
  }
};
using NovatelTables = std::array<NovatelTable, novatel_logs.size()>;

/// A line "%RAWIMUSXA,...;...*12345678": its length where it is right, else 0.
std::size_t take_line(std::string_view line, std::size_t kept, NovatelTables& tables) {
  const std::size_t comma = line.find(','), semicolon = line.find(';'), star = line.rfind('*');
  if (comma == std::string_view::npos || comma < 2 || line[comma - 1] != 'A') return 0;
  const auto log = std::find_if(novatel_logs.begin(), novatel_logs.end(), [&](const NovatelLog& l) { return line.substr(1, comma - 2) == l.name; });
  if (log == novatel_logs.end()) return 0;
  const auto which = static_cast<std::size_t>(log - novatel_logs.begin());
  std::uint32_t crc = 0;
  const bool whole = semicolon != std::string_view::npos && star != std::string_view::npos && star > semicolon && line.size() - star == 9 &&
                     std::from_chars(line.data() + star + 1, line.data() + line.size(), crc, 16).ptr == line.data() + line.size() &&
                     novatel_crc(line.substr(1, star - 1)) == crc;
  tables[which].add(whole ? sample_of_line(line.substr(semicolon + 1, star - semicolon - 1), log->has_type) : std::nullopt, which == kept);
  return whole ? line.size() : 0;
}

constexpr std::string_view long_sync = "\xAA\x44\x12", short_sync = "\xAA\x44\x13";

/// A binary message at the beginning of `bytes`, if there is a whole one: its length; else 0.
std::size_t take_message(std::string_view bytes, std::size_t kept, NovatelTables& tables) {
  constexpr std::size_t short_head = 12, crc_bytes = 4;
  const bool is_short = bytes.starts_with(short_sync);
  if (bytes.size() < short_head || (!is_short && !bytes.starts_with(long_sync))) return 0;
  const std::size_t head = is_short ? short_head : load<std::uint8_t>(bytes.data() + 3);
  if (head < short_head || bytes.size() < head) return 0;
  const std::size_t length = is_short ? load<std::uint8_t>(bytes.data() + 3) : load<std::uint16_t>(bytes.data() + 8);
  const auto id = load<std::uint16_t>(bytes.data() + 4);
  const std::size_t size = head + length + crc_bytes;
  if (bytes.size() < size) return 0;
  const auto log = std::find_if(novatel_logs.begin(), novatel_logs.end(), [id](const NovatelLog& l) { return l.id == id; });
  if (log == novatel_logs.end() || length != body_bytes) return 0;  // whose checksum is not computed either: it says how long it is
  const auto which = static_cast<std::size_t>(log - novatel_logs.begin());
  const bool whole = novatel_crc(bytes.substr(0, head + length)) == load<std::uint32_t>(bytes.data() + head + length);
  tables[which].add(whole ? sample_of_body(bytes.data() + head, log->has_type) : std::nullopt, which == kept);
  return whole ? size : 0;
}

/// The next byte with which a message may begin: at the beginning of a line, or a binary one.
std::size_t next_begin(std::string_view bytes, std::size_t from) {
  while (from < bytes.size()) {
    const std::size_t at = bytes.find_first_of("\xAA#%", from);
    if (at == std::string_view::npos) break;
    if (bytes[at] == '\xAA') {
      const std::string_view sync = bytes.substr(at, 3);
      if (sync == long_sync || sync == short_sync) return at;
    } else if (at == 0 || bytes[at - 1] == '\n' || bytes[at - 1] == '\r' || bytes.substr(at + 1, 6) == "RAWIMU") {
      return at;
    }
    from = at + 1;
  }
  return bytes.size();
}

constexpr std::size_t none_kept = novatel_logs.size();

/// ASCII and binary messages of a file, also mixed. `kept`: of which log the samples are kept.
NovatelTables scan_novatel(std::string_view bytes, std::size_t kept) {
  constexpr std::size_t longest_line = 1024;  // of the logs that are read
  NovatelTables tables;
  const ReadingMeter meter(bytes.size());
  for (std::size_t at = next_begin(bytes, 0); at < bytes.size();) {
    std::size_t size = 0;
    if (bytes[at] == '\xAA') {
      size = take_message(bytes.substr(at), kept, tables);
    } else {
      const std::string_view some = bytes.substr(at, longest_line);
      const std::size_t end = some.find_first_of("\r\n");
      if (end != std::string_view::npos || some.size() < longest_line) size = take_line(some.substr(0, end), kept, tables);
    }
    const std::size_t next = next_begin(bytes, at + std::max<std::size_t>(size, 1));
    meter.add(next - at);
    at = next;
  }
  return tables;
}

TableDescription describe_log(const NovatelLog& log, const NovatelTable& table) {
  const bool scaled = novatel_imu(table.type) != nullptr && !table.several_types;
  TableDescription out{std::string(log.name), std::string(log.name), {{"time", "ns"}}, table.rows};
  for (const char* triad : {"gyro", "accel"})
    for (const char axis : {'x', 'y', 'z'})
      out.columns.push_back({fmt::format("{}.{}", triad, axis), scaled ? (triad[0] == 'g' ? "rad/s" : "m/s^2") : "count"});
  return out;
}

std::vector<TableDescription> describe_tables(const NovatelTables& tables, const std::string& file) {
  std::vector<TableDescription> out;
  for (std::size_t k = 0; k < tables.size(); ++k)
    if (tables[k].rows > 0) out.push_back(describe_log(novatel_logs[k], tables[k]));
  std::size_t damaged = 0;
  for (const NovatelTable& table : tables) damaged += table.damaged;
  if (out.empty() && damaged > 0)
    throw Error(fmt::format("{}: all {} raw readings of an IMU in it have a wrong checksum or field; expected the log as the receiver wrote it", file,
                            damaged));
  if (out.empty())
    throw Error(file + ": is a log of a NovAtel receiver without raw readings of an IMU; expected RAWIMUSX, RAWIMUX, RAWIMUS or RAWIMU in it");
  return out;
}

std::vector<TableDescription> describe_novatel(const TableRequest& request) {
  const MappedFile file(request.file);
  return describe_tables(scan_novatel(file.text(), none_kept), request.file.string());
}

RawColumn column_of(const NovatelTable& table, std::size_t column, const NovatelImu* imu) {
  RawColumn raw;
  if (column == 0) {
    for (const NovatelSample& sample : table.samples) raw.integers.push_back(sample.time_ns);
    return raw;
  }
  const std::size_t axis = column - 1;
  const double scale = imu == nullptr ? 1 : (axis < 3 ? imu->gyro_rad : imu->accel_mps) * imu->rate_hz;
  raw.numbers.reserve(table.samples.size());
  for (const NovatelSample& sample : table.samples) raw.numbers.push_back(scale * sample.counts[axis]);
  return raw;
}

void read_novatel(const TableRequest& request, const Wanted& wanted, const PieceSink& sink) {
  const std::string name = request.file.string();
  const MappedFile file(request.file);
  const auto log_named = [](const std::string& topic) {
    return std::find_if(novatel_logs.begin(), novatel_logs.end(), [&](const NovatelLog& l) { return l.name == topic; });
  };
  auto log = log_named(request.topic);
  if (log == novatel_logs.end()) log = log_named(find_table(describe_novatel(request), request.topic, name).name);
  const auto which = static_cast<std::size_t>(log - novatel_logs.begin());
  NovatelTables tables = scan_novatel(file.text(), which);
  const NovatelTable table = std::move(tables[which]);
  const TableDescription description = describe_log(*log, table);
  if (table.rows == 0) find_table(describe_tables(tables, name), request.topic, name);  // which says what there is
  const NovatelImu* imu = table.several_types ? nullptr : novatel_imu(table.type);
  TableRows rows;
  rows.row = "message";
  for (const Column& column : wanted.columns) rows.columns.push_back(column_of(table, find_column(description, column, name), imu));
  if (table.damaged > 0)
    rows.warnings.push_back(fmt::format("{}: {} {} with a wrong checksum or field were left out", name, table.damaged, log->name));
  if (imu == nullptr)
    rows.warnings.push_back(
        fmt::format("{}: {}: its increments stay counts, whose scale depends on it; declare accel.unit and gyro.unit in a session with "
                    "counts_per_unit, or log RAWIMUSX",
                    name,
                    table.several_types ? "the type of the IMU changes"
                    : table.type < 0    ? fmt::format("{} does not say which IMU it is", log->name)
                                        : fmt::format("the scale of an IMU of type {} is not known here", table.type)));
  sink(std::move(rows));
}

/// By a message of one of the logs in the first bytes, or any of NovAtel's at the very beginning.
bool is_novatel(std::string_view head) {
  if (head.starts_with(long_sync) || head.starts_with(short_sync)) return true;
  for (std::size_t at = next_begin(head, 0); at < head.size(); at = next_begin(head, at + 1)) {
    const std::string_view rest = head.substr(at);
    if (rest.substr(1, 6) == "RAWIMU") return true;
    if (head[at] == '\xAA' && rest.size() >= 6 &&
        std::any_of(novatel_logs.begin(), novatel_logs.end(), [&](const NovatelLog& l) { return load<std::uint16_t>(rest.data() + 4) == l.id; }))
      return true;
  }
  return false;
}

}  // namespace

RecordingFormat novatel_format() { return {.name = "NovAtel log", .recognizes = is_novatel, .describe = describe_novatel, .read = read_novatel}; }

}  // namespace imulab::recording_io
