// Lines in which every number has its name: "X = 1, Y = 2", "ax:0.1 ay:0.2", "19:34:18.499 -> acc: 0.1 0.2 9.8"; and those of a table behind the
// stamps of a console: "19:34:18.499 -> 0.1,0.2,9.8".
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::recording_io {

/// The names of a line's numbers, and the numbers as they are written.
struct LabeledLine {
  std::vector<std::string> names, units, values;
};
/// Nothing for a line of another kind.
std::optional<LabeledLine> labeled_line(std::string_view line);

class Labels {
 public:
  /// Looks at the first lines: most of them have the same labels.
  explicit Labels(std::string_view head);

  bool found() const { return !names_.empty() || divider_ != 0; }
  /// False of a table behind stamps.
  bool names_all() const { return !names_.empty(); }
  const std::vector<std::string>& names() const { return names_; }
  const std::vector<std::string>& units() const { return units_; }
  /// Appends whole lines: numbers between commas; a line with other labels as it is.
  void add(std::string_view lines, std::string& out) const;

 private:
  std::vector<std::string> names_, units_;
  char divider_ = 0;  ///< of the fields behind a stamp and an arrow; 0: there are none
};

}  // namespace imulab::recording_io
