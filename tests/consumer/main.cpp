// Calibrates the session named on the command line and compensates its recording with the result.
#include <cstdio>
#include <exception>
#include <imulab/analysis/compensate_recording.hpp>
#include <imulab/core/error.hpp>
#include <imulab/estimate/handheld.hpp>
#include <imulab/io/calibration_file.hpp>
#include <imulab/io/file.hpp>
#include <imulab/io/recording_file.hpp>
#include <imulab/io/session_file.hpp>
#include <imulab/model/coefficient.hpp>
#include <imulab/recording/rests.hpp>
#include <utility>

int main(int argc, char** argv) try {
  if (argc != 2) throw imulab::Error("usage: consumer SESSION");
  const imulab::Session session = imulab::read_session(argv[1]);
  imulab::RecordingReading reading = imulab::read_recording(session, session.recordings.front());
  for (const auto& warning : reading.warnings) std::printf("warning: %s\n", warning.c_str());

  const imulab::Rests rests = imulab::rests_of(reading.recording, session);
  const imulab::Calibration calibration = imulab::calibrate_handheld(reading.recording, rests.ranges, session.imu, session.site);
  for (const int index : calibration.estimated)
    std::printf("%-24s %12.6g +/- %.2g\n", imulab::coefficient_table()[static_cast<std::size_t>(index)].name.data(),
                imulab::coefficient_value(calibration.model, index), *imulab::standard_uncertainty(calibration, index));
  std::printf("verdict: %s\n", calibration.quality.verdict.c_str());
  imulab::write_whole("calibration.json", imulab::calibration_text(calibration));

  // Columns of rad/s and m/s^2, sample by sample what the raw columns were.
  const imulab::Recording compensated = imulab::compensate(calibration.model, std::move(reading.recording)).recording;
  std::printf("%zu samples; the last: %g rad/s about x, %g m/s^2 along x\n", compensated.size(), compensated.gyro[0].back(),
              compensated.accel[0].back());
} catch (const std::exception& e) {  // imulab::Error: mend the input; imulab::Unsupported: the data do not tell
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
