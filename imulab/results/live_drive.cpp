#include "imulab/results/live_drive.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/formats/text/json_fields.hpp"
#include "imulab/model/frame_axes.hpp"
#include "imulab/navigation/aided/aided.hpp"
#include "imulab/results/live.hpp"
#include "imulab/results/requirement_progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace imulab {
namespace {

constexpr double not_known = 1e9;  // over the limit: behind all that have a number

/// By how much each coefficient exceeds what is wanted of it.
std::map<CoefficientIndex, double> excesses_of(const Calibration& calibration, const std::vector<Requirement>& requirements) {
  std::map<CoefficientIndex, double> out;
  for (const Requirement& required : requirements)
    for (const CoefficientIndex index : required.coefficients) {
      if (zero_by_frame(index)) continue;
      Requirement alone = required;
      alone.coefficients = {index};
      const double reached = assess(calibration, alone).reached;
      const double ratio = std::isfinite(reached) ? reached / required.limit : not_known;
      if (ratio > 1) out[index] = std::max(out[index], ratio);
    }
  const std::vector<std::string>& considered = calibration.quality.considered;  // effects among them
  for (const CoefficientIndex index : calibration.estimated)
    if (const Coefficient& c = coefficient(index); requirements.empty() && std::ranges::find(considered, c.name) != considered.end())
      if (c.term != Term::quadratic && c.term != Term::cubic) out[index] = 1;
  return out;
}

}  // namespace

std::vector<MissingCoefficients> missing_coefficients(const Calibration& calibration, const std::vector<Requirement>& requirements) {
  const std::map<CoefficientIndex, double> excesses = excesses_of(calibration, requirements);
  std::vector<std::pair<CoefficientIndex, double>> all(excesses.begin(), excesses.end());
  std::ranges::stable_sort(all, [](const auto& a, const auto& b) { return a.second > b.second; });
  std::vector<std::string> names;
  for (const auto& [index, excess] : all) names.emplace_back(coefficient(index).name);
  std::vector<MissingCoefficients> out;
  for (auto& [manoeuvre, group] : by_manoeuvre(names)) out.push_back({std::string(manoeuvre), std::move(group)});
  return out;
}

std::string live_drive_lines(const LiveDriveView& view) {
  const std::string at = fmt::format("{:8.1f} s  ", view.time_s);
  if (!view.problem.empty()) return fmt::format("{}no estimate yet: {}\n", at, view.problem);
  std::string text, reached;
  for (const RequirementResult& r : view.requirements) reached += (reached.empty() ? "" : ", ") + progress_text(r);
  if (!reached.empty()) text += fmt::format("{}{}: {}\n", at, view.done ? "done" : "reached", reached);
  if (view.done) return text;
  for (const std::string& reason : view.because) text += fmt::format("{}doubtful: {}\n", at, reason);
  for (const MissingCoefficients& m : view.missing)
    text += fmt::format("{}missing: {}{}\n", at, fmt::join(m.coefficients, ", "), m.shown_by.empty() ? "" : "; shown by " + m.shown_by);
  return text.empty() ? at + "all coefficients are determined\n" : text;
}

template <class Fields>
void describe(Fields& f, const MissingCoefficients& m) {
  f("coefficients", m.coefficients), f("shown_by", m.shown_by);
}

template <class Fields>
void describe(Fields& f, const LiveDriveView& view) {
  f("time_s", view.time_s), f("requirements", std::vector<RequirementProgress>(view.requirements.begin(), view.requirements.end())),
      f("done", view.done);
  f("missing", view.missing), f("because", view.because, fields::if_any), f("problem", view.problem, fields::if_any);
}

std::string live_drive_json(const LiveDriveView& view) { return json_text(written(view), JsonLayout::one_line); }

}  // namespace imulab
