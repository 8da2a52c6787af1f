// Machines on which the IMU is mounted by its faces: a rate table or centrifuge, which turn it about one vertical axis, and a thermal chamber, which
// does not move (Dai 2011 section 3). The mean readings of an ideal IMU there, in closed form, as a function of the machine's errors.
//
//   k       the axis: up, except for the tilt of the machine
//   C_nb  = R_tilt R(up, angle) C_mount R(mount)      C_mount: `up` points up and, at zero angle, `outward` north
//   w     = k_b (W + w_ie . k)                        W = rate (1 + rate error); Earth's horizontal rate averages out as the axis turns
//   f     = k_b g_k - outward_b (W + w_ie . k)^2 r_i  for accelerometer i at its own radius r_i; Coriolis' outward part is in the square, its
//                                                     upward part comes from Earth's horizontal rate
#pragma once

#include "imulab/compensate.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/eigen.hpp"
#include "imulab/rig/motion.hpp"
#include "imulab/simulate.hpp"

#include <span>
#include <string>
#include <vector>

namespace imulab {

/// Rate table, centrifuge or chamber.
bool is_machine(RigKind kind);

/// "+z+x": up, then outward.
std::string mount_name(const Mount& mount);
/// C_nb at zero angle, without errors.
Matrix3d mount_attitude(const Mount& mount);
/// The mount of a step; one without is +z up, +x outward.
Mount mount_of(const Step& step);

/// Every error source of a machine that does these steps: its tilt, the scale of its rate, and for each mount three rotations and a radius.
std::vector<RigErrorSource> machine_error_sources(const RigDeclaration& rig, std::span<const Step> steps);

/// The errors that act on one step.
template <class T>
struct MachineErrors {
  Eigen::Vector2<T> tilt = Eigen::Vector2<T>::Zero();   ///< about east, about north, rad
  Eigen::Vector3<T> mount = Eigen::Vector3<T>::Zero();  ///< rotation vector in body axes, rad
  T rate = T(0);                                        ///< relative
  T radius = T(0);                                      ///< m
};

/// The element that a source gives at a mount; null where it does not act there.
template <class T>
T* element_of(MachineErrors<T>& errors, const RigErrorSource& source, const Mount& mount) {
  const auto axis = static_cast<Eigen::Index>(source.axis);
  if (source.kind == RigErrorKind::tilt) return &errors.tilt[axis];
  if (source.kind == RigErrorKind::rate) return &errors.rate;
  if (source.place != mount) return nullptr;
  if (source.kind == RigErrorKind::mount) return &errors.mount[axis];
  return source.kind == RigErrorKind::radius ? &errors.radius : nullptr;
}

/// Those of one mount.
MachineErrors<double> errors_at(const RigErrors& errors, const Mount& mount);

/// "arm.csv: step 3 (spin at 20 s)".
std::string machine_step_name(const Step& step, std::size_t index);

/// Throws Error where a machine cannot do these steps: a kind of step that it does not have, a spin without a mount, a centrifuge's without radii.
void expect_possible(const RigDeclaration& rig, std::span<const Step> steps);

/// Surroundings of a machine.
template <class T>
struct MachinePlace {
  T gravity;           ///< m/s^2
  Vector3d rate_ie_n;  ///< rad/s
};

/// Gravity and the Earth's rate there; no rate without a latitude.
MachinePlace<double> place_of(const Site& site);

template <class T>
struct SteadyMotion {
  Eigen::Vector3<T> force, rate;  ///< m/s^2, rad/s
};

/// exp of a small rotation vector, to the third order: 4e-9 at one degree.
template <class T>
Eigen::Matrix3<T> small_rotation(const Eigen::Vector3<T>& r) {
  const Eigen::Matrix3<T> k = skew<T>(r), k2 = k * k;
  return Eigen::Matrix3<T>::Identity() + k + k2 * T(0.5) + k * k2 * T(1.0 / 6);
}

/// The mean motion of a hold or spin.
template <class T>
SteadyMotion<T> steady_motion(const Step& step, const MachineErrors<T>& errors, const MachinePlace<T>& place) {
  using Vector = Eigen::Vector3<T>;
  const Mount mount = mount_of(step);
  Matrix3d C_mount = mount_attitude(mount);
  if (step.kind == StepKind::hold) C_mount = rotation_about(Vector3d::UnitZ(), step.angles[static_cast<std::size_t>(RigAxis::outer)]) * C_mount;
  const Eigen::Matrix3<T> C_tilt = small_rotation<T>(Vector(errors.tilt[0], errors.tilt[1], T(0)));
  const Eigen::Matrix3<T> C_nb = C_tilt * C_mount.cast<T>() * small_rotation<T>(errors.mount);
  const Vector axis_n = C_tilt.col(2), axis_b = C_nb.transpose() * axis_n;
  const Vector rate_ie_n = place.rate_ie_n.template cast<T>();
  if (step.kind == StepKind::hold) return {C_nb.row(2).transpose() * place.gravity, C_nb.transpose() * rate_ie_n};
  Vector outward = Vector::Zero();
  outward[mount.outward.index] = T(mount.outward.sign);
  const Vector outward_b = small_rotation<T>(errors.mount).transpose() * outward;
  const T rate = step.rate * (T(1) + errors.rate) + rate_ie_n.dot(axis_n);
  Vector force = axis_b * (place.gravity * axis_n[2]);
  for (int i = 0; i < 3; ++i) force[i] -= outward_b[i] * rate * rate * (step.radius[static_cast<std::size_t>(i)] + errors.radius);
  return {force, axis_b * rate};
}

/// The mean motion on a machine without errors.
Motion steady_motion(const Step& step, const Site& site);

/// The remainder of a horizontal vector in the mean over a spin, one sigma along each horizontal axis, if the angle at its begin is not known:
/// |sin(W T / 2) / (W T / 2)| / sqrt(2). Zero for a hold.
double horizontal_remainder(const Step& step);

/// The contribution of this remainder to the covariance of the means of force and rate over a spin, on an axis tilted by `tilt` [rad, one sigma about
/// east and about north]; zero for a hold.
Eigen::Matrix<double, 6, 6> spin_noise(const Step& step, double tilt, const MachinePlace<double>& place);

// A machine's steps -> the angle of its one axis as a function of time, and the positions of the IMU's accelerometers.

/// The motion of these steps (of one recording) on a rate table, centrifuge or chamber, as the outer axis of a table with one axis:
/// - spin: at its rate from its start to its end. Accelerometer i is at the step's radius i along `outward`; the IMU's own lever arms do not count;
/// - hold: at rest at its outer angle, modulo whole turns;
/// - the gap before a step: the rate changes smoothly, without angular acceleration at its ends; the IMU is remounted at its end.
/// The machine begins in the state of its first step if that begins at time 0, else at rest at zero angle. Throws Error where a step is impossible,
/// or has no gap before it that its angle, rate or mount needs.
RigMotion machine_motion(const RigDeclaration& rig, std::span<const Step> steps, const RigErrors& errors = {});

/// The motion of a recording on its rig.
RigMotion recorded_motion(const Session& session, const RecordingSource& source, const RigErrors& errors = {});

}  // namespace imulab
