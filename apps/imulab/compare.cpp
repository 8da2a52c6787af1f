// imulab compare CALIBRATION CALIBRATION|TRUTH...
#include "imulab/tasks/compare.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/report.hpp"
#include "imulab/core/error.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/report/comparison_page.hpp"

#include <fmt/core.h>

#include <filesystem>
#include <memory>

namespace imulab::command {

namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> files;
  std::string report;
  bool json = false, different_imus = false, verbose = false;
};

bool same_file(const std::string& a, const std::string& b) {
  std::error_code none;  // a file that does not exist is refused when it is read
  return a == b || fs::equivalent(a, b, none);
}

void check_files_differ(const std::vector<std::string>& files) {
  for (std::size_t i = 0; i < files.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (same_file(files[i], files[j]))
        throw Error(fmt::format("{}: the same file as {}; a comparison takes the errors as independent; expected different calibrations", files[i],
                                files[j]));
}

void run(const Options& options) {
  check_files_differ(options.files);
  std::vector<NamedCalibration> inputs;
  for (const std::string& file : options.files) inputs.push_back({file == "-" ? "standard input" : file, read_calibration(file)});
  const ComparedCalibrations compared = compare_calibrations(inputs, options.different_imus);
  for (const std::string& text : compared.warnings) warn(text);
  const ComparisonSummary& summary = compared.summary;
  if (!options.report.empty()) write_whole(options.report, comparison_page(summary));
  options.json ? print_json(comparison_json(inputs, summary.comparisons, summary.agreement))
               : print(comparison_table(inputs, summary.comparisons, summary.agreement, options.verbose));
}

}  // namespace

void add_compare(Verb app) {
  const auto options = std::make_shared<Options>();
  Verb verb = app.verb("compare", "Compare calibrations of one IMU, coefficient by coefficient");
  verb.option("CALIBRATION", options->files,
              "two or more calibrations, or truth.json of a simulation; - for standard input. The others are compared with the first. Their "
              "errors are taken as independent; a file without uncertainties is taken as the truth")
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
