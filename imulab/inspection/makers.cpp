#include "imulab/inspection/makers.hpp"

#include <array>
#include <cctype>

namespace imulab::inspection {
namespace {

// Sources: Xsens MT Low-Level Communication Protocol (SampleTimeFine: 10 kHz) and Xsens DOT user manual (SampleTimeFine: us); Bosch BMI160, BMI270
// and BMI323 data sheets (sensortime: 39.0625 us); ST LSM6DSO and ISM330DHCX data sheets (timestamp: 25 us); VectorNav VN-100/200/300 user manuals
// (TimeStartup, TimeGps, TimeSyncIn, TimeUtc: ns); PX4 (timestamp in us beside gyro_rad); ArduPilot (TimeUS, SampleUS).
constexpr std::array clocks{
    MakersClock{"sampletimefine", "Xsens MTi", 1e4, 0.9, 2100},   MakersClock{"sampletimefine", "Xsens DOT", 1e6, 0.9, 125},
    MakersClock{"sampletimecoarse", "Xsens MTi", 1, 0.9, 2100},   MakersClock{"sensortime", "Bosch", 25600, 0.7, 6500},
    MakersClock{"bmisensortime", "Bosch", 25600, 0.7, 6500},      MakersClock{"timestartup", "VectorNav", 1e9, 0.9, 1001},
    MakersClock{"timegps", "VectorNav", 1e9, 0.9, 1001},          MakersClock{"timesyncin", "VectorNav", 1e9, 0.9, 1001},
    MakersClock{"timesincestartup", "VectorNav", 1e9, 0.9, 1001}, MakersClock{"sampleus", "ArduPilot", 1e6, 9, 8100},
    MakersClock{"lsm6dsotimestamp", "ST", 40000, 1, 6700},        MakersClock{"ism330timestamp", "ST", 40000, 1, 6700},
};

std::string compact(std::string_view name) {
  std::string letters;
  for (const char c : name)
    if (std::isalnum(static_cast<unsigned char>(c))) letters += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return letters;
}

}  // namespace

std::optional<MakersClock> makers_clock(std::string_view name, double step) {
  const std::string key = compact(name);
  std::optional<MakersClock> found;
  for (const MakersClock& clock : clocks) {
    const double rate = clock.ticks_per_s / step;
    if (clock.name != key || rate < clock.least_hz || rate > clock.most_hz) continue;
    if (found) return std::nullopt;
    found = clock;
  }
  return found;
}

}  // namespace imulab::inspection
