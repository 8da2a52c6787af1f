// Navigates a session with its aids.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/navigation/aided/aided.hpp"
#include "imulab/tasks/navigate.hpp"
#include "imulab/tasks/verb.hpp"

#include <string>
#include <vector>

namespace imulab {

/// EVERY,LENGTH or EVERY,LENGTH,FIRST [s]: times of `length` withheld every so often, the first one `FIRST` (else EVERY) after `begin`, whole ones
/// before `end`. Throws OptionError for another form.
std::vector<Outage> regular_outages(const std::string& text, double begin, double end);

/// Throws OptionError for options that do not go with --aided, or without.
void check_aided(const NavigateVerbOptions& o);

/// Reads the files of the session's aids; throws as read_aids and navigate_aided do, and
/// Error where the session has no aids. `options`: what is kept of the states.
AnswerOf<AidedNavigation> aided_answer(const std::string& name, const Calibration& calibration, const Session& session, Recording recording,
                                       const NavigateVerbOptions& o, const std::vector<std::string>& told, AidedOptions options = {});

}  // namespace imulab
