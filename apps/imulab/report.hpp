// The option --report of the verbs: a result as a page.
#pragma once

#include "apps/imulab/command.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace imulab::command {

/// The option --report.
void add_report_option(Verb& verb, std::string& file);

/// Throws Error where the page would replace one of these, an input or another output. An empty name is no file.
void expect_others_stay(const std::string& page, const std::vector<std::filesystem::path>& others);

}  // namespace imulab::command
