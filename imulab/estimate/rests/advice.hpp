// Which turns a calibration by hand needs next: of the poses and turns that a hand can do, those after which it is nearest to what is required.
#pragma once

#include "imulab/estimate/method.hpp"
#include "imulab/estimate/rests/fit.hpp"
#include "imulab/estimate/rests/handheld_problem.hpp"

#include <vector>

namespace imulab::rests {

/// Each turn is the one after which the sum of the logarithms of uncertainty over requirement (where that is not yet reached) is smallest, of turns
/// about horizontal axes until a face, an edge or a corner of the unit points up, the short or the long way. The information of what was measured is
/// that of the fit, with its spreads; of what is to come that of the same conditions. Ends where everything is reached: without requirements, where
/// every coefficient that all IMUs have is determined.
std::vector<HandTurn> next_turns(HandheldProblem problem, const Fit& fit, const CalibrationOptions::Handheld& goal);

/// The turn after that many rests of which the data say nothing yet: the six faces in turn.
HandTurn opening_turn(std::size_t rests);

}  // namespace imulab::rests
