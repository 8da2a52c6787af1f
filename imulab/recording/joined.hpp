// Several recordings of one unit as one: on one clock, with time missing between them. A method that works on rests and turns needs no more.
#pragma once

#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <span>
#include <string>
#include <vector>

namespace imulab {

/// Where a recording is in the joined one.
struct JoinedPart {
  std::string name;
  double begin_s = 0;  ///< of the joined clock
  double shift_s = 0;  ///< from its own clock to the joined one
};

struct Joined {
  Session session;  ///< with one recording, and all steps on its clock
  Recording recording;
  std::vector<JoinedPart> parts;
};

/// In the order of the session. Throws Error for recordings of different units, kinds of output or rates, or where only some have a thermometer.
Joined join(const Session& session, std::span<const Recording> recordings);

/// The part that this time of the joined clock belongs to.
const JoinedPart& part_at(const std::vector<JoinedPart>& parts, double joined_s);

}  // namespace imulab
