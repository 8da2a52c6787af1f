#include "imulab/rig/table_motion.hpp"

#include "imulab/earth.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/rig/table_attitude.hpp"
#include "imulab/simulate.hpp"

#include <fmt/core.h>
#include <unsupported/Eigen/AutoDiff>

#include <algorithm>
#include <cmath>

namespace imulab {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int no_source = RigErrorIndex::none;

ErrorSource::Kind kind_of(RigErrorKind kind) {
  switch (kind) {
    case RigErrorKind::orthogonality:
      return ErrorSource::Kind::orthogonality;
    case RigErrorKind::angle:
      return ErrorSource::Kind::angle;
    case RigErrorKind::timing:
      return ErrorSource::Kind::timing;
    default:
      return ErrorSource::Kind::zero;  // the table's tilt is a leveling error too
  }
}

}  // namespace

TableMotion::TableMotion(const TablePlan& plan, const RigDeclaration& rig, const Site& site)
    : steps_(plan.steps), latitude_known_(site.latitude.has_value()), holds_(plan.holds.size()) {
  const std::vector<RigErrorSource> rig_sources = table_error_sources(rig, steps_);
  const RigErrorIndex index = index_of(rig_sources, steps_.size());
  for (const RigErrorSource& source : rig_sources) sources_.push_back({kind_of(source.kind), source.name(), source.known, source.sigma});
  const int site_at = static_cast<int>(sources_.size());
  sources_.push_back({ErrorSource::Kind::gravity, "gravity", site.gravity(), site.gravity_sigma()});
  if (latitude_known_) {
    sources_.push_back({ErrorSource::Kind::latitude, "latitude", *site.latitude, site.latitude_sigma.value_or(0)});
  } else {
    for (const char* direction : {"north", "up"})
      sources_.push_back({ErrorSource::Kind::earth, fmt::format("earth_rate.{}", direction), 0, earth_rate});
  }

  const auto add = [&](std::size_t step, double begin, double end) {
    Part part{step, begin, end, {}, {}};
    part.first.fill(no_source);
    part.second.fill(no_source);
    const bool turns = steps_[step].kind == StepKind::rotate;
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t element = 0; element < 2; ++element) part.first[orthogonality + 2 * a + element] = index.orthogonality[a][element];
      part.first[angle_error + a] = (turns ? index.angle_before : index.angle_after)[step][a];
      part.second[angle_error + a] = index.zero[a];
    }
    for (std::size_t k = 0; k < 2; ++k) part.first[tilt + k] = index.tilt[k];
    if (turns) {
      const auto axis = static_cast<std::size_t>(steps_[step].axis);
      part.first[end_error] = index.angle_after[step][axis];
      part.second[end_error] = index.zero[axis];
      part.first[timing] = index.timing[step];
    }
    part.first[gravity] = site_at;
    if (latitude_known_) {
      part.first[latitude] = site_at + 1;
    } else {
      part.first[earth] = site_at + 1;
      part.first[earth + 1] = site_at + 2;
    }
    parts_.push_back(part);
  };
  for (const TablePart& hold : plan.holds) add(hold.step, hold.begin, hold.end);
  for (const TablePart& turn : plan.turns) add(turn.step, turn.begin, turn.end);
}

VectorXd TableMotion::nominal() const {
  VectorXd v(static_cast<Eigen::Index>(sources_.size()));
  for (std::size_t k = 0; k < sources_.size(); ++k) v[static_cast<Eigen::Index>(k)] = sources_[k].nominal;
  return v;
}

VectorXd TableMotion::sigma() const {
  VectorXd v(static_cast<Eigen::Index>(sources_.size()));
  for (std::size_t k = 0; k < sources_.size(); ++k) v[static_cast<Eigen::Index>(k)] = sources_[k].sigma;
  return v;
}

double TableMotion::rate_moment(std::size_t turn, int power) const {
  const Step& turned = steps_[parts_[turn].step];
  const TurnProfile profile = turn_profile(turned);
  const double rate = turned.angle / (profile.duration * (1 - profile.ramp));  // between the ramps
  return std::pow(rate, power) * profile.duration * (1 - 2 * profile.ramp * power / (power + 1));
}

template <class T>
struct TableMotion::Surroundings {
  TableAxes<T> axes;
  Eigen::Vector3<T> force, rate_ie;  ///< in the table's frame
};

