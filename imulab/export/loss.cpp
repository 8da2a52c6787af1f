#include "imulab/export/loss.hpp"

#include "imulab/compensate.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/export/device_axes.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace imulab::export_io {

namespace {

/// Directions that are even over the sphere: a spiral of the golden angle. None is further than 14 degrees from one of these 100.
const std::vector<Vector3d>& directions() {
  static const std::vector<Vector3d> all = [] {
    constexpr int n = 100;
    std::vector<Vector3d> out;
    for (int i = 0; i < n; ++i) {
      const double z = 1 - (2 * i + 1.0) / n, radius = std::sqrt(1 - z * z), angle = std::numbers::pi * (3 - std::sqrt(5.0)) * i;
      out.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    }
    return out;
  }();
  return all;
}

bool has_range(const TriadModel& m) { return m.temperature && m.temperature->range[1] > m.temperature->range[0]; }
bool drifts_without_range(const TriadModel& m) { return m.varies() && !has_range(m); }

/// The thermal readings less their reference, over the calibrated range; only zero where no range is known.
std::vector<double> drifts(const TriadModel& m) {
  std::vector<double> out{0};
  if (!has_range(m)) return out;
  constexpr int steps = 40;
  for (int i = 0; i <= steps; ++i)
    out.push_back(m.temperature->range[0] + (m.temperature->range[1] - m.temperature->range[0]) * i / steps - m.temperature->reference);
  return out;
}

struct Condition {
  Vector3d force, rate;
  double accel_tau = 0, gyro_tau = 0;
};

/// The largest error of an axis over all conditions: each part of the condition in turn, the others kept, until all have been improved. The error is
/// nearly a sum of what force, rate and temperature cause, so that this finds the largest.
class Search {
 public:
  explicit Search(std::function<double(const Condition&)> error)
      : error_(std::move(error)), at_{unit::g * directions()[0], stated_rate_deg_s * unit::deg * directions()[0]}, best_(error_(at_)) {}

  double largest(const std::vector<double>& accel_taus, const std::vector<double>& gyro_taus) {
    for (int round = 0; round < 2; ++round) {
      turn(&Condition::rate, stated_rate_deg_s * unit::deg);
      turn(&Condition::force, unit::g);
      for (const double tau : accel_taus) take(&Condition::accel_tau, tau);
      for (const double tau : gyro_taus) take(&Condition::gyro_tau, tau);
    }
    return best_;
  }

 private:
  template <class Part>
  bool take(Part Condition::*part, const Part& value) {
    Condition other = at_;
    other.*part = value;
    const double e = error_(other);
    if (!(e > best_)) return false;
    best_ = e;
    at_ = other;
    return true;
  }
  /// All directions, then uphill from the best with smaller and smaller steps.
  void turn(Vector3d Condition::*part, double size) {
    for (const Vector3d& d : directions()) take(part, Vector3d(size * d));
    for (double step = 0.25; step > 0.01;) {
      const Vector3d d = (at_.*part) / size;
      const auto tangents = tangent_basis(d);
      bool better = false;
      for (const double way : {step, -step})
        for (int k = 0; k < 2; ++k) better = take(part, Vector3d(size * (d + way * tangents.row(k).transpose()).normalized())) || better;
      if (!better) step /= 2;
    }
  }

