// Pieces of a page: text made safe, numbers, tables, figures.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace imulab::report {

/// Any bytes as text of HTML, in an element or a quoted attribute: markup becomes characters, control characters and marks of writing direction
/// become their visible names (U+202E), what is not UTF-8 becomes the replacement character.
std::string escaped(std::string_view text);
/// The first characters of a long text, then "… (N characters)".
std::string shortened(std::string_view text, std::size_t most);

/// What a file is called without its folders, a session by its folder; a topic stays.
std::string name_of_file(std::string_view path);
/// A path as a link: bytes that have a meaning in one, or none, as %20.
std::string relative_url(std::string_view path);

/// Three significant digits, with a true minus sign; "not determined" where it is not finite.
std::string number_text(double value, int digits = 3);
/// A round value beside an axis; powers of ten as such where they are long, or all of an axis are to be `raised`.
std::string tick_text(double value, bool raised = false);
/// True where one of an axis's values is written as a power of ten: then all are.
bool are_raised(const std::vector<double>& ticks);
/// To the second significant digit of its uncertainty: 34303 for 34303.4 +- 32.
std::string rounded_to(double value, double uncertainty);
/// Two significant digits, as an uncertainty is stated.
std::string uncertainty_text(double uncertainty);

/// ug/g^2 as µg/g².
std::string readable_unit(std::string_view unit);

/// Cells are HTML. The first column is left-aligned, numbers of the others to the right unless `text_columns`.
struct Table {
  std::vector<std::string> head;
  std::vector<std::vector<std::string>> rows;
  bool text_columns = false;
  std::vector<std::size_t> left = {};  ///< further columns to the left: units
};
std::string table(const Table& table);

/// `content` is HTML, the others are text.
std::string section(std::string_view id, std::string_view heading, std::string_view lead, const std::string& content);
/// `wide`: as wide as the page, else two fit beside each other; a phone scrolls what does not fit.
std::string figure(const std::string& picture, std::string_view caption, bool wide = false);
/// Figures beside each other where there is room.
std::string beside(const std::vector<std::string>& figures);
std::string list(const std::vector<std::string>& texts, std::string_view id = "");
std::string paragraph(std::string_view text);
/// Folded on a screen, open in print.
std::string folded(std::string_view summary, const std::string& content);

}  // namespace imulab::report