template <class T>
TableMotion::Surroundings<T> TableMotion::surroundings_of(const std::array<T, locals>& e) const {
  using std::cos, std::sin;
  const double w_ie = latitude_known_ ? earth_rate : 0;
  const TableTilt<T> lean = table_tilt_of<T>(e[tilt], e[tilt + 1]);
  return {table_axes<T>({{{e[0], e[1]}, {e[2], e[3]}, {e[4], e[5]}}}), seen_by_table<T>(lean, {T(0), T(0), e[gravity]}),
          seen_by_table<T>(lean, {T(0), w_ie * cos(e[latitude]) + e[earth], w_ie * sin(e[latitude]) + e[earth + 1]})};
}

template <class T>
TablePose<T> TableMotion::pose_of(const Part& part, const Surroundings<T>& surroundings, const std::array<T, locals>& e) const {
  std::array<T, 3> angles;
  for (std::size_t a = 0; a < 3; ++a) angles[a] = steps_[part.step].angles[a] + e[angle_error + a];
  return table_pose<T>(surroundings.axes, angles);
}

template <class T>
struct TableMotion::BodyMotion {
  Eigen::Vector3<T> force, rate_ie;
  TurnInterval<T> turn;
};

template <class T>
TableMotion::BodyMotion<T> TableMotion::body_motion(const Part& part, const Surroundings<T>& surroundings, const std::array<T, locals>& e) const {
  const Step& step = steps_[part.step];
  const TablePose<T> pose = pose_of<T>(part, surroundings, e);
  BodyMotion<T> out{seen_in_body<T>(pose, surroundings.force), seen_in_body<T>(pose, surroundings.rate_ie), {}};
  if (step.kind == StepKind::hold) return out;
  const TurnProfile profile = turn_profile(step);
  TurnInterval<T>& turn = out.turn;
  turn.axis_b = axis_in_body<T>(pose, step.axis);
  turn.angle = step.angle + e[end_error] - e[angle_error + static_cast<std::size_t>(step.axis)];
  turn.before = T(step.start - part.begin);
  turn.duration = profile.duration + e[timing];
  turn.after = T(part.end - part.begin) - turn.before - turn.duration;
  turn.ramp = profile.ramp;
  return out;
}