  std::function<double(const Condition&)> error_;
  Condition at_;
  double best_;
};

/// The largest difference of two models' outputs [SI] for the readings that `truth` has.
double difference(const SensorModel& truth, const SensorModel& a, const SensorModel& b, bool of_accel, const std::vector<double>& accel_taus,
                  const std::vector<double>& gyro_taus) {
  double most = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (const int sign : {1, -1}) {
      Search search([&](const Condition& c) {
        const RawSample raw =
            decompensate(truth, {.rate = c.rate, .force = c.force}, Vector3d::Constant(c.gyro_tau), Vector3d::Constant(c.accel_tau));
        const Motion x = compensate(a, raw), y = compensate(b, raw);
        return sign * (of_accel ? x.force - y.force : x.rate - y.rate)[axis];
      });
      most = std::max(most, search.largest(accel_taus, gyro_taus));
    }
  return most;
}

/// The matrix is `matrix` from now on; the bias of the readings stays.
void replace_matrix(TriadModel& m, const Matrix3d& matrix) {
  const Vector3d bias = -m.matrix.inverse() * m.offset;
  m.matrix = matrix;
  m.offset = -matrix * bias;
}

constexpr const char *thermal_terms = "thermal terms", *thermal_matrix = "matrix over temperature";

struct Step {
  const char* what;  ///< "off-diagonal terms"
  bool of_accel;
  std::string condition;
  std::function<void(SensorModel&)> remove;
};

std::string range_of(const TriadModel& m) {
  if (!m.temperature) return "";
  const std::string& unit = m.temperature->unit;
  return fmt::format(" over {:g} to {:g} {}", m.temperature->range[0], m.temperature->range[1], unit == "degC" || unit == "K" ? unit : "raw");
}

void remove_change(TriadModel& m) { m.matrix_thermal1 = m.matrix_thermal2 = Matrix3d::Zero(); }
void remove_nonlinear(TriadModel& m) { m.quadratic = m.cubic = Vector3d::Zero(); }
Matrix3d diagonal_of(const Matrix3d& m) { return m.diagonal().asDiagonal(); }

std::vector<Step> steps(const SensorModel& model, const Held& held) {
  const std::string force = " at 1 g", rate = fmt::format(" at {:g} deg/s", stated_rate_deg_s);
  std::vector<Step> out;
  const auto add = [&](bool is_held, const char* what, bool of_accel, const std::string& condition, std::function<void(SensorModel&)> remove) {
    if (!is_held) out.push_back({what, of_accel, condition, std::move(remove)});
  };
  add(held.nonlinear, "quadratic and cubic terms", true, force, [](SensorModel& m) { remove_nonlinear(m.accel); });
  add(held.nonlinear, "quadratic and cubic terms", false, rate, [](SensorModel& m) { remove_nonlinear(m.gyro); });
  if (model.accel.matrix_varies())
    add(held.matrix_thermal, thermal_matrix, true, force + range_of(model.accel), [](SensorModel& m) { remove_change(m.accel); });
  if (model.gyro.matrix_varies())
    add(held.matrix_thermal, thermal_matrix, false, rate + range_of(model.gyro), [](SensorModel& m) { remove_change(m.gyro); });
  add(held.accel_thermal, thermal_terms, true, range_of(model.accel), [](SensorModel& m) { m.accel.thermal.setZero(); });
  add(held.gyro_thermal, thermal_terms, false, range_of(model.gyro), [](SensorModel& m) { m.gyro.thermal.setZero(); });
  add(held.g_sensitivity, "g-sensitivity", false, force, [](SensorModel& m) { m.g_sensitivity.setZero(); });
  add(held.accel_matrix, "off-diagonal terms", true, force, [](SensorModel& m) { replace_matrix(m.accel, diagonal_of(m.accel.matrix)); });
  add(held.gyro_matrix, "off-diagonal terms", false, rate, [](SensorModel& m) { replace_matrix(m.gyro, diagonal_of(m.gyro.matrix)); });
  add(held.accel_scale, "scale factors", true, force, [](SensorModel& m) { replace_matrix(m.accel, Matrix3d::Identity()); });
  add(held.gyro_scale, "scale factors", false, rate, [](SensorModel& m) { replace_matrix(m.gyro, Matrix3d::Identity()); });
  add(held.bias, "offsets", true, "", [](SensorModel& m) { m.accel.offset.setZero(); });
  add(held.bias, "offsets", false, "", [](SensorModel& m) { m.gyro.offset.setZero(); });
  return out;
}

/// "gyros, WHAT: up to ...": the largest difference of two models.
std::string together(const SensorModel& model, const SensorModel& other, bool of_accel, const char* what) {
  const double size = difference(model, model, other, of_accel, drifts(model.accel), drifts(model.gyro));
  const std::string range = drifts(of_accel ? model.accel : model.gyro).size() > 1 ? range_of(of_accel ? model.accel : model.gyro) : "";
  const std::string without = drifts_without_range(of_accel ? model.accel : model.gyro) ? ", without the thermal terms" : "";
  return of_accel ? fmt::format("accelerometers, {}: up to {} at 1 g{}{}", what, accel_size(size), range, without)
                  : fmt::format("gyros, {}: up to {} at 1 g and {:g} deg/s{}{}", what, gyro_size(size), stated_rate_deg_s, range, without);
}

/// The loss of thermal terms whose range is not known: what a change of temperature costs, where even that can be said.
std::string drift_without_range(const SensorModel& model, const SensorModel& before, const SensorModel& now, bool of_accel, const char* what) {
  constexpr double change = 10;
  const TriadModel& m = of_accel ? model.accel : model.gyro;
  const std::string begin = fmt::format("{} {}: ", of_accel ? "accelerometers'" : "gyros'", what);
  if (!m.temperature) return begin + "their size is not known: the calibration names neither reference nor range of temperatures";
  const std::vector<double> none{0}, changes{0, change, -change};
  const double size = difference(model, before, now, of_accel, of_accel ? changes : none, of_accel ? none : changes);
  const std::string& unit = m.temperature->unit;
  return fmt::format("{}up to {} at {:g} {} from the reference; no range of temperatures is known", begin,
                     of_accel ? accel_size(size) : gyro_size(size), change, unit == "degC" || unit == "K" ? unit : "raw");
}

/// The largest of |e_i . (w x (w x r_i))| over all directions of w: a quadratic form of w whose eigenvalues are known, |w|^2 (|r_ii| + |r_i|) / 2.
double lever_arm_size(const SensorModel& model) {
  double most = 0;
  for (int i = 0; i < 3; ++i) most = std::max(most, (std::abs(model.lever_arm(i, i)) + model.lever_arm.row(i).norm()) / 2);
  return std::pow(stated_rate_deg_s * unit::deg, 2) * most;
}

}  // namespace

