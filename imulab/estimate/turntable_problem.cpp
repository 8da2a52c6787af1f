#include "imulab/estimate/turntable_problem.hpp"

#include "imulab/earth/earth.hpp"
#include "imulab/rig/table_attitude.hpp"

#include <Eigen/LU>
#include <ceres/jet.h>
#include <fmt/core.h>

#include <algorithm>

namespace imulab {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

enum Local { angle_error = 6, end_error = 9, timing = 10, gravity = 11, earth_north = 12, earth_up = 13 };

constexpr std::array<const char*, 6> orthogonality_names{"o1", "o2", "m1", "m2", "i1", "i2"};

/// A declared spread: drawn with this sigma, or known to be this.
ErrorSource source(ErrorSource::Kind kind, std::string name, const Spread& spread) {
  return {kind, std::move(name), spread.fixed ? spread.value : 0.0, spread.fixed ? 0.0 : spread.value};
}

}  // namespace

TableMotion::TableMotion(const TableObservations& plan, const RigDeclaration& rig, const Site& site) : steps_(plan.steps), holds_(plan.holds.size()) {
  using Kind = ErrorSource::Kind;
  const auto known = [](Kind kind, std::string name, double value) { return ErrorSource{kind, std::move(name), value, 0}; };
  for (std::size_t k = 0; k < 6; ++k) {
    const std::string name = fmt::format("orthogonality {}", orthogonality_names[k]);
    const auto& given = rig.given_orthogonality[k / 2];
    sources_.push_back(given ? known(Kind::orthogonality, name, (*given)[k % 2]) : source(Kind::orthogonality, name, rig.orthogonality));
  }
  for (std::size_t a = 0; a < 3; ++a) {
    const std::string name = fmt::format("zero of the {} axis", to_string(static_cast<RigAxis>(a)));
    sources_.push_back(rig.given_zero[a] ? known(Kind::zero, name, *rig.given_zero[a]) : source(Kind::zero, name, rig.zero));
  }
  std::array<int, 3> in_force{};  // the angle error of each axis
  const auto next = [&] { return static_cast<int>(sources_.size()); };
  for (std::size_t a = 0; a < 3; ++a) {
    in_force[a] = next();
    sources_.push_back(source(Kind::angle, fmt::format("angle of the {} axis at the start", to_string(static_cast<RigAxis>(a))), rig.angle));
  }
  std::vector<std::array<int, 3>> before, after;  // by step
  std::vector<int> duration;
  std::array<double, 3> commanded{};
  for (std::size_t k = 0; k < steps_.size(); ++k) {
    const Step& step = steps_[k];
    before.push_back(in_force);
    const bool there_at_once = k == 0 && step.kind == StepKind::hold && step.start < 1e-9;
    const auto moved = there_at_once ? std::array<bool, 3>{} : axes_moved(step, commanded);
    for (std::size_t a = 0; a < 3; ++a) {
      if (!moved[a]) continue;
      in_force[a] = next();
      sources_.push_back(
          source(Kind::angle, fmt::format("angle of the {} axis from step {} on", to_string(static_cast<RigAxis>(a)), k + 1), rig.angle));
    }
    after.push_back(in_force);
    duration.push_back(step.kind == StepKind::rotate ? next() : -1);
    if (step.kind == StepKind::rotate) {
      sources_.push_back(source(Kind::timing, fmt::format("duration of the turn in step {}", k + 1), rig.timing));
      commanded[static_cast<std::size_t>(step.axis)] += step.angle;
    } else {
      commanded = step.angles;
    }
  }
  const int site_at = next();
  sources_.push_back({Kind::gravity, "gravity", site.gravity(), site.gravity_sigma()});
  const Vector3d earth = site.latitude ? earth_rate_enu(*site.latitude) : Vector3d::Zero();
  const double unknown = site.latitude ? 0 : earth_rate;
  sources_.push_back({Kind::earth, "Earth's rate north", earth.y(), unknown});
  sources_.push_back({Kind::earth, "Earth's rate up", earth.z(), unknown});

  const auto add = [&](std::size_t step, double begin, double end, bool rest_after) {
    Part part{step, begin, end, rest_after, {}, {}};
    part.first.fill(-1);
    part.second.fill(-1);
    for (int k = 0; k < 6; ++k) part.first[static_cast<std::size_t>(k)] = k;
    const bool turns = steps_[step].kind == StepKind::rotate;
    for (std::size_t a = 0; a < 3; ++a) {
      part.first[angle_error + a] = (turns ? before : after)[step][a];
      part.second[angle_error + a] = static_cast<int>(6 + a);
    }
    if (turns) {
      const auto axis = static_cast<std::size_t>(steps_[step].axis);
      part.first[end_error] = after[step][axis];
      part.second[end_error] = static_cast<int>(6 + axis);
      part.first[timing] = duration[step];
    }
    for (int k = 0; k < 3; ++k) part.first[static_cast<std::size_t>(gravity + k)] = site_at + k;
    parts_.push_back(part);
  };
  for (const HoldObservation& hold : plan.holds) add(hold.step, hold.begin, hold.end, true);
  for (const TurnObservation& turn : plan.turns) add(turn.step, turn.begin, turn.end, turn.rest_after);
}

