// An aided navigation as JSON and as a table for a terminal (docs/theory/aided.md).
#pragma once

#include "imulab/coefficient.hpp"
#include "imulab/navigation/aided/aided.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// The innovations and the residuals during one kind of motion.
struct AidedMotion {
  std::string kind;
  std::size_t innovations = 0;
  double rms = 0;                                       // in stated sigmas
  std::optional<AidedResiduals> gyro = {}, accel = {};  // absent: the data resolve less than one
};
/// Groups the innovations by the motion of the track at their times; a kind without innovations and residuals is omitted.
std::vector<AidedMotion> innovations_by_motion(const AidedNavigation& navigation);

/// A session navigated with its aids. From JSON: the solution has begin and end as times, the track is thinned; covariances have their
/// diagonals alone, of position and attitude.
struct AidedSummary {
  std::string session;
  AidedNavigation navigation;
  double largest_sigma = 0;  // m, horizontal
  std::vector<AidedMotion> motion = {};
};
std::string aided_json(const std::string& session, const AidedNavigation& navigation);

/// What an aid turned out to be: absent values are not states of its kind.
struct AidedAid {
  std::string name, kind;
  std::vector<double> lever_arm, lever_arm_sigma;   // right, forward, up [m]; empty: none
  std::vector<double> mounting, mounting_sigma;     // pitch, yaw [rad]; empty: none
  std::optional<double> delay, delay_sigma, drift;  // s, s, s/s
  double sigma_factor = 1;                          // of its first kind of value: the sigma found over the stated one
};
std::vector<AidedAid> aided_aids(const AidedNavigation& navigation);

/// Root mean square over the outages of the errors over their sigmas, and the median of the largest horizontal errors [m].
struct OutageSummary {
  double ratio = 0, median = 0, worst = 0;
};
OutageSummary outage_summary(const std::vector<OutageResult>& outages, OutageErrors OutageResult::*part);

/// One sigma of the position at its largest [m], horizontal, outside withheld times and in them.
double largest_sigma(const AidedNavigation& navigation);

std::string aided_headline(const AidedNavigation& navigation);
namespace json_io {
class Field;
}
namespace result_io {
/// Throws Error that names the file and the field.
AidedSummary aided_of(const json_io::Field& root);
}  // namespace result_io
std::string aided_table(const std::string& session, const AidedNavigation& navigation);

}  // namespace imulab
