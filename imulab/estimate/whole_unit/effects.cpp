// States of the machines' points, on which the effects of the table depend.
#include "imulab/estimate/kernel/site.hpp"
#include "imulab/estimate/whole_unit/problem.hpp"
#include "imulab/rig/thermal_scale.hpp"
#include "imulab/units.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace imulab::whole_unit {

using Eigen::MatrixXd;

namespace {

/// Returns the mean of C_bn at a point: horizontal components average out while it turns.
Matrix3d mean_attitude(const Step& step) {
  const Matrix3d C_bn = mount_attitude(mount_of(step)).transpose();
  if (step.kind == StepKind::hold) return C_bn * rotation_about(Vector3d::UnitZ(), -step.angles[static_cast<std::size_t>(RigAxis::outer)]);
  return C_bn * Vector3d::UnitZ() * Vector3d::UnitZ().transpose();
}

/// Returns the kelvin per unit of the thermal readings: as declared, or for raw units as if their range were that of a chamber, 70 K.
double kelvin(const MachinePoints& points, const Session& session) {
  const ThermalRange& thermal = points.thermal[points.thermometer()];
  if (thermal.unit != "raw") return 1;
  const RecordingSource& first = session.recordings.front();
  const auto& source = points.thermometer() == 0 ? first.accel_temperature : first.gyro_temperature;
  if (source && source->per_K) return 1 / *source->per_K;
  return 70 / std::max(thermal.size(), 1e-12);
}

/// Returns the force variance of the sensors themselves: as declared, else that of the quietest point.
Vector3d own_variance(const PointProblem& problem) {
  if (const double N = declared_terms(problem.session->imu).accel.N; N > 0) return Vector3d::Constant(N * N / problem.points.interval_s);
  Vector3d least = Vector3d::Constant(HUGE_VAL);
  for (const MachinePoint& p : problem.points.all) least = least.cwiseMin(p.scatter.head<3>());
  return problem.model.accel.matrix.cwiseAbs2() * least;
}

/// Properties common to the points of a session.
struct Reached {
  double full_force, full_rate;
  double full_arm_rate = 0;  ///< largest rate of a centrifuge
  std::vector<double> begin, end;
  std::vector<std::string> rigs;
};

Reached reached(const PointProblem& problem) {
  const auto [force, rate] = problem.full_scale();
  const std::size_t recordings = problem.session->recordings.size();
  Reached out{.full_force = std::max(force, problem.session->site.gravity()),
              .full_rate = std::max(rate, 1 * unit::deg),
              .begin = std::vector<double>(recordings, HUGE_VAL),
              .end = std::vector<double>(recordings, -HUGE_VAL),
              .rigs = {}};
  for (const MachinePoint& p : problem.points.all) {
    out.begin[p.recording] = std::min(out.begin[p.recording], p.step.start);
    out.end[p.recording] = std::max(out.end[p.recording], p.step.end);
    if (p.machine == RigKind::centrifuge) out.full_arm_rate = std::max(out.full_arm_rate, std::abs(p.step.rate));
  }
  for (const RecordingSource& source : problem.session->recordings)
    if (const std::string& name = problem.session->rig_of(source)->name; std::find(out.rigs.begin(), out.rigs.end(), name) == out.rigs.end())
      out.rigs.push_back(name);
  return out;
}

/// Sets the tilt of machines without a declared level to that of a mechanic's level, 0.1 mm/m. { fixed = 0 } declares an exactly level machine.
void set_undeclared_levels(std::vector<CommonError>& common, const Session& session) {
  for (CommonError& error : common) {
    if (error.rig.empty() || error.source.kind != RigErrorKind::tilt) continue;
    const auto rig = std::find_if(session.rigs.begin(), session.rigs.end(), [&](const RigDeclaration& r) { return r.name == error.rig; });
    if (rig != session.rigs.end() && rig->zero == Spread{}) error.sigma = 20 * unit::arcsec;
  }
}

/// Returns the force of an additional arm of 1 m at full rate.
Vector3d stretching(const MachinePoint& point, double full_rate) {
  if (point.machine != RigKind::centrifuge || point.step.kind != StepKind::spin) return Vector3d::Zero();
  const Mount mount = mount_of(point.step);
  const double rate = point.step.rate;
  return -mount.outward.sign * rate * rate * std::pow(rate / full_rate, 2) * Vector3d::Unit(mount.outward.index);
}

/// Returns the change of the output per unit of the thermal reading.
Vector3d of_thermometer(const TriadModel& triad, const Vector3d& reading) {
  if (!triad.temperature) return Vector3d::Zero();
  const Vector3d warming = reading.array() - triad.temperature->reference;
  return -triad.matrix * (triad.thermal.col(1) + 2 * triad.thermal.col(2).cwiseProduct(warming));
}

}  // namespace

