// Navigates a session: the solution, its errors against a reference, and the part of them that the calibration explains.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/results/navigation.hpp"
#include "imulab/tasks/verb.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

struct NavigateVerbOptions : ShowOptions {
  std::string calibration, truth, barometer, gaps = "integrate";
  std::optional<std::string> vertical, require;  ///< absent: the channel that the session declares, else free; limits on errors
  std::vector<std::string> sessions, declarations, topics;
  std::optional<double> heading_deg, heading_sigma_deg;
  std::string outages;  ///< of an aided navigation: EVERY,LENGTH
  bool aided = false, filter = false;
  bool align = false, allow_undetermined = false;
};
/// The verb `navigate`, which sets these.
Verb& declare(Verb& command, NavigateVerbOptions& o);
/// The options of a session's navigation, with the vertical channel and the barometer that it declares where the options name none; reads the
/// heights. Throws OptionError for what contradicts itself.
NavigateOptions navigate_options(const NavigateVerbOptions& o, const Session& session);

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

/// The warnings are those of the sessions, with their names in front where there are several; `told`: those about the calibration, which were shown
/// before.
AnswerOf<std::vector<NavigatedSession>> navigation_answer(std::vector<NavigatedSession> sessions, const NavigateVerbOptions& o,
                                                          const std::vector<std::string>& told);

}  // namespace imulab
