#include "imulab/estimate/hybrid_filter.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/estimate/hybrid_blocks.hpp"
#include "imulab/estimate/hybrid_correction.hpp"
#include "imulab/estimate/hybrid_navigator.hpp"

#include <gtest/gtest.h>

#include "tests/hybrid_session.hpp"

namespace imulab {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

struct Navigated {
  Matrix3d C_nb;
  Vector3d velocity = Vector3d::Zero();
};

Navigated navigate(const HybridSession& s, const std::vector<HybridBlock>& blocks, const SensorModel& model, const HybridSite& site,
                   const HybridLayout& layout, const Matrix3d& start) {
  const HybridSamples samples = compensated(s.recording, blocks, model);
  HybridNavigator navigator(samples, s.recording, site, layout);
  navigator.C_nb = start;
  Navigated out;
  for (const HybridBlock& block : blocks) out.velocity += navigator.over(block, blocks.front().samples.begin).velocity;
  out.C_nb = navigator.C_nb;
  return out;
}

/// Errors of what a model computes against what another does, as the filter defines them: C_hat = (I - [phi x]) C.
VectorXd errors_of(const Navigated& computed, const Navigated& truth) {
  VectorXd e(6);
  e << -rotation_log(computed.C_nb * truth.C_nb.transpose()), computed.velocity - truth.velocity;
  return e;
}

TEST(HybridFilter, ItsDerivativesAreThoseOfTheNavigation) {
  // Three rests and the turns between them without noise at 100 Hz; every kind of state, each alone.
  const HybridSession s = hybrid_session(1, [](Session& session) {
    session = hybrid_procedure(6, 100);
    session.imu.accel_noise_density = session.imu.gyro_noise_density = 1e-14;
  });
  const HybridLayout layout = hybrid_layout({true, true, true, false}, false);
  HybridBlocks cut = hybrid_blocks(s.recording, {s.rests[0], s.rests[1], s.rests[2]}, true);
  for (HybridBlock& block : cut.blocks) block.observed = false;  // nothing but the transition
  const HybridSite site{*s.session.site.latitude, s.truth.gravity, 0, 1e-4};
  const HybridNoise noise{Vector3d::Constant(1e-9), Vector3d::Constant(1e-9)};
  const HybridSamples felt = compensated(s.recording, cut.blocks, s.truth.model);
  HybridNavigator navigator(felt, s.recording, site, layout);
  navigator.align(cut.blocks.front().samples);
  HybridSettings settings;
  settings.layout = layout;
  settings.start = navigator.C_nb;
  settings.start_sigma = Vector3d::Constant(1e-9);

  const VectorXd none = VectorXd::Zero(layout.constants);
  const Navigated computed = navigate(s, cut.blocks, s.truth.model, site, layout, navigator.C_nb);
  for (Index state = 0; state < layout.constants; ++state) {
    if (state >= HybridLayout::start && state < HybridLayout::start + 3) continue;
    // Large enough against rounding, small enough for its square: a rotation by 1e-5 is a square of 1e-10.
    VectorXd x = none;
    x[state] = state == HybridLayout::gravity ? 1e-5 : state < 3 ? 1e-4 : state >= layout.lever_arm && state < layout.lever_arm + 9 ? 1e-3 : 1e-6;
    HybridSite there = site;
    if (state == HybridLayout::gravity) there.gravity *= 1 + x[state];
    const VectorXd difference = errors_of(computed, navigate(s, cut.blocks, corrected(s.truth.model, x, layout), there, layout, navigator.C_nb));
    const VectorXd predicted = hybrid_pass(s.recording, cut.blocks, s.truth.model, site, noise, settings, x, none).x.tail(6);
    // What a sample's derivatives leave out goes with the square of the 2e-3 rad it turns; the size effect takes the rate at a block's end from its
    // neighbours. The absolute part: a quadratic term squares its own axis's reading, without what its neighbours' misalignments add.
    for (const Index part : {0, 3})
      EXPECT_LT((difference - predicted).segment<3>(part).norm(), 2e-3 * difference.segment<3>(part).norm() + (part == 0 ? 1e-13 : 2e-10))
          << "state " << state << (part == 0 ? ", attitude " : ", velocity ") << difference.segment<3>(part).transpose() << " predicted "
          << predicted.segment<3>(part).transpose();
  }
}

TEST(HybridBlocks, CoverTheRecordingFromTheFirstRestToTheLast) {
  const HybridSession s = hybrid_session(2);
  const std::vector<HybridBlock> blocks = hybrid_blocks(s.recording, s.rests, true).blocks;
  EXPECT_EQ(blocks.back().samples.end, s.rests.back().end);
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    EXPECT_GT(blocks[k].samples.size(), 0u);
    EXPECT_EQ(blocks[k].samples.begin, k > 0 ? blocks[k - 1].samples.end : s.rests.front().begin);
    EXPECT_LE(blocks[k].samples.size(), blocks[k].at_rest ? 30u : 9u);  // a second, or a fifth, and half more
  }
}

}  // namespace
}  // namespace imulab
