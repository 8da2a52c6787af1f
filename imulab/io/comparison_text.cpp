#include "imulab/io/comparison_text.hpp"

#include "imulab/model/coefficient.hpp"

#include <nlohmann/json.hpp>

namespace imulab {

namespace {

using Json = nlohmann::ordered_json;

Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json to_json(const CoefficientDifference& d) {
  return {{"a", d.a},
          {"b", d.b},
          {"difference", d.difference},
          {"standard_uncertainty", or_null(d.uncertainty)},
          {"sigmas", or_null(d.sigmas())},
          {"user", {{"difference", d.user_difference}, {"standard_uncertainty", or_null(d.user_uncertainty)}, {"unit", d.user_unit}}}};
}

Json to_json(const NamedComparison& named) {
  Json coefficients = Json::object();
  for (const auto& d : named.comparison.coefficients)
    coefficients[std::string(coefficient_table()[static_cast<std::size_t>(d.index)].name)] = to_json(d);
  const Consistency& c = named.comparison.consistency;
  return {{"a", named.a},
          {"b", named.b},
          {"frame", "accelerometers"},
          {"coefficients", std::move(coefficients)},
          {"consistency", {{"chi2", c.chi2}, {"degrees_of_freedom", c.degrees_of_freedom}, {"p_value", c.p_value}}}};
}

}  // namespace

std::string comparison_json(const std::vector<NamedComparison>& comparisons) {
  if (comparisons.size() == 1) return to_json(comparisons[0]).dump(2) + "\n";
  Json list = Json::array();
  for (const auto& c : comparisons) list.push_back(to_json(c));
  return Json{{"comparisons", std::move(list)}}.dump(2) + "\n";
}

}  // namespace imulab
