// Calibration -> JSON text, easy to read: one row of numbers per line.
#include "imulab/core/error.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/json_dump.hpp"
#include "imulab/model/coefficient.hpp"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace imulab {

namespace {

using Json = nlohmann::ordered_json;

/// Every coefficient's `value(index)` where the file has it: {"accel": {"offset": [..], "matrix": [[..]..], ..}, "gyro": {..}}.
template <class Value>
Json shaped(Value value) {
  Json out;
  for (const CoefficientIndex i : coefficient_indices()) {
    const Coefficient& c = coefficient(i);
    const auto row = static_cast<std::size_t>(c.row), column = static_cast<std::size_t>(c.column);
    Json& term = out[std::string(to_string(c.triad))][std::string(to_string(c.term))];
    (is_vector(c.term) ? term[row] : term[row][column]) = value(i);
  }
  return out;
}

Json temperature_json(const std::optional<ThermalReading>& t) {
  if (!t) return nullptr;
  return {{"unit", t->unit}, {"reference", t->reference}, {"range", t->range}};
}

Json model_json(const SensorModel& model) {
  Json out = shaped([&](CoefficientIndex i) {
    const double value = coefficient_value(model, i);
    if (!std::isfinite(value)) throw Error(std::string(coefficient(i).name) + " is not finite; expected a finite number");
    return value;
  });
  for (const char* triad : {"accel", "gyro"}) {
    for (auto& row : out[triad]["thermal"]) row[0] = 0.0;  // the gauge
    const TriadModel& m = triad == std::string_view("accel") ? model.accel : model.gyro;
    if (!m.raw_unit.empty()) out[triad]["raw"] = m.raw_unit;
    out[triad]["temperature"] = temperature_json(m.temperature);
  }
  return out;
}

Json uncertainty_json(const Calibration& calibration) {
  return shaped([&](CoefficientIndex i) {
    const auto u = standard_uncertainty(calibration, i);
    return u ? Json(*u) : Json(nullptr);
  });
}

Json covariance_json(const Calibration& calibration) {
  Json names = Json::array(), matrix = Json::array();
  for (const CoefficientIndex i : calibration.estimated) names.push_back(coefficient(i).name);
  for (Eigen::Index i = 0; i < calibration.covariance.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < calibration.covariance.cols(); ++j) row.push_back(calibration.covariance(i, j));
    matrix.push_back(std::move(row));
  }
  return {{"coefficients", std::move(names)}, {"matrix", std::move(matrix)}};
}

