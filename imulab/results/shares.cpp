#include "imulab/results/shares.hpp"

#include "imulab/model/effects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace imulab {
namespace {

constexpr std::size_t share_columns = 6, group_columns = 5;  // in 80 columns; beside groups there is a name

Shares part_of(const Shares& all, const std::vector<std::size_t>& columns) {
  Shares part{{}, all.percent(Eigen::all, columns)};
  for (const std::size_t k : columns) part.sources.push_back(all.sources[k]);
  return part;
}

}  // namespace

Shares all_shares(const Prediction& p) { return {p.sources, 100 * (p.variance.array().colwise() / p.first_order().array().square())}; }

std::size_t source_group(std::string_view source) {
  enum : std::size_t { rig, site, noise, terms, of_effects, undetermined };
  if (source == undetermined_source) return undetermined;
  if (find_effect(source) != nullptr) return of_effects;
  for (const std::string_view of_rig : {"orthogonality", "angle", "zero", "timing"})
    if (source == of_rig) return rig;
  for (const std::string_view of_site : {"gravity", "latitude", "earth rate"})
    if (source == of_site) return site;
  return source.ends_with(" noise") || source.ends_with(" turn-on") ? noise : terms;
}

Shares by_group(const Shares& each) {
  Shares groups{{source_groups.begin(), source_groups.end()}, Eigen::ArrayXXd::Zero(each.percent.rows(), source_groups.size())};
  for (std::size_t k = 0; k < each.sources.size(); ++k)
    groups.percent.col(static_cast<Eigen::Index>(source_group(each.sources[k]))) += each.percent.col(static_cast<Eigen::Index>(k));
  std::vector<std::size_t> columns, small;
  for (std::size_t k = 0; k < source_groups.size(); ++k)
    if ((groups.percent.col(static_cast<Eigen::Index>(k)) >= 0.5).any()) columns.push_back(k);
  const auto total = [&](std::size_t k) { return groups.percent.col(static_cast<Eigen::Index>(k)).sum(); };
  while (columns.size() + (small.empty() ? 0 : 1) > group_columns) {
    const auto least = std::min_element(columns.begin(), columns.end(), [&](std::size_t a, std::size_t b) { return total(a) < total(b); });
    small.push_back(*least);
    columns.erase(least);
  }
  Shares shares = part_of(groups, columns);
  if (small.empty()) return shares;
  shares.sources.emplace_back("others");
  shares.percent.conservativeResize(Eigen::NoChange, shares.percent.cols() + 1);
  shares.percent.rightCols<1>() = part_of(groups, small).percent.rowwise().sum();
  return shares;
}

const std::string& largest_source(const Shares& each, Eigen::Index row) {
  Eigen::Index largest = 0;
  each.percent.row(row).maxCoeff(&largest);
  return each.sources[static_cast<std::size_t>(largest)];
}

std::string groups_text(const std::vector<std::string>& sources) {
  std::string text;
  for (std::size_t group = 0; group < source_groups.size(); ++group) {
    std::string members;
    for (const std::string& source : sources)
      if (source_group(source) == group && find_effect(source) == nullptr && source != undetermined_source)
        members += (members.empty() ? "" : ", ") + source;
    if (!members.empty()) text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", source_groups[group], members);
  }
  return text;
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
  static const std::map<std::string, std::string> narrow{{"accel", "acc."},
                                                         {"accelerometer", "acc."},
                                                         {"asymmetry", "asym."},
                                                         {"centrifuge", "cent."},
                                                         {"coefficients", "det."},
                                                         {"determined", "det."},
                                                         {"others", "oth."},
                                                         {"cross_terms", "cross"},
                                                         {"earth", "Earth"},
                                                         {"effects", "eff."},
                                                         {"elastic", "elas"},
                                                         {"fourth_order", "4th"},
                                                         {"g_sensitivity", "g"},
                                                         {"g_squared", "g^2"},
                                                         {"gravity", "g"},
                                                         {"heading", "head."},
                                                         {"higher_orders", "5th"},
                                                         {"hysteresis", "hyst."},
                                                         {"latitude", "lat."},
                                                         {"orthogonality", "orth."},
                                                         {"quadratic", "quad."},
                                                         {"rectification", "rect."},
                                                         {"scale_drift", "sc.d."},
                                                         {"scale_force", "sc.f."},
                                                         {"scale_temperature", "sc./K"},
                                                         {"matrix_thermal", "m./K"},
                                                         {"terms", "term"},
                                                         {"thermometer", "ther."},
                                                         {"timing", "time"},
                                                         {"turn-on", "on"},
                                                         {"turn_on", "on"},
                                                         {"offset_temperature", "b./K"},
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
