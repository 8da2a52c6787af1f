#include "imulab/simulate/simulate_aid.hpp"

#include "imulab/core/random.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/navigation/aided/aided_budget.hpp"
#include "imulab/rig/machine.hpp"
#include "imulab/units.hpp"

#include <Eigen/Geometry>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

namespace imulab {
namespace {

using Eigen::Vector3d, Eigen::Matrix3d;

/// The true motion of a point of the body.
struct PointMotion {
  double latitude = 0, longitude = 0, height = 0;
  Vector3d velocity, velocity_b;  // east-north-up and right-forward-up
  double heading = 0;             // of the forward axis
  Eigen::Matrix3d C_nb;
  double meridian_radius = 0, parallel_radius = 0;
};

PointMotion motion_at(const motion::Kinematics& body, const Vector3d& arm) {
  const LocalEarth earth = local_earth(body.latitude, body.height);
  const Vector3d rate_eb_b = body.rate_nb_b + body.C_nb.transpose() * earth.transport_rate(body.velocity), moved = body.C_nb * arm;
  PointMotion p;
  p.meridian_radius = earth.meridian_radius, p.parallel_radius = earth.transverse_radius * earth.cos_latitude;
  p.latitude = body.latitude + moved.y() / p.meridian_radius;
  p.longitude = body.longitude + moved.x() / p.parallel_radius;
  p.height = body.height + moved.z();
  p.velocity = body.velocity + body.C_nb * rate_eb_b.cross(arm);
  p.velocity_b = body.C_nb.transpose() * p.velocity;
  const Vector3d forward = body.C_nb.col(1);
  p.heading = std::atan2(forward.x(), forward.y());
  p.C_nb = body.C_nb;
  return p;
}

/// Errors of equal standard deviation on three axes, row by row.
class AidErrors {
 public:
  AidErrors(double sigma, std::optional<double> correlation, double interval, const RandomStream& draws) : draws_(draws) {
    white_ = sigma * (correlation ? std::sqrt(white_share) : 1);
    slow_ = correlation ? sigma * std::sqrt(1 - white_share) : 0;
    decay_ = correlation ? std::exp(-interval / *correlation) : 0;
    state_ = slow_ * next_draw();
  }
  Vector3d next() {
    const Vector3d error = state_ + white_ * next_draw();
    state_ = decay_ * state_ + slow_ * std::sqrt(1 - decay_ * decay_) * next_draw();
    return error;
  }

 private:
  Vector3d next_draw() {
    Vector3d v;
    for (double& each : v) each = draws_.normal(drawn_++);
    return v;
  }

