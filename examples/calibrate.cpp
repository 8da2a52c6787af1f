// Calibrates a unit from arrays in memory and writes calibration.json.
//
// Your arrays come from a driver, a log or a ROS bag; here a simulated unit that is turned by hand stands in for them.
#include <cstdio>
#include <exception>
#include <imulab/calibrate.hpp>
#include <imulab/files.hpp>
#include <imulab/procedure.hpp>
#include <imulab/recording.hpp>
#include <imulab/simulate.hpp>

using namespace imulab;

struct Log {
  std::vector<double> t;  // s
  Columns3 gyro, accel;   // rad/s, m/s^2
};

/// Forty rests with moves between them, at 100 Hz.
Log record() {
  const Session procedure = hand_held_procedure({}, 1);
  const Recording simulated = simulate_recording(procedure, procedure.recordings.front(), draw_truth(procedure, 1), 1);
  Log log{{}, simulated.gyro, simulated.accel};
  for (std::size_t i = 0; i < simulated.size(); ++i) log.t.push_back(simulated.time_s(i));
  return log;
}

int main() try {
  const Log log = record();
  const Recording recording = make_recording(log.t, log.gyro, log.accel);

  Session session;  // what is known besides the readings; without steps the rests are found in them
  session.site.latitude = 45 * unit::deg;
  session.site.height = 0;

  const Calibration calibration = calibrate("handheld", {session, {&recording, 1}}).calibration;
  for (const CoefficientIndex index : calibration.estimated)
    std::printf("%-24s %12.6g  u = %.2g  %s\n", coefficient(index).name.data(), coefficient_value(calibration.model, index),
                *standard_uncertainty(calibration, index), coefficient(index).unit.data());
  for (const std::string& warning : calibration.quality.findings.warnings()) std::printf("warning: %s\n", warning.c_str());
  std::printf("verdict: %s\n", verdict_text(calibration.quality).c_str());
  write_whole("calibration.json", calibration_text(calibration));
} catch (const std::exception& e) {  // Error: the input is wrong; Unsupported: the data do not support the request
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
