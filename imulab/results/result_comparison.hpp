// Saved results of one kind side by side: budgets, noise, predictions, navigations. Figures by name, curves over one axis.
#pragma once

#include "imulab/results/summary.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace imulab {

struct NamedResult {
  std::string name;  ///< of its file, or a budget's grade
  SavedResult result;
  std::string note = {};  ///< what is known of it besides, as the noise of a budget
};

/// One figure of every result; NaN where a result does not have it.
struct ComparedFigure {
  std::string name, unit;
  std::vector<double> values, uncertainties, bounds;  ///< in the unit; bounds: of a figure that is only known to be smaller
  double significance = -1;  ///< largest change against the first: in sigmas where uncertainties are known, else relative; below 0: not known
};

struct ComparedCurve {
  std::size_t result = 0;
  std::string panel;  ///< of a figure: "gyros [deg/h]"
  std::vector<double> x, y;
};

struct ResultComparison {
  std::string kind;  ///< "budget"
  std::string headline;
  std::vector<std::string> names, notes;
  std::vector<ComparedFigure> figures;  ///< the most significant first
  bool in_sigmas = false;               ///< what significance is
  std::vector<ComparedCurve> curves;
  std::string x_label;
  bool logarithmic = false;  ///< both axes
};

/// The name of a result's kind: "calibration", "budget", ...
std::string kind_name(const SavedResult& result);

/// Throws Error for fewer than two results, a mix of kinds, and a kind or content that cannot be compared.
ResultComparison compare_results(const std::vector<NamedResult>& results);

/// {"kind", "results": [names], "notes", "figures": {name: {"unit", "values", "standard_uncertainties", "bounds", "sigmas" or "relative_change"}}}
std::string result_comparison_json(const ResultComparison& comparison);
/// The results, then a row a figure. Without `details` only the first rows.
std::string result_comparison_table(const ResultComparison& comparison, bool details = false);

/// "12.30", "< 0.2", "-": a figure of the k-th result with the digits that its uncertainty supports.
std::string figure_text(const ComparedFigure& figure, std::size_t k);
/// "+3.1" sigmas, or "x 2.3"; of the k-th against the first. Empty where it is not known.
std::string change_text(const ComparedFigure& figure, std::size_t k);

}  // namespace imulab
