// Navigates a session: the solution, its errors against a reference, and the part of them that the calibration explains.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/results/navigation.hpp"

#include <filesystem>
#include <optional>

namespace imulab {

/// An IMU whose recordings are in rad/s and m/s^2 already.
Calibration no_calibration();

/// A reference solution.
struct TrueMotion {
  std::string name;  ///< of its file
  Solution solution;
};
/// Throws Error as read_solution does.
TrueMotion read_truth(const std::filesystem::path& file);
/// The one that a session names; none where it names none.
std::optional<TrueMotion> session_truth(const Session& session);

/// `explain`: also the errors that the calibration's uncertainties explain. Throws as `navigate` and
/// `navigation_errors` do. A recording that is moved here is compensated in its place.
NavigatedSession navigate_session(const std::string& name, const Calibration& calibration, const Session& session, Recording recording,
                                  NavigateOptions options, const std::optional<TrueMotion>& truth, bool explain);

}  // namespace imulab
