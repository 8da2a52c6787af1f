// Matrices and biases as JSON, for programs of one's own: the whole model, in the form in which biases are subtracted from readings.
#include "imulab/coefficient.hpp"
#include "imulab/export/consumer_model.hpp"
#include "imulab/export/noise_values.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"
#include "imulab/noise/data_sheet.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace imulab::export_io {

namespace {

using MatrixJson = nlohmann::ordered_json;

MatrixJson numbers(const Vector3d& v) { return {v[0], v[1], v[2]}; }
MatrixJson rows(const Matrix3d& m) { return {numbers(m.row(0).transpose()), numbers(m.row(1).transpose()), numbers(m.row(2).transpose())}; }

MatrixJson triad_json(const ConsumerTriad& t, const TriadModel& m, const char* si) {
  MatrixJson out{{"unit_in", m.raw_unit.empty() ? si : m.raw_unit}, {"unit_out", si}, {"matrix", rows(t.C)}, {"bias", numbers(t.b)}};
  if (!m.quadratic.isZero(0)) out["quadratic"] = numbers(m.quadratic);
  if (!m.cubic.isZero(0)) out["cubic"] = numbers(m.cubic);
  if (!m.varies() || !m.temperature) return out;
  out["thermal"] = {{"c1", numbers(m.thermal.col(1))},       {"c2", numbers(m.thermal.col(2))}, {"c3", numbers(m.thermal.col(3))},
                    {"m1", rows(m.matrix_thermal1)},         {"m2", rows(m.matrix_thermal2)},   {"unit", m.temperature->unit},
                    {"reference", m.temperature->reference}, {"range", m.temperature->range}};
  return out;
}

MatrixJson recorded_json(const std::optional<RecordedAs>& recorded) {
  if (!recorded) return nullptr;
  return {{"unit", plain(recorded->unit)},
          {"counts_per_unit", recorded->counts_per_unit},
          {"interval_s", recorded->interval_s},
          {"axes", {plain(recorded->axes[0]), plain(recorded->axes[1]), plain(recorded->axes[2])}}};
}

MatrixJson finite_json(double value) { return std::isfinite(value) ? MatrixJson(value) : MatrixJson(nullptr); }

MatrixJson coefficient_json(const NoiseCoefficient& c, bool assumed = false) {
  return {{"value", finite_json(c.value)},
          {"standard_uncertainty", finite_json(c.standard_uncertainty)},
          {"interval", {finite_json(c.lower), finite_json(c.upper)}},
          {"determined", c.determined},
          {c.bounded && assumed ? "assumed" : "bounded", c.bounded}};
}

/// Every term of every axis, null for an axis without noise.
MatrixJson axes_json(const std::array<std::optional<NoiseCoefficients>, 3>& axes) {
  MatrixJson out = MatrixJson::array();
  for (const auto& axis : axes) {
    if (!axis) {
      out.push_back(nullptr);
      continue;
    }
    MatrixJson terms = MatrixJson::object();
    for (const NoiseTerm& term : noise_terms()) terms[term.name] = coefficient_json((*axis).*(term.coefficient), has_assumed_bounds(*axis));
    terms["markov"] = MatrixJson::array();
    for (const MarkovTerm& m : axis->markov)
      terms["markov"].push_back(MatrixJson{{"sigma", coefficient_json(m.sigma)}, {"time_s", coefficient_json(m.time)}});
    out.push_back(terms);
  }
  return out;
}

MatrixJson noise_json(const NoiseValue& v) {
  if (v.missing) return nullptr;
  MatrixJson axes = MatrixJson::array();
  for (const double axis : v.axes) axes.push_back(std::isfinite(axis) ? MatrixJson(axis) : MatrixJson(nullptr));
  return {{"value", v.value}, {"axes", axes}, {"comment", v.comment}};
}

MatrixJson uncertainties_json(const Calibration& c) {
  MatrixJson out = MatrixJson::object();
  for (const CoefficientIndex index : c.estimated) out[std::string(coefficient(index).name)] = *standard_uncertainty(c, index);
  return out;
}

}  // namespace

std::string json_matrix_text(const ExportInput& input) {
  const Calibration& c = input.calibration;
  const ConsumerModel m = consumer_model(c.model);
  MatrixJson out{
      {"format", "imulab.matrix/1"},
      {"imu", plain(c.imu)},
      {"method", plain(c.method)},
      {"created", plain(c.created)},
      {"frame", std::string(to_string(c.frame))},
      {"equations",
       {"V = u - (c1 tau + c2 tau^2 + c3 tau^3), tau = T - reference: u a reading along the body axis, T the thermal reading of its axis, not "
        "beyond the range; V = u without \"thermal\"",
        "specific force = S (matrix (V - bias) + quadratic V^2 + cubic V^3) of the accelerometers; at rest +g along up",
        "angular rate = S (matrix (V - bias) + quadratic V^2 + cubic V^3) - matrix g_sensitivity force of the gyros",
        "S = identity + m1 tau + m2 tau^2, tau of the row's axis",
        "matrices by rows; matrix is the correction, bias is subtracted from readings; absent terms are zero",
        "units: of bias, c1, c2 and c3 unit_in; of m1 and m2 1; of matrix unit_out / unit_in; of g_sensitivity unit_in / (m/s^2)",
        "recorded: how the recording had the readings: column j times unit / counts_per_unit (/ interval_s) is u along axes[j]; null: not known",
        "standard_uncertainty: of the coefficients of imulab's own model, outputs in SI, readings in unit_in; not_determined: starting values",
        "noise: axes have every term of x, y, z with its interval of 95 %"}},
      {"not_determined", not_determined(c)},
      {"not_held", left_out_of_matrices(input)},
      {"accelerometers", triad_json(m.accel, c.model.accel, "m/s^2")},
      {"gyros", triad_json(m.gyro, c.model.gyro, "rad/s")}};
  out["accelerometers"]["recorded"] = recorded_json(c.recorded_accel);
  out["gyros"]["recorded"] = recorded_json(c.recorded_gyro);
  out["gyros"]["g_sensitivity"] = rows(m.G);
  if (!c.model.lever_arm.isZero(0)) out["accelerometers"]["lever_arm_m"] = rows(c.model.lever_arm);
  out["standard_uncertainty"] = uncertainties_json(c);
  if (input.noise != nullptr) {
    const NoiseValues n = noise_values(input, "json-matrix");
    out["noise"] = {{"rate_hz", n.stream_rate_hz ? MatrixJson(*n.stream_rate_hz) : MatrixJson(nullptr)},
                    {"accelerometers", {{"N", noise_json(n.accel_N)}, {"K", noise_json(n.accel_K)}, {"axes", axes_json(input.noise->accel)}}},
                    {"gyros", {{"N", noise_json(n.gyro_N)}, {"K", noise_json(n.gyro_K)}, {"axes", axes_json(input.noise->gyro)}}}};
  }
  return out.dump(2, ' ', false, MatrixJson::error_handler_t::replace) + "\n";  // a name may be any bytes
}

Sentences left_out_of_matrices(const ExportInput& input) {
  Sentences out;
  if (input.calibration.estimated.size() > 1) out.emplace_back("the correlations of the coefficients' uncertainties");
  if (input.noise == nullptr) out.emplace_back("noise: not known, since no noise.json was given");
  return out;
}

}  // namespace imulab::export_io
