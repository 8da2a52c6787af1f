// Results of one kind side by side: figures by name, curves over one axis; as JSON, out and in, and as a table. compare_results.hpp makes them.
#pragma once

#include "imulab/formats/text/json.hpp"

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace imulab {

/// One figure of every result; NaN where a result does not have it.
struct ComparedFigure {
  std::string name, unit;
  std::vector<double> values, uncertainties, bounds;  ///< in the unit; bounds: of a figure that is only known to be smaller

  bool in_sigmas() const;       ///< its changes; else they are relative
  double significance() const;  ///< the largest change against the first: in sigmas or relative; below 0: not known
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
  std::vector<ComparedCurve> curves;
  std::string x_label;
  bool logarithmic = false;                                 ///< both axes
  std::vector<std::pair<std::string, double>> limits = {};  ///< of the curves' figure, with their texts; not in JSON

  bool in_sigmas() const;  ///< its significances
};

/// {"kind", "results": [names], "notes", "figures": {name: {"unit", "values", "standard_uncertainties", "bounds", "sigmas" or "relative_change"}}},
/// then for the picture "x_label", "logarithmic", "curves": [{"result", "panel", "x", "y"}].
std::string result_comparison_json(const ResultComparison& comparison);
/// Reads that. Throws Error that names the field.
ResultComparison result_comparison_of(const json_io::Field& root);
/// The results, then a row a figure. Without `details` only the first rows.
std::string result_comparison_table(const ResultComparison& comparison, bool details = false);

/// "A", ..., "Z", "#27": the k-th of the compared in a table.
std::string letter_of(std::size_t k);
/// "largest difference: gyro.x.N: a.json 1.2 deg/sqrt(h), b.json ..."
std::string headline_of(const ResultComparison& comparison);
/// "12.30", "< 0.2", "-": a figure of the k-th result with the digits that its uncertainty supports.
std::string figure_text(const ComparedFigure& figure, std::size_t k);
/// "+3.1" sigmas, or "x 2.3"; of the k-th against the first. Empty where it is not known.
std::string change_text(const ComparedFigure& figure, std::size_t k);

}  // namespace imulab
