// The agreement of a recording with a model where the truth is known without any instrument: at rest the force is gravity, and a turn between two
// rests takes gravity's direction from one to the other.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/recording.hpp"
#include "imulab/sensor_model.hpp"

#include <array>
#include <vector>

namespace imulab {

/// The model that stands for no calibration: readings in SI as they are. For readings in counts, which have no scale of their own: the same readings
/// at zero, and one scale for the three axes of a triad, without misalignments and all else.
SensorModel uncalibrated(const SensorModel& model);

/// One rest by two models.
struct GravityAtRest {
  Range range;
  double begin_s = 0, end_s = 0;  ///< of its first and last sample
  Vector3d force;                 ///< mean, after: gravity's reaction, which points up [m/s^2]
  double before = 0, after = 0;   ///< size of the mean force [m/s^2]
};

/// Gives the agreement in every range that is not empty. Throws Error where a model needs a temperature that the recording lacks.
std::vector<GravityAtRest> gravity_at_rests(const Recording& recording, const std::vector<Range>& rests, const SensorModel& before,
                                            const SensorModel& after);

/// One triad's mean in a rest.
struct TriadAtRest {
  Vector3d temperature;          ///< thermal reading of each axis
  Vector3d error;                ///< output less its true value [m/s^2, rad/s]; NaN where the rest does not show it
  double size = 0;               ///< of the mean output
  double size_at_reference = 0;  ///< the same without the terms over temperature
};
struct RestOverTemperature {
  TriadAtRest accel, gyro;
};

/// Compares the rests with a model that has terms over temperature. `known_up`: upward components of the true force and of the Earth's rate; NaN: not
/// known, or the triad's offsets are not. A rest shows the error of an axis within 45 deg of the vertical, if the other axes are right. The parts of
/// a rest that was cut as its temperature changed also show the others' errors, against their mean over these parts. Throws Error as gravity_at_rests
/// does.
std::vector<RestOverTemperature> rests_over_temperature(const Recording& recording, const std::vector<GravityAtRest>& rests, const SensorModel& model,
                                                        const std::array<double, 2>& known_up);

/// The turn from one rest to the next: the angle between gravity as the gyros take it along, and gravity as the accelerometers measure it there.
struct TurnError {
  double begin_s = 0, end_s = 0;
  double angle = 0;              ///< of the turn [rad]
  double before = 0, after = 0;  ///< rad
};

/// Compares consecutive rests between which no time is missing and no reading is at a limit; turns below a degree are left out. The Earth's rate is
/// taken from the rest before the turn where the gyros resolve it.
std::vector<TurnError> turn_errors(const Recording& recording, const std::vector<GravityAtRest>& rests, const SensorModel& before,
                                   const SensorModel& after);

}  // namespace imulab
