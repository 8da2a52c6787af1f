// The table of `imulab export --to csv`: names of coefficients and their values. Uncertainties of single coefficients say nothing without their
// correlations, and are left.
#include "imulab/coefficient.hpp"
#include "imulab/formats/import/numbers.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

namespace imulab::import_io {

namespace {

constexpr std::string_view csv_head = "name,value,standard_uncertainty,unit";

struct Row {
  int line = 0;
  double value = 0;
  std::string_view unit;
  bool determined = true;
};

/// "accel.readings,count,,": the unit of a triad's readings.
bool is_unit_row(std::string_view name) { return name == "accel.readings" || name == "gyro.readings"; }

std::map<std::string, Row, std::less<>> rows_of(const Source& s) {
  std::map<std::string, Row, std::less<>> rows;
  for (const Line& line : lines_of(s.text)) {
    if (line.text == csv_head) continue;
    const auto words = words_of(line.text, ",");
    if (words.size() < 2) fail_at(s, line.number, fmt::format("\"{}\": expected a name and a value", excerpt(line.text)));
    const auto value = is_unit_row(words[0]) ? 0 : finite_number(words[1]);
    if (!value) fail_at(s, line.number, fmt::format("{}: expected a number, found \"{}\"", excerpt(words[0]), excerpt(words[1])));
    if (!rows.try_emplace(std::string(words[0]),
                          Row{line.number, *value, is_unit_row(words[0]) ? words[1] : words.back(), words.size() < 3 || words[2] != "inf"})
             .second)
      fail_at(s, line.number, excerpt(words[0]) + ": is given twice; expected each name once");
  }
  return rows;
}

}  // namespace

bool is_csv_table(std::string_view text) {
  const auto lines = lines_of(text);
  return !lines.empty() && lines.front().text == csv_head;
}

ImportedModel read_csv_table(const Source& s) {
  const auto rows = rows_of(s);
  const auto row = [&](const std::string& name) -> const Row& {
    const auto found = rows.find(name);
    if (found == rows.end()) fail_at(s, 0, name + ": is missing; expected a row with it");
    return found->second;
  };
  ImportedModel out;
  for (const CoefficientIndex i : coefficient_indices()) {
    const std::string name(coefficient(i).name);
    if (is_extended(coefficient(i)) && !rows.contains(name)) continue;
    const Row& found = row(name);
    set_coefficient(out.model, i, found.value);
    if (!found.determined) out.not_determined.emplace_back(coefficient(i).name);
  }
  out.raw_known = rows.contains("accel.readings") && rows.contains("gyro.readings");  // tables of the first versions have none
  if (out.raw_known)
    for (auto& [m, name, si] : {std::tuple{&out.model.accel, "accel.readings", "m/s^2"}, std::tuple{&out.model.gyro, "gyro.readings", "rad/s"}}) {
      const Row& unit = row(name);
      if (unit.unit != si && unit.unit != "count")
        fail_at(s, unit.line, fmt::format("{}: expected {} or count, found \"{}\"", name, si, excerpt(unit.unit)));
      m->raw_unit = std::string(unit.unit);
    }
  for (auto& [m, name] : {std::pair{&out.model.accel, "accel"}, std::pair{&out.model.gyro, "gyro"}}) {
    const std::string temperature = fmt::format("{}.temperature.", name);
    if (!rows.contains(temperature + "reference") && !m->varies()) continue;
    const Row& reference = row(temperature + "reference");
    const double lowest = row(temperature + "lowest").value, highest = row(temperature + "highest").value;
    if (lowest > highest) fail_at(s, reference.line, temperature + "lowest: is above highest; expected a range");
    const bool named = reference.unit == "degC" || reference.unit == "K";
    m->temperature = ThermalReading{named ? std::string(reference.unit) : "raw", reference.value, {lowest, highest}};
  }
  return out;
}

}  // namespace imulab::import_io
