// Errors of aids that last: innovations that are alike over several in a row, of which a filter takes each for news.
//
// n white values tell their mean to sigma / sqrt(n). Where the mean of n innovations has a sigma that is `times` larger, a noise of `times` the sigma
// tells as much in the long run as the values do: so the source is made that much noisier.
#pragma once

#include "imulab/navigation/aided/aided.hpp"
#include "imulab/navigation/aided/problem.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace imulab::aided {

/// What innovations of one source have in common over several in a row, where chance does not explain it: the sigma of their mean over
/// the stated one, the largest of all; 1: white. Innovations smaller than stated count by their stated size.
struct SerialCorrelation {
  std::size_t values = 0;  // in a row
  double times = 1;
};
/// Of each source that has some, as many as there are factors.
std::vector<SerialCorrelation> serial_correlations(const AidedNavigation& navigation);

/// Widens `lasting` of the source whose innovations have most in common: those of others may be alike because it is believed. What has a slow error
/// of its own is left as it is. False where there is none.
bool widen_lasting(const Problem& problem, AidedNavigation& navigation);
/// The doubt in words where innovations have much in common; otherwise empty.
void judge_lasting(AidedNavigation& navigation);

}  // namespace imulab::aided
