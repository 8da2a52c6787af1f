// Errors of aids that last: innovations that are alike over several in a row, of which a filter takes each for news.
#pragma once

#include "imulab/navigation/aided/aided.hpp"

#include <cstddef>
#include <string>

namespace imulab::aided {

/// What innovations of one source have in common over several in a row, where chance does not explain it: the sigma of their mean over
/// the stated one, the largest of all; 1: white. Innovations smaller than stated count by their stated size.
struct SerialCorrelation {
  std::string source;
  std::size_t values = 0;  // in a row
  double times = 1;
};
SerialCorrelation serial_correlation(const AidedNavigation& navigation);

/// The doubt in words; empty where there is none.
std::string lasting_errors(const AidedNavigation& navigation);

}  // namespace imulab::aided
