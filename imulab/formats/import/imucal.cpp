// imucal's JSON (mad-lab-fau/imucal: imucal/calibration_info.py, ferraris_calibration_info.py) and imulab's own json-matrix.
#include "imulab/coefficient.hpp"
#include "imulab/formats/import/numbers.hpp"
#include "imulab/formats/text/json.hpp"
#include "imulab/recording/unit_names.hpp"
#include "imulab/units.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab::import_io {

namespace {

using json_io::Field, json_io::Keys, json_io::parse_json;

Vector3d vector_field(const Field& f) {
  Vector3d v;
  for (std::size_t i = 0; i < 3; ++i) v[static_cast<Eigen::Index>(i)] = f.item(i, 3, "numbers").number();
  return v;
}

Matrix3d matrix_field(const Field& f) {
  Matrix3d m;
  for (std::size_t i = 0; i < 3; ++i) m.row(static_cast<Eigen::Index>(i)) = vector_field(f.item(i, 3, "rows of 3 numbers")).transpose();
  return m;
}

struct UnitOfText {
  double si;  ///< one of it in SI; 1 for counts
  bool count, known;
};

/// imucal's units are free text; those that it writes and its users give. A unit that is not given: not known.
UnitOfText imucal_unit(const Field& root, const char* key) {
  if (!root.has(key) || root[key].is_null()) return {1, false, false};
  const std::string unit = root[key].text();
  if (unit == "m/s^2" || unit == "m/s2" || unit == "m/s**2" || unit == "rad/s") return {1, false, true};
  if (unit == "deg/s" || unit == "dps") return {unit::deg, false, true};
  if (unit == "g") return {unit::g, false, true};
  if (unit == "a.u." || unit == "count" || unit == "counts" || unit == "LSB") return {1, true, true};
  root[key].expected("m/s^2, g, rad/s, deg/s or a.u.");
}

/// Reads `recorded` of a triad as a calibration file has it.
std::optional<RecordedAs> recorded_field(const Field& triad, Quantity quantity, const std::string& raw) {
  if (!triad.has("recorded") || triad["recorded"].is_null()) return std::nullopt;
  const Field f = triad["recorded"];
  RecordedAs out{f["unit"].text(), f["counts_per_unit"].number(), f["interval_s"].number(), {}};
  const std::vector<std::string_view> units = unit_names(quantity, out.interval_s > 0);
  if (std::find(units.begin(), units.end(), out.unit) == units.end() || (out.unit == "count") != (raw == "count"))
    f["unit"].expected("a unit of what becomes " + raw);
  if (!(out.counts_per_unit > 0) || (out.unit == "count" && out.counts_per_unit != 1)) f["counts_per_unit"].expected("a number above 0; 1 for count");
  if (!(out.interval_s >= 0)) f["interval_s"].expected("a number from 0 on");
  std::string seen;
  for (std::size_t i = 0; i < 3; ++i) {
    out.axes[i] = f["axes"].item(i, 3, "axes").text();
    const std::string& axis = out.axes[i];
    if (axis.size() != 2 || std::string_view("+-").find(axis[0]) == std::string_view::npos ||
        std::string_view("xyz").find(axis[1]) == std::string_view::npos || seen.find(axis[1]) != std::string::npos)
      f["axes"].expected("three body axes from \"+x\" to \"-z\", each once");
    seen += axis[1];
  }
  return out;
}

std::vector<std::string> coefficient_names(const Field& list) {
  std::vector<std::string> out = list.texts();
  for (const std::string& name : out)
    if (std::none_of(coefficient_table().begin(), coefficient_table().end(), [&](const Coefficient& c) { return c.name == name; }))
      list.expected("names of coefficients, such as gyro.matrix.xy");
  return out;
}

}  // namespace

bool is_imucal(std::string_view text) {
  return text.find_first_not_of(" \t\r\n") != std::string_view::npos && text[text.find_first_not_of(" \t\r\n")] == '{' &&
         (text.find("\"cal_type\"") != std::string_view::npos || text.find("\"K_a\"") != std::string_view::npos);
}
bool is_json_matrix(std::string_view text) { return text.find("\"imulab.matrix/") != std::string_view::npos; }

