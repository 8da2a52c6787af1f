// Comparisons of calibrations as JSON and as a table.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/compare.hpp"
#include "imulab/model/conclusion.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

struct NamedCalibration {
  std::string name;  ///< of its file
  Calibration calibration;
};

/// What a comparison says of each calibration.
struct ComparedCalibration {
  std::string name, imu, serial, method;
  BodyFrame frame = BodyFrame::accelerometers;
  std::string date, dated;  ///< YYYY-MM-DD, and of what: "measured" (declared), "recorded" (stamps), "calibrated"; empty: not known
  bool bare = false;        ///< no uncertainties: taken as the truth
  bool doubtful = false;
  bool with_turn_on = false;  ///< its offsets were compared with their repeatability from turn-on to turn-on
};
ComparedCalibration compared_calibration(const NamedCalibration& named);

struct ComparisonSummary {
  std::vector<std::string> names;       ///< a, then the others
  std::vector<Comparison> comparisons;  ///< one for each of the others
  std::optional<Agreement> agreement = {};
  std::vector<ComparedCalibration> calibrations = {};  ///< as `names`; from JSON of an earlier version: none
  std::vector<RequirementResult> requirements = {};    ///< tolerances
};

/// Of the k-th of the others less the first, in years; absent where a date is not known, and for less than 30 days, from which a change per year
/// would only be a multiple of the uncertainty.
std::optional<double> years_between(const ComparisonSummary& summary, std::size_t k);

/// Is the size of each difference at most the limit (simple acceptance)? `reached`: the largest difference of these coefficients, of matrices
/// relative to the row's scale; infinite where one of the two did not determine it.
RequirementResult assess(const ComparisonSummary& summary, const Requirement& tolerance);

/// A verdict where there are tolerances; a headline always.
Conclusion conclusion_about(const ComparisonSummary& summary);

/// From this many sigmas on a difference is significant among all that the comparisons test.
double significant_from(const ComparisonSummary& summary);

/// Rows of the comparisons: most significant first, then what is not tested. The first `significant` of them differ significantly in one of them at
/// least.
struct RankedRows {
  std::vector<std::size_t> rows;
  std::size_t significant = 0, tested = 0;
};
RankedRows ranked_rows(const std::vector<Comparison>& comparisons, double from);

/// A pair's tests: of the k-th of the others and the first.
struct PairTest {
  std::size_t k = 0, differing = 0, tested = 0;  ///< coefficients that differ significantly, of those with an uncertainty
  Consistency together;
  std::string differences;  ///< against the stated uncertainties: "larger", "as stated", "smaller"; empty: nothing is tested
};
/// "accel.offset.z (41 sigmas), ..., and 3 more"; empty where all agree.
std::string differing_text(const Consistency& consistency);
std::string probability_text(double p);
/// "the differences are as large as the stated uncertainties say", or larger or smaller.
std::string size_text(const Consistency& consistency);
/// A chi-square of differences, judged so.
std::string judged_text(const Consistency& consistency);
/// "42 coefficients do not differ significantly, 9 are not tested": the rows that are not shown; empty where all are.
std::string rest_text(const std::vector<Comparison>& comparisons, const RankedRows& ranked, std::size_t shown);
/// The pairs with the least probable differences first.
std::vector<PairTest> ranked_pairs(const ComparisonSummary& summary);

/// One comparison as an object {"a", "b", "frame", "coefficients", "consistency"}; several as {"comparisons": [such objects], "agreement": {...} or
/// null}; then "calibrations", and "requirements" where there are any. SI, and user units beside.
std::string comparison_json(const ComparisonSummary& summary);

/// The verdict, the results of the tests, the calibrations, then one row per coefficient that differs significantly: for one comparison the
/// difference in user units, in sigmas and per year, of several each difference in sigmas. With `details` all rows, and the values in SI.
std::string comparison_table(const ComparisonSummary& summary, bool details = false);

}  // namespace imulab
