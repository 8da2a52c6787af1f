#include "imulab/estimate/hybrid/path_parts.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/recording/turn.hpp"
#include "imulab/rig/turntable.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace imulab::hybrid {

namespace {

constexpr double quarter = std::numbers::pi / 2;
constexpr std::array<int, 4> turns{1, 2, -1, -2};

std::size_t index_of(int quarters) { return static_cast<std::size_t>(std::find(turns.begin(), turns.end(), quarters) - turns.begin()); }

BodyState body_at(const QuarterPose& pose, std::size_t turning) {
  AxisStates states;
  for (std::size_t a = 0; a < 3; ++a) states[a].angle = pose[a] * quarter;
  states[turning].rate = 1;
  BodyState body = turntable_state(ideal_axes(), states);
  body.C_nb = body.C_nb.array().round();  // exactly one of 24
  return body;
}

}  // namespace

PathParts::PathParts(const InformationModel& model, double turn_rate, double acceleration, int quantum, int most)
    : turn_rate_(turn_rate), acceleration_(acceleration) {
  std::vector<Matrix3d> attitudes;
  for (int p = 0; p < 64; ++p) {
    const QuarterPose pose{p / 16, p / 4 % 4, p % 4};
    for (std::size_t a = 0; a < 3; ++a) {
      const BodyState body = body_at(pose, a);
      const Vector3d axis = body.C_nb * body.rate_nb_b;
      Eigen::Index along;
      axis.cwiseAbs().maxCoeff(&along);
      axis_[place(pose)][a] = {static_cast<std::size_t>(along), axis[along] < 0 ? 1u : 0u};
      if (a > 0) continue;
      const auto found = std::find(attitudes.begin(), attitudes.end(), body.C_nb);
      attitude_[place(pose)] = static_cast<std::size_t>(found - attitudes.begin());
      if (found == attitudes.end()) attitudes.push_back(body.C_nb);
    }
  }
  turn_.resize(attitudes.size());
  rest_.resize(attitudes.size());
  tbb::parallel_for(std::size_t{0}, attitudes.size(), [&](std::size_t k) {
    for (Eigen::Index a = 0; a < 3; ++a)
      for (std::size_t t = 0; t < turns.size(); ++t)
        turn_[k][static_cast<std::size_t>(a)][t] =
            turn_information(model, attitudes[k], {Vector3d::Unit(a), turns[t] * quarter, turn_rate_, acceleration_});
    const int of_turns = model.observe_motion ? 0 : unseen_before + unseen_after, at_end = std::max<int>(of_turns, settling_time);
    const MotionInformation one = rest_information(model, attitudes[k], quantum);
    for (const std::size_t outermost : {0u, 1u}) {
      std::vector<MotionInformation>& rests = rest_[k][outermost];
      rests.push_back(rest_information(model, attitudes[k], quantum - (outermost == 1 ? at_end : of_turns)));
      for (int quanta = 2; quanta <= most; ++quanta) rests.push_back(joined(rests.back(), one));
    }
  });
}

const MotionInformation& PathParts::turn(const QuarterPose& pose, const QuarterTurn& turn) const {
  const auto [along, opposite] = axis_[place(pose)][static_cast<std::size_t>(turn.axis)];
  return turn_[attitude_[place(pose)]][along][index_of(opposite == 1 ? -turn.quarters : turn.quarters)];
}

const MotionInformation& PathParts::rest(const QuarterPose& pose, int quanta, bool outermost) const {
  return rest_[attitude_[place(pose)]][outermost ? 1 : 0][static_cast<std::size_t>(quanta - 1)];
}

QuarterPose PathParts::turned(QuarterPose pose, const QuarterTurn& turn) const {
  int& angle = pose[static_cast<std::size_t>(turn.axis)];
  angle = (angle + turn.quarters + 4) % 4;
  return pose;
}

double PathParts::duration(const QuarterTurn& turn) const { return turn_duration(turn.quarters * quarter, turn_rate_, acceleration_); }

}  // namespace imulab::hybrid
