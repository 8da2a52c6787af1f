// Findings about the data and the result, as values. Each finding has a code (finding_code.hpp), which programs can test, and a sentence.
//
// Example:
//   for (const Finding& f : calibration.quality.findings) std::printf("%s: %s\n", name_of(f.code).data(), f.text.c_str());
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// The judgement of a result. `met` and `not_met` concern requirements; `none` means that nothing was judged.
enum class Verdict : std::uint8_t { none, good, doubtful, met, not_met };
/// Returns "good", "doubtful", "met" or "not met"; empty for `none`.
std::string_view to_string(Verdict verdict);

/// A note states data and settings that were used; a warning states a consequence; a doubt makes the verdict doubtful.
enum class Severity : std::uint8_t { note, warning, doubt };
std::string_view to_string(Severity severity);

enum class Code : std::uint16_t;
/// Converts between a code and its name, such as "wrong-latitude". An unknown name gives `other`.
std::string_view name_of(Code code);
Code code_of(std::string_view name);

struct Finding {
  Code code{};
  Severity severity = Severity::note;
  std::string subject = {};          ///< coefficient, effect, axis or aid; empty: the result as a whole
  std::vector<double> numbers = {};  ///< numbers of the text, in its order and units
  std::string text = {};             ///< one sentence
  std::string advice = {};           ///< consequence and remedy; may be empty
  std::string place = {};            ///< recording, as the start of a warning; may be empty
  bool operator==(const Finding&) const = default;
};

/// The subject of a finding, as an argument of Findings::add.
struct Subject {
  std::string_view name;
};

/// Findings in the order in which they were made.
class Findings : public std::vector<Finding> {
 public:
  using vector::vector;

  /// Adds a finding: the text of its code (model/finding_table.hpp), with `values` inserted.
  template <Code code, class... Values>
  Finding& add(const Values&... values);
  void append(const Findings& more) { insert(end(), more.begin(), more.end()); }
  void prepend(const Findings& more) { insert(begin(), more.begin(), more.end()); }
  /// Adds sentences without a code.
  void append(Severity severity, const std::vector<std::string>& texts);
  void prepend(Severity severity, const std::vector<std::string>& texts);

  bool has(Code code) const;                             ///< returns true if a finding has this code
  bool doubtful() const;                                 ///< returns true if one is a doubt
  std::vector<std::string> of(Severity severity) const;  ///< returns place, text and advice
  std::vector<std::string> notes() const { return of(Severity::note); }
  std::vector<std::string> reasons() const;   ///< returns the texts of the doubts
  std::vector<std::string> warnings() const;  ///< returns place, text and advice of warnings, and of doubts with advice
  std::vector<std::string> all() const;       ///< returns warnings and doubts, each in the form of a warning
};

}  // namespace imulab
