// The option --report of the verbs: a result as a page.
#pragma once

#include "apps/imulab/command.hpp"

#include <string>

namespace imulab::command {

/// The option --report.
void add_report_option(Verb& verb, std::string& file);

}  // namespace imulab::command