void PointProblem::mirror_latitude() {
  if (latitude_ < 0) return;
  site.latitude = -*site.latitude;
  set_place();
}

void PointProblem::set_place() {
  const Site there = kernel::farther_north(site, effects.value()[latitude_]);
  place_ = place_of(there);
  const kernel::SiteChanges changes(there);
  for (const MachinePoint& p : points.all) {
    EffectState state;
    changes.fill(state, mean_attitude(p.step));
    by_effects[p.recording][p.number].col(latitude_) << -state.by_latitude.force, -state.by_latitude.rate;
  }
}

void PointProblem::add_effects(const kernel::SeenOfUnit& seen) {
  const Reached all = reached(*this);
  kernel::EffectSizes sizes = kernel::effect_sizes(*session, seen);
  for (const char* name : {"accel.offset_temperature", "gyro.offset_temperature"}) sizes.declared[name] = 0;  // they are coefficients
  effects = kernel::Effects(sizes, {.accel = true,
                                    .gyro = true,
                                    .thermometer = points.thermal[points.thermometer()].known,
                                    .mount = true,
                                    .centrifuge = all.full_arm_rate > 0,
                                    .latitude = session->site.latitude.has_value(),
                                    .heading = true,
                                    .thermal = model.accel.temperature || model.gyro.temperature,
                                    .recordings = static_cast<int>(session->recordings.size()),
                                    .machines = static_cast<int>(all.rigs.size())});
  for (const kernel::EffectGroup& group : effects.groups())
    if (group.effect->name == "site.latitude") latitude_ = group.first;
  set_undeclared_levels(common, *session);
  common[0].sigma = kernel::beside_effects(session->site).gravity_sigma();
  update_effects();
}

void PointProblem::update_effects() {
  if (effects.size() == 0) return;
  const Reached all = reached(*this);
  const Site there = latitude_ < 0 ? site : kernel::farther_north(site, effects.value()[latitude_]);
  const kernel::SiteChanges changes(there);
  const Vector3d own = own_variance(*this);
  const auto thermometer = static_cast<Eigen::Index>(3 * points.thermometer());
  std::vector<PlayOperator> play(session->recordings.size(), PlayOperator(place_.gravity));
  by_effects.resize(session->recordings.size());
  for (const MachinePoint& p : points.all) {
    const Motion m = motion(p);
    const auto rig = std::find(all.rigs.begin(), all.rigs.end(), session->rig_of(session->recordings[p.recording])->name);
    const double begin = all.begin[p.recording], span = std::max(all.end[p.recording] - begin, 1e-9);
    EffectState state{.force = m.force,
                      .rate = m.rate,
                      .gravity = place_.gravity,
                      .full_force = all.full_force,
                      .full_rate = all.full_rate,
                      .time = (0.5 * (p.step.start + p.step.end) - begin) / span - 0.5,
                      .recording = static_cast<int>(p.recording),
                      .play = play[p.recording](m.force),
                      .shaking = model.accel.matrix.cwiseAbs2() * p.scatter.head<3>() - own,
                      .stretching = stretching(p, all.full_arm_rate),
                      .machine = static_cast<int>(rig - all.rigs.begin())};
    const TriadModel& triad = thermometer == 0 ? model.accel : model.gyro;
    if (triad.temperature) state.warming = (p.temperature.segment<3>(thermometer).mean() - triad.temperature->reference) * kelvin(points, *session);
    state.by_thermometer = {of_thermometer(model.accel, p.temperature.head<3>()) / kelvin(points, *session),
                            of_thermometer(model.gyro, p.temperature.tail<3>()) / kelvin(points, *session)};
    changes.fill(state, mean_attitude(p.step));
    auto& of_recording = by_effects[p.recording];
    if (of_recording.size() <= p.number) of_recording.resize(p.number + 1);
    MatrixXd& jacobian = of_recording[p.number] = MatrixXd::Zero(6, effects.size());
    effects.add_derivatives(jacobian, 0, Triad::accel, Matrix3d::Identity(), state);
    effects.add_derivatives(jacobian, 3, Triad::gyro, Matrix3d::Identity(), state);
  }
}

}  // namespace imulab::whole_unit