std::string accel_size(double si) {
  const bool small = si < 1e3 * unit::ug;
  return fmt::format("{} {}", text::number(si / (small ? unit::ug : 1e3 * unit::ug)), small ? "ug" : "mg");
}

std::string gyro_size(double si) {
  const bool small = si < 0.1 * unit::deg;
  return fmt::format("{} {}", text::number(si / (small ? unit::deg_per_h : unit::deg)), small ? "deg/h" : "deg/s");
}

SensorModel reduced(SensorModel model, const Held& held) {
  for (const Step& step : steps(model, held)) step.remove(model);
  return model;
}

std::vector<std::string> losses(const SensorModel& model, const Held& held) {
  std::vector<std::string> out;
  SensorModel now = model;
  std::array<int, 2> lost{0, 0};
  for (const Step& step : steps(model, held)) {
    const SensorModel before = now;
    step.remove(now);
    const bool thermal = step.what == thermal_terms || step.what == thermal_matrix;
    if (thermal && drifts_without_range(step.of_accel ? model.accel : model.gyro)) {
      out.push_back(drift_without_range(model, before, now, step.of_accel, step.what));
      continue;
    }
    const std::vector<double> none{0};
    const double size = difference(model, before, now, step.of_accel, thermal ? drifts(model.accel) : none, thermal ? drifts(model.gyro) : none);
    if (!(size > 1e-12)) continue;  // of the rounding of g
    ++lost[step.of_accel ? 0 : 1];
    out.push_back(fmt::format("{} {}: up to {}{}", step.of_accel ? "accelerometers'" : "gyros'", step.what,
                              step.of_accel ? accel_size(size) : gyro_size(size), step.condition));
  }
  for (const bool of_accel : {true, false})
    if (lost[of_accel ? 0 : 1] > 1) out.push_back(together(model, now, of_accel, "all of this together"));
  if (!held.lever_arm && !model.lever_arm.isZero(0))
    out.push_back(fmt::format("lever arms: the forces are those at the accelerometers' own positions, up to {} from the origin's at {:g} deg/s",
                              accel_size(lever_arm_size(model)), stated_rate_deg_s));
  return out;
}

std::vector<std::string> whole_calibration(const SensorModel& model) {
  const SensorModel none = reduced(model, {});
  return {together(model, none, true, "the whole calibration"), together(model, none, false, "the whole calibration")};
}

std::vector<std::string> whole_calibration_left_out(const ExportInput& input) {
  const SensorModel& m = input.calibration.model;
  const bool turned = device_axes(input.calibration).turned(), counts = m.accel.raw_unit == "count" || m.gyro.raw_unit == "count";
  if (!turned && !counts && losses(m, {}).empty()) return {};  // it changes nothing
  std::vector<std::string> out{"the calibration: apply it with `imulab compensate` before"};
  if (turned) out.emplace_back("the device's axes, which are not x, y, z of the body: `imulab compensate` turns the readings");
  if (counts) return out;
  const std::vector<std::string> sizes = whole_calibration(m);
  out.insert(out.end(), sizes.begin(), sizes.end());
  return out;
}

}  // namespace imulab::export_io
