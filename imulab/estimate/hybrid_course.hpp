// The course of the hybrid method: passes of the filter about ever better models, the terms that the data want, and the velocities they refuse.
#pragma once

#include "imulab/estimate/hybrid_filter.hpp"
#include "imulab/model/calibration.hpp"

#include <cstddef>
#include <optional>
#include <vector>

namespace imulab {

/// What does not change from pass to pass.
struct HybridData {
  const Recording& recording;
  std::vector<HybridBlock> blocks;
  HybridSite site;
  HybridNoise noise;
  SensorModel coarse;
  std::vector<int> wanted;  ///< table indices to estimate; empty: all
};

/// Where the repetitions stand.
struct HybridCourse {
  SensorModel model;  ///< the point of linearisation, with `site`
  HybridSite site;
  HybridTerms terms;
  HybridSettings settings;
  Eigen::VectorXd total;  ///< what was corrected since the coarse solution
  Eigen::VectorXd prior;  ///< standard deviations about the coarse solution
  HybridPass pass;        ///< the last one; once converged it is about the final model
  bool converged = false;
  bool heading_known = false;  ///< the start's, well enough for a linearisation
  int repetitions = 0;
};

/// From the coarse solution, or on from where `before` stands, with these terms. What of the model belonged to a term that is left out goes back to
/// the coarse solution.
HybridCourse begin_course(const HybridData& data, const HybridTerms& terms);
HybridCourse with_terms(const HybridData& data, const HybridCourse& before, const HybridTerms& terms);

/// Errors of the course's model by its last pass. A coefficient of which the data do not halve the prior is undetermined: it is held at the coarse
/// solution, and how far that may be off counts in the others' covariance.
struct HybridErrors {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
  std::vector<Eigen::Index> undetermined;
};
HybridErrors determined_errors(const HybridCourse& course);

/// One pass, about the same model.
HybridCourse repeated(const HybridData& data, HybridCourse course);

/// Passes until the correction is below a hundredth of its sigma.
HybridCourse converged(const HybridData& data, HybridCourse course);

/// Blocks whose velocity the converged solution cannot explain: the unit was bumped or shaken. Empty also where so many are that the model is in
/// doubt.
std::vector<std::size_t> outlying_blocks(const HybridData& data, const HybridCourse& course);

/// What the site and the fixed model leave unexplained.
struct SeenLatitude {
  double value, sigma;  ///< rad: that of the Earth's rate as the gyros see it
};
struct HybridReview {
  std::optional<SeenLatitude> latitude;  ///< where it contradicts the site's
  HybridTerms significant;
  std::vector<TermTest> tests;
};

/// One pass with these terms and the latitude open tells which of them are significant (Wald), all considered together.
HybridReview review(const HybridData& data, const HybridCourse& course, const HybridTerms& terms, double significance);

}  // namespace imulab
