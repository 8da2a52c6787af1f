// A flight whose latitude, longitude, height and attitude are elementary functions of time: eastward at about 200 m/s, its heading swinging
// to north and south. No integrator is involved.
#pragma once

#include "imulab/navigation/integration/local_earth.hpp"
#include "imulab/navigation/motion/trajectory.hpp"
#include "imulab/units.hpp"

#include <cmath>
#include <numbers>

namespace imulab {

/// Value and first two derivatives of amplitude sin(2 pi t / period + phase).
struct Swing {
  double value, first, second;
  Swing(double amplitude, double period, double phase, double t) {
    const double w = 2 * std::numbers::pi / period, s = std::sin(w * t + phase), c = std::cos(w * t + phase);
    value = amplitude * s;
    first = amplitude * w * c;
    second = -amplitude * w * w * s;
  }
};

/// Swings of 40 deg in heading, 5 deg in pitch and 25 deg in roll. `pace` shortens their periods of 240, 90 and 45 s.
inline motion::Trajectory closed_form_flight(double duration, double pace = 1) {
  motion::Trajectory flight;
  flight.duration = duration;
  flight.at = [pace](double t) {
    const double a = 6378137, f = 1 / 298.257223563, e2 = f * (2 - f), longitude_rate = 4e-5;
    const Swing latitude(2e-3, 600, 0.3, t), height(100, 300, 0.7, t);
    motion::Kinematics k;
    k.latitude = 0.7 + latitude.value;
    k.longitude = 0.2 + longitude_rate * t;
    k.height = 3000 + height.value;
    const double s = std::sin(k.latitude), c = std::cos(k.latitude), w = 1 - e2 * s * s;
    const double rn = a / std::sqrt(w), rm = rn * (1 - e2) / w;
    const double rn_rate = rn * e2 * s * c / w * latitude.first, rm_rate = 3 * rm * e2 * s * c / w * latitude.first;
    k.velocity = {(rn + k.height) * c * longitude_rate, (rm + k.height) * latitude.first, height.first};
    k.acceleration = {((rn_rate + height.first) * c - (rn + k.height) * s * latitude.first) * longitude_rate,
                      (rm_rate + height.first) * latitude.first + (rm + k.height) * latitude.second, height.second};
    const Swing roll(25 * unit::deg, 45 / pace, 2, t), pitch(5 * unit::deg, 90 / pace, 1, t), heading(40 * unit::deg, 240 / pace, 0, t);
    const EulerAngles angles{roll.value, pitch.value, std::numbers::pi / 2 + heading.value};
    k.C_nb = attitude_matrix(angles);
    k.rate_nb_b = attitude_rate(angles, {roll.first, pitch.first, heading.first});
    return k;
  };
  return flight;
}

}  // namespace imulab