VectorXd TableMotion::nominal() const {
  VectorXd v(static_cast<Index>(sources_.size()));
  for (std::size_t k = 0; k < sources_.size(); ++k) v[static_cast<Index>(k)] = sources_[k].nominal;
  return v;
}

VectorXd TableMotion::sigma() const {
  VectorXd v(static_cast<Index>(sources_.size()));
  for (std::size_t k = 0; k < sources_.size(); ++k) v[static_cast<Index>(k)] = sources_[k].sigma;
  return v;
}

VectorXd TableMotion::with(const ConstantTableErrors& errors) const {
  VectorXd v = nominal();
  for (std::size_t k = 0; k < 6; ++k) v[static_cast<Index>(k)] = errors.orthogonality[k / 2][k % 2];
  for (std::size_t a = 0; a < 3; ++a) v[static_cast<Index>(6 + a)] = errors.zero[a];
  return v;
}

template <class T>
Eigen::Matrix<T, 6, 1> TableMotion::truth_of(const Part& part, const std::array<T, locals>& e) const {
  const Step& step = steps_[part.step];
  const TableAxes<T> axes = table_axes<T>({{{e[0], e[1]}, {e[2], e[3]}, {e[4], e[5]}}});
  std::array<T, 3> angles;
  for (std::size_t a = 0; a < 3; ++a) angles[a] = step.angles[a] + e[angle_error + a];
  const Eigen::Vector3<T> force = seen_in_body<T>(axes, angles, {T(0), T(0), e[gravity]});
  const Eigen::Vector3<T> rate_ie = seen_in_body<T>(axes, angles, {T(0), e[earth_north], e[earth_up]});
  Eigen::Matrix<T, 6, 1> out;
  if (step.kind == StepKind::hold) {
    out << force, rate_ie;
    return out;
  }
  const TurnProfile profile = turn_profile(step);
  TableTurn<T> turn;
  turn.axis_b = axis_in_body<T>(axes, angles, step.axis);
  turn.angle = step.angle + e[end_error] - e[angle_error + static_cast<std::size_t>(step.axis)];
  turn.before = T(step.start - part.begin);
  turn.duration = profile.duration + e[timing];
  turn.after = T(part.end - part.begin) - turn.before - turn.duration;
  turn.ramp = profile.ramp;
  Eigen::Vector3<T> rate = turn.axis_b * turn.angle + integral_in_body<T>(turn, rate_ie);
  // Where no rest follows, the sum ends at the commanded time: a late turn's last part is missing (as if it stopped without a ramp).
  if (!part.rest_after) rate -= turn.axis_b * (e[timing] * (step.angle < 0 ? -step.rate : step.rate));
  out << rate, integral_in_body<T>(turn, force);
  return out;
}

std::array<double, TableMotion::locals> TableMotion::local(const Part& part, const VectorXd& errors) const {
  std::array<double, locals> e{};
  for (std::size_t k = 0; k < locals; ++k) {
    if (part.first[k] >= 0) e[k] += errors[part.first[k]];
    if (part.second[k] >= 0) e[k] += errors[part.second[k]];
  }
  return e;
}

