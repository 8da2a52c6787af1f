#include "imulab/navigation/motion/mission.hpp"

#include "imulab/error.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab::motion {
namespace {

constexpr double most_samples = 1e7, longest = 1e6, bytes_per_sample = 270;  // a row of the recording and one of the truth

void check_size(double duration, double rate) {
  const double samples = duration * rate;
  if (!(samples * (1 + 1e-12) >= 1)) throw Error(fmt::format("{:g} s at {:g} Hz: expected one sample at least", duration, rate));
  if (samples > most_samples * (1 + 1e-12))
    throw Error(fmt::format("{:g} s at {:g} Hz are {:.0f} samples, files of {:.1f} GB: expected at most {:.0f} samples", duration, rate, samples,
                            samples * bytes_per_sample / 1e9, most_samples));
  if (duration > longest) throw Error(fmt::format("{:g} s: expected at most {:g} s", duration, longest));
}

}  // namespace

Trajectory trajectory_of(const Mission& mission) {
  if (mission.track) {
    if (mission.track->size() > 1) check_size(mission.track->time.back() - mission.track->time.front(), mission.rate);
    return track(*mission.track, mission.smoothing);
  }
  double duration = 0;
  for (const Segment& s : mission.segments) duration += s.duration;
  if (!mission.segments.empty()) check_size(duration, mission.rate);
  return flight(mission.start, mission.segments, mission.carrier);
}

}  // namespace imulab::motion

namespace imulab {

CityDrive city_drive(double interval) {
  using namespace motion;
  constexpr double speed = 60 / 3.6;  // m/s
  const FlightStart parked{.latitude = 40 * unit::deg, .longitude = 116.3 * unit::deg, .height = 50};
  std::vector<Segment> segments{rest(301), accelerate(speed, 20)};
  for (int leg = 0; leg < 9; ++leg) segments.insert(segments.end(), {straight(375), turn(45 * unit::deg, 3 * unit::deg, 3)});
  segments.push_back(accelerate(-speed, 20));
  Carrier vehicle;
  vehicle.banks = false;
  const Trajectory path = flight(parked, segments, vehicle);
  CityDrive drive{ideal_increments(path, interval), {}, truth(path, interval, static_cast<std::size_t>(std::lround(1 / interval)))};
  InitialState& start = drive.session.initial.emplace();
  start.latitude = parked.latitude, start.longitude = parked.longitude, start.height = parked.height;
  Site& site = drive.session.site;
  site.latitude = parked.latitude, site.longitude = parked.longitude, site.height = parked.height;
  Step hold;
  hold.recording = "recording.csv";
  hold.end = 300;
  drive.session.steps = {hold};
  return drive;
}

}  // namespace imulab

namespace imulab::motion {

double UnitTemperature::at(double t) const {
  const auto after = std::upper_bound(time.begin(), time.end(), t);
  if (after == time.begin()) return celsius.front();
  if (after == time.end()) return celsius.back();
  const auto i = static_cast<std::size_t>(after - time.begin());
  const double part = (t - time[i - 1]) / (time[i] - time[i - 1]);
  return (1 - part) * celsius[i - 1] + part * celsius[i];
}

}  // namespace imulab::motion
