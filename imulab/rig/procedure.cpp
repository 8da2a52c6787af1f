#include "imulab/rig/procedure.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/units.hpp"

#include <cmath>
#include <numbers>

namespace imulab {

namespace {

/// Uniform over all attitudes: outer and inner uniform, middle with density cos. Whole tenths of a degree, which read well in a file.
std::array<double, 3> random_angles(std::uint64_t seed, std::uint64_t pose) {
  const RandomStream draws(seed, "hand-held attitudes");
  const auto tenths = [](double angle) { return std::round(angle / unit::deg * 10) / 10 * unit::deg; };
  const auto turn = [](double u) { return std::numbers::pi * (2 * u - 1); };
  return {tenths(turn(draws.uniform(3 * pose))), tenths(std::asin(2 * draws.uniform(3 * pose + 1) - 1)), tenths(turn(draws.uniform(3 * pose + 2)))};
}

void validate(const HandHeldOptions& o) {
  if (o.poses < 1) throw Error("hand-held: at least one pose was expected");
  if (!(o.first_rest > 0 && o.rest > 0 && o.move > 0)) throw Error("hand-held: first_rest, rest and move above 0 s were expected");
  if (!(o.rate_hz > 0)) throw Error("hand-held: rate_hz above 0 was expected");
}

RecordingSource si_recording(double rate_hz) {
  RecordingSource source;
  source.file = "recording.csv";
  source.rate_hz = rate_hz;
  source.time.column = "t";
  source.gyro.columns = {"gx", "gy", "gz"};
  source.gyro.unit = "rad/s";
  source.accel.columns = {"ax", "ay", "az"};
  source.accel.unit = "m/s^2";
  return source;
}

}  // namespace

Session hand_held_procedure(const HandHeldOptions& options, std::uint64_t seed) {
  validate(options);
  Session session;
  session.imu.name = "hand-held";
  session.imu.grade = options.grade;
  session.site.latitude = options.latitude;
  session.site.height = options.height;
  session.rigs.emplace_back();  // kind none
  session.recordings.push_back(si_recording(options.rate_hz));
  double time = 0;
  for (int pose = 0; pose < options.poses; ++pose) {
    Step hold;
    hold.recording = session.recordings.front().file;
    hold.start = pose == 0 ? 0 : time + options.move;
    hold.end = hold.start + (pose == 0 ? options.first_rest : options.rest);
    hold.angles = random_angles(seed, static_cast<std::uint64_t>(pose));
    if (pose > 0)  // the hand goes the short way
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double last = session.steps.back().angles[axis];
        hold.angles[axis] = last + std::remainder(hold.angles[axis] - last, 2 * std::numbers::pi);
      }
    time = hold.end;
    session.steps.push_back(hold);
  }
  return session;
}

}  // namespace imulab