  RandomStream draws_;
  std::uint64_t drawn_ = 0;
  double white_ = 0, slow_ = 0, decay_ = 0;
  Vector3d state_;
};

double value_at(AidKind kind, const PointMotion& point) {
  return kind == AidKind::wheels ? point.velocity_b.y() : kind == AidKind::barometer ? point.height : point.heading;
}

double default_value_sigma(AidKind kind) {
  return kind == AidKind::wheels ? 0.1 : kind == AidKind::barometer ? 1 : has_attitude(kind) ? 0.1 * unit::deg : 1 * unit::deg;
}

/// The horizontal displacement of a position at a time.
Vector3d jump_at(const Aid& aid, double time, const RandomStream& draws) {
  for (std::size_t k = 0; k < aid.jumps.size(); ++k)
    if (time >= aid.jumps[k].begin && time < aid.jumps[k].end) {
      const double direction = 2 * std::numbers::pi * draws.uniform(k);
      return aid.jump.value_or(0) * Vector3d(std::sin(direction), std::cos(direction), 0);
    }
  return Vector3d::Zero();
}

/// What is declared; the sizes that are not, as documented.
Aid with_defaults(Aid aid) {
  if (aid.kind == AidKind::gnss && !aid.position_sigma && !aid.velocity_sigma) aid.position_sigma = 1.5, aid.velocity_sigma = 0.05;
  if (aid.kind != AidKind::gnss && !aid.value_sigma) aid.value_sigma = default_value_sigma(aid.kind);
  if (has_attitude(aid.kind) && !aid.position_sigma) aid.position_sigma = aid.kind == AidKind::pose ? 0.002 : 0.01;
  return aid;
}

void add_gnss_row(const Aid& aid, const PointMotion& point, const Vector3d& error, const Vector3d& velocity_error, AidRecord& record) {
  if (aid.position_sigma) {
    record.position.emplace_back(point.latitude + error.y() / point.meridian_radius, point.longitude + error.x() / point.parallel_radius,
                                 point.height + error.z());
    record.position_sigma.push_back(Vector3d::Constant(*aid.position_sigma));
  }
  if (aid.velocity_sigma) {
    record.velocity.push_back(point.velocity + velocity_error);
    record.velocity_sigma.push_back(Vector3d::Constant(*aid.velocity_sigma));
  }
}

/// The frame of poses: from east-north-up axes to its own. Its tilt is a shortest rotation, so level axes in it are east and north.
Matrix3d frame_in(AidFrame frame, const RandomStream& draws) {
  return frame == AidFrame::free ? rotation_exp(Vector3d(draws.normal(10), draws.normal(11), 0)) : Matrix3d::Identity();
}

void add_pose_row(const Aid& aid, const PointMotion& first, const PointMotion& point, const Matrix3d& frame, const Vector3d& error,
                  const Vector3d& turn, AidRecord& record) {
  if (aid.kind != AidKind::attitude) {
    const Vector3d way((point.longitude - first.longitude) * first.parallel_radius, (point.latitude - first.latitude) * first.meridian_radius,
                       point.height - first.height);
    record.place.push_back(frame * way + error);
    record.position_sigma.push_back(Vector3d::Constant(*aid.position_sigma));
  }
  record.attitude.push_back(Eigen::Quaterniond(frame * point.C_nb * rotation_exp(turn)).coeffs());
  record.value_sigma.push_back(*aid.value_sigma);
}

}  // namespace

double aid_rate(const Aid& aid) {
  const bool fast = aid.kind == AidKind::wheels || aid.kind == AidKind::barometer;
  return aid.rate.value_or(has_attitude(aid.kind) ? 100 : fast ? 10 : 1);
}

SimulatedAid simulate_aid(const Aid& declared, std::size_t number, const motion::Trajectory& motion, std::uint64_t seed) {
  if (!has_record(declared.kind)) throw Error(fmt::format("an aid of kind {} measures nothing; expected one with a file", to_string(declared.kind)));
  const auto stream = [&](const char* of) { return RandomStream(seed, fmt::format("aid {} {}", number, of)); };
  const Aid aid = with_defaults(declared);
  SimulatedAid out{declared};
  const RandomStream installed = stream("installation");
  for (Eigen::Index i = 0; i < 3; ++i)
    out.lever_arm[i] =
        aid.lever_arm.value_or(Vector3d::Zero())[i] + aid.lever_arm_sigma.value_or(0) * installed.normal(static_cast<std::uint64_t>(i));
  out.delay = aid.delay.value_or(0) + aid.delay_sigma.value_or(0) * installed.normal(3);
  const double rate = aid_rate(aid);
  const bool gnss = aid.kind == AidKind::gnss, poses = has_attitude(aid.kind);
  AidErrors errors(gnss || poses ? aid.position_sigma.value_or(0) : *aid.value_sigma, aid.correlation, 1 / rate, stream("errors"));
  AidErrors velocity_errors(poses ? *aid.value_sigma : aid.velocity_sigma.value_or(0), std::nullopt, 1 / rate, stream("velocity errors"));
  const Matrix3d frame = frame_in(aid.frame, installed);
  const PointMotion first = motion_at(motion.at(0), out.lever_arm);
  AidRecord& record = out.aid.record = {};
  for (std::size_t k = 0; static_cast<double>(k) / rate <= motion.duration; ++k) {
    const double time = static_cast<double>(k) / rate;
    const PointMotion point = motion_at(motion.at(time), out.lever_arm);
    record.time.push_back(std::llround(1e9 * (time + out.delay)));
    const Vector3d error = errors.next();
    if (gnss) {
      add_gnss_row(aid, point, error + jump_at(aid, time, stream("jumps")), velocity_errors.next(), record);
    } else if (poses) {
      add_pose_row(aid, first, point, frame, error, velocity_errors.next(), record);
    } else {
      record.value.push_back(value_at(aid.kind, point) + error.x());
      record.value_sigma.push_back(*aid.value_sigma);
    }
  }
  out.aid.scale = TimeScale::recording;
  out.aid.rate.reset(), out.aid.jump.reset(), out.aid.jumps.clear();
  return out;
}

motion::Trajectory trajectory_on_rig(const Session& procedure, const RecordingSource& source, const RigErrors& errors) {
  const RigDeclaration* rig = procedure.rig_of(source);
  if (rig != nullptr && is_machine(rig->kind))
    throw Error(fmt::format("aids on a rig of kind {} are not simulated; expected a turntable, or a hand", to_string(rig->kind)));
  const Site& site = procedure.site;
  if (!site.latitude || !site.longitude || !site.height)
    throw Error("the site lacks latitude, longitude or height, which an aid measures; expected latitude_deg, longitude_deg and height_m in [site]");
  const RigMotion turning = recorded_motion(procedure, source, errors);
  const auto at = [turning, site](double time) {
    const BodyState body = body_state(turning, std::min(time, turning.end()));
    motion::Kinematics k;
    k.latitude = *site.latitude, k.longitude = *site.longitude, k.height = *site.height;
    k.C_nb = body.C_nb, k.rate_nb_b = body.rate_nb_b;
    return k;
  };
  return {turning.end(), {}, at};
}

}  // namespace imulab
