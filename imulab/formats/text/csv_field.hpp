// Texts of others in tables of comma-separated values: the one place where names, serial numbers and file names become fields of a CSV file.
#pragma once

#include <string>
#include <string_view>

namespace imulab::text {

/// One field. Line ends and what steers a terminal are shown as `one_line` does, so that a row is one line. A text that a spreadsheet would run as a
/// formula gets a ' in front: one that begins, spaces apart, with = + - @ and is no number, or with a tab or a line end. In quotes where it has to
/// be.
std::string csv_field(std::string_view text);

/// Whether a spreadsheet would run a cell of this text.
bool would_run(std::string_view cell);

}  // namespace imulab::text
