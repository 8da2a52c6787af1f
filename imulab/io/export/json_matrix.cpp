// Matrices and biases as JSON, for programs of one's own: the whole model, in the form in which biases are subtracted from readings.
#include "imulab/io/export/consumer_model.hpp"
#include "imulab/io/export/noise_values.hpp"
#include "imulab/io/export/targets.hpp"
#include "imulab/io/export/write.hpp"
#include "imulab/model/coefficient.hpp"

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
  if (m.thermal.isZero(0) || !m.temperature) return out;
  out["thermal"] = {{"c1", numbers(m.thermal.col(1))},
                    {"c2", numbers(m.thermal.col(2))},
                    {"unit", m.temperature->unit},
                    {"reference", m.temperature->reference},
                    {"range", m.temperature->range}};
  return out;
}

MatrixJson noise_json(const NoiseValue& v) {
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
  MatrixJson out{{"format", "imulab.matrix/1"},
                 {"imu", plain(c.imu)},
                 {"method", plain(c.method)},
                 {"created", plain(c.created)},
                 {"equations",
                  {"V = u - (c1 (T - reference) + c2 (T - reference)^2): u a reading, T the thermal reading of its axis; V = u without \"thermal\"",
                   "specific force = matrix (V - bias) + quadratic V^2 + cubic V^3 of the accelerometers; at rest +g along up",
                   "angular rate = matrix (V - bias - g_sensitivity force) + quadratic V^2 + cubic V^3 of the gyros",
                   "matrices by rows; matrix is the correction, bias is subtracted from readings; absent terms are zero",
                   "standard_uncertainty: of the coefficients of imulab's own model, in SI"}},
                 {"not_held", left_out_of_matrices(input)},
                 {"accelerometers", triad_json(m.accel, c.model.accel, "m/s^2")},
                 {"gyros", triad_json(m.gyro, c.model.gyro, "rad/s")}};
  out["gyros"]["g_sensitivity"] = rows(m.G);
  if (!c.model.lever_arm.isZero(0)) out["accelerometers"]["lever_arm_m"] = rows(c.model.lever_arm);
  out["standard_uncertainty"] = uncertainties_json(c);
  if (input.noise != nullptr) {
    const NoiseValues n = noise_values(input, "json-matrix");
    out["noise"] = {{"rate_hz", n.rate_hz},
                    {"accelerometers", {{"N", noise_json(n.accel_N)}, {"K", noise_json(n.accel_K)}}},
                    {"gyros", {{"N", noise_json(n.gyro_N)}, {"K", noise_json(n.gyro_K)}}}};
  }
  return out.dump(2) + "\n";
}

Sentences left_out_of_matrices(const ExportInput& input) {
  if (input.noise != nullptr) return {};
  return {"noise: not known; give --noise noise.json"};
}

}  // namespace imulab::export_io
