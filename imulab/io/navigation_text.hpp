// Results of navigation as JSON, for machines.
#pragma once

#include "imulab/analysis/navigate.hpp"
#include "imulab/analysis/navigation_error.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// One session navigated; errors where there is a truth.
struct NavigatedSession {
  std::string session;  ///< its name on the command line
  Navigated navigated;
  std::optional<NavigationErrors> errors;
};

/// One session as an object; several as {"sessions": [...], "rate_nmi_per_h": {"rms", "cep"}}.
std::string navigation_json(const std::vector<NavigatedSession>& sessions);

}  // namespace imulab
