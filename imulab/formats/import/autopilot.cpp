// Parameters of PX4 and ArduPilot (equations and names as in imulab/export/px4.cpp and ardupilot.cpp).
#include "imulab/formats/import/numbers.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace imulab::import_io {

namespace {

struct Parameter {
  int line = 0;
  double value = 0;
};
using Parameters = std::map<std::string, Parameter, std::less<>>;

/// Lines "1 1 NAME VALUE TYPE", "NAME,VALUE", "NAME VALUE" or "NAME=VALUE". Values of parameters that are not asked for need be no numbers.
Parameters parameters_of(const Source& s, std::string_view prefix, std::string_view thermal_prefix) {
  Parameters out;
  for (const Line& line : lines_of(s.text)) {
    const auto words = words_of(line.text, " \t\r,=");
    const auto found =
        std::find_if(words.begin(), words.end(), [&](std::string_view word) { return word.starts_with(prefix) || word.starts_with(thermal_prefix); });
    if (found == words.end()) continue;
    const auto name = static_cast<std::size_t>(found - words.begin());
    if (!(words.size() == 2 && name == 0) && !(words.size() == 5 && name == 2))
      fail_at(s, line.number,
              fmt::format("{}: expected NAME,VALUE, or five columns with name and value in the third and fourth", excerpt(line.text)));
    const auto value = finite_number(words[name + 1]);
    if (!value) fail_at(s, line.number, fmt::format("{}: expected a number, found \"{}\"", excerpt(words[name]), excerpt(words[name + 1])));
    if (!out.try_emplace(std::string(words[name]), Parameter{line.number, *value}).second)
      fail_at(s, line.number, fmt::format("{}: is given twice; expected each parameter once", excerpt(words[name])));
  }
  return out;
}

double value_of(const Source& s, const Parameters& parameters, const std::string& name) {
  const auto found = parameters.find(name);
  if (found == parameters.end()) fail_at(s, 0, name + ": is missing; expected a parameter file with it");
  return found->second.value;
}
double value_or(const Parameters& parameters, const std::string& name, double otherwise) {
  const auto found = parameters.find(name);
  return found == parameters.end() ? otherwise : found->second.value;
}

/// d(T) = c0 + c1 d + c2 d^2 + c3 d^3 of the readings, d = T - reference.
struct Cubic {
  Vector3d c0 = Vector3d::Zero(), c1 = Vector3d::Zero(), c2 = Vector3d::Zero(), c3 = Vector3d::Zero();
};

/// Biases b at the reference.
void set_triad(TriadModel& m, const Vector3d& scale, const Vector3d& b, const Cubic& drift, const ThermalReading& temperature) {
  m.matrix = scale.asDiagonal();
  m.offset = -scale.cwiseProduct(b + drift.c0);
  m.thermal << Vector3d::Zero(), drift.c1, drift.c2, drift.c3;
  if (!m.thermal.isZero(0)) m.temperature = temperature;
}

void name_units(SensorModel& m) {
  m.accel.raw_unit = "m/s^2";
  m.gyro.raw_unit = "rad/s";
}

void expect_range(const Source& s, const std::string& name, double low, double high) {
  if (!(high > low)) fail_at(s, 0, fmt::format("{}TMIN, {}TMAX: {:g} to {:g}; expected a range of temperatures", name, name, low, high));
}

/// PX4's TC_A0_..., TC_G0_...
Cubic px4_drift(const Source& s, const Parameters& p, const std::string& group, ThermalReading& temperature) {
  Cubic out;
  if (value_or(p, group + "_ENABLE", 0) == 0) return out;
  const std::string name = fmt::format("{}{}_", group, s.instance);
  temperature = {"degC", value_of(s, p, name + "TREF"), {value_of(s, p, name + "TMIN"), value_of(s, p, name + "TMAX")}};
  expect_range(s, name, temperature.range[0], temperature.range[1]);
  for (int axis = 0; axis < 3; ++axis) {
    out.c0[axis] = value_of(s, p, fmt::format("{}X0_{}", name, axis));
    out.c1[axis] = value_of(s, p, fmt::format("{}X1_{}", name, axis));
    out.c2[axis] = value_of(s, p, fmt::format("{}X2_{}", name, axis));
    out.c3[axis] = value_of(s, p, fmt::format("{}X3_{}", name, axis));
  }
  return out;
}

/// ArduPilot's INS_TCAL1_...: P(T) - P(Tcal), P about 35 degC, written about Tcal.
Cubic ardupilot_drift(const Source& s, const Parameters& p, const char* triad, ThermalReading& temperature) {
  Cubic out;
  const std::string name = fmt::format("INS_TCAL{}_", s.instance + 1);
  if (value_or(p, name + "ENABLE", 0) != 1) return out;
  constexpr double about = 35, scale = 1e-6, not_set = -300;
  temperature = {"degC", 0, {value_of(s, p, name + "TMIN"), value_of(s, p, name + "TMAX")}};
  expect_range(s, name, temperature.range[0], temperature.range[1]);
  temperature.reference =
      std::clamp(value_or(p, fmt::format("INS_{}{}_CALTEMP", triad, s.instance + 1), not_set), temperature.range[0], temperature.range[1]);
  const double e = temperature.reference - about;
  for (int axis = 0; axis < 3; ++axis) {
    const auto c = [&](int power) { return scale * value_of(s, p, fmt::format("{}{}{}_{}", name, triad, power, "XYZ"[axis])); };
    out.c1[axis] = c(1) + 2 * c(2) * e + 3 * c(3) * e * e;
    out.c2[axis] = c(2) + 3 * c(3) * e;
    out.c3[axis] = c(3);
  }
  return out;
}

bool names_parameter(std::string_view text, std::string_view prefix) {
  for (const Line& line : lines_of(text))
    for (const std::string_view word : words_of(line.text, " \t\r,="))
      if (word.starts_with(prefix)) return true;
  return false;
}

}  // namespace

