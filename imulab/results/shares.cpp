#include "imulab/results/shares.hpp"

#include "imulab/model/effects.hpp"

#include <algorithm>
#include <map>

namespace imulab {
namespace {

constexpr std::size_t share_columns = 6;  // in 80 columns

Shares part_of(const Shares& all, const std::vector<std::size_t>& columns) {
  Shares part{{}, all.percent(Eigen::all, columns)};
  for (const std::size_t k : columns) part.sources.push_back(all.sources[k]);
  return part;
}

/// The effects of the table as one.
Shares with_effects_together(const Shares& all) {
  std::vector<std::size_t> others, effects;
  for (std::size_t k = 0; k < all.sources.size(); ++k) (find_effect(all.sources[k]) ? effects : others).push_back(k);
  if (effects.empty()) return all;
  Shares shares = part_of(all, others);
  shares.sources.emplace_back("effects");
  shares.percent.conservativeResize(Eigen::NoChange, shares.percent.cols() + 1);
  shares.percent.rightCols<1>() = part_of(all, effects).percent.rowwise().sum();
  return shares;
}

}  // namespace

Shares all_shares(const Prediction& p) { return {p.sources, 100 * (p.variance.array().colwise() / p.first_order().array().square())}; }

Shares visible(const Shares& each) {
  const Shares all = with_effects_together(each);
  std::vector<std::size_t> columns, small;
  for (std::size_t k = 0; k < all.sources.size(); ++k)
    if ((all.percent.col(static_cast<Eigen::Index>(k)) >= 0.5).any()) columns.push_back(k);
  const auto total = [&](std::size_t k) { return all.percent.col(static_cast<Eigen::Index>(k)).sum(); };
  while (columns.size() + (small.empty() ? 0 : 1) > share_columns) {
    const auto least = std::min_element(columns.begin(), columns.end(), [&](std::size_t a, std::size_t b) { return total(a) < total(b); });
    small.push_back(*least);
    columns.erase(least);
  }
  Shares shares = part_of(all, columns);
  if (small.empty()) return shares;
  shares.sources.emplace_back("others");
  shares.percent.conservativeResize(Eigen::NoChange, shares.percent.cols() + 1);
  shares.percent.rightCols<1>() = part_of(all, small).percent.rowwise().sum();
  return shares;
}

std::vector<Shares> in_columns(const Shares& all) {
  std::vector<Shares> tables;
  for (std::size_t begin = 0; begin < all.sources.size(); begin += share_columns) {
    std::vector<std::size_t> columns;
    for (std::size_t k = begin; k < std::min(begin + share_columns, all.sources.size()); ++k) columns.push_back(k);
    tables.push_back(part_of(all, columns));
  }
  return tables;
}

std::array<std::string, 2> column_head(const std::string& source) {
  static const std::map<std::string, std::string> narrow{
      {"accel", "acc."},        {"accelerometer", "acc."},      {"asymmetry", "asym."},     {"centrifuge", "cent."}, {"change", "move"},
      {"coefficients", "det."}, {"cross_terms", "cross"},       {"earth", "Earth"},         {"effects", "eff."},     {"elastic", "elas."},
      {"fourth_order", "4th"},  {"g_sensitivity", "g"},         {"g_squared", "g^2"},       {"gravity", "g"},        {"higher_orders", "5th"},
      {"hysteresis", "hyst."},  {"latitude", "lat."},           {"orthogonality", "orth."}, {"quadratic", "quad."},  {"rectification", "rect."},
      {"scale_drift", "sc.d."}, {"scale_temperature", "sc./K"}, {"timing", "time"},         {"turn-on", "on"},       {"turn_on", "on"},
      {"undetermined", "not"}};
  const auto short_for = [](const std::string& word) {
    const auto found = narrow.find(word);
    return found == narrow.end() ? word : found->second;
  };
  const auto end = source.find_first_of(". ");  // "accel.quadratic", "gyro noise"
  return end == std::string::npos ? std::array{std::string(), short_for(source)}
                                  : std::array{short_for(source.substr(0, end)), short_for(source.substr(end + 1))};
}

}  // namespace imulab
