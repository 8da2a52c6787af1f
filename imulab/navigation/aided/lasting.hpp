// Correlated errors of aids: innovations remain correlated over several values, although a filter treats values as independent.
//
// n white values determine their mean to sigma / sqrt(n). If the sigma of the mean of n innovations is larger by `times`, the values are in the long
// run as informative as white noise with `times` the sigma, so the noise of the source is increased by this factor.
#pragma once

#include "imulab/navigation/aided/aided.hpp"
#include "imulab/navigation/aided/problem.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace imulab::aided {

/// Significant correlation of a source's innovations: the largest ratio of the sigma of a mean over several values to the stated one; 1: white.
/// Innovations smaller than stated count with their stated size.
struct SerialCorrelation {
  std::size_t values = 0;  // length of the mean
  double times = 1;
};
/// Returns the correlation of each source with innovations, in the order of the factors.
std::vector<SerialCorrelation> serial_correlations(const AidedNavigation& navigation);

/// Multiplies `lasting` of the source with the most correlated innovations, which may be the cause of other sources' correlation. Sources with a slow
/// error of their own are not changed. Returns false if no source qualifies.
bool widen_lasting(const Problem& problem, AidedNavigation& navigation);
/// Adds a doubt if innovations are strongly correlated.
void judge_lasting(AidedNavigation& navigation);

}  // namespace imulab::aided