template <class T>
Eigen::Matrix<T, 6, 1> TableMotion::truth_of(const Part& part, const Surroundings<T>& surroundings, const std::array<T, locals>& e) const {
  const auto [force, rate_ie, turn] = body_motion<T>(part, surroundings, e);
  Eigen::Matrix<T, 6, 1> out;
  if (steps_[part.step].kind == StepKind::hold) {
    out << force, rate_ie;
    return out;
  }
  const Eigen::Vector3<T> rate = turn.axis_b * turn.angle + integral_in_body<T>(turn, rate_ie);
  out << integral_in_body<T>(turn, force), rate;
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

namespace {

/// Three Gauss-Legendre nodes in each of some panels of an interval: sample(time, weight).
template <class Sample>
void at_nodes(double from, double to, int panels, Sample&& sample) {
  constexpr std::array<double, 3> node{-0.77459666924148337704, 0, 0.77459666924148337704}, weight{5.0 / 18, 8.0 / 18, 5.0 / 18};
  const double width = (to - from) / panels;
  for (int k = 0; k < panels && to > from; ++k)
    for (std::size_t n = 0; n < node.size(); ++n) sample(from + width * (k + 0.5 + 0.5 * node[n]), width * weight[n]);
}

}  // namespace

std::vector<TableMotion::Moment> TableMotion::moments(std::size_t number) const {
  const Part& part = parts_[number];
  const auto e = local(part, nominal());
  const Surroundings<double> surroundings = surroundings_of<double>(e);
  const BodyMotion<double> motion = body_motion<double>(part, surroundings, e);
  const TablePose<double> pose = pose_of<double>(part, surroundings, e);
  const TableTilt<double> lean = table_tilt_of<double>(e[tilt], e[tilt + 1]);
  Matrix3d before;
  for (Eigen::Index k = 0; k < 3; ++k) before.col(k) = seen_in_body<double>(pose, seen_by_table<double>(lean, Vector3d::Unit(k)));
  if (is_hold(number)) return {{0.5 * (part.begin + part.end), 1, motion.force, motion.rate_ie, before}};
  const TurnInterval<double>& turn = motion.turn;
  const double start = part.begin + turn.before, stop = start + turn.duration, ramp = turn.ramp * turn.duration;
  const double full = turn.angle / (turn.duration - ramp);  // rate between the ramps
  std::vector<Moment> out;
  const auto moment = [&](double time, double weight, double turned_by, double rate) {
    const auto now = [&](const Vector3d& v) { return turned<double>(turn.axis_b, std::cos(turned_by), -std::sin(turned_by), v); };
    Matrix3d C_bn;
    for (Eigen::Index k = 0; k < 3; ++k) C_bn.col(k) = now(before.col(k));
    out.push_back({time, weight, now(motion.force), now(motion.rate_ie) + rate * turn.axis_b, C_bn});
  };
  const auto panels = [&](double angle) { return std::max(1, static_cast<int>(std::ceil(std::abs(angle) / 0.5))); };
  const double by_ramp = 0.5 * full * ramp;
  at_nodes(part.begin, start, 1, [&](double t, double w) { moment(t, w, 0, 0); });
  at_nodes(0, ramp, panels(by_ramp), [&](double t, double w) { moment(start + t, w, by_ramp * t * t / (ramp * ramp), full * t / ramp); });
  at_nodes(ramp, turn.duration - ramp, panels(turn.angle), [&](double t, double w) { moment(start + t, w, by_ramp + full * (t - ramp), full); });
  at_nodes(0, ramp, panels(by_ramp), [&](double t, double w) { moment(stop - t, w, turn.angle - by_ramp * t * t / (ramp * ramp), full * t / ramp); });
  at_nodes(stop, part.end, 1, [&](double t, double w) { moment(t, w, turn.angle, 0); });
  return out;
}

Vector3d TableMotion::force_at(const std::array<double, 3>& angles) const {
  if (parts_.empty()) return Vector3d::Zero();
  auto e = local(parts_.front(), nominal());
  const Surroundings<double> surroundings = surroundings_of<double>(e);
  std::array<double, 3> actual = angles;
  for (std::size_t a = 0; a < 3; ++a) actual[a] += e[angle_error + a];
  return seen_in_body<double>(table_pose<double>(surroundings.axes, actual), surroundings.force);
}

VectorXd TableMotion::truth(const VectorXd& errors) const {
  VectorXd out(static_cast<Eigen::Index>(6 * parts_.size()));
  if (parts_.empty()) return out;
  const auto surroundings = surroundings_of<double>(local(parts_.front(), errors));
  for (std::size_t k = 0; k < parts_.size(); ++k)
    out.segment<6>(static_cast<Eigen::Index>(6 * k)) = truth_of<double>(parts_[k], surroundings, local(parts_[k], errors));
  return out;
}

Eigen::Matrix<double, 6, TableMotion::locals> TableMotion::local_jacobian(const Part& part, const std::array<double, locals>& value) const {
  using Jet = Eigen::AutoDiffScalar<Eigen::Vector<double, locals>>;
  std::array<Jet, locals> e;
  for (std::size_t l = 0; l < locals; ++l) e[l] = Jet(value[l], locals, static_cast<int>(l));
  const Eigen::Matrix<Jet, 6, 1> truth = truth_of<Jet>(part, surroundings_of<Jet>(e), e);
  Eigen::Matrix<double, 6, locals> out;
  for (Eigen::Index row = 0; row < 6; ++row) out.row(row) = truth[row].derivatives();
  return out;
}

MatrixXd TableMotion::jacobian(const VectorXd& errors) const {
  MatrixXd out = MatrixXd::Zero(static_cast<Eigen::Index>(6 * parts_.size()), errors.size());
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    const auto derivatives = local_jacobian(parts_[k], local(parts_[k], errors));
    for (std::size_t l = 0; l < locals; ++l)
      for (const int source : {parts_[k].first[l], parts_[k].second[l]})
        if (source != no_source) out.col(source).segment<6>(static_cast<Eigen::Index>(6 * k)) += derivatives.col(static_cast<Eigen::Index>(l));
  }
  return out;
}

std::vector<MatrixXd> TableMotion::curvatures(const VectorXd& errors, const MatrixXd& weights) const {
  // Central differences of the exact derivatives. The truth's higher derivatives are as large as its second: errors are step^2 and rounding / step.
  constexpr double step = 1e-4;
  std::vector<MatrixXd> out(static_cast<std::size_t>(weights.rows()), MatrixXd::Zero(errors.size(), errors.size()));
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    const Part& part = parts_[k];
    const auto weight = weights.middleCols<6>(static_cast<Eigen::Index>(6 * k));
    for (std::size_t l = 0; l < locals; ++l) {
      if (part.first[l] == no_source && part.second[l] == no_source) continue;
      auto more = local(part, errors), less = more;
      more[l] += step, less[l] -= step;
      const MatrixXd second = weight * (local_jacobian(part, more) - local_jacobian(part, less)) / (2 * step);
      for (const int source : {part.first[l], part.second[l]})
        for (std::size_t m = 0; m < locals && source != no_source; ++m)
          for (const int other : {part.first[m], part.second[m]})
            for (std::size_t sum = 0; sum < out.size() && other != no_source; ++sum)
              out[sum](source, other) += second(static_cast<Eigen::Index>(sum), static_cast<Eigen::Index>(m));
    }
  }
  return out;
}

}  // namespace imulab
