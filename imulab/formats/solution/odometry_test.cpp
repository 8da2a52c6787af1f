#include "imulab/formats/solution/odometry.hpp"

#include "imulab/earth.hpp"
#include "imulab/formats/recording/bag/bytes.hpp"
#include "imulab/formats/recording/bag/chunk.hpp"
#include "imulab/formats/recording/bag/topics.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include "tests/temporary_folder.hpp"
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

namespace imulab {
namespace {

struct ReadMessage {
  std::int32_t seconds = 0;
  std::uint32_t nanoseconds = 0;
  std::vector<double> numbers;  // position, quaternion x y z w, covariance, linear, angular, covariance
};

/// By the rules of CDR: eight bytes of time, "map" and "base_link" with their lengths and ends, then doubles aligned to eight.
ReadMessage read_odometry(std::string_view bytes) {
  constexpr std::size_t head = 4, numbers = 32;
  ReadMessage out{bag::load<std::int32_t>(bytes.data() + head), bag::load<std::uint32_t>(bytes.data() + head + 4), {}};
  EXPECT_EQ(bytes.substr(head + 12, 3), "map");
  EXPECT_EQ(bytes.substr(head + 20, 9), "base_link");
  for (std::size_t at = head + numbers; at + 8 <= bytes.size(); at += 8) out.numbers.push_back(bag::load<double>(bytes.data() + at));
  return out;
}

/// 1.25 s before 1970 and later: eastward at 10 m/s, turning left by 0.5 deg a step; the second state is 1 km north of the first.
AidedNavigation short_drive() {
  AidedNavigation n;
  for (int i = 0; i < 3; ++i) {
    NavigationState s;
    s.latitude = 45 * unit::deg + (i > 0 ? 1000 / local_earth(45 * unit::deg, 200).meridian_radius : 0);
    s.longitude = 10 * unit::deg, s.height = 200, s.velocity = {10, 0, 0};
    s.q_nb = Eigen::Quaterniond(attitude_matrix({0, 0, (90 - 0.5 * i) * unit::deg}));
    n.solution.time.push_back(-1.25 + 0.5 * i), n.solution.states.push_back(s);
  }
  Eigen::Matrix<double, 9, 1> sigma;
  sigma << 0.001, 0.002, 0.01, 0.1, 0.2, 0.3, 1, 2, 3;
  n.covariance = {{-1.25, sigma.cwiseAbs2().asDiagonal()}, {0, sigma.cwiseAbs2().asDiagonal()}};
  return n;
}

std::vector<ReadMessage> messages_of(const std::filesystem::path& file) {
  std::vector<ReadMessage> out;
  const auto bag = bag::open_bag(file);
  EXPECT_EQ(bag->topics().size(), 1u);
  EXPECT_THAT(bag->warnings(), testing::IsEmpty());
  const bag::Topic& topic = bag->topics().front();
  EXPECT_EQ(topic.name, "/imulab/odometry");
  EXPECT_EQ(topic.type, "nav_msgs/msg/Odometry");
  bag->each_message(topic, [&](std::int64_t, std::string_view bytes) {
    EXPECT_EQ(bytes.size(), 4 + 32 + 8 * (7 + 36 + 6 + 36));
    out.push_back(read_odometry(bytes));
  });
  return out;
}

void write_odometry(const std::filesystem::path& path, const AidedNavigation& n) {
  OdometryFile file(path);
  for (std::size_t i = 0; i < n.solution.size(); ++i) file.add(n, n.solution.time[i], n.solution.states[i]);
  file.commit();
}

TEST(Odometry, IsCompressed) {
  if (bag::compression_of_new_bags().empty()) GTEST_SKIP() << "a build without libzstd";
  AidedNavigation n = short_drive();
  for (int i = 3; i < 1000; ++i) n.solution.time.push_back(-1.25 + 0.5 * i), n.solution.states.push_back(n.solution.states.back());
  const TemporaryFolder folder;
  write_odometry(folder / "drive.mcap", n);
  EXPECT_EQ(messages_of(folder / "drive.mcap").size(), 1000u);
  EXPECT_LT(std::filesystem::file_size(folder / "drive.mcap"), 1000u * 720u / 4) << "covariances are mostly zeros";
}

TEST(Odometry, IsInTheAxesOfTheFirstPosition) {
  const TemporaryFolder folder;
  write_odometry(folder / "drive.mcap", short_drive());
  const std::vector<ReadMessage> all = messages_of(folder / "drive.mcap");
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0].seconds, -2);
  EXPECT_EQ(all[0].nanoseconds, 750'000'000u);
  const std::vector<double>&a = all[0].numbers, &b = all[1].numbers;
  for (int k = 0; k < 3; ++k) EXPECT_EQ(a[k], 0);
  EXPECT_NEAR(a[6], 1, 1e-12);  // forward is east: the axes of the map
  EXPECT_NEAR(b[1], 1000, 0.01);
  EXPECT_NEAR(b[2], -1000. * 1000 / 2 / 6.37e6, 1e-3);  // below the plane of the first position
  EXPECT_NEAR(2 * std::asin(b[5]), 0.5 * unit::deg, 1e-6);
  constexpr std::size_t linear = 43, angular = 46;
  EXPECT_NEAR(a[linear], 10, 1e-9);
  EXPECT_NEAR(b[linear + 1], -10 * std::sin(0.5 * unit::deg), 1e-9);
  for (const ReadMessage& m : all) EXPECT_NEAR(m.numbers[angular + 2], 1 * unit::deg, 1e-9);  // rad/s, to the left
}

TEST(Odometry, HasTheWholeCovariance) {
  const TemporaryFolder folder;
  write_odometry(folder / "drive.mcap", short_drive());
  const std::vector<double> a = messages_of(folder / "drive.mcap").at(0).numbers;
  const auto pose = [&](std::size_t i, std::size_t j) { return a[7 + 6 * i + j]; };
  const auto twist = [&](std::size_t i, std::size_t j) { return a[49 + 6 * i + j]; };
  for (const auto& [k, sigma] : {std::pair(0, 1.), std::pair(1, 2.), std::pair(2, 3.), std::pair(3, 0.001), std::pair(4, 0.002), std::pair(5, 0.01)})
    EXPECT_NEAR(pose(k, k), sigma * sigma, 1e-12 * sigma * sigma);
  EXPECT_NEAR(twist(0, 0), 0.1 * 0.1, 1e-12);
  EXPECT_NEAR(twist(1, 1), 0.2 * 0.2 + 10 * 10 * 0.01 * 0.01, 1e-12);    // the heading turns 10 m/s sideways
  EXPECT_NEAR(twist(2, 2), 0.3 * 0.3 + 10 * 10 * 0.002 * 0.002, 1e-12);  // the tilt about north, upward
  EXPECT_EQ(twist(3, 3), 0);
}

}  // namespace
}  // namespace imulab
