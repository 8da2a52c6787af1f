// Whether an IMU moves, as its receivers and wheels tell: a steady acceleration looks like a rest to it.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <cstddef>
#include <optional>
#include <vector>

namespace imulab::aided {

/// A row says that it moves, by more than its sigmas let expect, or is elsewhere than `first`, the first position of all that are asked.
bool shows_motion(const Aid& aid, std::size_t row, std::optional<Eigen::Vector3d>& first);

/// One of the aids that go with a recording moves between these stamps [s].
bool any_moves(const std::vector<Aid>& aids, const std::string& recording, double begin, double end);

/// The rests of a recording (rests_of) in which no aid moves.
std::vector<Range> rests_in_place(const Recording& recording, const Session& session);

}  // namespace imulab::aided
