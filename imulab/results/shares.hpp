// The shares of the error sources in the variance of every coefficient, as columns of a table of 80 columns.
#pragma once

#include "imulab/core/eigen.hpp"
#include "imulab/estimate/prediction.hpp"

#include <array>
#include <string>
#include <vector>

namespace imulab {

/// Percent of the variance by source, a row a coefficient.
struct Shares {
  std::vector<std::string> sources;
  Eigen::ArrayXXd percent;
};

Shares all_shares(const Prediction& prediction);
/// What a person reads: the effects of the table as one, without sources that hardly have a share; where the others do not fit, the least are one.
Shares visible(const Shares& each);
/// Every source, as many tables as they need.
std::vector<Shares> in_columns(const Shares& all);
/// A source's name as the two lines of a narrow column's head.
std::array<std::string, 2> column_head(const std::string& source);

}  // namespace imulab
