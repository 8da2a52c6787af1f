#include "imulab/io/comparison_text.hpp"

#include "imulab/model/coefficient.hpp"

#include <nlohmann/json.hpp>

namespace imulab {

namespace {

using Json = nlohmann::ordered_json;

std::string name_of(int index) { return std::string(coefficient_table()[static_cast<std::size_t>(index)].name); }

Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json to_json(const CoefficientDifference& d) {
  return {{"a", d.a},
          {"b", d.b},
          {"difference", d.difference},
          {"standard_uncertainty", or_null(d.uncertainty)},
          {"sigmas", or_null(d.sigmas())},
          {"user", {{"difference", d.user_difference}, {"standard_uncertainty", or_null(d.user_uncertainty)}, {"unit", d.user_unit}}}};
}

Json to_json(const Consistency& c) { return {{"chi2", c.chi2}, {"degrees_of_freedom", c.degrees_of_freedom}, {"p_value", c.p_value}}; }

Json to_json(const std::string& a, const std::string& b, const Comparison& comparison) {
  Json coefficients = Json::object();
  for (const auto& d : comparison.coefficients) coefficients[name_of(d.index)] = to_json(d);
  return {
      {"a", a}, {"b", b}, {"frame", "accelerometers"}, {"coefficients", std::move(coefficients)}, {"consistency", to_json(comparison.consistency)}};
}

Json to_json(const Agreement& agreement) {
  Json coefficients = Json::object(), differing = Json::array();
  for (const auto& c : agreement.coefficients) {
    coefficients[name_of(c.index)] = to_json(c.consistency);
    if (c.differs) differing.push_back(name_of(c.index));
  }
  return {{"calibrations", agreement.calibrations},
          {"coefficients", std::move(coefficients)},
          {"consistency", to_json(agreement.consistency)},
          {"differing", std::move(differing)}};
}

}  // namespace

std::string comparison_json(const std::vector<std::string>& files, const std::vector<Comparison>& comparisons,
                            const std::optional<Agreement>& agreement) {
  if (comparisons.size() == 1) return to_json(files[0], files[1], comparisons[0]).dump(2) + "\n";
  Json list = Json::array();
  for (std::size_t k = 0; k < comparisons.size(); ++k) list.push_back(to_json(files[0], files[k + 1], comparisons[k]));
  return Json{{"comparisons", std::move(list)}, {"agreement", agreement ? to_json(*agreement) : Json(nullptr)}}.dump(2) + "\n";
}

}  // namespace imulab
