// imulab predict PROCEDURE --method hybrid
#include "apps/imulab/command.hpp"
#include "apps/imulab/hybrid_table.hpp"
#include "imulab/core/error.hpp"
#include "imulab/io/prediction_text.hpp"
#include "imulab/io/session_file.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/model/user_unit.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab::command {

namespace {

const Coefficient& row_of(int index) { return coefficient_table()[static_cast<std::size_t>(index)]; }

/// The least that any of the requirements allows it; none: 0.
double limit_of(int index, const std::vector<Requirement>& requirements) {
  double limit = 0;
  for (const Requirement& r : requirements)
    if (std::find(r.coefficients.begin(), r.coefficients.end(), index) != r.coefficients.end())
      limit = limit > 0 ? std::min(limit, r.limit) : r.limit;
  return limit;
}

std::string listed(const std::vector<std::string>& texts) {
  std::string out;
  for (const std::string& text : texts) out += (out.empty() ? "" : ", then ") + text;
  return out;
}

}  // namespace

void print_hybrid_table(const HybridPrediction& p, const std::vector<Requirement>& requirements) {
  const bool required = !requirements.empty();
  fmt::print("{:<21} {:<9} {:>9}{}\n", "coefficient", "unit", "sigma", required ? "  required   ratio" : "");
  for (std::size_t i = 0; i < p.coefficients.size(); ++i) {
    const Coefficient& c = row_of(p.coefficients[i]);
    double largest = 0;  // one unit for all of a term
    for (std::size_t k = 0; k < p.coefficients.size(); ++k)
      if (row_of(p.coefficients[k]).triad == c.triad && row_of(p.coefficients[k]).term == c.term)
        largest = std::max(largest, p.sigma[static_cast<Eigen::Index>(k)]);
    const UserUnit unit = user_unit(c, largest);
    const double sigma = p.sigma[static_cast<Eigen::Index>(i)], limit = limit_of(p.coefficients[i], requirements);
    fmt::print("{:<21} {:<9} {:>9.4g}", c.name, unit.name, sigma / unit.size);
    if (limit > 0) fmt::print("  {:>8.4g} {:>7.3f}", limit / unit.size, sigma / limit);
    fmt::print("\n");
  }
  for (std::size_t i = 0; i < p.undetermined.size(); ++i) {
    const Coefficient& c = row_of(p.undetermined[i]);
    const UserUnit unit = user_unit(c, 0);
    fmt::print("{:<21} {:<9} {:>9.4g}  not determined\n", c.name, unit.name, p.remaining[static_cast<Eigen::Index>(i)] / unit.size);
  }
}

std::string text_of_hybrid(const Shortfall& s) {
  const auto name = row_of(s.coefficient).name;
  if (!std::isfinite(s.sigma)) return fmt::format("{} is not determined", name);
  const UserUnit& unit = s.requirement.unit;
  return fmt::format("{} has {:.4g} {} where {:g} {} is required", name, s.sigma / unit.size, unit.name, s.requirement.limit / unit.size, unit.name);
}

void predict_hybrid(const std::string& procedure, const std::optional<std::string>& require, bool json) {
  const std::vector<Requirement> requirements = require ? parse_requirements(*require) : std::vector<Requirement>{};
  const HybridPlan plan = hybrid_plan(read_session(procedure));
  expect_estimated(requirements, plan);
  const HybridPrediction p = predict(plan);
  const std::vector<Shortfall> missed = shortfalls(p, requirements);
  std::optional<HybridAdvice> advice;
  if (!missed.empty() || !p.undetermined.empty()) advice = advise(plan, p, missed.empty() ? std::vector<Requirement>{} : requirements);
  if (json) {
    fmt::print("{}", prediction_json(p, missed, advice));
  } else {
    fmt::print("Standard uncertainty of every coefficient by the hybrid method\n\n");
    print_hybrid_table(p, requirements);
  }
  if (!advice) return;
  std::string worst, open;
  for (const int index : advice->coefficients) worst += fmt::format(" {}", row_of(index).name);
  if (!json) {
    fmt::print("\nWorst determined:{}\nWhat helps most after the procedure: {}, and rest\n", worst, listed(advice->turns));
    for (const Shortfall& s : missed) fmt::print("{}\n", text_of_hybrid(s));
  }
  for (const int index : p.undetermined) open += fmt::format(" {}", row_of(index).name);
  if (!open.empty()) throw Unsupported(fmt::format("the procedure does not determine:{}\n  {}, and rest", open, listed(advice->turns)));
  throw Unsupported(fmt::format("the requirements are not met: {}", text_of_hybrid(missed.front())));
}

}  // namespace imulab::command
