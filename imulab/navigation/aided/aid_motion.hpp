// Detects from receivers and wheels whether an IMU moves: for the IMU, a steady motion resembles a rest.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <cstddef>
#include <optional>
#include <vector>

namespace imulab::aided {

/// Returns true if a row differs from rest by more than its sigmas allow, in velocity or from `first`, the first position of all tested rows.
bool shows_motion(const Aid& aid, std::size_t row, std::optional<Eigen::Vector3d>& first);

/// Returns true if one of the aids of a recording moves between these stamps [s].
bool any_moves(const std::vector<Aid>& aids, const std::string& recording, double begin, double end);

/// Returns the rests of a recording (rests_of) in which no aid moves.
std::vector<Range> rests_in_place(const Recording& recording, const Session& session);

}  // namespace imulab::aided
