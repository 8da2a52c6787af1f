#include "imulab/formats/recording/written/csv_writer.hpp"

#include "imulab/compensate.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/recording/unit_names.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string_view>

namespace imulab {
namespace {

struct WrittenColumn {
  std::string_view name;
  const std::vector<double>* values;
  double increment_s = 0;  ///< > 0: written as an increment over this interval
};

using Names = std::array<std::string_view, 3>;
constexpr Names gyro_names{"gx", "gy", "gz"}, accel_names{"ax", "ay", "az"}, gyro_temperature_names{"tgx", "tgy", "tgz"},
    accel_temperature_names{"tax", "tay", "taz"};
constexpr std::string_view gyro_temperature_name = "tg", accel_temperature_name = "ta";

/// By bits: 1 saturated, 2 outside the calibrated temperatures, 4 replaced.
constexpr std::array<std::string_view, 8> flag_names{"",         "saturated",          "out_of_range",          "saturated|out_of_range",
                                                     "replaced", "saturated|replaced", "out_of_range|replaced", "saturated|out_of_range|replaced"};

void add_triad(std::vector<WrittenColumn>& columns, const Columns3& triad, const Names& names, double increment_s) {
  for (std::size_t i = 0; i < 3; ++i) columns.push_back({names[i], &triad[i], increment_s});
}

void add_thermal(std::vector<WrittenColumn>& columns, const Columns3& thermal, std::string_view name, const Names& names) {
  if (thermal[0].empty()) return;
  if (thermal[0] == thermal[1] && thermal[0] == thermal[2]) {
    columns.push_back({name, &thermal[0]});
  } else {
    add_triad(columns, thermal, names, 0);
  }
}

std::vector<WrittenColumn> reading_columns(const Recording& r) {
  std::vector<WrittenColumn> columns;
  add_triad(columns, r.gyro, gyro_names, r.gyro_increment ? r.interval_s : 0);
  add_triad(columns, r.accel, accel_names, r.accel_increment ? r.interval_s : 0);
  return columns;
}

std::string header(const std::vector<WrittenColumn>& columns, bool flags) {
  std::string text = "t";
  for (const WrittenColumn& column : columns) text.append(",").append(column.name);
  return text + (flags ? ",flags\n" : "\n");
}

/// The increment that divided by the interval gives the mean back: the whole number where there is one (counts), else the nearest that does.
double as_increment(double mean, double interval_s) {
  const double product = mean * interval_s;
  for (const double candidate : {std::nearbyint(product), product, std::nextafter(product, HUGE_VAL), std::nextafter(product, -HUGE_VAL)})
    if (candidate / interval_s == mean) return candidate;
  return product;
}

/// Appends row i.
void add_row(std::string& text, const Recording& recording, const std::vector<WrittenColumn>& columns, std::size_t i, const std::string_view* flag) {
  std::array<char, 32> number;  // the longest double takes 24
  text.append(number.data(), text::write_seconds(number.data(), recording.time_ns[i]));
  for (const WrittenColumn& column : columns) {
    const double value = (*column.values)[i], written = column.increment_s > 0 ? as_increment(value, column.increment_s) : value;
    number[0] = ',';
    text.append(number.data(), std::to_chars(number.data() + 1, number.data() + number.size(), written).ptr);
  }
  if (flag != nullptr) text.append(",").append(*flag);
  text.push_back('\n');
}

std::vector<Column> columns_of(const Names& names) { return {std::string(names[0]), std::string(names[1]), std::string(names[2])}; }

/// For each sample the place of its flags' name above.
std::vector<std::uint8_t> marks_of(const CompensatedRecording& c) {
  std::vector<std::uint8_t> marks(c.recording.size(), 0);
  for (const std::size_t i : c.recording.saturated) marks[i] |= 1;
  for (const std::size_t i : c.out_of_range) marks[i] |= 2;
  for (const std::size_t i : c.replaced) marks[i] |= 4;
  return marks;
}

/// Writes a header and rows as they come, so that a day's recording needs no second copy in memory.
void write_rows(const std::filesystem::path& path, std::string text, std::size_t rows, const std::function<void(std::string&, std::size_t)>& add) {
  constexpr std::size_t block = 1 << 20;
  WholeFile file(path);
  for (std::size_t i = 0; i < rows; ++i) {
    add(text, i);
    if (text.size() < block) continue;
    file.write(text);
    text.clear();
  }
  file.write(text);
  file.commit();
}

}  // namespace

void write_recording(const std::filesystem::path& path, const Recording& recording) {
  std::vector<WrittenColumn> columns = reading_columns(recording);
  add_thermal(columns, recording.gyro_temperature, gyro_temperature_name, gyro_temperature_names);
  add_thermal(columns, recording.accel_temperature, accel_temperature_name, accel_temperature_names);
  write_rows(path, header(columns, false), recording.size(),
             [&](std::string& text, std::size_t i) { add_row(text, recording, columns, i, nullptr); });
}

RecordingSource written_source(RecordingSource source) {
  source.time = {.column = "t"};
  source.topic.clear(), source.layout.clear();
  const auto triad = [](TriadSource& t, const Names& names, const char* rate_unit, const char* increment_unit) {
    t.file.reset(), t.topic.reset(), t.time.reset(), t.axes.reset();
    t.columns = columns_of(names);
    if (t.unit == "count") return;
    if (t.limits)
      for (double& limit : *t.limits) limit *= si_factor(t.unit) / t.counts_per_unit.value_or(1);
    t.counts_per_unit.reset();
    t.integers = Integers::as_written;
    t.unit = t.output == Output::rate ? rate_unit : increment_unit;
  };
  triad(source.gyro, gyro_names, "rad/s", "rad");
  triad(source.accel, accel_names, "m/s^2", "m/s");
  const auto thermal = [](std::optional<ThermalSource>& t, std::string_view name, const Names& names) {
    if (t) t->file.reset(), t->topic.reset(), t->time.reset();
    if (t && t->columns.size() == 3)
      t->columns = columns_of(names);
    else if (t)
      t->columns = {std::string(name)};
  };
  thermal(source.gyro_temperature, gyro_temperature_name, gyro_temperature_names);
  thermal(source.accel_temperature, accel_temperature_name, accel_temperature_names);
  return source;
}

std::string compensated_header(bool flags) { return header(reading_columns({}), flags); }

std::string compensated_rows(const CompensatedRecording& c, bool flags) {
  const std::vector<WrittenColumn> columns = reading_columns(c.recording);
  const std::vector<std::uint8_t> marks = flags ? marks_of(c) : std::vector<std::uint8_t>{};
  std::string text;
  text.reserve(c.recording.size() * 160);  // six numbers of 20 characters, a time, flags
  for (std::size_t i = 0; i < c.recording.size(); ++i) add_row(text, c.recording, columns, i, flags ? &flag_names[marks[i]] : nullptr);
  return text;
}

void write_compensated_rows(const std::filesystem::path& path, const CompensatedRecording& c) {
  const bool flags = !(c.recording.saturated.empty() && c.out_of_range.empty() && c.replaced.empty());
  const std::vector<WrittenColumn> columns = reading_columns(c.recording);
  const std::vector<std::uint8_t> marks = flags ? marks_of(c) : std::vector<std::uint8_t>{};
  write_rows(path, compensated_header(flags), c.recording.size(),
             [&](std::string& text, std::size_t i) { add_row(text, c.recording, columns, i, flags ? &flag_names[marks[i]] : nullptr); });
}

}  // namespace imulab
