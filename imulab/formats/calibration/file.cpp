#include "imulab/formats/calibration/file.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/json_fields.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/model/calibration_fields.hpp"
#include "imulab/recording/unit_names.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab {

namespace {

using json_io::Field;

constexpr std::string_view format_family = "imulab.calibration/", format_name = "imulab.calibration/1";

/// Where a coefficient sits in `model` and in `standard_uncertainty`.
Field element(const Field& shaped, Triad triad, Term term, int row, int column) {
  const auto i = static_cast<std::size_t>(row), j = static_cast<std::size_t>(column);
  const Field field = shaped[to_string(triad)][to_string(term)];
  if (is_vector(term)) return field.item(i, 3, "numbers");
  const Field elements = field.item(i, 3, "rows of numbers");
  return elements.item(j, term == Term::thermal && elements.size() != 3 ? 4 : 3, "numbers");
}

/// Files of earlier versions have no thermal terms of the third order.
bool has_element(const Field& shaped, const Coefficient& c) {
  if (!shaped.has(to_string(c.triad)) || !shaped[to_string(c.triad)].has(to_string(c.term))) return false;
  return c.term != Term::thermal || c.column < 3 || shaped[to_string(c.triad)][to_string(c.term)].item(0, 3, "rows of numbers").size() > 3;
}

std::vector<CoefficientIndex> read_estimated(const Field& names) {
  std::vector<CoefficientIndex> out;
  for (std::size_t i = 0, n = names.size(); i < n; ++i) {
    const Field name = names.item(i, n, "names");
    const CoefficientIndex index = json_io::coefficient_of(name, name.text());
    if (std::find(out.begin(), out.end(), index) != out.end()) name.fail(name.text() + " is listed twice");
    out.push_back(index);
  }
  return out;
}

/// `whole`: of which it is a part, which says what is rounding; null: of itself.
Eigen::MatrixXd read_covariance(const Field& field, std::size_t n, const Eigen::MatrixXd* whole = nullptr) {
  const auto at = [&](std::size_t i, std::size_t j) { return field.item(i, n, "rows, one a coefficient").item(j, n, "numbers, one a coefficient"); };
  if (field.size() != n) field.fail(fmt::format("expected {} rows, one a coefficient", n));
  const auto size = static_cast<Eigen::Index>(n);
  Eigen::MatrixXd p(size, size);
  for (Eigen::Index i = 0; i < size; ++i)
    for (Eigen::Index j = 0; j < size; ++j) p(i, j) = at(static_cast<std::size_t>(i), static_cast<std::size_t>(j)).number();
  for (Eigen::Index i = 0; i < size; ++i)
    if (p(i, i) < 0) at(static_cast<std::size_t>(i), static_cast<std::size_t>(i)).expected("a variance, which is not negative");
  for (Eigen::Index i = 0; i < size; ++i)
    for (Eigen::Index j = 0; j < i; ++j) {
      const double scale = whole != nullptr ? std::sqrt((*whole)(i, i) * (*whole)(j, j)) : std::sqrt(p(i, i) * p(j, j));
      const Field element = at(static_cast<std::size_t>(i), static_cast<std::size_t>(j));
      // A billionth of the scale is far above the rounding of any program that computed the matrix.
      if (std::abs(p(i, j) - p(j, i)) > 1e-9 * scale) element.expected(fmt::format("{}, as on the other side of the diagonal", p(j, i)));
      if (std::abs(p(i, j)) > (1 + 1e-9) * scale) element.expected("a covariance that its two variances allow");
    }
  return p;
}

/// Part of the covariance.
Eigen::MatrixXd read_constant(const Field& field, const Calibration& c) {
  Eigen::MatrixXd part = read_covariance(field, c.estimated.size(), &c.covariance);
  for (Eigen::Index i = 0; i < part.rows(); ++i)
    if (part(i, i) > (1 + 1e-9) * c.covariance(i, i))
      field.fail(fmt::format("{}: {} is more than its variance of {}; expected a part of it",
                             coefficient(c.estimated[static_cast<std::size_t>(i)]).name, part(i, i), c.covariance(i, i)));
  return part;
}

/// The stated uncertainties repeat the covariance's diagonal for readers; a file edited in one place only is refused.
void check_uncertainties(const Field& field, const Calibration& calibration) {
  for (const CoefficientIndex i : coefficient_indices()) {
    const Coefficient& c = coefficient(i);
    if (!has_element(field, c)) continue;
    const Field stated = element(field, c.triad, c.term, c.row, c.column);
    const auto computed = standard_uncertainty(calibration, i);
    if (!computed && !stated.is_null()) stated.expected("null: the covariance does not hold " + std::string(c.name));
    if (computed && !(std::abs(stated.number() - *computed) <= 1e-6 * *computed))
      stated.expected(fmt::format("{}, from the covariance of {}", *computed, c.name));
  }
}

/// `raw`: the unit that the model takes.
void check_recorded(const Field& f, const RecordedAs& r, Quantity quantity, const std::string& raw) {
  if (!(r.counts_per_unit > 0)) f["counts_per_unit"].expected("a number above 0");
  if (!(r.interval_s >= 0)) f["interval_s"].expected("a number above 0, or null");
  const std::vector<std::string_view> units = unit_names(quantity, r.interval_s > 0);
  if (std::find(units.begin(), units.end(), r.unit) == units.end()) f["unit"].expected(text::listed(units));
  const bool counts = r.unit == "count";
  if (!raw.empty() && counts != (raw == "count")) f["unit"].expected(fmt::format("what becomes {}, which the model takes", raw));
  if (counts && r.counts_per_unit != 1) f["counts_per_unit"].expected("1 with the unit count");
  std::string seen;
  for (std::size_t i = 0; i < 3; ++i) {
    const Field axis = f["axes"].item(i, 3, "axes");
    const std::string& name = r.axes[i];
    if (name.size() != 2 || (name[0] != '+' && name[0] != '-') || std::string_view("xyz").find(name[1]) == std::string::npos)
      axis.expected("a body axis from \"+x\" to \"-z\"");
    if (seen.find(name[1]) != std::string::npos) axis.expected("an axis that no other column has");
    seen += name[1];
  }
}

void check_format(const Field& root) {
  if (!root.has("format")) root.fail(fmt::format("format: is missing; expected \"{}\"", format_name));
  const std::string format = root["format"].text();
  if (format == format_name) return;
  if (format.starts_with(format_family)) root["format"].fail(fmt::format("{} is a newer format; this program reads {}", format, format_name));
  root["format"].expected(fmt::format("\"{}\"", format_name));
}

/// The standard uncertainty of every coefficient where the model has it, or nothing: {"accel": {"offset": [..], "matrix": [[..]..], ..}, "gyro":
/// {..}}.
JsonFields uncertainties_json(const Calibration& calibration) {
  JsonFields out;
  for (const Triad triad : {Triad::accel, Triad::gyro}) {
    JsonFields terms;
    for (const Term term : terms_of(triad)) {
      std::array<std::vector<std::optional<double>>, 3> rows;
      rows.fill(std::vector<std::optional<double>>(term == Term::thermal ? 4 : 3));
      std::array<std::optional<double>, 3> diagonal;
      bool shown = !is_matrix_thermal(term);
      for (const CoefficientIndex i : coefficient_indices()) {
        const Coefficient& c = coefficient(i);
        if (c.triad != triad || c.term != term) continue;
        const auto row = static_cast<std::size_t>(c.row), column = static_cast<std::size_t>(c.column);
        rows[row][column] = diagonal[row] = standard_uncertainty(calibration, i);
        shown = shown || diagonal[row];
      }
      if (shown) terms.fields.emplace_back(to_string(term), is_vector(term) ? JsonValue(diagonal) : JsonValue(rows));
    }
    out.fields.emplace_back(to_string(triad), std::move(terms));
  }
  return out;
}

JsonFields calibration_json(const Calibration& calibration) {
  for (const CoefficientIndex i : coefficient_indices())
    if (!std::isfinite(coefficient_value(calibration.model, i)))
      throw Error(std::string(coefficient(i).name) + " is not finite; expected a finite number");
  return std::get<JsonFields>(written(calibration).is);
}

}  // namespace

