// The conditions of a static calibration: the size of gravity and Earth's rate at every rest, the attitude of each rest unknown.
#pragma once

#include "imulab/estimate/rests/problem.hpp"

namespace imulab::rests {

/// The gyros' start: Cheng's linear solution where they resolve Earth's rate, else as declared, with a note why. False: they are not calibrated.
bool start_gyros_at_rest(kernel::RestStart& start, const Recording& recording, const Session& session);

/// Each rest gives |f| = g and, with the gyros, the vertical and horizontal parts of Earth's rate:
///   up . w = w_ie sin L          (Cheng 2014 eq 12)
///   |w - up (up . w)| = w_ie cos L
class StaticProblem : public RestProblem {
 public:
  StaticProblem(const kernel::RestStart& start, const Site& site, std::vector<CoefficientIndex> indices, bool with_gyros);

  Conditions conditions(const Spreads& spreads) const;
  void drop(std::size_t suspect) { rests_.erase(rests_.begin() + static_cast<std::ptrdiff_t>(suspect)); }

 private:
  void add_rest(Conditions& c, Eigen::Index row, const RestMeans& rest, const Spreads& spreads) const;
  bool with_gyros_;
};

}  // namespace imulab::rests
