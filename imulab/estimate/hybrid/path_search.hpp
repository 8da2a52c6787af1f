// Beam search over the turns of a hybrid calibration's path, all rests of which are equal.
#pragma once

#include "imulab/estimate/hybrid/path_judge.hpp"

#include <vector>

namespace imulab::hybrid {

struct Candidate {
  QuarterPath path;
  double merit;  ///< smaller is better: the time to meet the requirements if rests and turns were lengthened equally
  bool within;   ///< the limits
};

/// Paths from zero angles of these moves, with every rest `rest` quanta and all in all at most `longest` [s]: each that was better than those before.
std::vector<Candidate> search_turns(const PathJudge& judge, const std::vector<QuarterTurn>& moves, int rest, double longest);

}  // namespace imulab::hybrid
