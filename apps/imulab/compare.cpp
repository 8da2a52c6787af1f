// imulab compare CALIBRATION CALIBRATION|TRUTH...
#include "imulab/analysis/compare.hpp"

#include "apps/imulab/command.hpp"
#include "imulab/core/error.hpp"
#include "imulab/io/calibration_file.hpp"
#include "imulab/io/comparison_text.hpp"
#include "imulab/model/coefficient.hpp"

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
  bool json = false;
};

// ---- the calibrations

struct Input {
  std::string name;
  Calibration calibration;
};

/// The accelerometers' frame is found from their matrix.
void warn_of_open_frame(const Input& input) {
  const std::vector<int>& estimated = input.calibration.estimated;
  if (input.calibration.frame != "rig" || estimated.empty()) return;
  for (const int index : select_coefficients("accel.matrix"))
    if (std::find(estimated.begin(), estimated.end(), index) == estimated.end())
      return warn(
          fmt::format("{}: {} was not estimated, so the accelerometers' frame, in which is compared, is not known: differences have the other's "
                      "misalignments in them",
                      input.name, coefficient_table()[static_cast<std::size_t>(index)].name));
}

Input read(const std::string& file) {
  Input input{file == "-" ? "standard input" : file, read_calibration(file)};
  try {
    compare(input.calibration, input.calibration);  // refuses a singular matrix, which only here has its file's name
  } catch (const Error& e) {
    throw Error(fmt::format("{}: model.{}", input.name, e.what()));
  }
  warn_of_open_frame(input);
  return input;
}

bool same_file(const std::string& a, const std::string& b) {
  std::error_code none;  // what does not exist is refused by name when it is read
  return a == b || fs::equivalent(a, b, none);
}

