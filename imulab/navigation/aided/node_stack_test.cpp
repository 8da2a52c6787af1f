#include "imulab/navigation/aided/node_stack.hpp"

#include "imulab/error.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <string>

namespace imulab::aided {
namespace {

/// Returns a node with different values in all members; its lists have zero to three elements.
Node drawn_node(std::size_t k, Eigen::Index size) {
  double n = static_cast<double>(k);
  const auto fill = [&](auto&& m) {
    for (Eigen::Index i = 0; i < m.size(); ++i) m.data()[i] = std::sqrt(++n);
  };
  Node node;
  node.samples = k;
  for (Eigen::VectorXd* v : {&node.reference.x, &node.error, &node.next.decay, &node.next.driven}) v->resize(size), fill(*v);
  fill(node.reference.motion.q_nb.coeffs()), fill(node.reference.motion.velocity);
  node.reference.motion.latitude = std::sqrt(++n), node.reference.motion.longitude = std::sqrt(++n), node.reference.motion.height = std::sqrt(++n);
  Eigen::MatrixXd half(size, size);
  fill(half);
  node.covariance = half + half.transpose();
  node.next.motion.resize(9, size), fill(node.next.motion), fill(node.next.gyro), fill(node.next.accel), node.next.interval = std::sqrt(++n);
  for (std::vector<EpochRows>* all : {&node.rows, &node.withheld})
    for (std::size_t i = 0; i < (all == &node.rows ? k % 4 : k % 2); ++i) {
      EpochRows& e = all->emplace_back();
      e.observation = i + 7, e.rows.source = {i, i + 1};
      for (Eigen::VectorXd* v : {&e.rows.residual, &e.rows.variance, &e.weight, &e.innovation, &e.innovation_variance}) v->resize(2), fill(*v);
      e.rows.derivative.resize(2, size), fill(e.rows.derivative), e.gain.resize(size, 2), fill(e.gain);
    }
  return node;
}

void expect_same(const EpochRows& a, const EpochRows& b) {
  EXPECT_EQ(a.observation, b.observation);
  EXPECT_EQ(a.rows.source, b.rows.source);
  EXPECT_EQ(a.rows.residual, b.rows.residual);
  EXPECT_EQ(a.rows.derivative, b.rows.derivative);
  EXPECT_EQ(a.rows.variance, b.rows.variance);
  EXPECT_EQ(a.weight, b.weight);
  EXPECT_EQ(a.innovation, b.innovation);
  EXPECT_EQ(a.innovation_variance, b.innovation_variance);
  EXPECT_EQ(a.gain, b.gain);
}

void expect_same(const Node& a, const Node& b) {
  EXPECT_EQ(a.samples, b.samples);
  EXPECT_EQ(a.reference.x, b.reference.x);
  EXPECT_EQ(a.reference.motion.q_nb.coeffs(), b.reference.motion.q_nb.coeffs());
  EXPECT_EQ(a.reference.motion.velocity, b.reference.motion.velocity);
  EXPECT_EQ(a.reference.motion.latitude, b.reference.motion.latitude);
  EXPECT_EQ(a.reference.motion.longitude, b.reference.motion.longitude);
  EXPECT_EQ(a.reference.motion.height, b.reference.motion.height);
  EXPECT_EQ(a.error, b.error);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.next.motion, b.next.motion);
  EXPECT_EQ(a.next.gyro, b.next.gyro);
  EXPECT_EQ(a.next.accel, b.next.accel);
  EXPECT_EQ(a.next.decay, b.next.decay);
  EXPECT_EQ(a.next.driven, b.next.driven);
  EXPECT_EQ(a.next.interval, b.next.interval);
  ASSERT_EQ(a.rows.size(), b.rows.size());
  for (std::size_t i = 0; i < a.rows.size(); ++i) expect_same(a.rows[i], b.rows[i]);
  ASSERT_EQ(a.withheld.size(), b.withheld.size());
  for (std::size_t i = 0; i < a.withheld.size(); ++i) expect_same(a.withheld[i], b.withheld[i]);
}

// Nodes of 130 kB are bit-identical over two blocks of 32 MB in the file.
TEST(NodeStack, GivesBackWhatItTook) {
  NodeStack stack;
  constexpr std::size_t count = 700;
  constexpr Eigen::Index size = 160;
  for (std::size_t k = 0; k < count; ++k) {
    stack.push(drawn_node(k, size));
    stack.back().error[0] = 1;  // the last node may still change
  }
  ASSERT_EQ(stack.size(), count);
  for (std::size_t k = count; k-- > 0;) {
    Node expected = drawn_node(k, size);
    expected.error[0] = 1;
    expect_same(stack.pop(), expected);
  }
  EXPECT_TRUE(stack.empty());
}

TEST(NodeStack, SaysWhereItFindsNoPlace) {
  const char* const before = std::getenv("TMPDIR");
  const std::string kept = before != nullptr ? before : "";
  setenv("TMPDIR", "/nowhere", 1);
  NodeStack stack;
  try {
    for (std::size_t k = 0; k < 400; ++k) stack.push(drawn_node(k, 160));
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), testing::AllOf(testing::HasSubstr("/nowhere: a temporary file cannot be made"), testing::HasSubstr("TMPDIR")));
  }
  before != nullptr ? setenv("TMPDIR", kept.c_str(), 1) : unsetenv("TMPDIR");
}

}  // namespace
}  // namespace imulab::aided
