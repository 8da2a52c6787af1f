// One sensor model for every method: raw output -> specific force and angular rate, 63 coefficients (Dai 2011 eqs 1-4, doi:10.3788/OPE.20111907.1620)
// and lever arms.
//
//   V = U - (c1 tau + c2 tau^2)                      per axis, tau = T - T0; the constant c0 is zero by the gauge
//   a = A0 + A1 Va + A2 Va^2 + A3 Va^3               A1 full, A2 and A3 diagonal
//   w = W0 + W1 Vg + W2 Vg^2 + W3 Vg^3 + C a         C: the gyros' g-sensitivity
//
// Example:
//   SensorModel model;  // the ideal unit: output is input
//   model.gyro.offset = {1e-3, 0, 0};
//   const Motion motion = compensate(model, RawSample{.gyro = {0, 0, 0}, .accel = {0, 0, 9.81}});
//
// Units: out is m/s^2 (accelerometers) or rad/s (gyros), raw the unit of the recording: SI, or counts. Axes are the body's (frame.hpp). A plain
// value: copies are independent, and const use is safe on any thread.
#pragma once

#include "imulab/eigen.hpp"

#include <array>
#include <optional>
#include <string>

namespace imulab {

/// A triad's thermal reading: its unit, the T0 of the model, and the range of the calibration.
struct ThermalReading {
  std::string unit = "degC";  ///< "degC", "K" or "raw" (for instance a gyro's resonance frequency)
  double reference = 0;       ///< T0
  std::array<double, 2> range{0, 0};
  bool operator==(const ThermalReading&) const = default;
};

/// Polynomial part of one triad. Units: out = m/s^2 (accelerometers) or rad/s (gyros), raw = the recording's unit.
struct TriadModel {
  Vector3d offset = Vector3d::Zero();              ///< A0, W0: out
  Matrix3d matrix = Matrix3d::Identity();          ///< A1, W1: out/raw
  Vector3d quadratic = Vector3d::Zero();           ///< diagonal of A2, W2: out/raw^2
  Vector3d cubic = Vector3d::Zero();               ///< diagonal of A3, W3: out/raw^3
  Matrix3d thermal = Matrix3d::Zero();             ///< row i: c0 = 0, c1 [raw/K], c2 [raw/K^2] of axis i
  std::string raw_unit = {};                       ///< unit of the model's input: "count", "rad/s", "m/s^2"; empty: not stated
  std::optional<ThermalReading> temperature = {};  ///< absent: the session had no thermal reading
};

struct SensorModel {
  TriadModel gyro, accel;
  Matrix3d g_sensitivity = Matrix3d::Zero();  ///< C: (rad/s)/(m/s^2)
  Matrix3d lever_arm = Matrix3d::Zero();      ///< row i: position of accelerometer i's sensitive point, m
};

}  // namespace imulab
