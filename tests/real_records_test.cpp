// Two calibrations of one real sensor from different data agree within what they state: without a truth, the test of the stated uncertainties.
#include "imulab/coefficient.hpp"
#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/rests.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calibration_input.hpp"
#include "tests/run_command.hpp"
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

namespace imulab {
namespace {

const std::filesystem::path data = std::filesystem::path(IMULAB_SOURCE) / ".." / "shared" / "data";

/// 100 Hz, nothing but numbers; empty where the record is not here.
std::vector<std::vector<double>> columns_of(const std::filesystem::path& file, std::size_t count) {
  std::vector<std::vector<double>> columns(count);
  std::ifstream in(file);
  std::size_t at = 0;
  for (double value; in >> value; ++at) columns[at % count].push_back(value);
  return columns;
}

Recording recording_of(std::string accel_unit, std::string gyro_unit, Columns3 accel, Columns3 gyro) {
  Recording r;
  r.name = "by hand", r.interval_s = 0.01;
  r.accel_unit = std::move(accel_unit), r.gyro_unit = std::move(gyro_unit);
  r.accel = std::move(accel), r.gyro = std::move(gyro);
  for (std::size_t i = 0; i < r.accel[0].size(); ++i) r.time_ns.push_back(static_cast<std::int64_t>(i + 1) * 10'000'000);
  return r;
}

Recording xsens() {
  const auto accel = columns_of(data / "imu_tk_xsens" / "xsens_acc.mat", 4), gyro = columns_of(data / "imu_tk_xsens" / "xsens_gyro.mat", 4);
  return recording_of("count", "count", {accel[1], accel[2], accel[3]}, {gyro[1], gyro[2], gyro[3]});
}

Recording mpu9150() {
  const auto c = columns_of(data / "mpu9150_by_hand" / "imu3.log", 6);
  return recording_of("m/s^2", "rad/s", {c[0], c[1], c[2]}, {c[3], c[4], c[5]});
}

Recording part_of(const Recording& r, std::size_t begin, std::size_t end) {
  const auto cut = [&](const Columns3& triad) {
    Columns3 out;
    for (std::size_t j = 0; j < 3; ++j)
      out[j].assign(triad[j].begin() + static_cast<std::ptrdiff_t>(begin), triad[j].begin() + static_cast<std::ptrdiff_t>(end));
    return out;
  };
  return recording_of(r.accel_unit, r.gyro_unit, cut(r.accel), cut(r.gyro));
}

Site site() {
  Site out;
  out.given_gravity = 9.80665;
  return out;
}

std::vector<Range> rests_in(const Recording& r) {
  Session session;
  session.site = site();
  return rests_of(r, session).ranges;
}

Calibration by_hand(const Recording& r, const std::vector<Range>& rests) { return calibrated("handheld", r, rests, {}, site()); }

/// Coefficients that every IMU has and g-sensitivities, where both state them: their differences against both covariances. Priors and rests in common
/// make the differences smaller than that, never larger.
void expect_agreement(const Calibration& a, const Calibration& b, int least) {
  std::vector<Eigen::Index> at_a, at_b;
  for (std::size_t i = 0; i < a.estimated.size(); ++i)
    for (std::size_t k = 0; k < b.estimated.size(); ++k)
      if (const Term term = coefficient(a.estimated[i]).term; a.estimated[i] == b.estimated[k] && (!is_optional(term) || term == Term::g_sensitivity))
        at_a.push_back(static_cast<Eigen::Index>(i)), at_b.push_back(static_cast<Eigen::Index>(k));
  Eigen::VectorXd difference(std::ssize(at_a));
  for (Eigen::Index i = 0; i < difference.size(); ++i) {
    const CoefficientIndex index = a.estimated[static_cast<std::size_t>(at_a[static_cast<std::size_t>(i)])];
    difference[i] = coefficient_value(a.model, index) - coefficient_value(b.model, index);
  }
  const Eigen::MatrixXd covariance = a.covariance(at_a, at_a) + b.covariance(at_b, at_b);
  const Eigen::VectorXd unit = covariance.diagonal().cwiseSqrt().cwiseInverse(), scaled = unit.cwiseProduct(difference);
  const double chi2 = squared_norm_in(unit.asDiagonal() * covariance * unit.asDiagonal(), scaled);
  const auto count = static_cast<double>(difference.size());
  EXPECT_GE(count, least);
  EXPECT_LT(chi2, chi_square_quantile(0.99, count)) << "on " << count << ": once in a hundred";
}

void expect_parts_to_agree(const Recording& r, int least) {
  if (r.size() == 0) GTEST_SKIP() << "the record is not here: " << data;
  const std::vector<Range> rests = rests_in(r);
  {
    SCOPED_TRACE("even and odd rotations");
    const auto with_rotations = [&](std::size_t first) {
      Recording out = r;  // a gap in a rotation makes it useless
      for (std::size_t k = 1 - first; k + 1 < rests.size(); k += 2) out.gaps.push_back((rests[k].end + rests[k + 1].begin) / 2);
      return by_hand(out, rests);
    };
    expect_agreement(with_rotations(0), with_rotations(1), least);
  }
  {
    SCOPED_TRACE("even and odd rests");
    std::vector<Range> even, odd;
    for (std::size_t k = 0; k < rests.size(); ++k) (k % 2 == 0 ? even : odd).push_back(rests[k]);
    expect_agreement(by_hand(r, even), by_hand(r, odd), least);
  }
  {
    SCOPED_TRACE("halves");
    const Range& middle = rests[rests.size() / 2];
    const Recording first = part_of(r, 0, middle.begin + middle.size() / 2), second = part_of(r, middle.begin + middle.size() / 2, r.size());
    expect_agreement(by_hand(first, rests_in(first)), by_hand(second, rests_in(second)), least);
  }
}

TEST(RealRecords, PartsOfTheXsensRecordAgree) { expect_parts_to_agree(xsens(), 30); }
TEST(RealRecords, PartsOfTheMpu9150RecordAgree) { expect_parts_to_agree(mpu9150(), 25); }

TEST(RealRecords, AHalfThatDoesNotCoverTheDirectionsStatesNoWrongGyroOffset) {
  const Recording r = mpu9150();
  if (r.size() == 0) GTEST_SKIP() << "the record is not here: " << data;
  const Recording half = part_of(r, 0, r.size() / 2);
  const Calibration few = by_hand(half, rests_in(half)), whole = by_hand(r, rests_in(r));
  EXPECT_FALSE(few.quality.unobservable.empty());
  EXPECT_EQ(few.quality.verdict, Verdict::doubtful);
  for (const CoefficientIndex index : select_coefficients("gyro.offset")) {
    const auto u = standard_uncertainty(few, index);
    if (!u) continue;
    const double apart = std::abs(coefficient_value(few.model, index) - coefficient_value(whole.model, index));
    EXPECT_LT(apart, 4 * std::hypot(*u, *standard_uncertainty(whole, index))) << coefficient(index).name;
    EXPECT_LT(apart, 1000 * unit::deg_per_h) << coefficient(index).name << ": the rests show it to Earth's rate and the g-sensitivity";
  }
}

// A car with an RTK receiver: the sizes of twelve sources of noise settle, for `calibrate` as for `navigate`. The reason that remains is the grade's,
// which nothing declares.
TEST(RealRecords, TheNoiseOfADriveSettles) {
  const std::filesystem::path drive = std::filesystem::weakly_canonical(data / "drive_0708");
  if (!std::filesystem::exists(drive)) GTEST_SKIP() << "the record is not here: " << drive;
  const TemporaryFolder folder;
  folder.write("session.toml", fmt::format(R"(format = "imulab.session/1"
[imu]
name = "car"
grade = "mems"
[[recording]]
file = "{0}/imu.csv"
time = {{ column = "t_gpst_s", unit = "s", scale = "gps" }}
gyro = {{ columns = ["gx_dps", "gy_dps", "gz_dps"], output = "rate", unit = "deg/s", axes = ["-y", "+x", "+z"] }}
accel = {{ columns = ["ax_g", "ay_g", "az_g"], output = "rate", unit = "g", axes = ["-y", "+x", "+z"] }}
[[aid]]
kind = "gnss"
file = "{0}/gnss.pos"
lever_arm_m = [-0.05, 0, 0]
lever_arm_sigma_m = 0.3
delay_sigma_s = 0.5
[[aid]]
kind = "vehicle"
)",
                                           drive.string()));
  const CommandResult result = run_imulab(folder, "calibrate session.toml --method drive --effects none");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(on_one_line(result.output + result.errors),
              testing::Not(testing::AnyOf(testing::HasSubstr("converge"), testing::HasSubstr("still change"))));
}

}  // namespace
}  // namespace imulab