void check_files_differ(const std::vector<std::string>& files) {
  for (std::size_t i = 0; i < files.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (same_file(files[i], files[j]))
        throw Error(fmt::format("{}: the same file as {}, expected different calibrations: their errors count as independent", files[i], files[j]));
}

void check_same_raw_units(const Input& a, const Input& b) {
  for (const auto& [triad, a_unit, b_unit] : {std::tuple("accel", a.calibration.model.accel.raw_unit, b.calibration.model.accel.raw_unit),
                                              std::tuple("gyro", a.calibration.model.gyro.raw_unit, b.calibration.model.gyro.raw_unit)})
    if (!a_unit.empty() && !b_unit.empty() && a_unit != b_unit)
      throw Error(fmt::format("{}: {} was calibrated from {}, expected {} as in {}", b.name, triad, b_unit, a_unit, a.name));
}

std::vector<Input> read_all(const std::vector<std::string>& files) {
  check_files_differ(files);
  std::vector<Input> inputs;
  for (const auto& file : files) {
    inputs.push_back(read(file));
    for (std::size_t k = 0; k + 1 < inputs.size(); ++k) check_same_raw_units(inputs[k], inputs.back());
  }
  return inputs;
}

// ---- the table: one row a coefficient, one difference and its sigmas for each calibration after the first; of two there is room for more

std::string letter(std::size_t k) { return k < 26 ? std::string(1, static_cast<char>('A' + k)) : fmt::format("#{}", k + 1); }

std::string describe(const Input& input) {
  const Calibration& c = input.calibration;
  const std::string frame = c.frame == "rig" ? "the rig's frame" : "the accelerometers' frame";
  if (c.estimated.empty()) return fmt::format("{}  (no uncertainties: taken as the truth; {})", input.name, frame);
  return fmt::format("{}  ({}{}{}; {})", input.name, c.imu, c.imu.empty() ? "" : ", ", c.method, frame);
}

std::string or_dash(const std::optional<double>& value, const char* format) { return value ? fmt::format(fmt::runtime(format), *value) : "-"; }

bool significant(const CoefficientDifference& d, double mark_from) { return std::abs(d.user_sigmas().value_or(0)) > mark_from; }

void print_heading(std::size_t others) {
  const bool pair = others == 1;
  fmt::print("{:<24} {:>15}", "coefficient", "A");
  if (pair) fmt::print(" {:>15}", "B");
  for (std::size_t k = 1; k <= others; ++k) fmt::print(" {:>11}", letter(k) + " - A");
  if (pair) fmt::print(" {:>9}", "+/-");
  fmt::print(" {:<20}", "unit");
  for (std::size_t k = 1; k <= others; ++k) fmt::print(" {:>8}{}", pair ? "sigmas" : letter(k) + " sigmas", k < others ? "  " : "");
  fmt::print("\n");
}

void print_row(const std::vector<Comparison>& comparisons, std::size_t row, double mark_from) {
  const bool pair = comparisons.size() == 1;
  const CoefficientDifference& first = comparisons[0].coefficients[row];
  fmt::print("{:<24} {:>15.8g}", coefficient_table()[static_cast<std::size_t>(first.index)].name, first.a);
  if (pair) fmt::print(" {:>15.8g}", first.b);
  for (const auto& c : comparisons) fmt::print(" {:>11.4g}", c.coefficients[row].user_difference);
  if (pair) fmt::print(" {:>9}", or_dash(first.user_uncertainty, "{:.2g}"));
  std::string line = fmt::format(" {:<20}", first.user_unit);
  for (const auto& c : comparisons)
    line += fmt::format(" {:>8}{}", or_dash(c.coefficients[row].user_sigmas(), "{:+.1f}"), significant(c.coefficients[row], mark_from) ? " *" : "  ");
  fmt::print("{}\n", line.substr(0, line.find_last_not_of(' ') + 1));
}

/// How a chi-square of differences stands to the stated uncertainties.
std::string verdict(const Consistency& c) {
  const char* size = c.p_value < 0.001 ? "larger than" : c.p_value > 0.999 ? "smaller than" : "as large as";
  return fmt::format("chi2 = {:.1f}, probability of more {:.2g}: the differences are {} the stated uncertainties say", c.chi2, c.p_value, size);
}

void print_comparison(const std::string& who, const Comparison& comparison, double mark_from) {
  const auto& rows = comparison.coefficients;
  const auto marked = std::count_if(rows.begin(), rows.end(), [&](const auto& d) { return significant(d, mark_from); });
  const auto tested = std::count_if(rows.begin(), rows.end(), [](const auto& d) { return d.user_sigmas().has_value(); });
  fmt::print("{}{} of {} coefficients differ significantly (* beyond {:.1f} sigma: 1 % for all together).\n", who, marked, tested, mark_from);
  const Consistency& c = comparison.consistency;
  if (c.degrees_of_freedom > 0) fmt::print("{}{} coefficients together: {}.\n", who, c.degrees_of_freedom, verdict(c));
  if (c.degrees_of_freedom == 0)
    fmt::print("{}No coefficient has an uncertainty on a side that the other can be held against: nothing to test.\n", who);
}

void print_agreement(const Agreement& agreement) {
  if (agreement.consistency.degrees_of_freedom == 0) {
    fmt::print("The {} calibrations have no coefficient in common: nothing to test.\n", agreement.calibrations);
    return;
  }
  std::string differing;
  for (const auto& c : agreement.coefficients)
    if (c.differs) differing += fmt::format("{}{}", differing.empty() ? "" : ", ", coefficient_table()[static_cast<std::size_t>(c.index)].name);
  fmt::print("All {} calibrations about their weighted mean, {} degrees of freedom: {}.\nCoefficients that differ among them: {}.\n",
             agreement.calibrations, agreement.consistency.degrees_of_freedom, verdict(agreement.consistency),
             differing.empty() ? "none" : differing);
}

void print_table(const std::vector<Input>& inputs, const std::vector<Comparison>& comparisons, const std::optional<Agreement>& joint) {
  std::size_t tests = 0;
  for (const auto& c : comparisons)
    for (const auto& d : c.coefficients) tests += d.user_sigmas().has_value();
  const double mark_from = significant_sigmas(tests);
  for (std::size_t k = 0; k < inputs.size(); ++k) fmt::print("{}  {}\n", letter(k), describe(inputs[k]));
  const bool pair = comparisons.size() == 1;
  fmt::print("{} in the accelerometers' frame; quadratic and cubic terms are compared unrotated. {} in SI.\n\n", pair ? "Both" : "All",
             pair ? "A and B" : "A");
  print_heading(comparisons.size());
  for (std::size_t row = 0; row < comparisons[0].coefficients.size(); ++row) print_row(comparisons, row, mark_from);
  fmt::print("\n");
  for (std::size_t k = 0; k < comparisons.size(); ++k) print_comparison(pair ? "" : letter(k + 1) + " - A: ", comparisons[k], mark_from);
  if (joint) print_agreement(*joint);
}

void run(const Options& options) {
  const std::vector<Input> inputs = read_all(options.files);
  std::vector<Calibration> calibrations;
  std::vector<std::string> names;
  for (const auto& input : inputs) {
    calibrations.push_back(input.calibration);
    names.push_back(input.name);
  }
  const std::vector<Comparison> comparisons = compare(calibrations[0], std::vector<Calibration>(calibrations.begin() + 1, calibrations.end()));
  std::optional<Agreement> joint = agreement(calibrations);
  if (joint->calibrations < 3) joint.reset();  // of two, their comparison says it all
  if (options.json) {
    fmt::print("{}", comparison_json(names, comparisons, joint));
  } else {
    print_table(inputs, comparisons, joint);
  }
}

}  // namespace

void add_compare(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  CLI::App* const verb = app.add_subcommand("compare", "Calibrations of one unit coefficient by coefficient, in sigmas and in user units");
  verb->add_option("CALIBRATION", options->files,
                   "two or more: calibrations, or truth.json of a simulation; - is standard input. The others are compared with the first. Their "
                   "errors count as independent; a file without uncertainties counts as the truth")
      ->required()
      ->expected(2, -1);
  verb->add_flag("--json", options->json, "print the result for machines");
  verb->callback([options] { run(*options); });
}

}  // namespace imulab::command