VectorXd TableMotion::truth(const VectorXd& errors) const {
  VectorXd out(static_cast<Index>(6 * parts_.size()));
  for (std::size_t k = 0; k < parts_.size(); ++k) out.segment<6>(static_cast<Index>(6 * k)) = truth_of<double>(parts_[k], local(parts_[k], errors));
  return out;
}

MatrixXd TableMotion::jacobian(const VectorXd& errors) const {
  using Jet = ceres::Jet<double, locals>;
  MatrixXd out = MatrixXd::Zero(static_cast<Index>(6 * parts_.size()), errors.size());
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    const auto value = local(parts_[k], errors);
    std::array<Jet, locals> e;
    for (std::size_t l = 0; l < locals; ++l) e[l] = Jet(value[l], static_cast<int>(l));
    const Eigen::Matrix<Jet, 6, 1> truth = truth_of<Jet>(parts_[k], e);
    for (Index row = 0; row < 6; ++row)
      for (std::size_t l = 0; l < locals; ++l)
        for (const int source : {parts_[k].first[l], parts_[k].second[l]})
          if (source >= 0) out(static_cast<Index>(6 * k) + row, source) += truth[row].v[static_cast<Index>(l)];
  }
  return out;
}

VectorXd readings(const TableMotion& motion, const SensorModel& model, const VectorXd& truth) {
  const Matrix3d accel = model.accel.matrix.inverse(), gyro = model.gyro.matrix.inverse();
  const auto holds = static_cast<Index>(motion.holds());
  VectorXd out(motion.rows());
  for (Index k = 0; k < holds; ++k) {
    const Vector3d force = truth.segment<3>(6 * k), rate = truth.segment<3>(6 * k + 3);
    out.segment<3>(6 * k) = accel * (force - model.accel.offset);
    out.segment<3>(6 * k + 3) = gyro * (rate - model.gyro.offset - model.g_sensitivity * force);
  }
  for (Index k = 0; k < static_cast<Index>(motion.turns()); ++k) {
    const auto part = static_cast<std::size_t>(holds + k);
    const Vector3d rate = truth.segment<3>(6 * (holds + k)), force = truth.segment<3>(6 * (holds + k) + 3);
    const double duration = motion.end(part) - motion.begin(part);
    out.segment<3>(6 * holds + 3 * k) = gyro * (rate - model.gyro.offset * duration - model.g_sensitivity * force);
  }
  return out;
}

MatrixXd noise_covariance(const TableMotion& motion, const Matrix3d& accel_density, const Matrix3d& gyro_density) {
  MatrixXd out = MatrixXd::Zero(motion.rows(), motion.rows());
  const std::size_t holds = motion.holds(), parts = holds + motion.turns();
  for (std::size_t k = 0; k < parts; ++k) {
    const double duration = motion.end(k) - motion.begin(k);
    if (k < holds) {
      const auto row = static_cast<Index>(6 * k);
      out.block<3, 3>(row, row) = accel_density / duration;
      out.block<3, 3>(row + 3, row + 3) = gyro_density / duration;
      continue;
    }
    const auto row = static_cast<Index>(6 * holds + 3 * (k - holds));
    out.block<3, 3>(row, row) = gyro_density * duration;
    for (std::size_t hold = 0; hold < holds; ++hold) {  // the samples that are in a hold's mean and in the turn's sum
      const double shared = std::min(motion.end(k), motion.end(hold)) - std::max(motion.begin(k), motion.begin(hold));
      if (shared <= 0) continue;
      const auto hold_row = static_cast<Index>(6 * hold + 3);
      out.block<3, 3>(row, hold_row) = gyro_density * (shared / (motion.end(hold) - motion.begin(hold)));
      out.block<3, 3>(hold_row, row) = out.block<3, 3>(row, hold_row).transpose();
    }
    for (std::size_t other = holds; other < k; ++other) {  // turns with no rest between them may share a sample
      const double shared = std::min(motion.end(k), motion.end(other)) - std::max(motion.begin(k), motion.begin(other));
      if (shared <= 0) continue;
      const auto other_row = static_cast<Index>(6 * holds + 3 * (other - holds));
      out.block<3, 3>(row, other_row) = gyro_density * shared;
      out.block<3, 3>(other_row, row) = gyro_density * shared;
    }
  }
  return out;
}

}  // namespace imulab
