// Aids of a simulated mission, against the truth beside them.
#include "imulab/tasks/aid_files.hpp"

#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/session/mission.hpp"
#include "imulab/tasks/simulate.hpp"
#include "imulab/tasks/trajectory.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include "tests/temporary_folder.hpp"
#include <cmath>
#include <string>

namespace imulab {
namespace {

using ::testing::HasSubstr;

const std::string drive_head =
    "format = \"imulab.mission/1\"\nrate_hz = 10\ncarrier = \"vehicle\"\nstart = { latitude_deg = 40, longitude_deg = -105, height_m = 1600 }\n"
    "[[segment]]\nkind = \"rest\"\nduration_s = 10\n"
    "[[segment]]\nkind = \"accelerate\"\nduration_s = 10\nto_mps = 15\n"
    "[[segment]]\nkind = \"turn\"\nangle_deg = 720\nrate_dps = 10\n"
    "[[segment]]\nkind = \"straight\"\nduration_s = 1000\n";

struct SimulatedDrive {
  TemporaryFolder folder;
  FlownMission flown;
  Session session;
  AidsReading aids;

  explicit SimulatedDrive(const std::string& tables) {
    const std::filesystem::path mission = folder.write("drive.toml", drive_head + tables);
    flown = fly(read_mission(mission), {.mission = mission.string()});
    write_flown(folder / "drive", flown);
    session = read_session(folder / "drive");
    const RecordingSource& source = session.recordings.front();
    aids = read_aids(session, source, read_recording(session, source).recording);
  }
  /// The truth at a row of the truth's file, 10 a second.
  const NavigationState& truth(double time) const { return flown.truth.states.at(static_cast<std::size_t>(std::lround(10 * time))); }
};

/// East, north, up [m].
Eigen::Vector3d apart(const Eigen::Vector3d& position, const NavigationState& from) {
  const LocalEarth earth = local_earth(from.latitude, from.height);
  return {(position.y() - from.longitude) * earth.transverse_radius * earth.cos_latitude, (position.x() - from.latitude) * earth.meridian_radius,
          position.z() - from.height};
}

TEST(SimulatedAids, AreWhereTheAntennaWasAndLateByTheDelay) {
  const SimulatedDrive drive(
      "[[aid]]\nkind = \"gnss\"\nlever_arm_m = [0.4, -1.5, 1.2]\ndelay_s = 0.3\nposition_sigma_m = 1e-4\nvelocity_sigma_mps = 1e-5\nrate_hz = 2\n"
      "outages_s = [[300, 360]]\n[[aid]]\nkind = \"vehicle\"\n[[aid]]\nkind = \"wheels\"\nspeed_sigma_mps = 1e-5\n"
      "[[aid]]\nkind = \"heading\"\nheading_sigma_deg = 1e-6\n[[aid]]\nkind = \"barometer\"\nheight_sigma_m = 1e-4\n");
  ASSERT_EQ(drive.aids.aids.size(), 5u);
  EXPECT_TRUE(drive.aids.warnings.empty());
  const Aid& gnss = drive.aids.aids[0];
  EXPECT_EQ(gnss.file, "gnss_1.csv");
  EXPECT_EQ(gnss.scale, TimeScale::recording);
  EXPECT_EQ(gnss.outages, (std::vector<Outage>{{300, 360}}));
  EXPECT_FALSE(gnss.rate);
  EXPECT_EQ(gnss.record.time[60], 30'300'000'000) << "of 30 s";
  const NavigationState& at = drive.truth(30);
  EXPECT_LT((apart(gnss.record.position[60], at) - at.q_nb * Eigen::Vector3d(0.4, -1.5, 1.2)).norm(), 1e-3) << "a decimal of the file is 0.01 mm";
  const NavigationState &before = drive.truth(29.9), &after = drive.truth(30.1);
  const Eigen::Vector3d arm(0.4, -1.5, 1.2), swing = (after.q_nb * arm - before.q_nb * arm) / 0.2;
  EXPECT_GT(swing.norm(), 0.2) << "in a turn of 10 deg/s";
  EXPECT_LT((gnss.record.velocity[60] - at.velocity - swing).norm(), 1e-4) << "errors of 1e-5 m/s, and a difference quotient over 2 deg";
  EXPECT_NEAR(drive.aids.aids[2].record.value[300], (at.q_nb.conjugate() * at.velocity).y(), 1e-4);
  const Eigen::Vector3d forward = at.q_nb * Eigen::Vector3d::UnitY();
  EXPECT_NEAR(std::remainder(drive.aids.aids[3].record.value[30] - std::atan2(forward.x(), forward.y()), 2 * M_PI), 0, 1e-7);
  EXPECT_NEAR(drive.aids.aids[4].record.value[300], at.height, 1e-3);
}

TEST(SimulatedAids, HaveTheErrorsThatAreDeclared) {
  const SimulatedDrive drive(
      "[[aid]]\nkind = \"gnss\"\nposition_sigma_m = 2\ncorrelation_s = 5\njumps_s = [[500, 600]]\njump_m = 100\n"
      "[[aid]]\nkind = \"gnss\"\nvelocity_sigma_mps = 0.1\ndelay_sigma_s = 0.1\n");
  const AidRecord& r = drive.aids.aids[0].record;
  ASSERT_GT(r.time.size(), 1000u);
  EXPECT_TRUE(r.velocity.empty()) << "none is declared";
  double sum = 0, lagged = 0, jumped = 0;
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  int n = 0;
  for (std::size_t i = 0; i < r.time.size(); ++i) {
    const double t = 1e-9 * static_cast<double>(r.time[i]);
    const Eigen::Vector3d error = apart(r.position[i], drive.truth(t));
    if (t >= 500 && t < 600) {
      jumped += error.head<2>().norm() / 100;
    } else {
      sum += error.squaredNorm(), lagged += error.dot(last), ++n;
    }
    last = t >= 499 && t < 600 ? Eigen::Vector3d::Zero().eval() : error;
  }
  // 3 x 970 values, of which one in ten is independent: 4 % of the standard deviation.
  EXPECT_NEAR(std::sqrt(sum / (3 * n)), 2, 0.25);
  EXPECT_NEAR(lagged / sum, 0.9 * std::exp(-1.0 / 5), 0.06);
  EXPECT_NEAR(jumped, 100, 2);
  EXPECT_NE(drive.flown.aids[1].delay, 0);
  EXPECT_THAT(read_text(drive.folder / "drive/gnss_2.csv"), HasSubstr("delay_s = "));
}

TEST(SimulatedAids, OfAProcedureStandAtItsSite) {
  const std::string procedure =
      "format = \"imulab.session/1\"\n[imu]\nname = \"one\"\ngrade = \"mems\"\n[site]\nlatitude_deg = 48\nlongitude_deg = 11\nheight_m = "
      "500\n[rig]\nkind = "
      "\"turntable\"\n"
      "[[step]]\nkind = \"hold\"\nduration_s = 5\n[[step]]\nkind = \"rotate\"\naxis = \"outer\"\nangle_deg = 90\nrate_dps = 30\n[[step]]\nkind = "
      "\"hold\"\nduration_s = 5\n"
      "[[aid]]\nkind = \"gnss\"\nlever_arm_m = [0, 1, 0]\nposition_sigma_m = 1e-4\n";
  const Simulation made = simulate_session(parse_session(procedure, "procedure.toml"));
  ASSERT_EQ(made.aids.size(), 1u);
  NavigationState site;
  site.latitude = 48 * unit::deg, site.longitude = 11 * unit::deg, site.height = 500;
  const AidRecord& r = made.aids[0].aid.record;
  EXPECT_LT((apart(r.position.front(), site) - Eigen::Vector3d(0, 1, 0)).norm(), 1e-3);
  EXPECT_LT((apart(r.position.back(), site) - Eigen::Vector3d(-1, 0, 0)).norm(), 1e-3) << "after a turn to the left";
  EXPECT_EQ(made.session.aids[0].file, "gnss_1.csv");
  EXPECT_EQ(made.session.aids[0].record, r) << "also without the file";
}

}  // namespace
}  // namespace imulab