ImportedModel read_imucal(const Source& s) {
  const JsonValue json = parse_json(s.text, s.file, "a calibration of imucal", Keys::once);
  const Field root(json, s.file, "");
  const Matrix3d C_a = inverse_at(s, 0, "K_a R_a", matrix_field(root["K_a"]) * matrix_field(root["R_a"]));
  const Matrix3d C_g = inverse_at(s, 0, "K_g R_g", matrix_field(root["K_g"]) * matrix_field(root["R_g"]));
  const Vector3d b_a = vector_field(root["b_a"]), b_g = vector_field(root["b_g"]);
  ImportedModel out;
  const auto made_in = [&](const char* key, const char* initial) {
    const UnitOfText unit = imucal_unit(root, key);
    if (unit.known) return unit;
    out.warnings.push_back(fmt::format("{} is not given: taken as {}, imucal's own", key, initial));
    return UnitOfText{std::string_view(initial) == "deg/s" ? unit::deg : 1, false, true};
  };
  const UnitOfText accel = made_in("acc_unit", "m/s^2"), gyro = made_in(root.has("gyro_unit") ? "gyro_unit" : "gyr_unit", "deg/s");
  UnitOfText accel_raw = imucal_unit(root, "from_acc_unit"), gyro_raw = imucal_unit(root, "from_gyr_unit");
  for (const auto& [raw, made, C, name] :
       {std::tuple{&accel_raw, &accel, &C_a, "from_acc_unit"}, std::tuple{&gyro_raw, &gyro, &C_g, "from_gyr_unit"}}) {
    if (raw->known) continue;
    const double scale = std::cbrt(std::abs(C->determinant()));
    const bool same = scale >= 0.5 && scale <= 2;
    *raw = same ? *made : UnitOfText{1, true, true};
    out.warnings.push_back(fmt::format("{} is not given: the readings are taken to be {}, because their scale is {:.3g}", name,
                                       same ? "in the unit of the result" : "counts", scale));
  }
  // acc = (K_a R_a)^-1 (u - b_a);  gyr = (K_g R_g)^-1 (u - b_g - K_ga acc), each in the file's units; readings in imulab are in SI or counts.
  SensorModel& m = out.model;
  m.accel.matrix = C_a * (accel.si / accel_raw.si);
  m.accel.offset = -C_a * b_a * accel.si;
  m.gyro.matrix = C_g * (gyro.si / gyro_raw.si);
  m.gyro.offset = -C_g * b_g * gyro.si;
  m.g_sensitivity = -C_g * matrix_field(root["K_ga"]) * (gyro.si / accel.si);
  m.accel.raw_unit = accel_raw.count ? "count" : "m/s^2";
  m.gyro.raw_unit = gyro_raw.count ? "count" : "rad/s";
  return out;
}

ImportedModel read_json_matrix(const Source& s) {
  const JsonValue json = parse_json(s.text, s.file, "matrices", Keys::once);
  const Field root(json, s.file, "");
  if (root["format"].text() != "imulab.matrix/1") root["format"].expected("\"imulab.matrix/1\"");
  ImportedModel out;
  for (auto& [triad, name] : {std::pair{&out.model.accel, "accelerometers"}, std::pair{&out.model.gyro, "gyros"}}) {
    const Field f = root[name];
    triad->matrix = matrix_field(f["matrix"]);
    triad->offset = -triad->matrix * vector_field(f["bias"]);
    if (f.has("quadratic")) triad->quadratic = vector_field(f["quadratic"]);
    if (f.has("cubic")) triad->cubic = vector_field(f["cubic"]);
    triad->raw_unit = f["unit_in"].text();
    if (triad->raw_unit != "count" && triad->raw_unit != "m/s^2" && triad->raw_unit != "rad/s") f["unit_in"].expected("count, m/s^2 or rad/s");
    if (!f.has("thermal")) continue;
    const Field t = f["thermal"];
    triad->thermal.col(1) = vector_field(t["c1"]);
    triad->thermal.col(2) = vector_field(t["c2"]);
    if (t.has("c3")) triad->thermal.col(3) = vector_field(t["c3"]);
    if (t.has("m1")) triad->matrix_thermal1 = matrix_field(t["m1"]);
    if (t.has("m2")) triad->matrix_thermal2 = matrix_field(t["m2"]);
    triad->temperature = ThermalReading{
        t["unit"].text(), t["reference"].number(), {t["range"].item(0, 2, "numbers").number(), t["range"].item(1, 2, "numbers").number()}};
    if (triad->temperature->unit != "degC" && triad->temperature->unit != "K" && triad->temperature->unit != "raw")
      t["unit"].expected("degC, K or raw");
    if (triad->temperature->range[0] > triad->temperature->range[1]) t["range"].expected("[lowest, highest]");
  }
  out.model.g_sensitivity = -out.model.gyro.matrix * matrix_field(root["gyros"]["g_sensitivity"]);
  out.recorded_accel = recorded_field(root["accelerometers"], Quantity::accel, out.model.accel.raw_unit);
  out.recorded_gyro = recorded_field(root["gyros"], Quantity::gyro, out.model.gyro.raw_unit);
  if (root.has("not_determined")) out.not_determined = coefficient_names(root["not_determined"]);
  if (root["accelerometers"].has("lever_arm_m")) out.model.lever_arm = matrix_field(root["accelerometers"]["lever_arm_m"]);
  return out;
}

}  // namespace imulab::import_io
