#include "imulab/estimate/kernel/second_opinion.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/frame.hpp"
#include "imulab/model/relative_uncertainty.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace imulab::kernel {

std::optional<SecondOpinion> second_opinion(const Calibration& estimate, const Calibration& other) {
  constexpr double least = 0.1;  // fraction of the larger variance; a smaller difference means the same data with the same weights
  const Calibration a = in_accelerometer_frame(estimate), b = in_accelerometer_frame(other);
  struct Pair {
    CoefficientIndex index;
    double of_a, of_b;  // variances
  };
  std::vector<Pair> pairs;
  for (const CoefficientIndex index : a.estimated) {
    const std::optional<double> of_a = standard_uncertainty(a, index), of_b = standard_uncertainty(b, index);
    if (of_a && of_b && is_result(a, index) && is_result(b, index)) pairs.push_back({index, *of_a * *of_a, *of_b * *of_b});
  }
  const bool a_is_better = std::ranges::any_of(pairs, [&](const Pair&p) { return p.of_a < (1 - least) * p.of_b; }),
             b_is_better = std::ranges::any_of(pairs, [&](const Pair&p) { return p.of_b < (1 - least) * p.of_a; });
  std::optional<SecondOpinion> worst;
  for (const Pair& p : pairs) {
    const bool independent = a_is_better && b_is_better;
    if (!independent && !(std::abs(p.of_b - p.of_a) >= least * std::max(p.of_a, p.of_b))) continue;
    // Each method infers effect sizes from its own part of the data: the estimates may differ by the uncertainty of the better one.
    const double variance = independent ? p.of_a + p.of_b : std::max(std::abs(p.of_b - p.of_a), std::min(p.of_a, p.of_b));
    const double sigmas = (coefficient_value(b.model, p.index) - coefficient_value(a.model, p.index)) / std::sqrt(variance);
    if (!worst || std::abs(sigmas) > std::abs(worst->sigmas)) worst = SecondOpinion{b.method, std::string(coefficient(p.index).name), sigmas};
  }
  return worst;
}

void add_second_opinion(Calibration& calibration, const Calibration& other) {
  constexpr double most = 3.7;
  Quality& quality = calibration.quality;
  if (other.quality.verdict == Verdict::doubtful) {
    if (other.quality.cause && quality.cause == other.quality.cause) return;
    const bool first = !quality.cause;
    for (const Finding& doubt : other.quality.findings) {
      if (!is_of_session(doubt.code)) continue;
      quality.findings.add<Code::other_method_doubts>(doubt.text, other.method).subject = name_of(doubt.code);
      if (first) quality.cause = other.quality.cause;
    }
    return judge(quality);
  }
  const std::optional<SecondOpinion> opinion = second_opinion(calibration, other);
  if (!opinion) return;
  quality.second_opinion = opinion;
  if (std::abs(opinion->sigmas) > most)
    quality.findings.add<Code::other_method_differs>(opinion->method, Subject{opinion->coefficient}, std::abs(opinion->sigmas));
  judge(quality);
}

}  // namespace imulab::kernel
