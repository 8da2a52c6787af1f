// The shares of the error sources in the variance of every coefficient, as columns of a table of 80 columns.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/predict.hpp"

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Percent of the variance by source, a row a coefficient.
struct Shares {
  std::vector<std::string> sources;
  Eigen::ArrayXXd percent;
};

Shares all_shares(const Prediction& prediction);

/// Kinds of sources: each has a column of the table, and a color of a picture. Their order is that of both.
inline constexpr std::array<std::string_view, 6> source_groups{"rig", "site", "noise", "terms", "effects", "not determined"};
/// The place of a source among these.
std::size_t source_group(std::string_view source);
/// What a person reads: the sources of a group as one, without groups that hardly have a share; where the others do not fit, the least are "others".
Shares by_group(const Shares& each);
/// The source with the largest share of a row.
const std::string& largest_source(const Shares& each, Eigen::Index row);
/// "rig: orthogonality, angle; noise: gyro noise": the sources that the groups contain. Effects are not listed.
std::string groups_text(const std::vector<std::string>& sources);
/// Every source, as many tables as they need.
std::vector<Shares> in_columns(const Shares& all);
/// A source's name as the two lines of a narrow column's head.
std::array<std::string, 2> column_head(const std::string& source);

}  // namespace imulab
