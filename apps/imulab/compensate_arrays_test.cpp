// Compensated readings as arrays for NumPy.
#include "imulab/files.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/formats/recording/table_reader.hpp"
#include "imulab/formats/recording/written/csv_writer.hpp"
#include "imulab/session.hpp"

#include <gmock/gmock.h>

#include "tests/recorded_session.hpp"

namespace imulab {
namespace {

TEST(CompensateCommand, WritesArraysThatReadBackAsTheTableDoes) {
  const TemporaryFolder folder;
  hand_held_session().write(folder);
  ASSERT_EQ(run_imulab(folder, "calibrate session --method handheld -o c.json").exit_code, 0);
  ASSERT_EQ(run_imulab(folder, "compensate c.json session -o out.npz").exit_code, 0);
  ASSERT_EQ(run_imulab(folder, "compensate c.json session/recording.csv -o out.csv").exit_code, 0) << "a recording is inspected";
  const TableRequest request{folder / "out.npz", "", ""};
  const auto arrays = recording_io::read_columns(request, {"time_ns", "gyro.1", "gyro.3", "accel.2"});
  Session session;
  session.file = folder / "session.toml";
  RecordingSource source = written_source({});
  source.file = "out.csv";
  source.gyro.unit = "rad/s", source.accel.unit = "m/s^2";
  const Recording table = read_recording(session, source).recording;
  EXPECT_EQ(arrays.columns[0].integers, table.time_ns);
  EXPECT_EQ(arrays.columns[1].numbers, table.gyro[0]);
  EXPECT_EQ(arrays.columns[2].numbers, table.gyro[2]);
  EXPECT_EQ(arrays.columns[3].numbers, table.accel[1]);
}

}  // namespace
}  // namespace imulab
