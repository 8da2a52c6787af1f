// imulab compare CALIBRATION CALIBRATION|TRUTH...
#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/io/calibration_file.hpp"
#include "imulab/io/comparison_text.hpp"
#include "imulab/model/coefficient.hpp"

#include <fmt/core.h>

#include "apps/imulab/command.hpp"
#include <algorithm>
#include <cmath>
#include <memory>
#include <tuple>

namespace imulab::command {

namespace {

struct Options {
  std::string first;
  std::vector<std::string> others;
  bool json = false;
};

std::string describe(const std::string& file, const Calibration& c) {
  const std::string frame = c.frame == "rig" ? "the rig's frame" : "the accelerometers' frame";
  if (c.estimated.empty()) return fmt::format("{}  (no uncertainties: taken as the truth; {})", file, frame);
  return fmt::format("{}  ({}{}{}; {})", file, c.imu, c.imu.empty() ? "" : ", ", c.method, frame);
}

/// Of m coefficients that agree, one in a hundred comparisons marks any.
double marking_sigmas(std::size_t m) { return normal_quantile(1 - 0.005 / static_cast<double>(std::max<std::size_t>(m, 1))); }

void print_row(const CoefficientDifference& d, double mark_from) {
  const auto sigmas = d.user_sigmas();
  const auto optional = [](const std::optional<double>& value, const char* format) {
    return value ? fmt::format(fmt::runtime(format), *value) : "-";
  };
  fmt::print("{:<24} {:>15.8g} {:>15.8g} {:>11.4g} {:>9} {:<20} {:>8}{}\n", coefficient_table()[static_cast<std::size_t>(d.index)].name, d.a, d.b,
             d.user_difference, optional(d.user_uncertainty, "{:.2g}"), d.user_unit, optional(sigmas, "{:+.1f}"),
             sigmas && std::abs(*sigmas) > mark_from ? " *" : "");
}

void print_consistency(const Consistency& c) {
  if (c.degrees_of_freedom == 0) {
    fmt::print("No coefficient has an uncertainty on a side that the other can be held against: nothing to test.\n");
    return;
  }
  const char* verdict = "the differences are as large as the stated uncertainties say";
  if (c.p_value < 0.001) verdict = "the differences are larger than the stated uncertainties say";
  if (c.p_value > 0.999) verdict = "the differences are smaller than the stated uncertainties say";
  fmt::print("{} coefficients together: chi2 = {:.1f}, probability of more {:.2g}: {}.\n", c.degrees_of_freedom, c.chi2, c.p_value, verdict);
}

void print_table(const NamedComparison& named, const Calibration& a, const Calibration& b) {
  const auto& rows = named.comparison.coefficients;
  fmt::print("A  {}\nB  {}\n", describe(named.a, a), describe(named.b, b));
  fmt::print("Both in the accelerometers' frame; quadratic and cubic terms are compared unrotated. A and B in SI.\n\n");
  fmt::print("{:<24} {:>15} {:>15} {:>11} {:>9} {:<20} {:>8}\n", "coefficient", "A", "B", "B - A", "+/-", "unit", "sigmas");
  const auto tested = static_cast<std::size_t>(std::count_if(rows.begin(), rows.end(), [](const auto& d) { return d.user_sigmas().has_value(); }));
  const double mark_from = marking_sigmas(tested);
  for (const auto& d : rows) print_row(d, mark_from);
  const auto marked = std::count_if(rows.begin(), rows.end(), [&](const auto& d) { return std::abs(d.user_sigmas().value_or(0)) > mark_from; });
  fmt::print("\n{} of {} coefficients differ significantly (* beyond {:.1f} sigma: 1 % for all together).\n", marked, tested, mark_from);
  print_consistency(named.comparison.consistency);
}

void check_same_raw_unit(const std::string& a_file, const Calibration& a, const std::string& b_file, const Calibration& b) {
  for (const auto& [triad, a_unit, b_unit] : {std::tuple("accel", a.model.accel.raw_unit, b.model.accel.raw_unit), std::tuple("gyro", a.model.gyro.raw_unit, b.model.gyro.raw_unit)})
    if (!a_unit.empty() && !b_unit.empty() && a_unit != b_unit)
      throw Error(fmt::format("{}: {} was calibrated from {}, {} from {}; they cannot be compared", b_file, triad, b_unit, a_file, a_unit));
}

void run(const Options& options) {
  const Calibration first = read_calibration(options.first);
  std::vector<NamedComparison> comparisons;
  std::vector<Calibration> others;
  for (const auto& file : options.others) {
    others.push_back(read_calibration(file));
    check_same_raw_unit(options.first, first, file, others.back());
    comparisons.push_back({options.first, file, compare(first, others.back())});
  }
  if (options.json) {
    fmt::print("{}", comparison_json(comparisons));
    return;
  }
  for (std::size_t i = 0; i < comparisons.size(); ++i) {
    if (i > 0) fmt::print("\n");
    print_table(comparisons[i], first, others[i]);
  }
}

}  // namespace

void add_compare(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  CLI::App* const verb = app.add_subcommand("compare", "Calibrations coefficient by coefficient, in sigmas and in user units");
  verb->add_option("CALIBRATION", options->first, "the calibration the others are compared with")->required();
  verb->add_option("OTHERS", options->others, "calibrations, or truth.json of a simulation")->required()->expected(1, -1);
  verb->add_flag("--json", options->json, "print the result for machines");
  verb->callback([options] { run(*options); });
}

}  // namespace imulab::command
