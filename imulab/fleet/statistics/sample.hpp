// A fleet's calibrations in memory, in columns: what its statistics work on.
#pragma once

#include "imulab/core/eigen.hpp"
#include "imulab/model/coefficient.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace imulab {

/// Rows are calibrations in the order of their times; columns coefficients in table order. SI, in the accelerometers' frame.
struct FleetSample {
  std::vector<CoefficientIndex> coefficients;
  Eigen::MatrixXd values, variances;                     ///< NaN where a calibration's data did not determine the coefficient
  Eigen::ArrayXd time;                                   ///< s since 1970
  std::vector<std::int64_t> calibration;                 ///< numbers in the store
  std::vector<Eigen::Index> unit, station, operated_by;  ///< of each row, from 0
  std::vector<std::string> units, stations, operators;   ///< their names; of units with the serial number
  std::vector<Eigen::Index> last;                        ///< each unit's last row, in the order of their times
  std::vector<Eigen::Index> common;                      ///< columns that most units' last calibrations have together
  Eigen::MatrixXd mean_covariance;                       ///< of these columns, over those last calibrations
  std::vector<CoefficientIndex> left_out = {};           ///< no column: in every calibration that states them only the prior sets them
  std::vector<std::string> serials = {};                 ///< of the units, or their names where they have none

  const std::string& unit_of_row(Eigen::Index row) const { return units[static_cast<std::size_t>(unit[static_cast<std::size_t>(row)])]; }
};

}  // namespace imulab