template <class Value>
Json or_null(const std::optional<Value>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json text_or_null(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }

Json parts_json(const std::vector<PartResidual>& parts) {
  Json out = Json::array();
  for (const PartResidual& p : parts) out.push_back({{"begin_s", p.begin_s}, {"end_s", p.end_s}, {"residual", p.residual}, {"used", p.used}});
  return out;
}

Json requirements_json(const std::vector<RequirementResult>& requirements) {
  Json out = Json::array();
  for (const RequirementResult& r : requirements)  // an infinite number is null
    out.push_back({{"requirement", r.text}, {"coefficient", r.coefficient}, {"limit", r.limit}, {"reached", r.reached}, {"met", r.met}});
  return out;
}

Json sources_json(const std::vector<SourceFile>& sources) {
  Json out = Json::array();
  for (const SourceFile& s : sources)
    out.push_back({{"file", s.file},
                   {"sha256", s.sha256},
                   {"bytes", s.bytes},
                   {"first_s", s.first_s},
                   {"last_s", s.last_s},
                   {"accel_temperature", or_null(s.accel_temperature)},
                   {"gyro_temperature", or_null(s.gyro_temperature)}});
  return out;
}

Json references_json(const std::vector<Reference>& references) {
  Json out = Json::array();
  for (const Reference& r : references)
    out.push_back({{"quantity", r.quantity},
                   {"instrument", r.instrument},
                   {"certificate", r.certificate},
                   {"date", text_or_null(r.date)},
                   {"statement", text_or_null(r.statement)}});
  return out;
}

Json number_or_null(double value) { return value == 0 ? Json(nullptr) : Json(value); }

Json quality_json(const Quality& q) {
  Json tests = Json::array(), sources = Json::array();
  for (const auto& t : q.term_tests)
    tests.push_back({{"term", t.term},
                     {"statistic", t.statistic},
                     {"degrees_of_freedom", t.degrees_of_freedom},
                     {"p_value", t.p_value},
                     {"kept", t.kept},
                     {"cross_validation_with", number_or_null(t.cross_validation_with)},
                     {"cross_validation_without", number_or_null(t.cross_validation_without)}});
  Json residuals = Json::array(), rig = Json::array();
  for (const auto& r : q.fit_residuals) residuals.push_back({{"axis", r.axis}, {"rms", r.rms}, {"largest", r.largest}, {"full_scale", r.full_scale}});
  for (const auto& e : q.rig_errors)
    rig.push_back({{"name", e.name}, {"declared_sigma", e.declared_sigma}, {"value", e.value}, {"standard_uncertainty", e.uncertainty}});
  for (const auto& s : q.sources) sources.push_back({{"name", s.name}, {"relative", s.relative}, {"consequence", s.consequence}});
  return {{"chi2_per_dof", q.chi2_per_dof},
          {"degrees_of_freedom", q.degrees_of_freedom},
          {"condition", q.condition},
          {"converged", q.converged},
          {"unobservable", q.unobservable},
          {"warnings", q.warnings},
          {"verdict", q.verdict},
          {"because", q.because},
          {"requirements", requirements_json(q.requirements)},
          {"considered", q.considered},
          {"rotation_residual_deg", or_null(q.rotation_residual_deg)},
          {"term_tests", std::move(tests)},
          {"sources", std::move(sources)},
          {"fit_residuals", std::move(residuals)},
          {"rig_errors", std::move(rig)},
          {"rests", parts_json(q.rests)},
          {"rotations", parts_json(q.rotations)},
          {"notes", q.notes}};
}

/// Objects and lists of lists one element a line, plain lists on one line.
std::string layout(const Json& value, const std::string& indent) {
  const bool plain = std::none_of(value.begin(), value.end(), [](const Json& v) { return v.is_structured(); });
  if (!value.is_structured() || value.empty()) return dump_json(value, -1);
  const bool one_line = value.is_array() && plain;
  const std::string inner = indent + "  ", separator = one_line ? ", " : ",\n" + inner;
  std::string out;
  for (const auto& item : value.items()) {
    if (!out.empty()) out += separator;
    if (value.is_object()) out += dump_json(Json(item.key()), -1) + ": ";
    out += layout(item.value(), inner);
  }
  const std::string brackets = value.is_array() ? "[]" : "{}";
  if (one_line) return fmt::format("{}{}{}", brackets[0], out, brackets[1]);
  return fmt::format("{}\n{}{}\n{}{}", brackets[0], inner, out, indent, brackets[1]);
}

Json recorded_json(const RecordedAs& r) {
  return {{"unit", r.unit}, {"counts_per_unit", r.counts_per_unit}, {"interval_s", number_or_null(r.interval_s)}, {"axes", r.axes}};
}

Json calibration_json(const Calibration& c) {
  Json out{{"format", "imulab.calibration/1"},
           {"imu", c.imu},
           {"serial", text_or_null(c.serial)},
           {"operator", text_or_null(c.operated_by)},
           {"station", text_or_null(c.station)},
           {"measured", text_or_null(c.measured)},
           {"firmware", text_or_null(c.firmware)},
           {"filter", text_or_null(c.filter)},
           {"valid_until", text_or_null(c.valid_until)},
           {"warm_up", text_or_null(c.warm_up)},
           {"power_cycles", text_or_null(c.power_cycles)},
           {"references", references_json(c.references)},
           {"method", c.method},
           {"created", c.created},
           {"software", c.software},
           {"session", {{"file", c.session_file}, {"sha256", c.session_sha256}}},
           {"sources", sources_json(c.sources)},
           {"options", c.options},
           {"frame", c.frame},
           {"model", model_json(c.model)},
           {"standard_uncertainty", uncertainty_json(c)},
           {"covariance", covariance_json(c)},
           {"quality", quality_json(c.quality)}};
  if (c.recorded_accel) out["recorded"]["accel"] = recorded_json(*c.recorded_accel);
  if (c.recorded_gyro) out["recorded"]["gyro"] = recorded_json(*c.recorded_gyro);
  return out;
}

}  // namespace

std::string calibration_text(const Calibration& c) { return layout(calibration_json(c), "") + "\n"; }

void write_calibration(const std::filesystem::path& path, const Calibration& c) { write_whole(path, calibration_text(c)); }

std::string truth_text(const Calibration& c, const std::vector<RecordedRigErrors>& rig) {
  Json json = calibration_json(c);
  for (const auto& [recording, errors] : rig) {
    Json& values = json["rig"][recording] = Json::object();
    for (std::size_t i = 0; i < errors.sources.size(); ++i) values[errors.sources[i].name()] = errors.values[i];
  }
  return layout(json, "") + "\n";
}

}  // namespace imulab
