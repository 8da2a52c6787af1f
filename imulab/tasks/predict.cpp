#include "imulab/tasks/predict.hpp"

#include "imulab/formats/text/figures.hpp"
#include "imulab/report/prediction_page.hpp"
#include "imulab/tasks/content.hpp"

#include <fmt/format.h>

#include <utility>

namespace imulab {
namespace {

/// Everything that the Monte Carlo depends on.
std::string identity_of(const Session& procedure, const PredictionOptions& options) {
  std::vector<IdentityField> fields = content_of(procedure);
  for (const CoefficientIndex index : options.terms) fields.emplace_back("term", coefficient(index).name);
  fields.emplace_back("classical", options.classical ? "true" : "false");
  fields.emplace_back("runs", fmt::format("{}", options.runs));
  fields.emplace_back("seed", fmt::format("{}", options.seed));
  return work_identity("predict", fields);
}

}  // namespace

Prediction predicted(std::string_view name, const Session& procedure, PredictionOptions options) {
  if (options.checkpoint) options.checkpoint->identity = identity_of(procedure, options);
  return predict(method(name), procedure, options);
}

std::string prediction_text(const Prediction& p, const std::vector<Requirement>& requirements, bool details) {
  std::string text = prediction_table(p, requirements, details);
  if (p.tolerances) return tolerance_table(*p.tolerances, p.missed) + "\n" + text;
  if (p.advice) text += "\n" + advice_text(*p.advice);
  for (const Shortfall& s : p.missed) text += text::wrapped("", shortfall_text(s));
  return text;
}

std::string prediction_page(const Prediction& p, const std::string& procedure, bool required) {
  PredictionReport report{.procedure = procedure, .summary = summary_of(p), .required = required};
  if (p.tolerances) report.tables = {tolerance_table(*p.tolerances, p.missed)};
  return prediction_page(report);
}

std::string shortcomings(const Prediction& p) {
  if (!p.undetermined.empty()) {
    std::string names;
    for (const CoefficientIndex index : p.undetermined) names += fmt::format(" {}", coefficient(index).name);
    return fmt::format("the procedure does not determine:{}{}", names, p.advice ? "; " + turns_text(*p.advice) : "");
  }
  if (p.tolerances)
    return p.tolerances->answers.back().declared.factor
               ? ""
               : "the requirements are not met with this procedure, not even with a hundredth of the declared table errors, timing and noise";
  return p.missed.empty() ? "" : fmt::format("the requirements are not met: {}", shortfall_text(p.missed.front()));
}

}  // namespace imulab