bool is_px4(std::string_view text) { return names_parameter(text, "CAL_ACC") || names_parameter(text, "CAL_GYRO"); }
bool is_ardupilot(std::string_view text) { return names_parameter(text, "INS_ACC") || names_parameter(text, "INS_GYR"); }

ImportedModel read_px4(const Source& s) {
  const Parameters p = parameters_of(s, "CAL_", "TC_");
  ImportedModel out;
  name_units(out.model);
  const auto xyz = [&](const char* sensor, const char* tail) {
    const auto at = [&](char axis) { return value_of(s, p, fmt::format("CAL_{}{}_{}{}", sensor, s.instance, axis, tail)); };
    return Vector3d(at('X'), at('Y'), at('Z'));
  };
  ThermalReading accel_temperature, gyro_temperature;
  const Cubic accel = px4_drift(s, p, "TC_A", accel_temperature), gyro = px4_drift(s, p, "TC_G", gyro_temperature);
  set_triad(out.model.accel, xyz("ACC", "SCALE"), xyz("ACC", "OFF"), accel, accel_temperature);
  set_triad(out.model.gyro, Vector3d::Ones(), xyz("GYRO", "OFF"), gyro, gyro_temperature);
  return out;
}

ImportedModel read_ardupilot(const Source& s) {
  const Parameters p = parameters_of(s, "INS_", "INS_");
  ImportedModel out;
  name_units(out.model);
  const auto xyz = [&](const char* triad, const char* tail) {
    const auto at = [&](char axis) {
      return value_of(s, p, fmt::format("INS_{}{}{}_{}", triad, s.instance == 0 ? "" : std::to_string(s.instance + 1), tail, axis));
    };
    return Vector3d(at('X'), at('Y'), at('Z'));
  };
  ThermalReading accel_temperature, gyro_temperature;
  const Cubic accel = ardupilot_drift(s, p, "ACC", accel_temperature), gyro = ardupilot_drift(s, p, "GYR", gyro_temperature);
  set_triad(out.model.accel, xyz("ACC", "SCAL"), xyz("ACC", "OFFS"), accel, accel_temperature);
  set_triad(out.model.gyro, Vector3d::Ones(), xyz("GYR", "OFFS"), gyro, gyro_temperature);
  return out;
}

}  // namespace imulab::import_io
