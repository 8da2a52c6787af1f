// What a result says of the data and of itself, as values: each finding has a code (finding_code.hpp) by which a program can act, and its sentence.
//
// Example:
//   for (const Finding& f : calibration.quality.findings) std::printf("%s: %s\n", name_of(f.code).data(), f.text.c_str());
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// What a result is worth. `met` and `not_met` are about requirements; none: nothing was judged.
enum class Verdict : std::uint8_t { none, good, doubtful, met, not_met };
/// "good", "doubtful", "met", "not met"; empty of none.
std::string_view to_string(Verdict verdict);

/// A note states data and settings that were used, a warning a consequence; a doubt makes the verdict doubtful.
enum class Severity : std::uint8_t { note, warning, doubt };
std::string_view to_string(Severity severity);

enum class Code : std::uint16_t;
/// "wrong-latitude"; and the code of such a name: `other` if there is none.
std::string_view name_of(Code code);
Code code_of(std::string_view name);

struct Finding {
  Code code{};
  Severity severity = Severity::note;
  std::string subject = {};          ///< the coefficient, effect, axis or aid that it is about; empty: the whole
  std::vector<double> numbers = {};  ///< those of the text, in its order and units
  std::string text = {};             ///< one sentence
  std::string advice = {};           ///< the consequence, and what to do; may be empty
  std::string place = {};            ///< the recording, with which a warning begins; may be empty
  bool operator==(const Finding&) const = default;
};

/// The name of what a finding is about, as an argument of Findings::add.
struct Subject {
  std::string_view name;
};

/// In the order in which they were made.
class Findings : public std::vector<Finding> {
 public:
  using vector::vector;

  /// Adds a finding with the words of its code (model/finding_table.hpp), into which the values go.
  template <Code code, class... Values>
  Finding& add(const Values&... values);
  void append(const Findings& more) { insert(end(), more.begin(), more.end()); }
  void prepend(const Findings& more) { insert(begin(), more.begin(), more.end()); }
  /// Sentences that have no code.
  void append(Severity severity, const std::vector<std::string>& texts);
  void prepend(Severity severity, const std::vector<std::string>& texts);

  bool has(Code code) const;
  bool doubtful() const;                                 ///< true if one is a doubt
  std::vector<std::string> of(Severity severity) const;  ///< place, text and advice
  std::vector<std::string> notes() const { return of(Severity::note); }
  std::vector<std::string> reasons() const;   ///< of the doubts: their texts
  std::vector<std::string> warnings() const;  ///< of the warnings, and of doubts that have an advice: place, text and advice
  std::vector<std::string> all() const;       ///< warnings and doubts, each as a warning
};

}  // namespace imulab
