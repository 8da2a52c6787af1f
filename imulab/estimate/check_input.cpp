#include "imulab/estimate/check_input.hpp"

#include "imulab/error.hpp"
#include "imulab/model/relative_uncertainty.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/session_fields.hpp"
#include "imulab/recording/validate.hpp"
#include "imulab/rests.hpp"
#include "imulab/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace imulab {
namespace {

constexpr std::size_t most_advised_turns = 100;  // `plan.hpp` plans longer procedures in less than 1 s per turn

void append(std::vector<std::string>& problems, const std::vector<std::string>& more, std::string_view place) {
  for (const std::string& problem : more) problems.push_back(fmt::format("{}: {}", place, problem));
}

void check_requirements(const std::vector<Requirement>& requirements, std::vector<std::string>& problems) {
  for (const Requirement& r : requirements) append(problems, problems_of(r), "requirements");
}

std::vector<std::string> problems_of(const CalibrationOptions& options) {
  std::vector<std::string> problems;
  append(problems, problems_of(options.terms), "terms");
  for (const auto& [name, level] : {std::pair{"significance", options.significance}, std::pair{"outlier_level", options.outlier_level}})
    if (!(level >= 0 && level < 1)) problems.push_back(fmt::format("{}: {} is no probability; expected at least 0 and less than 1", name, level));
  check_requirements(options.handheld.requirements, problems);
  if (!(options.handheld.rest_s > 0 && std::isfinite(options.handheld.rest_s)))
    problems.push_back(fmt::format("handheld.rest_s: {} is no time; expected more than 0", options.handheld.rest_s));
  if (options.handheld.advised_turns > most_advised_turns)
    problems.push_back(fmt::format("handheld.advised_turns: {}; expected at most {}", options.handheld.advised_turns, most_advised_turns));
  if (!(options.hybrid.curve_interval >= 0 && std::isfinite(options.hybrid.curve_interval)))
    problems.push_back(fmt::format("hybrid.curve_interval: {} is no time; expected 0 or more", options.hybrid.curve_interval));
  return problems;
}

/// Checks that given rests are in the only recording, in time order. Rests found in the data may overlap by a window of the detection.
void check_rests(const CalibrationInput& input, std::vector<std::string>& problems) {
  if (!input.rests) return;
  const std::size_t before = problems.size();
  const Recording none, &recording = input.recordings.empty() ? none : input.recordings.front();
  const double window = recording.interval_s > 0 ? RestOptions{}.window_s / recording.interval_s : 0;
  const auto shared = static_cast<std::size_t>(std::min(window, 1e9));
  std::size_t begin = 0, end = 0;  // limits of the previous rest
  for (const Range& rest : *input.rests) {
    const std::size_t least = std::max(begin, end - std::min(end, shared));
    if (rest.end <= rest.begin)
      problems.push_back(fmt::format("rests: samples {} to {} are no rest: it ends before it begins; expected [begin, end)", rest.begin, rest.end));
    else if (rest.begin < least || rest.end <= end || rest.end > recording.size())
      problems.push_back(fmt::format("rests: samples {} to {} are no rest; expected ranges in ascending order from {} to {}", rest.begin, rest.end,
                                     least, recording.size()));
    begin = rest.begin + 1, end = std::max(end, rest.end);
  }
  if (problems.size() == before && input.recordings.size() > 1) problems.push_back("rests: they are of one recording, and there are several");
}

}  // namespace

void validate(const CalibrationOptions& options) { throw_problems("", problems_of(options)); }

void validate(const PredictionOptions& options) {
  std::vector<std::string> problems;
  append(problems, problems_of(options.terms), "terms");
  check_requirements(options.requirements, problems);
  throw_problems("", problems);
}

CalibrationInput checked_input(const Method& method, const CalibrationInput& input, const CalibrationOptions& options) {
  CalibrationInput out = input;
  std::vector<std::string> problems = problems_of(options);
  collect_problem(problems, [&] { validate(input.session); });
  if (input.recordings.empty())
    problems.push_back(fmt::format("the method {} takes {}; got none", method.name, method.takes_several ? "recordings" : "one recording"));
  for (const Recording& recording : input.recordings) {
    collect_problem(problems, [&] { validate(recording); });
    const double most = session_fields::sampling_rate().high;  // Hz
    if (recording.interval_s > 0 && 1 / recording.interval_s > most * (1 + 1e-9))
      problems.push_back(fmt::format("{}: {:g} samples a second; expected at most {:g}: are the stamps in another unit than nanoseconds?",
                                     recording.name, 1 / recording.interval_s, most));
  }
  if (!input.recordings.empty()) collect_problem(problems, [&] { out.session = declared_session(input.session, input.recordings); });
  check_rests(input, problems);
  throw_problems("", problems);
  if (out.session.file.empty()) out.session.file = "session";  // name in messages for a session in memory
  return out;
}

void expect_valid(const Session& procedure, const PredictionOptions& options) {
  std::vector<std::string> problems;
  collect_problem(problems, [&] { validate(options); });
  collect_problem(problems, [&] { validate(procedure); });
  throw_problems("", problems);
}

std::string note_of_absent(const Prediction& restricted, const Prediction& whole) {
  std::vector<std::string> absent;
  for (const std::vector<CoefficientIndex>* list : {&whole.coefficients, &whole.undetermined})
    for (const CoefficientIndex index : *list) {
      if (contains(restricted.coefficients, index) || contains(restricted.undetermined, index)) continue;
      const Coefficient& c = coefficient(index);
      std::string term = fmt::format("{}.{}", to_string(c.triad), to_string(c.term));
      if (!is_vector(c.term)) term += c.term == Term::thermal ? "" : c.row == c.column ? ".diagonal" : ".off_diagonal";
      if (std::find(absent.begin(), absent.end(), term) == absent.end()) absent.push_back(std::move(term));
    }
  if (absent.empty()) return "";
  return fmt::format("taken as absent, since the terms do not name them: {}; an IMU that has them is calibrated worse than this",
                     fmt::join(absent, ", "));
}

}  // namespace imulab
