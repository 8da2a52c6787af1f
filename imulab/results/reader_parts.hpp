// Parts of results from their JSON. Slow to compile: for the sources that read it, no others.
#pragma once

#include "imulab/formats/text/json_field.hpp"
#include "imulab/results/summary.hpp"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace imulab::result_io {

using json_text::Field;

inline Eigen::Vector3d vector_at(const Field& f) {
  return {f.item(0, 3, "numbers").number(), f.item(1, 3, "numbers").number(), f.item(2, 3, "numbers").number()};
}

/// As many numbers as `count`, times `unit`.
inline std::vector<double> numbers_at(const Field& f, std::size_t count, double unit = 1) {
  std::vector<double> out;
  out.reserve(count);
  if (f.size() != count) f.fail(fmt::format("expected {} numbers", count));
  for (std::size_t i = 0; i < count; ++i) out.push_back(f.item(i, count, "numbers").number() * unit);
  return out;
}
inline std::vector<double> numbers_at(const Field& f) { return numbers_at(f, f.size()); }

NavigationSummary navigation_of(const Field& root);
BudgetSummary budget_of(const Field& root);
CompensationSummary compensation_of(const Field& root);

}  // namespace imulab::result_io
