// Several grades of sensors on one mission, side by side.
#include "imulab/core/text.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/grade.hpp"
#include "imulab/report/comparison_page.hpp"
#include "imulab/results/compare_results.hpp"
#include "imulab/tasks/budget.hpp"
#include "imulab/tasks/navigation_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <sstream>
#include <utility>

namespace imulab {
namespace {

/// Objects of budgets as one object, of the same format.
std::string budgets_text(const std::vector<AnswerOf<MissionBudget>>& budgets) {
  std::string out;
  for (const auto& each : budgets) {
    std::string text = each.document();
    text.erase(text.find_last_not_of(" \n") + 1);
    out += (out.empty() ? "" : ",\n") + text;
  }
  return "{\n\"format\": \"imulab.budget/1\",\n\"budgets\": [\n" + out + "\n]\n}\n";
}

/// The worst of all, with its grades first; the headline says which grade is good enough.
Conclusion joint(const std::vector<AnswerOf<MissionBudget>>& budgets, const std::string& headline) {
  constexpr std::array worst_last{Verdict::none, Verdict::met, Verdict::not_met, Verdict::doubtful};
  const auto rank = [&](Verdict verdict) { return std::find(worst_last.begin(), worst_last.end(), verdict); };
  Conclusion out{Verdict::none, ""};
  for (const auto& each : budgets)
    if (rank(each.conclusion.verdict) > rank(out.verdict)) out.verdict = each.conclusion.verdict;
  std::vector<std::string> parts;
  for (const Verdict verdict : worst_last) {
    std::string names;
    for (const auto& each : budgets)
      if (verdict != Verdict::none && each.conclusion.verdict == verdict) names += (names.empty() ? "" : ", ") + each.data->grade;
    if (verdict == out.verdict && !names.empty())
      parts.insert(parts.begin(), names);  // the verdict itself is before the headline
    else if (!names.empty())
      parts.push_back(fmt::format("{}{}{}", to_string(verdict), verdict == Verdict::met ? " by " : ": ", names));
  }
  parts.push_back(headline);
  out.headline = fmt::format("{}", fmt::join(parts, "; "));
  return out;
}

/// A line each, where there is a verdict.
std::string verdicts_by_grade(const std::vector<AnswerOf<MissionBudget>>& budgets) {
  std::string out;
  for (const auto& each : budgets)
    if (each.conclusion.verdict != Verdict::none)
      out += text::wrapped(fmt::format("  {:<12} {:<9} ", each.data->grade, to_string(each.conclusion.verdict)), each.conclusion.headline);
  return out.empty() ? "" : out + "\n";
}

}  // namespace

std::vector<std::string> several_grades(const BudgetVerbOptions& o) {
  std::vector<std::string> out;
  if (!o.grade || o.grade->find(',') == std::string::npos) return out;
  std::istringstream names(*o.grade);
  for (std::string name; std::getline(names, name, ',');) out.emplace_back(trimmed(name, " "));
  for (std::size_t k = 0; k < out.size(); ++k)
    if (std::find(out.begin() + static_cast<std::ptrdiff_t>(k) + 1, out.end(), out[k]) != out.end())
      throw OptionError("grade", out[k] + " is named twice; expected each grade once");
  errors_of_option("grade", [&] {
    for (const std::string& name : out) grade(name);
  });
  return out;
}

Answer grades_answer(const MissionFile& file, const BudgetVerbOptions& o, const Tell& tell, const std::function<void(double)>& progress) {
  const std::vector<std::string> grades = several_grades(o);
  if (!o.output.empty()) throw OptionError("output", "takes the files of one grade; expected one --grade, or --json and --report for several");
  if (!o.shared.checkpoint.empty() || !o.shared.part.empty())
    throw OptionError(o.shared.part.empty() ? "checkpoint" : "part", "belongs to the budget of one grade");
  const auto budgets = std::make_shared<std::vector<AnswerOf<MissionBudget>>>();
  std::vector<BudgetSummary> results;
  std::vector<std::string> warnings;
  std::string missed;
  for (const std::string& grade : grades) {
    BudgetVerbOptions own = o;
    own.grade = grade;
    const double done = static_cast<double>(budgets->size()), all = static_cast<double>(grades.size());
    budgets->push_back(budget_answer(file, own, tell, [&](double part) {
      if (progress) progress((done + part) / all);
    }));
    const auto& answer = budgets->back();
    const MissionBudget& b = *answer.data;
    for (const std::string& warning : answer.warnings) warnings.push_back(grade + ": " + warning);
    if (!answer.shortcomings.empty()) missed += (missed.empty() ? "" : "; ") + grade + ": " + answer.shortcomings;
    results.push_back({.budget = b.budget, .monte_carlo = b.monte_carlo, .runs = b.runs, .grade = b.grade, .noise = b.noise});
  }
  const auto made = std::make_shared<ResultComparison>(compare_grades(std::move(results)));
  for (std::size_t k = 0; k < budgets->size(); ++k)  // how long each may be without its aids
    for (const LossCurve& c : loss_curves((*budgets)[k].data->budget, (*budgets)[k].conclusion.requirements)) {
      if (!c.limit) continue;
      made->notes[k] += fmt::format("; {}: {}", c.name, c.within ? fmt::format("for {:.3g} s after the loss", *c.within) : "all of the time");
      if (k == 0) made->limits.push_back({c.name, *c.limit});
    }
  const std::shared_ptr<const ResultComparison> comparison = made;
  const Conclusion conclusion = joint(*budgets, comparison->headline);
  return {.json = [budgets] { return budgets_text(*budgets); },
          .table = [comparison, budgets](bool details) { return verdicts_by_grade(*budgets) + result_comparison_table(*comparison, details); },
          .page = [comparison, conclusion, warnings] { return result_comparison_page(*comparison, conclusion, warnings); },
          .warnings = warnings,
          .shortcomings = missed,
          .conclusion = conclusion};
}

}  // namespace imulab
