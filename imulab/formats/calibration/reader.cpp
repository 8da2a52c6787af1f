#include "imulab/core/error.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/json_field.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/recording/unit_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <iterator>
#include <limits>

namespace imulab {

namespace {

using json_text::expect_known_keys, json_text::Field, json_text::Json, json_text::parse_json, json_text::Problems;

constexpr std::string_view format_family = "imulab.calibration/", format_name = "imulab.calibration/1";

/// Where a coefficient sits in `model` and in `standard_uncertainty`.
Field element(const Field& shaped, Triad triad, Term term, int row, int column) {
  const auto i = static_cast<std::size_t>(row), j = static_cast<std::size_t>(column);
  const Field field = shaped[to_string(triad)][to_string(term)];
  return is_vector(term) ? field.item(i, 3, "numbers") : field.item(i, 3, "rows of 3 numbers").item(j, 3, "numbers");
}

std::optional<ThermalReading> read_temperature(const Field& triad, const Matrix3d& thermal) {
  if (!triad.has("temperature") || triad["temperature"].is_null()) {
    constexpr const char* why = "expected a reading with its reference, because the thermal terms are not zero";
    if (!thermal.isZero(0)) triad.has("temperature") ? triad["temperature"].fail(why) : triad.fail(std::string("temperature: is missing; ") + why);
    return std::nullopt;
  }
  const Field field = triad["temperature"];
  ThermalReading out;
  out.unit = field["unit"].text();
  if (out.unit != "degC" && out.unit != "K" && out.unit != "raw") field["unit"].expected("degC, K or raw");
  out.reference = field["reference"].number();
  if (!field.has("range")) return out;  // not known
  for (std::size_t i = 0; i < 2; ++i) out.range[i] = field["range"].item(i, 2, "numbers").number();
  if (out.range[0] > out.range[1]) field["range"].expected("[lowest, highest]");
  return out;
}

bool has_term(const Field& shaped, const Coefficient& c) {
  return shaped.has(to_string(c.triad)) && shaped[to_string(c.triad)].has(to_string(c.term));
}

/// A triad's terms, of which the matrix is required; one that is missing is zero.
void read_triad(const Field& field, Triad triad, SensorModel& model, Problems& problems) {
  std::vector<std::string_view> known{"temperature", "raw"};
  TriadModel& m = triad == Triad::accel ? model.accel : model.gyro;
  std::optional<Term> wrong;  // one problem a term
  for (const CoefficientIndex i : coefficient_indices()) {
    const Coefficient& c = coefficient(i);
    if (c.triad != triad) continue;
    if (std::find(known.begin(), known.end(), to_string(c.term)) == known.end()) known.push_back(to_string(c.term));
    if (wrong == c.term || (c.term != Term::matrix && !has_term(field, c))) continue;
    const bool good = problems.none_in([&] {
      set_coefficient(model, i, element(field, triad, c.term, c.row, c.column).number());
      if (c.term != Term::thermal) return;
      const Field constant = element(field, triad, Term::thermal, c.row, 0);
      if (constant.number() != 0) constant.expected("0: the constant of the thermal polynomial is zero by definition (it belongs in the offset)");
    });
    if (!good) wrong = c.term;
  }
  const Field terms = field[to_string(triad)];
  problems.none_in([&] { m.raw_unit = terms.text_or_empty("raw"); });
  problems.none_in([&] { m.temperature = read_temperature(terms, m.thermal); });
  expect_known_keys(terms, known, false, problems);
}

SensorModel read_model(const Field& field, Problems& problems) {
  SensorModel model;
  for (const Triad triad : {Triad::accel, Triad::gyro})
    if (problems.none_in([&] { field[to_string(triad)].keys(); })) read_triad(field, triad, model, problems);
  expect_known_keys(field, {"accel", "gyro"}, false, problems);
  return model;
}

std::vector<CoefficientIndex> read_estimated(const Field& names) {
  std::vector<CoefficientIndex> out;
  for (std::size_t i = 0, n = names.size(); i < n; ++i) {
    const Field name = names.item(i, n, "names");
    CoefficientIndex index;
    try {
      index = coefficient_index(name.text());
    } catch (const Error& e) {
      name.fail(e.what());
    }
    if (std::find(out.begin(), out.end(), index) != out.end()) name.fail(name.text() + " is listed twice");
    out.push_back(index);
  }
  return out;
}

Eigen::MatrixXd read_covariance(const Field& field, std::size_t n) {
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
      const double scale = std::sqrt(p(i, i) * p(j, j));
      const Field element = at(static_cast<std::size_t>(i), static_cast<std::size_t>(j));
      // A billionth of the scale is far above the rounding of any program that computed the matrix.
      if (std::abs(p(i, j) - p(j, i)) > 1e-9 * scale) element.expected(fmt::format("{}, as on the other side of the diagonal", p(j, i)));
      if (std::abs(p(i, j)) > (1 + 1e-9) * scale) element.expected("a covariance that its two variances allow");
    }
  return p;
}

/// The stated uncertainties repeat the covariance's diagonal for readers; a file edited in one place only is refused.
void check_uncertainties(const Field& field, const Calibration& calibration) {
  for (const CoefficientIndex i : coefficient_indices()) {
    const Coefficient& c = coefficient(i);
    if (!has_term(field, c)) continue;
    const Field stated = element(field, c.triad, c.term, c.row, c.column);
    const auto computed = standard_uncertainty(calibration, i);
    if (!computed && !stated.is_null()) stated.expected("null: the covariance does not hold " + std::string(c.name));
    if (computed && !(std::abs(stated.number() - *computed) <= 1e-6 * *computed))
      stated.expected(fmt::format("{}, from the covariance of {}", *computed, c.name));
  }
}

PartResidual read_part(const Field& f) { return {f["begin_s"].number(), f["end_s"].number(), f["residual"].number_or_nan(), f["used"].truth()}; }

RequirementResult read_requirement(const Field& f) {
  return {f["requirement"].text(), f["coefficient"].text(), f["limit"].number(), f["reached"].number_or_infinity(), f["met"].truth()};
}

Quality read_quality(const Field& field) {
  Quality q;
  if (field.has("chi2_per_dof")) q.chi2_per_dof = field["chi2_per_dof"].number_or_nan();
  if (field.has("condition")) q.condition = field["condition"].number_or_nan();
  q.unobservable = field.texts("unobservable");
  q.warnings = field.texts("warnings");
  q.verdict = field.text_or_empty("verdict");
  q.because = field.texts("because");
  q.considered = field.texts("considered");
  if (field.has("converged")) q.converged = field["converged"].truth();
  if (field.has("degrees_of_freedom")) q.degrees_of_freedom = field["degrees_of_freedom"].whole_number();
  if (field.has("rotation_residual_deg") && !field["rotation_residual_deg"].is_null())
    q.rotation_residual_deg = field["rotation_residual_deg"].number();
  q.term_tests = field.list("term_tests", [](const Field& f) {
    const auto validation = [&](const char* key) { return f.has(key) && !f[key].is_null() ? f[key].number() : 0.0; };
    return TermTest{f["term"].text(),  f["statistic"].number_or_nan(),      f["degrees_of_freedom"].whole_number(), f["p_value"].number_or_nan(),
                    f["kept"].truth(), validation("cross_validation_with"), validation("cross_validation_without")};
  });
  q.fit_residuals = field.list("fit_residuals", [](const Field& f) {
    return FitResidual{f["axis"].text(), f["rms"].number_or_nan(), f["largest"].number_or_nan(), f["full_scale"].number_or_nan()};
  });
  q.rig_errors = field.list("rig_errors", [](const Field& f) {
    return RigErrorEstimate{f["name"].text(), f["declared_sigma"].number_or_nan(), f["value"].number_or_nan(),
                            f["standard_uncertainty"].number_or_nan()};
  });
  q.sources = field.list("sources", [](const Field& f) {
    return UncertaintySource{f["name"].text(), f["relative"].number_or_nan(), f["consequence"].text()};
  });
  q.notes = field.texts("notes");
  q.rests = field.list("rests", read_part);
  q.rotations = field.list("rotations", read_part);
  q.requirements = field.list("requirements", read_requirement);
  return q;
}

SourceFile read_source(const Field& f) {
  const auto range = [&](const char* key) -> std::optional<std::array<double, 2>> {
    if (!f.has(key) || f[key].is_null()) return std::nullopt;
    return std::array{f[key].item(0, 2, "numbers").number(), f[key].item(1, 2, "numbers").number()};
  };
  return {f["file"].text(),     f["sha256"].text(),         f["bytes"].size_in_bytes(), f["first_s"].number(),
          f["last_s"].number(), range("accel_temperature"), range("gyro_temperature")};
}

/// `raw`: the unit that the model takes.
RecordedAs read_recorded(const Field& f, Quantity quantity, const std::string& raw) {
  RecordedAs out{
      f["unit"].text(), f["counts_per_unit"].number(), f.has("interval_s") && !f["interval_s"].is_null() ? f["interval_s"].number() : 0, {}};
  if (!(out.counts_per_unit > 0)) f["counts_per_unit"].expected("a number above 0");
  if (!(out.interval_s >= 0)) f["interval_s"].expected("a number above 0, or null");
  const std::vector<std::string_view> units = unit_names(quantity, out.interval_s > 0);
  if (std::find(units.begin(), units.end(), out.unit) == units.end()) f["unit"].expected(text::listed(units));
  const bool counts = out.unit == "count";
  if (!raw.empty() && counts != (raw == "count")) f["unit"].expected(fmt::format("what becomes {}, which the model takes", raw));
  if (counts && out.counts_per_unit != 1) f["counts_per_unit"].expected("1 with the unit count");
  std::string seen;
  for (std::size_t i = 0; i < 3; ++i) {
    const Field axis = f["axes"].item(i, 3, "axes");
    out.axes[i] = axis.text();
    if (out.axes[i].size() != 2 || (out.axes[i][0] != '+' && out.axes[i][0] != '-') ||
        std::string_view("xyz").find(out.axes[i][1]) == std::string::npos)
      axis.expected("a body axis from \"+x\" to \"-z\"");
    if (seen.find(out.axes[i][1]) != std::string::npos) axis.expected("an axis that no other column has");
    seen += out.axes[i][1];
  }
  return out;
}

/// The IMU, the recordings and what was used.
void read_origin(const Field& root, Calibration& c, Problems& problems) {
  for (const auto& [key, value] : {std::pair{"imu", &c.imu},
                                   {"method", &c.method},
                                   {"created", &c.created},
                                   {"software", &c.software},
                                   {"serial", &c.serial},
                                   {"operator", &c.operated_by},
                                   {"station", &c.station},
                                   {"measured", &c.measured},
                                   {"firmware", &c.firmware},
                                   {"filter", &c.filter},
                                   {"valid_until", &c.valid_until},
                                   {"warm_up", &c.warm_up},
                                   {"power_cycles", &c.power_cycles}})
    problems.none_in([&root, key = key, value = value] { *value = root.text_or_empty(key); });
  problems.none_in([&] {
    if (!root.has("session")) return;
    c.session_file = root["session"].text_or_empty("file");
    c.session_sha256 = root["session"].text_or_empty("sha256");
  });
  problems.none_in([&] {
    c.references = root.list("references", [](const Field& f) {
      return Reference{f["quantity"].text(), f["instrument"].text(), f["certificate"].text(), f.text_or_empty("date"), f.text_or_empty("statement")};
    });
  });
  problems.none_in([&] { c.sources = root.list("sources", read_source); });
  problems.none_in([&] { c.options = root.text_map("options"); });
}

void read_recorded(const Field& root, Calibration& c, Problems& problems) {
  if (!root.has("recorded")) return;
  const Field recorded = root["recorded"];
  problems.none_in([&] {
    if (recorded.has("accel")) c.recorded_accel = read_recorded(recorded["accel"], Quantity::accel, c.model.accel.raw_unit);
  });
  problems.none_in([&] {
    if (recorded.has("gyro")) c.recorded_gyro = read_recorded(recorded["gyro"], Quantity::gyro, c.model.gyro.raw_unit);
  });
}

/// Without a covariance none is known.
void read_uncertainties(const Field& root, Calibration& c, Problems& problems) {
  const auto given = [&root](const char* key) { return root.has(key) && !root[key].is_null(); };
  const bool read = problems.none_in([&] {
    if (given("covariance")) c.estimated = read_estimated(root["covariance"]["coefficients"]);
    c.covariance = given("covariance") ? read_covariance(root["covariance"]["matrix"], c.estimated.size()) : Eigen::MatrixXd(0, 0);
  });
  problems.none_in([&] {
    if (read && given("standard_uncertainty")) check_uncertainties(root["standard_uncertainty"], c);
  });
}

const std::vector<std::string_view>& known_keys() {
  static const std::vector<std::string_view> keys{"format",
                                                  "imu",
                                                  "method",
                                                  "created",
                                                  "software",
                                                  "serial",
                                                  "operator",
                                                  "station",
                                                  "measured",
                                                  "firmware",
                                                  "filter",
                                                  "valid_until",
                                                  "warm_up",
                                                  "power_cycles",
                                                  "references",
                                                  "session",
                                                  "sources",
                                                  "options",
                                                  "frame",
                                                  "model",
                                                  "recorded",
                                                  "covariance",
                                                  "standard_uncertainty",
                                                  "quality",
                                                  "rig"};
  return keys;
}

void check_format(const Field& root) {
  if (!root.has("format")) root.fail(fmt::format("format: is missing; expected \"{}\"", format_name));
  const std::string format = root["format"].text();
  if (format == format_name) return;
  if (format.starts_with(format_family)) root["format"].fail(fmt::format("{} is a newer format; this program reads {}", format, format_name));
  root["format"].expected(fmt::format("\"{}\"", format_name));
}

}  // namespace

Calibration parse_calibration(std::string_view text, const std::string& file) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) throw Error(file + ": is empty; expected a calibration");
  const Json json = parse_json(text, file, "a calibration");
  const Field root(json, file, "");
  check_format(root);
  Calibration c;
  Problems problems;
  read_origin(root, c, problems);
  problems.none_in([&] {
    c.frame = root.has("frame") ? root["frame"].text() : "rig";
    if (c.frame != "accelerometers" && c.frame != "rig") root["frame"].expected("\"accelerometers\" or \"rig\"");
  });
  problems.none_in([&] { c.model = read_model(root["model"], problems); });
  read_recorded(root, c, problems);
  read_uncertainties(root, c, problems);
  problems.none_in([&] {
    if (root.has("quality")) c.quality = read_quality(root["quality"]);
  });
  expect_known_keys(root, known_keys(), true, problems);
  problems.expect_none();
  return c;
}

Calibration read_calibration(const std::filesystem::path& path) {
  return parse_calibration(MappedFile(path, Content::settings).text(), input_name(path));
}

}  // namespace imulab
