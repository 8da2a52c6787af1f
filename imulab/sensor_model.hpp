// The sensor model of all methods, from raw output to specific force and angular rate: 63 coefficients (Dai 2011 eqs 1-4,
// doi:10.3788/OPE.20111907.1620), lever arms, and more terms over temperature.
//
//   V = U - (c1 tau + c2 tau^2 + c3 tau^3)           per axis, tau = T - T0 within the calibrated range; c0 is zero by the gauge
//   a = S (A0 + A1 Va + A2 Va^2 + A3 Va^3)           A1 full, A2 and A3 diagonal; S = I + M1 tau + M2 tau^2, tau of the row's axis
//   w = S (W0 + W1 Vg + W2 Vg^2 + W3 Vg^3) + C a     C: the gyros' g-sensitivity
//
// Example:
//   SensorModel model;  // the ideal unit: output is input
//   model.gyro.offset = {1e-3, 0, 0};
//   const Motion motion = compensate(model, RawSample{.gyro = {0, 0, 0}, .accel = {0, 0, 9.81}});
//
// Units: out is m/s^2 (accelerometers) or rad/s (gyros); raw is the unit of the recording, SI or counts. Axes are body axes (frame.hpp). Types are
// plain values: copies are independent, and const use is safe on any thread.
#pragma once

#include "imulab/eigen.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string>

namespace imulab {

/// A triad's thermal reading: unit, reference T0 of the model, and calibrated range.
struct ThermalReading {
  std::string unit = "degC";          ///< "degC", "K" or "raw" (for instance a gyro's resonance frequency)
  double reference = 0;               ///< T0
  std::array<double, 2> range{0, 0};  ///< 0, 0: unknown
  bool has_range() const { return range[0] != 0 || range[1] != 0; }
  /// Returns tau of a temperature. Outside the calibrated range the thermal terms keep their values at its limit; NaN remains NaN.
  double tau(double temperature) const { return (has_range() ? std::clamp(temperature, range[0], range[1]) : temperature) - reference; }
  bool operator==(const ThermalReading&) const = default;
};

/// Thermal coefficients: a row per axis, a column per power.
using Thermal = Eigen::Matrix<double, 3, 4>;

/// The polynomial of one triad. Units: out = m/s^2 (accelerometers) or rad/s (gyros), raw = unit of the recording.
struct TriadModel {
  Vector3d offset = Vector3d::Zero();              ///< A0, W0: out
  Matrix3d matrix = Matrix3d::Identity();          ///< A1, W1: out/raw
  Vector3d quadratic = Vector3d::Zero();           ///< diagonal of A2, W2: out/raw^2
  Vector3d cubic = Vector3d::Zero();               ///< diagonal of A3, W3: out/raw^3
  Thermal thermal = Thermal::Zero();               ///< row i: c0 = 0, c1 [raw/K], c2 [raw/K^2], c3 [raw/K^3] of axis i
  Matrix3d matrix_thermal1 = Matrix3d::Zero();     ///< M1: 1/K
  Matrix3d matrix_thermal2 = Matrix3d::Zero();     ///< M2: 1/K^2
  std::string raw_unit = {};                       ///< unit of the model's input: "count", "rad/s", "m/s^2"; empty: not stated
  std::optional<ThermalReading> temperature = {};  ///< absent: the session has no thermal reading

  /// Returns true if the output depends on the temperature.
  bool varies() const { return !thermal.rightCols<3>().isZero(0) || matrix_varies(); }
  /// Returns true if the matrix depends on it.
  bool matrix_varies() const { return !matrix_thermal1.isZero(0) || !matrix_thermal2.isZero(0); }
  /// Returns c0 + c1 tau + c2 tau^2 + c3 tau^3 per axis: the contribution of the temperature to the raw output.
  Vector3d drift(const Vector3d& tau) const {
    return thermal.col(0) + (thermal.col(1) + (thermal.col(2) + thermal.col(3).cwiseProduct(tau)).cwiseProduct(tau)).cwiseProduct(tau);
  }
  /// Returns S = I + M1 tau + M2 tau^2.
  Matrix3d matrix_factor(const Vector3d& tau) const {
    return Matrix3d::Identity() + tau.asDiagonal() * (matrix_thermal1 + tau.asDiagonal() * matrix_thermal2);
  }
  bool all_finite() const {
    return offset.allFinite() && matrix.allFinite() && quadratic.allFinite() && cubic.allFinite() && thermal.allFinite() &&
           matrix_thermal1.allFinite() && matrix_thermal2.allFinite();
  }
  void remove_temperature() { thermal.setZero(), matrix_thermal1.setZero(), matrix_thermal2.setZero(); }
};

struct SensorModel {
  TriadModel gyro, accel;
  Matrix3d g_sensitivity = Matrix3d::Zero();  ///< C: (rad/s)/(m/s^2)
  Matrix3d lever_arm = Matrix3d::Zero();      ///< row i: position [m] of the sensitive point of accelerometer i
};

}  // namespace imulab
