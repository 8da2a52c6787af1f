// The library's functions against the command, to the last bit.
#include "imulab/compensate.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/model/compensation_derivatives.hpp"

#include <gmock/gmock.h>

#include "tests/run_command.hpp"

namespace imulab {
namespace {

/// What depends on the time, on files and on the command line alone is the command's.
std::string numbers_of(Calibration c) {
  c.created.clear(), c.options.clear(), c.sources.clear(), c.session_file.clear();
  return calibration_text(c);
}

TEST(Library, CalibratesAndCompensatesAsTheCommandDoes) {
  const TemporaryFolder folder;
  for (const char* arguments : {"procedure handheld --poses 20 -o p.toml", "simulate p.toml --seed 3 -o session",
                                "calibrate session --method static -o c.json", "compensate c.json session -o out"})
    ASSERT_EQ(run_imulab(folder, arguments).exit_code, 0) << arguments;
  ASSERT_EQ(run_shell(folder, "cp session/session.toml out").exit_code, 0);
  const Session session = read_session(folder / "session/session.toml");
  const Recording recording = read_recording(session, session.recordings.front()).recording;
  const Calibration c = calibrate("static", {session, {&recording, 1}}).calibration;
  const Calibration of_command = read_calibration(folder / "c.json");
  EXPECT_EQ(numbers_of(c), numbers_of(of_command));
  EXPECT_EQ(c.software, of_command.software);

  const Session compensated = read_session(folder / "out/session.toml");
  const Recording written = read_recording(compensated, compensated.recordings.front()).recording;
  ASSERT_EQ(written.size(), recording.size());
  const SampleCompensator compensator(of_command.model, {.leave_lever_arms = true});
  for (std::size_t i = 0; i < recording.size(); ++i) {
    const auto reading = [&](const Columns3& triad) { return Vector3d(triad[0][i], triad[1][i], triad[2][i]); };
    const auto [rate, force] = compensator(reading(recording.gyro), reading(recording.accel));
    ASSERT_EQ(rate, reading(written.gyro)) << i;
    ASSERT_EQ(force, reading(written.accel)) << i;
  }
}

}  // namespace
}  // namespace imulab
