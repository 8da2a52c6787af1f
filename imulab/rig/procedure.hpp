// Standard procedures: sessions without recordings, ready to edit and to simulate.
#pragma once

#include "imulab/core/units.hpp"
#include "imulab/recording/session.hpp"

#include <cstdint>
#include <string>

namespace imulab {

struct HandHeldOptions {
  int poses = 40;          ///< rests, each at an attitude of its own
  double first_rest = 30;  ///< s; the longest: it shows the noise
  double rest = 4;         ///< s
  double move = 2;         ///< s, from rest to rest
  double rate_hz = 100;
  double latitude = 45 * unit::deg;
  double height = 0;  ///< m
  std::string grade = "mems";
};

/// A unit turned by hand: rests at random attitudes (every direction of gravity and every heading alike) with moves between them.
Session hand_held_procedure(const HandHeldOptions& options, std::uint64_t seed);

}  // namespace imulab
