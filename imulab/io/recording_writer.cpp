#include "imulab/io/decimal.hpp"
#include "imulab/io/file.hpp"
#include "imulab/io/recording_file.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

namespace imulab {
namespace {

struct WrittenColumn {
  std::string_view name;
  const std::vector<double>* values;
  double increment_s = 0;  ///< > 0: written as an increment over this interval
};

/// The increment that divided by the interval gives the mean back: the whole number where there is one (counts), else the nearest that does.
double as_increment(double mean, double interval_s) {
  const double product = mean * interval_s;
  for (const double candidate : {std::nearbyint(product), product, std::nextafter(product, HUGE_VAL), std::nextafter(product, -HUGE_VAL)})
    if (candidate / interval_s == mean) return candidate;
  return product;
}

void add_triad(std::vector<WrittenColumn>& columns, const Columns3& triad, const std::array<std::string_view, 3>& names, double increment_s) {
  for (std::size_t i = 0; i < 3; ++i) columns.push_back({names[i], &triad[i], increment_s});
}

void add_thermal(std::vector<WrittenColumn>& columns, const Columns3& thermal, std::string_view name, const std::array<std::string_view, 3>& names) {
  if (thermal[0].empty()) return;
  if (thermal[0] == thermal[1] && thermal[0] == thermal[2]) {
    columns.push_back({name, &thermal[0]});
  } else {
    add_triad(columns, thermal, names, 0);
  }
}

std::vector<WrittenColumn> columns_of(const Recording& r) {
  std::vector<WrittenColumn> columns;
  add_triad(columns, r.gyro, {"gx", "gy", "gz"}, r.gyro_increment ? r.interval_s : 0);
  add_triad(columns, r.accel, {"ax", "ay", "az"}, r.accel_increment ? r.interval_s : 0);
  add_thermal(columns, r.gyro_temperature, "tg", {"tgx", "tgy", "tgz"});
  add_thermal(columns, r.accel_temperature, "ta", {"tax", "tay", "taz"});
  return columns;
}

}  // namespace

void write_recording(const std::filesystem::path& path, const Recording& recording, const std::vector<std::string>& flags) {
  constexpr std::size_t block = 1 << 20;  // written as it fills, so that a day's recording needs no second copy in memory
  const std::vector<WrittenColumn> columns = columns_of(recording);
  WholeFile file(path);
  fmt::memory_buffer text;
  text.push_back('t');
  for (const WrittenColumn& column : columns) fmt::format_to(std::back_inserter(text), ",{}", column.name);
  if (!flags.empty()) text.append(std::string_view(",flags"));
  text.push_back('\n');
  std::array<char, 32> number;  // the longest double takes 24
  for (std::size_t i = 0; i < recording.size(); ++i) {
    text.append(number.data(), write_seconds(number.data(), recording.time_ns[i]));
    for (const WrittenColumn& column : columns) {
      const double value = (*column.values)[i];
      number[0] = ',';
      const double written = column.increment_s > 0 ? as_increment(value, column.increment_s) : value;
      text.append(number.data(), std::to_chars(number.data() + 1, number.data() + number.size(), written).ptr);
    }
    if (!flags.empty()) {
      text.push_back(',');
      text.append(flags[i]);
    }
    text.push_back('\n');
    if (text.size() < block) continue;
    file.write({text.data(), text.size()});
    text.clear();
  }
  file.write({text.data(), text.size()});
  file.commit();
}

}  // namespace imulab
