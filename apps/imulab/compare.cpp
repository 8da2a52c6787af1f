// imulab compare CALIBRATION CALIBRATION|TRUTH...
#include "imulab/model/compare.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/report.hpp"
#include "apps/imulab/usable.hpp"
#include "imulab/core/error.hpp"
#include "imulab/io/calibration/file.hpp"
#include "imulab/io/result/comparison.hpp"
#include "imulab/io/text/file.hpp"
#include "imulab/io/text/printable.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/report/comparison_page.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <tuple>

namespace imulab::command {

namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> files;
  std::string report;
  bool json = false, different_imus = false, verbose = false;
};

/// The accelerometers' frame follows from their matrix.
void warn_of_open_frame(const NamedCalibration& input) {
  const std::vector<CoefficientIndex>& estimated = input.calibration.estimated;
  if (input.calibration.frame != "rig" || estimated.empty()) return;
  for (const CoefficientIndex index : select_coefficients("accel.matrix"))
    if (std::find(estimated.begin(), estimated.end(), index) == estimated.end())
      return warn(
          fmt::format("{}: {} was not estimated, so the accelerometers' frame, in which is compared, is not known: differences have the other's "
                      "misalignments in them",
                      input.name, coefficient(index).name));
}

NamedCalibration read(const std::string& file) {
  NamedCalibration input{file == "-" ? "standard input" : file, read_calibration(file)};
  expect_sizes(input.calibration, input.name);
  errors_at(input.name, [&] { compare(input.calibration, input.calibration); });  // a singular matrix is refused where its file is known
  warn_of_open_frame(input);
  return input;
}

bool same_file(const std::string& a, const std::string& b) {
  std::error_code none;  // a file that does not exist is refused when it is read
  return a == b || fs::equivalent(a, b, none);
}

void check_files_differ(const std::vector<std::string>& files) {
  for (std::size_t i = 0; i < files.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (same_file(files[i], files[j]))
        throw Error(fmt::format("{}: the same file as {}; their errors count as independent; expected different calibrations", files[i], files[j]));
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
    throw Error(fmt::format("{}: is of serial number {}, and {} is of {}; expected calibrations of one IMU, or --different-imus", b.name,
                            excerpt(of_b), a.name, excerpt(of_a)));
}

std::vector<NamedCalibration> read_all(const std::vector<std::string>& files, bool different_imus) {
  check_files_differ(files);
  std::vector<NamedCalibration> inputs;
  for (const auto& file : files) {
    inputs.push_back(read(file));
    for (std::size_t k = 0; k + 1 < inputs.size(); ++k) {
      check_same_raw_units(inputs[k], inputs.back());
      if (!different_imus) check_same_imu(inputs[k], inputs.back());
    }
  }
  return inputs;
}

void run(const Options& options) {
  const std::vector<NamedCalibration> inputs = read_all(options.files, options.different_imus);
  std::vector<Calibration> calibrations;
  for (const auto& input : inputs) calibrations.push_back(input.calibration);
  const std::vector<Comparison> comparisons = compare(calibrations[0], std::vector<Calibration>(calibrations.begin() + 1, calibrations.end()));
  std::optional<Agreement> joint = agreement(calibrations);
  if (joint->calibrations < 3) joint.reset();  // for two, their comparison is enough
  if (!options.report.empty()) {
    ComparisonSummary summary{.names = {}, .comparisons = comparisons, .agreement = joint};
    for (const auto& input : inputs) summary.names.push_back(input.name);
    write_whole(options.report, comparison_page(summary));
  }
  options.json ? print_json(comparison_json(inputs, comparisons, joint)) : print(comparison_table(inputs, comparisons, joint, options.verbose));
}

}  // namespace

void add_compare(Verb app) {
  const auto options = std::make_shared<Options>();
  Verb verb = app.verb("compare", "Compare calibrations of one IMU, coefficient by coefficient");
  verb.option("CALIBRATION", options->files,
              "two or more calibrations, or truth.json of a simulation; - for standard input. The others are compared with the first. Their "
              "errors count as independent; a file without uncertainties counts as the truth")
      .required()
      .takes_several(2)
      .reads();
  verb.flag("--different-imus", options->different_imus, "compare calibrations of different serial numbers");
  add_report_option(verb, options->report);
  verb.flag("--json", options->json, "print the result as JSON");
  verb.flag("-v,--verbose", options->verbose, "print also the values in SI");
  verb.example("imulab compare calibration.json session/truth.json");
  verb.does([options] { run(*options); });
}

}  // namespace imulab::command
