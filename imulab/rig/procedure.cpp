#include "imulab/rig/procedure.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/units.hpp"

#include <cmath>

namespace imulab {

namespace {

/// Uniform over all attitudes: outer and inner uniform, middle with density cos. In tenths of a degree, whole, which read well in a file.
std::array<double, 3> random_tenths(std::uint64_t seed, std::uint64_t pose) {
  const RandomStream draws(seed, "hand-held attitudes");
  const auto symmetric = [&](std::uint64_t k) { return 2 * draws.uniform(3 * pose + k) - 1; };
  return {std::round(1800 * symmetric(0)), std::round(std::asin(symmetric(1)) / unit::deg * 10), std::round(1800 * symmetric(2))};
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
  source.time.column = std::string("t");
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
  std::array<double, 3> tenths{};
  for (int pose = 0; pose < options.poses; ++pose) {
    const auto target = random_tenths(seed, static_cast<std::uint64_t>(pose));
    Step hold;
    hold.recording = session.recordings.front().file;
    hold.start = pose == 0 ? 0 : session.steps.back().end + options.move;
    hold.end = hold.start + (pose == 0 ? options.first_rest : options.rest);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      tenths[axis] += std::remainder(target[axis] - tenths[axis], 3600);  // the hand goes the short way
      hold.angles[axis] = tenths[axis] / 10 * unit::deg;
    }
    session.steps.push_back(hold);
  }
  return session;
}

}  // namespace imulab
