// An aided navigation as a page.
#pragma once

#include "imulab/model/conclusion.hpp"
#include "imulab/navigation/aided/aided.hpp"

#include <string>
#include <vector>

namespace imulab {

/// HTML, self-contained: track on a plain grid, sigmas over time, innovations, withheld times, what the aids and the sensors turned out to be.
std::string aided_page(const std::string& session, const AidedNavigation& navigation, const Conclusion& conclusion,
                       const std::vector<std::string>& warnings);

}  // namespace imulab
