#include "imulab/tasks/compare.hpp"

#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"
#include "imulab/compare.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/report/comparison_page.hpp"
#include "imulab/tasks/usable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

namespace imulab {
namespace {

/// The accelerometers' frame follows from their matrix.
std::vector<std::string> open_frame(const NamedCalibration& input) {
  const std::vector<CoefficientIndex>& estimated = input.calibration.estimated;
  if (input.calibration.frame != BodyFrame::rig || estimated.empty()) return {};
  for (const CoefficientIndex index : select_coefficients("accel.matrix"))
    if (std::find(estimated.begin(), estimated.end(), index) == estimated.end())
      return {
          fmt::format("{}: {} was not estimated; the accelerometers' frame of the comparison is unknown; differences contain the other's "
                      "misalignments",
                      input.name, coefficient(index).name)};
  return {};
}

void check_same_raw_units(const NamedCalibration& a, const NamedCalibration& b) {
  for (const auto& [triad, a_unit, b_unit] : {std::tuple("accel", a.calibration.model.accel.raw_unit, b.calibration.model.accel.raw_unit),
                                              std::tuple("gyro", a.calibration.model.gyro.raw_unit, b.calibration.model.gyro.raw_unit)})
    if (!a_unit.empty() && !b_unit.empty() && a_unit != b_unit)
      throw Error(fmt::format("{}: {} was calibrated from {}, expected {} as in {}", b.name, triad, b_unit, a_unit, a.name));
}

void check_same_imu(const NamedCalibration& a, const NamedCalibration& b) {
  const std::string &of_a = a.calibration.serial, &of_b = b.calibration.serial;
  if (!of_a.empty() && !of_b.empty() && of_a != of_b)
    throw Error(fmt::format("{}: is of serial number {}, and {} is of {}; expected calibrations of one IMU, or that different IMUs are allowed",
                            b.name, excerpt(of_b), a.name, excerpt(of_a)));
}

}  // namespace

Verb& declare(Verb& command, CompareOptions& o) {
  Verb& verb = command.verb("compare", "Compare calibrations of one IMU, or saved results of one kind");
  verb.option("CALIBRATION", o.files,
              "two or more calibrations, or truth.json of a simulation, compared with the first; a file without uncertainties is the truth. Or "
              "results of one verb as JSON: noise, budget, predict or navigate. - for standard input")
      .required()
      .takes_several(2)
      .reads();
  verb.option("--tolerance LIMITS", o.tolerance,
              "limits for the size of each difference, without its uncertainty, as in \"gyro.bias <= 0.01 deg/h\"; exit code 1 if one is exceeded. A "
              "coefficient that one calibration did not determine meets none, nor does a doubtful calibration");
  verb.option("--different-imus", o.different_imus, "compare calibrations of different serial numbers");
  report_option(verb, o.report);
  json_option(verb, o.json);
  verb.option("-v,--verbose", o.verbose, "also print all coefficients, and values in SI").of_command();
  verb.example("imulab compare calibration.json session/truth.json");
  verb.example("imulab compare spring.json autumn.json --tolerance \"gyro.bias <= 0.01 deg/h\"");
  return verb;
}

AnswerOf<ComparisonSummary> comparison_answer(std::vector<NamedCalibration> calibrations, bool different_imus,
                                              const std::optional<std::string>& tolerance) {
  const std::vector<Requirement> tolerances =
      tolerance ? errors_of_option("tolerance", [&] { return parse_requirements(*tolerance); }) : std::vector<Requirement>();
  const std::vector<NamedCalibration> inputs = std::move(calibrations);
  const auto summary = std::make_shared<ComparisonSummary>();
  std::vector<std::string> warnings;
  std::vector<Calibration> all;
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    const NamedCalibration& input = inputs[k];
    expect_sizes(input.calibration, input.name);
    errors_at(input.name, [&] { compare(input.calibration, input.calibration); });  // a singular matrix is refused where its name is known
    for (std::size_t i = 0; i < k; ++i) {
      check_same_raw_units(inputs[i], input);
      if (!different_imus) check_same_imu(inputs[i], input);
    }
    for (auto& texts : {open_frame(input), doubt_about(input.calibration, input.name)}) warnings.insert(warnings.end(), texts.begin(), texts.end());
    summary->names.push_back(input.name);
    summary->calibrations.push_back(compared_calibration(input));
    all.push_back(input.calibration);
  }
  summary->comparisons = compare(all.front(), std::vector<Calibration>(all.begin() + 1, all.end()));
  summary->agreement = agreement(all);
  if (summary->agreement->calibrations < 3) summary->agreement.reset();  // for two, their comparison is enough
  for (const Requirement& each : tolerances) summary->requirements.push_back(assess(*summary, each));
  const Conclusion conclusion = conclusion_about(*summary);
  const bool missed = conclusion.verdict == Verdict::not_met || conclusion.verdict == Verdict::doubtful;
  return {{.json = [summary] { return comparison_json(*summary); },
           .table = [summary](bool details) { return comparison_table(*summary, details); },
           .page = [summary, warnings] { return comparison_page(*summary, warnings); },
           .warnings = warnings,
           .shortcomings = missed ? conclusion_text(conclusion) : "",
           .conclusion = conclusion},
          summary};
}

AnswerOf<ResultComparison> result_comparison_answer(const std::vector<NamedResult>& results) {
  const auto comparison = std::make_shared<const ResultComparison>(compare_results(results));
  return {{.json = [comparison] { return result_comparison_json(*comparison); },
           .table = [comparison](bool details) { return result_comparison_table(*comparison, details); },
           .page = [comparison] { return result_comparison_page(*comparison); },
           .conclusion = {Verdict::none, comparison->headline}},
          comparison};
}

}  // namespace imulab
