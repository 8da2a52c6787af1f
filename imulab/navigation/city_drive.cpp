#include "imulab/navigation/city_drive.hpp"

#include "imulab/core/units.hpp"
#include "imulab/navigation/motion/flight.hpp"

#include <cmath>

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
