// A prediction as a page: the uncertainty of each coefficient, and what limits it; and a planned procedure.
#pragma once

#include "imulab/results/summary.hpp"

#include <string>

namespace imulab {

struct PredictionReport {
  std::string procedure;  ///< its name
  PredictionSummary summary;
  std::vector<std::string> tables = {};  ///< further text, as the command prints it
  Conclusion conclusion = {};
};

/// HTML, self-contained.
std::string prediction_page(const PredictionReport& report);

namespace report {
/// Uncertainties with the shares of their sources, for pages that contain a prediction.
std::string prediction_sections(const PredictionSummary& summary);
std::string shortfall_line(const Shortfall& shortfall);
/// Text with its columns kept.
std::string preformatted(const std::string& text);
}  // namespace report

/// HTML, self-contained. `written`: the file that has the procedure; empty: none.
std::string plan_page(const PlanSummary& plan, const Conclusion& conclusion = {}, const std::string& written = "");

}  // namespace imulab
