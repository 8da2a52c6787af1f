// imulab compensate with a bag in and the same bag out.
#include <gmock/gmock.h>

#include "tests/bag_fixture.hpp"
#include "tests/run_command.hpp"

namespace imulab {
namespace {

using testing::HasSubstr;

/// A session of a bag, whose accelerometers are at their limit in `limits`.
void write_bag_session(const TemporaryFolder& folder, const std::string& file, const std::string& limits) {
  std::filesystem::copy_file(bag::fixture("imu_zstd.mcap"), folder / "run.mcap", std::filesystem::copy_options::overwrite_existing);
  folder.write(
      "session.toml",
      "format = \"imulab.session/1\"\n[imu]\nname = \"x\"\n[site]\ngravity_mps2 = 9.8\n[[recording]]\nfile = \"" + file +
          "\"\ntime = { column = \"header.stamp\", unit = \"ns\" }\n"
          "gyro = { columns = [\"angular_velocity.x\", \"angular_velocity.y\", \"angular_velocity.z\"], output = \"rate\", unit = \"rad/s\" }\n"
          "accel = { columns = [\"linear_acceleration.x\", \"linear_acceleration.y\", \"linear_acceleration.z\"], output = \"rate\", "
          "unit = \"m/s^2\"" +
          limits + " }\n");
}

class CompensateBag : public testing::Test {
 protected:
  CompensateBag() {
    EXPECT_EQ(run_imulab(folder_, "procedure handheld -o hand.toml").exit_code, 0);
    EXPECT_EQ(run_imulab(folder_, "simulate hand.toml -o hand").exit_code, 0);
    EXPECT_EQ(run_imulab(folder_, "calibrate hand --method handheld -o cal.json").exit_code, 0);
  }
  TemporaryFolder folder_;
};

TEST_F(CompensateBag, WritesTheReadingsOfTheTableIntoTheBag) {
  write_bag_session(folder_, "run.mcap", "");
  const CommandResult result = run_imulab(folder_, "compensate cal.json session.toml -o out.mcap");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
  EXPECT_THAT(on_one_line(result.output), HasSubstr("out.mcap: 60 samples, 0 saturated"));
  ASSERT_EQ(run_imulab(folder_, "compensate cal.json session.toml -o out.csv").exit_code, 0);
  const recording_io::TableRows in_bag = bag::read_columns(folder_ / "out.mcap", "/imu0", bag::imu_columns());
  const recording_io::TableRows in_table = bag::read_columns(folder_ / "out.csv", "", {"gx", "gy", "gz", "ax", "ay", "az"});
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(in_bag.columns[3 + k].numbers, in_table.columns[k].numbers);
}

TEST_F(CompensateBag, SaysThatMessagesHaveNoFlags) {
  write_bag_session(folder_, "run.mcap", ", limits = [-100, 9.5]");
  const CommandResult result = run_imulab(folder_, "compensate cal.json session.toml -o out.mcap");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(on_one_line(result.errors), HasSubstr("out.mcap: messages have no flags: 60 saturated"));
}

TEST_F(CompensateBag, NeverOverwritesItsInputAndRefusesOtherKinds) {
  write_bag_session(folder_, "run.mcap", "");
  const std::string before = read_text(folder_ / "run.mcap");
  EXPECT_EQ(run_imulab(folder_, "compensate cal.json session.toml -o run.mcap").exit_code, 2);
  EXPECT_EQ(read_text(folder_ / "run.mcap"), before);
  const CommandResult other = run_imulab(folder_, "compensate cal.json session.toml -o out.bag");
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(on_one_line(other.errors), HasSubstr("out.bag: run.mcap is a ROS 2 bag in MCAP; expected a file *.mcap for the compensated recording"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.bag"));
  EXPECT_EQ(run_imulab(folder_, "compensate cal.json hand -o out.mcap").exit_code, 2) << "a table is no bag";
}

}  // namespace
}  // namespace imulab
