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
  if (source == "orthogonality") return {"", "orth."};
  if (source == "gravity") return {"", "g"};
  if (source == "latitude") return {"", "lat."};
  if (source == "earth rate") return {"Earth", "rate"};
  if (source == "gyro noise") return {"gyro", "noise"};
  if (source == "accelerometer noise") return {"acc.", "noise"};
  if (source == "gyro turn-on") return {"gyro", "on"};
  if (source == "accelerometer turn-on") return {"acc.", "on"};
  if (source == "timing") return {"", "time"};
  if (source == "effects") return {"eff-", "ects"};
  if (source == undetermined_source) return {"not", "det."};
  if (source == "gyro.g_sensitivity") return {"gyro", "g"};
  if (const auto dot = source.find('.'); dot != std::string::npos) {  // a term or an effect: "accel.quadratic", "mount.elastic"
    static const std::map<std::string, std::string> narrow{{"quadratic", "quad."},   {"asymmetry", "asym."},     {"cross_terms", "cross"},
                                                           {"hysteresis", "hyst."},  {"rectification", "rect."}, {"g_squared", "g^2"},
                                                           {"fourth_order", "4th"},  {"higher_orders", "5th"},   {"scale_temperature", "sc./K"},
                                                           {"scale_drift", "sc.d."}, {"turn_on", "on"},          {"elastic", "elas."},
                                                           {"change", "move"},       {"latitude", "lat."}};
    const std::string owner = source.substr(0, dot), name = source.substr(dot + 1);
    const auto found = narrow.find(name);
    return {owner == "accel" ? "acc." : owner == "centrifuge" ? "cent." : owner, found == narrow.end() ? name : found->second};
  }
  return {"", source};
}

}  // namespace imulab
