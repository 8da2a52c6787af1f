// For tests of navigation: a flight from a rest, as a session in SI with its truth.
#pragma once

#include "imulab/core/random.hpp"
#include "imulab/files.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/units.hpp"

#include "tests/temporary_folder.hpp"
#include <cmath>
#include <functional>

namespace imulab {

struct FlightSession {
  Session session;
  Recording recording;
  Solution truth;
};

inline constexpr double flight_rest = 40;  // s

/// Rests, speeds up to 40 m/s, turns by 90 deg to the right and continues: 100 s at 50 Hz. `noise` scales that of a navigation-grade IMU.
inline FlightSession flight_session(double noise, std::uint64_t seed = 1) {
  const double interval = 0.02, gyro_noise = 0.002 * unit::deg_per_sqrt_h, accel_noise = 5e-5;
  using namespace motion;
  const Trajectory motion = flight({45 * unit::deg, 0.1, 100, 0, 30 * unit::deg},
                                   {straight(flight_rest), accelerate(40, 20), turn(90 * unit::deg, 6 * unit::deg, 3), straight(22)});
  FlightSession out;
  out.session.imu.name = "flight";
  out.session.imu.gyro_noise_density = gyro_noise;
  out.session.imu.accel_noise_density = accel_noise;
  out.session.site.latitude = 45 * unit::deg;
  out.session.site.longitude = 0.1;
  out.session.site.height = 100;
  RecordingSource source;
  source.file = "recording.csv";
  source.rate_hz = 1 / interval;
  source.time.column = "t";
  source.gyro = {.columns = {"gx", "gy", "gz"}, .unit = "rad/s", .limits = std::array{-0.5, 0.5}};
  source.accel = {.columns = {"ax", "ay", "az"}, .unit = "m/s^2"};
  out.session.recordings.push_back(source);
  out.session.truth_file = "truth.csv";

  Recording& r = out.recording;
  r.name = source.file;
  r.interval_s = interval;
  const RandomStream draws(seed, "flight session");
  std::uint64_t next = 0;
  const std::vector<Increment> ideal = ideal_increments(motion, interval);
  out.truth.time.push_back(0);
  out.truth.states.push_back(navigation_state(motion.at(0)));
  for (std::size_t i = 0; i < ideal.size(); ++i) {
    r.time_ns.push_back(20000000 * static_cast<std::int64_t>(i + 1));
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      r.gyro[k].push_back(ideal[i].angle[axis] / interval + noise * gyro_noise / std::sqrt(interval) * draws.normal(next++));
      r.accel[k].push_back(ideal[i].velocity[axis] / interval + noise * accel_noise / std::sqrt(interval) * draws.normal(next++));
    }
    if ((i + 1) % 5 > 0) continue;  // the truth at 10 Hz
    out.truth.time.push_back(r.time_s(i));
    out.truth.states.push_back(navigation_state(motion.at(r.time_s(i))));
  }
  return out;
}

/// The state at the end of the rest as [initial].
inline InitialState flight_start() { return {flight_rest, 45 * unit::deg, 0.1, 100, {0, 0, 0}, 0, 0, 30 * unit::deg}; }

inline void write(const TemporaryFolder& folder, const std::string& name, const FlightSession& flight) {
  std::filesystem::create_directories(folder / name);
  folder.write(name + "/session.toml", session_text(flight.session));
  write_recording(folder / (name + "/recording.csv"), flight.recording);
  write_solution(folder / (name + "/truth.csv"), flight.truth);
}

}  // namespace imulab
