// Results of navigation as JSON and as tables.
#pragma once

#include "imulab/navigate.hpp"
#include "imulab/navigation/budget/budget.hpp"
#include "imulab/recording.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// One session navigated; errors where there is a reference.
struct NavigatedSession {
  std::string session;  ///< its name on the command line
  Navigated navigated;
  std::optional<NavigationErrors> errors;
  std::optional<ErrorBudget> explained = {};  ///< the errors that its calibration and alignment explain
  std::string unexplained = {};               ///< why they are not known
};

/// One session as an object; several as {"sessions": [...], "rate_nmi_per_h": {"rms", "cep", "sessions"}}. Units are in the keys
/// (docs/theory/strapdown.md).
std::string navigation_json(const std::vector<NavigatedSession>& sessions);

/// One session: alignment, end, errors at the end. Several: a row each, and the pure-inertial rate of all.
/// "position error 120 m horizontal, 0.8 nmi/h; heading error 30 arcsec", or of several sessions their rates.
std::string navigation_headline(const std::vector<NavigatedSession>& sessions);
std::string navigation_table(const std::vector<NavigatedSession>& sessions);

/// Distance, speed and bank of the motion; largest rate and force of its recording where that is in SI.
std::string motion_table(const Recording& recording, const Solution& truth);

}  // namespace imulab
