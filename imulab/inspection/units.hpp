// The unit of a triad's readings, by what the Earth says: gravity at rest, and the turns of gravity between rests.
#pragma once

#include "imulab/recording/session.hpp"

#include <string>
#include <vector>

namespace imulab::inspection {

/// A unit that readings may have, and what speaks for it.
struct UnitGuess {
  std::string unit = "count";
  Output output = Output::rate;
  std::string evidence;
  std::string open;  ///< the question, where several units fit or none; empty where one does
};

/// `norm`: of the readings at rest, which is `interval_s` g where they are increments. `named`: the unit that the file or the column's name states;
/// may be empty. `whole`: the readings are whole numbers.
UnitGuess accel_unit(double norm, double least, double most, double interval_s, const std::string& named, bool whole);

/// `scale`: rad/s per reading, by the turns.
UnitGuess gyro_unit(double scale, double interval_s, const std::string& named, bool whole);

/// The scales that gyros can have: of every unit, as rates and as increments.
std::vector<double> gyro_scales(double interval_s);

}  // namespace imulab::inspection
