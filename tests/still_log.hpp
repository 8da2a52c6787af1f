// A log at rest whose noise is the same each time, for tests of the command `noise`.
#pragma once

#include "tests/run_command.hpp"
#include <array>
#include <cmath>
#include <functional>
#include <sstream>

namespace imulab {

using ReadingsAt = std::function<std::array<double, 6>(int i)>;

/// A number between -1 and 1 that looks random: Weyl's sequence, mixed.
inline double repeated_noise(int i, int axis) {
  const double x = std::sin(12.9898 * i + 78.233 * axis) * 43758.5453;
  return 2 * (x - std::floor(x)) - 1;
}

inline std::array<double, 6> still_readings(int i) {
  std::array<double, 6> row{};
  for (int k = 0; k < 6; ++k) row[static_cast<std::size_t>(k)] = (k < 3 ? 1e-3 : 0.01) * repeated_noise(i, k) + (k == 5 ? 9.8 : 0);
  return row;
}

/// log.csv at 100 Hz, and a session.toml that declares it. After sample `skip_from` so many are missing.
inline void write_still_log(const TemporaryFolder& folder, int samples, const ReadingsAt& row, int skip_from = -1, int skip = 0) {
  std::ostringstream text;
  text.precision(12);
  text << "t,gx,gy,gz,ax,ay,az\n";
  for (int i = 1; i <= samples; ++i) {
    text << 0.01 * (i + (skip_from >= 0 && i > skip_from ? skip : 0));
    for (const double value : row(i)) text << ',' << value;
    text << '\n';
  }
  folder.write("log.csv", text.str());
  folder.write("session.toml",
               "format = \"imulab.session/1\"\n[imu]\nname = \"test\"\n[site]\nlatitude_deg = 47.0\n[rig]\nkind = \"none\"\n"
               "[[recording]]\nfile = \"log.csv\"\nrate_hz = 100\ntime = { column = \"t\", unit = \"s\" }\n"
               "gyro = { columns = [\"gx\", \"gy\", \"gz\"], output = \"rate\", unit = \"rad/s\" }\n"
               "accel = { columns = [\"ax\", \"ay\", \"az\"], output = \"rate\", unit = \"m/s^2\" }\n");
}

}  // namespace imulab
