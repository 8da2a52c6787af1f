// The origin of a calibration, as far as a session declares it: whose it is, who made it, when, and from what.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <span>
#include <string>

namespace imulab {

/// "imulab 0.1.0"
std::string software();

/// Fills in the origin of the calibration, as the session declares it: the IMU's serial number, who took the data, the time now (UTC), this
/// software's version, the session's file and its SHA-256, and the form of the readings in the recordings. `recordings`: one for each of the
/// session's. `calibrate` does this itself.
void add_declared_origin(Calibration& calibration, const Session& session, std::span<const Recording> recordings);

}  // namespace imulab