void describe_uncertainties(JsonWriter& f, const Calibration& c) {
  f("standard_uncertainty", uncertainties_json(c));
  f.table("covariance", [&](JsonWriter& covariance) {
    covariance("coefficients", c.estimated);
    covariance("matrix", c.covariance);
    if (c.constant_covariance.size() > 0) covariance("constant", c.constant_covariance);
  });
}

/// Without a covariance none is known.
void describe_uncertainties(JsonReader& f, Calibration& c) {
  f.knows("standard_uncertainty"), f.knows("covariance");
  const auto given = [&](const char* key) { return f.at().has(key) && !f.at()[key].is_null(); };
  const bool read = f.attempt([&] {
    if (given("covariance")) c.estimated = read_estimated(f.at()["covariance"]["coefficients"]);
    c.covariance = given("covariance") ? read_covariance(f.at()["covariance"]["matrix"], c.estimated.size()) : Eigen::MatrixXd(0, 0);
    if (given("covariance") && f.at()["covariance"].has("constant")) c.constant_covariance = read_constant(f.at()["covariance"]["constant"], c);
  });
  f.attempt([&] {
    if (read && given("standard_uncertainty")) check_uncertainties(f.at()["standard_uncertainty"], c);
  });
}

Calibration parse_calibration(std::string_view text, const std::string& file) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) throw Error(file + ": is empty; expected a calibration");
  const JsonValue json = json_io::parse_json(text, file, "a calibration");
  const Field root(json, file, "");
  check_format(root);
  Calibration c;
  json_io::Problems problems;
  JsonReader reader(root, &problems);
  describe(reader, c);
  problems.none_in([&] {
    if (c.recorded_accel) check_recorded(root["recorded"]["accel"], *c.recorded_accel, Quantity::accel, c.model.accel.raw_unit);
  });
  problems.none_in([&] {
    if (c.recorded_gyro) check_recorded(root["recorded"]["gyro"], *c.recorded_gyro, Quantity::gyro, c.model.gyro.raw_unit);
  });
  problems.expect_none();
  return c;
}

Calibration read_calibration(const std::filesystem::path& path) {
  return parse_calibration(MappedFile(path, Content::settings).text(), input_name(path));
}

std::string calibration_text(const Calibration& c) { return json_text(calibration_json(c), JsonLayout::rows_on_lines); }

void write_calibration(const std::filesystem::path& path, const Calibration& c) {
  validate(c);  // what read_calibration would refuse
  write_whole(path, calibration_text(c));
}

std::string truth_text(const Calibration& c, const std::vector<RecordedRigErrors>& rig) {
  JsonFields json = calibration_json(c), recordings;
  for (const auto& [recording, errors] : rig) {
    JsonFields values;
    for (std::size_t i = 0; i < errors.sources.size(); ++i) values.fields.emplace_back(errors.sources[i].name(), errors.values[i]);
    recordings.fields.emplace_back(recording, std::move(values));
  }
  if (!rig.empty()) json.fields.emplace_back("rig", std::move(recordings));
  return json_text(json, JsonLayout::rows_on_lines);
}

}  // namespace imulab
