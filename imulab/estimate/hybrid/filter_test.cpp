#include "imulab/estimate/hybrid/filter.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/navigation/in_place/navigator.hpp"

#include <gtest/gtest.h>

#include "tests/hybrid_session.hpp"
#include <numbers>

namespace imulab::hybrid {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using in_place::cut_into_blocks;
using in_place::Navigator;

struct Navigated {
  Matrix3d C_nb;
  Vector3d velocity = Vector3d::Zero();
};

Navigated navigate(const Data& data, const SensorModel& model, const Place& place, const States& states, const Matrix3d& start) {
  Navigator navigator(data.recording, model, 0, place.latitude, place.gravity, states.sums());
  navigator.C_nb = start;
  Navigated out;
  for (const Block& block : data.blocks) out.velocity += navigator.over(block, data.blocks.front().samples.begin).velocity;
  out.C_nb = navigator.C_nb;
  return out;
}

/// Returns errors of one model's results relative to another's as the filter defines them: C_hat = (I - [phi x]) C.
VectorXd errors_of(const Navigated& computed, const Navigated& truth) {
  VectorXd e(6);
  e << -rotation_log(computed.C_nb * truth.C_nb.transpose()), computed.velocity - truth.velocity;
  return e;
}

/// Sets rests of 6 s at 100 Hz.
void without_noise(Session& session) {
  session = hybrid_procedure(6, 100);
  session.imu.accel_noise_density = session.imu.gyro_noise_density = 1e-14;
}

/// In each turn, a hand moves the unit to another place: up to 2 m/s^2 forward and back, in varying directions.
void move_by_hand(HybridSession& s) {
  Recording& r = s.recording;
  const SensorModel& model = s.truth.model;
  const Recording unmoved = r;
  Navigator at(unmoved, model, 0, *s.session.site.latitude, s.truth.gravity, {});
  at.align(s.rests.front());
  for (std::size_t k = 0, i = s.rests.front().begin; k + 1 < s.rests.size(); ++k) {
    const Range turn{s.rests[k].end, s.rests[k + 1].begin};
    for (; i < turn.begin; ++i) at.over({{i, i + 1}, true}, i);
    for (; i < turn.end; ++i) {
      const double phase = 2 * std::numbers::pi * (static_cast<double>(i - turn.begin) + 0.5) / static_cast<double>(turn.size());
      at.over({{i, i + 1}, false}, i);
      const Vector3d more = model.accel.matrix.inverse() * at.C_nb.transpose() * (2 * std::sin(phase) * Vector3d(1, k % 2 == 0 ? 1 : -1, 0.5));
      for (std::size_t j = 0; j < 3; ++j) r.accel[j][i] += more[static_cast<Index>(j)];
    }
  }
}

void expect_derivatives_of_the_navigation(const HybridSession& s) {
  // Three rests and the turns between them test every kind of state, each alone.
  const SensorModel& model = s.truth.model;
  const Place place{*s.session.site.latitude, s.truth.gravity, 0, 1e-4};
  const States states({.optional = {Group::lever_arm, Group::quadratic, Group::g_sensitivity}}, place);
  Data data{s.recording,
            cut_into_blocks(s.recording, {s.rests[0], s.rests[1], s.rests[2]}, true).blocks,
            place,
            {Vector3d::Constant(1e-9), Vector3d::Constant(1e-9)},
            model};
  for (Block& block : data.blocks) block.observed = false;  // only the transition is tested
  Navigator navigator(s.recording, model, 0, place.latitude, place.gravity, states.sums());
  navigator.align(data.blocks.front().samples);
  const Linearization about{model, place, navigator.C_nb};

  const Navigated computed = navigate(data, model, place, states, navigator.C_nb);
  const Index start = states.first(Group::start), gravity = states.first(Group::gravity), arms = states.first(Group::lever_arm);
  for (Index state = 0; state < states.constants(); ++state) {
    if (state >= start && state < start + 3) continue;
    kernel::Parameters known = states.parameters(VectorXd::Zero(states.constants()));
    known.sigma.setZero();
    known.sigma.segment<3>(start).setConstant(1e-9);
    // The step is large compared with rounding but has a small square: a rotation by 1e-5 has a square of 1e-10.
    known.offset[state] = state == gravity ? 1e-5 : state < 3 ? 1e-4 : state >= arms && state < arms + 9 ? 1e-3 : 1e-6;
    Place there = place;
    if (state == gravity) there.gravity *= 1 + known.offset[state];
    const VectorXd difference = errors_of(computed, navigate(data, corrected(model, known.offset, states), there, states, navigator.C_nb));
    const VectorXd predicted = filter_pass(data, about, states, known).x.tail(6);
    // The neglected part of a sample's derivatives is proportional to the square of its turn of 2e-3 rad; the size effect uses the rate at a block's
    // end from neighboring samples. The absolute part: a quadratic term squares the reading of its own axis, without the misalignments.
    for (const Index part : {0, 3})
      EXPECT_LT((difference - predicted).segment<3>(part).norm(), 2e-3 * difference.segment<3>(part).norm() + (part == 0 ? 1e-13 : 2e-10))
          << "state " << state << (part == 0 ? ", attitude " : ", velocity ") << difference.segment<3>(part).transpose() << " predicted "
          << predicted.segment<3>(part).transpose();
  }
}

TEST(HybridFilter, ItsDerivativesAreThoseOfTheNavigation) { expect_derivatives_of_the_navigation(hybrid_session(1, without_noise)); }

TEST(HybridFilter, ItsDerivativesAreThoseOfAHandThatMovesTheUnit) {
  HybridSession s = hybrid_session(1, without_noise);
  move_by_hand(s);
  expect_derivatives_of_the_navigation(s);
}

TEST(HybridFilter, ItsDerivativesAreTheSameWithTheForceThatIsKnown) {
  const HybridSession s = hybrid_session(1, without_noise);
  const Place place{*s.session.site.latitude, s.truth.gravity, 0, 1e-4};
  const States states({.optional = {Group::lever_arm, Group::quadratic, Group::g_sensitivity}}, place);
  std::vector<Block> blocks = cut_into_blocks(s.recording, {s.rests[0], s.rests[1], s.rests[2]}, true).blocks;
  Navigator measured(s.recording, s.truth.model, 0, place.latitude, place.gravity, states.sums()), known = measured;
  measured.align(blocks.front().samples);
  known.C_nb = measured.C_nb;
  for (Block& block : blocks) {
    const auto derivatives = [&](Navigator& navigator, bool observed) {
      block.observed = observed;
      const in_place::BlockSums sums = navigator.over(block, blocks.front().samples.begin);
      Eigen::MatrixXd all(6, states.constants() + 6);
      all.setZero();
      all.leftCols<6>() = sums.by_errors_before(place.latitude);
      for (const Index i : states.corrections()) all.col(6 + i) = sums.by_coefficient(coefficient(states.corrects(i)));
      return all;
    };
    const Eigen::MatrixXd by_measured = derivatives(measured, false), by_known = derivatives(known, true);
    // A measured force is the mean over its interval; the known force is taken at the middle: a difference of 1e-5 in a turn.
    for (Index i = 0; i < by_known.cols(); ++i)
      EXPECT_LT((by_known - by_measured).col(i).norm(), 3e-4 * by_measured.col(i).norm() + 3e-5)
          << "block at " << block.samples.begin << ", column " << i;
  }
}

TEST(HybridFilter, LevelsAStartThatIsTilted) {
  const HybridSession s = hybrid_session(1);
  const Place place{*s.session.site.latitude, s.truth.gravity, 0, 1e-9};
  const States states({}, place);
  const in_place::Noise noise = {Vector3d::Constant(*s.session.imu.gyro_noise_density), Vector3d::Constant(*s.session.imu.accel_noise_density)};
  const Data data{s.recording, cut_into_blocks(s.recording, s.rests, true).blocks, place, noise, s.truth.model};
  const kernel::Parameters known = states.parameters(VectorXd::Zero(states.constants()));
  const Pass level = filter_pass(data, {s.truth.model, place}, states, known);
  for (const Vector3d& tilt : {Vector3d(1e-2, 0, 0), Vector3d(0, -1e-2, 0)}) {
    const Pass tilted = filter_pass(data, {s.truth.model, place, rotation_exp(tilt) * level.start}, states, known);
    // The first second is still tilted: its vertical force is wrong by 5e-5, ten standard deviations of one velocity in four hundred.
    for (const Index i : states.corrections())
      EXPECT_NEAR(tilted.x[i], level.x[i], std::sqrt(level.covariance(i, i))) << coefficient(states.corrects(i)).name;
  }
}

TEST(HybridBlocks, CoverTheRecordingFromTheFirstRestToTheLast) {
  const HybridSession s = hybrid_session(2);
  const std::vector<Block> blocks = cut_into_blocks(s.recording, s.rests, true).blocks;
  EXPECT_EQ(blocks.back().samples.end, s.rests.back().end);
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    EXPECT_GT(blocks[k].samples.size(), 0u);
    EXPECT_EQ(blocks[k].samples.begin, k > 0 ? blocks[k - 1].samples.end : s.rests.front().begin);
    EXPECT_LE(blocks[k].samples.size(), blocks[k].at_rest ? 30u : 9u);  // a second, or a fifth of one, plus a half
  }
}

}  // namespace
}  // namespace imulab::hybrid
