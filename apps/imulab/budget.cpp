// imulab budget SPEC
#include "apps/imulab/command.hpp"
#include "apps/imulab/error_sources.hpp"
#include "imulab/analysis/error_budget.hpp"
#include "imulab/analysis/error_monte_carlo.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/io/budget_text.hpp"
#include "imulab/io/calibration_file.hpp"
#include "imulab/io/file.hpp"
#include "imulab/io/mission_file.hpp"
#include "imulab/io/terminal.hpp"
#include "imulab/model/calibration.hpp"
#include "imulab/model/grade.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numeric>
#include <optional>

namespace imulab::command {

ErrorSources read_error_sources(const ErrorSpecification& specification, const std::string& mission) {
  try {
    if (!specification.calibration) return error_sources(specification);
    const Calibration calibration = read_calibration(std::filesystem::path(mission).parent_path() / *specification.calibration);
    if (const std::size_t open = calibration.quality.unobservable.size(); open > 0)
      warn(fmt::format("{}: {} coefficients were not determined (the first: {}) and count as exactly known: what the unit has of them is missing here",
                       *specification.calibration, open, calibration.quality.unobservable.front()));
    return error_sources(specification, &calibration);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: [errors]: {}", mission, e.what()));
  }
}

namespace {

constexpr double nmi_per_h = unit::nmi / unit::hour;

struct Options {
  std::string mission, folder;
  std::optional<std::string> grade, system, calibration;
  std::uint64_t runs = 200, seed = 1;
  double every = 10;
  bool catalogue = false, json = false;
};

void print_catalogue() {
  const auto range = [](const std::array<double, 2>& r, double unit) {
    return r[0] == 0 ? fmt::format("below {:g}", r[1] / unit) : fmt::format("{:g}..{:g}", r[0] / unit, r[1] / unit);
  };
  fmt::print("Grades as published (Xu 2024, table 1)\n\n");
  fmt::print("  {:<12} {:>13} {:>15} {:>12} {:>22} {:>12}\n", "", "rate nmi/h", "gyro deg/h", "accel ug", "misalignment arcsec", "scale ppm");
  for (const PublishedGrade& g : published_grades())
    fmt::print("  {:<12} {:>13} {:>15} {:>12} {:>22} {:>12}\n", g.name,
               g.position_rate[0] == 0 ? fmt::format("{:.0f} m/h", g.position_rate[1] * unit::hour) : range(g.position_rate, nmi_per_h),
               range(g.gyro_bias, unit::deg_per_h), range(g.accel_bias, unit::ug), range(g.misalignment, unit::arcsec), range(g.scale, unit::ppm));
  fmt::print("\nAirliners' systems as published (Xu 2024, table 2)\n\n  {:<12} {:<9} {:>10} {:>11}  {}\n", "", "gyro", "rate nmi/h", "gyro deg/h", "aircraft");
  for (const AirlinerSystem& s : airliner_systems())
    fmt::print("  {:<12} {:<9} {:>10.2g} {:>11.2g}  {}\n", s.name, s.gyro, s.position_rate / nmi_per_h, s.gyro_bias / unit::deg_per_h, s.aircraft);
  fmt::print("\nGrades to draw from (one sigma of each coefficient)\n\n  {:<12} {:>11} {:>10} {:>14} {:>12} {:>20} {:>19}\n", "", "gyro deg/h",
             "accel ug", "misal. arcsec", "scale ppm", "ARW deg/sqrt(h)", "VRW ug/sqrt(Hz)");
  for (const Grade& g : grades())
    fmt::print("  {:<12} {:>11.3g} {:>10.3g} {:>14.3g} {:>12.3g} {:>20.3g} {:>19.3g}\n", g.name, g.gyro_bias / unit::deg_per_h, g.accel_bias / unit::ug,
               g.gyro_misalignment / unit::arcsec, g.gyro_scale / unit::ppm, g.gyro_noise.N / unit::deg_per_sqrt_h,
               g.accel_noise.N / unit::ug_per_sqrt_hz);
}

std::string vertical_text(VerticalChannel vertical) {
  switch (vertical) {
    case VerticalChannel::free:
      return "vertical channel free";
    case VerticalChannel::fixed:
      return "height fixed";
    case VerticalChannel::aided:
      return "height aided by a barometer";
    case VerticalChannel::held:
      break;
  }
  return "height held by a barometer, vertical velocity free";
}

/// Of the mean square of the horizontal position error; the last: the correlation between groups.
std::vector<double> horizontal_shares(const ErrorBudget& b) {
  const std::size_t end = b.time.size() - 1;
  const auto at = static_cast<Eigen::Index>(end);
  std::vector<double> out(b.groups.size() + 1, 0);
  double all = 0;
  for (const int q : {0, 1}) {
    const double square = b.mean(q, at) * b.mean(q, at) + b.covariance[end](q, q);
    const std::vector<double> shares = b.shares(q, end);
    for (std::size_t k = 0; k < out.size(); ++k) out[k] += square * shares[k];
    all += square;
  }
  for (double& share : out) share = all > 0 ? share / all : 0;
  return out;
}

template <class Value>
std::string row_text(const Value& value) {
  std::string text;
  for (Eigen::Index q = 0; q < budget_quantities; ++q)
    text += fmt::format("{}{:>9.3g}", q % 3 == 0 ? "  " : " ", value(q) / (q >= 6 ? unit::arcsec : 1));
  return text;
}

void print_budget(const ErrorBudget& b, const std::optional<ErrorDistribution>& monte_carlo) {
  const auto end = static_cast<Eigen::Index>(b.time.size()) - 1;
  fmt::print("Errors after {:g} s, {}: of what is fixed, and one sigma of what is drawn\n\n", b.time.back(), vertical_text(b.vertical));
  fmt::print("{:<31}  {:^29}  {:^29}  {:^29}  {:>7}\n", "", "position, m", "velocity, m/s", "attitude, arcsec", "share of");
  fmt::print("{:<31}", "");
  for (int triple = 0; triple < 3; ++triple) fmt::print("  {:>9} {:>9} {:>9}", "east", "north", "up");
  fmt::print("  {:>8}\n", "position");
  const std::vector<double> shares = horizontal_shares(b);
  std::vector<std::size_t> order(b.groups.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t x, std::size_t y) { return shares[x] > shares[y]; });
  for (const std::size_t k : order) {
    const Contribution& c = b.groups[k];
    const bool drawn = !c.sigma.col(end).isZero(0), fixed = !c.fixed.col(end).isZero(0);
    std::string share = fmt::format("  {:>6.1f} %", std::round(1000 * shares[k]) / 10 + 0.0);
    if (fixed || !drawn) fmt::print("{:<24} fixed {}{}\n", c.name, row_text(c.fixed.col(end)), std::exchange(share, ""));
    if (drawn) fmt::print("{:<24} sigma {}{}\n", fixed ? "" : c.name, row_text(c.sigma.col(end)), share);
  }
  if (std::abs(shares.back()) > 5e-4) fmt::print("{:<124}  {:>6.1f} %\n", "correlation between groups", 100 * shares.back());
  const Eigen::VectorXd sigma = b.covariance.back().diagonal().cwiseMax(0.0).cwiseSqrt();
  fmt::print("{:<24} fixed {}\n{:<24} sigma {}\n", "all together", row_text(b.mean.col(end)), "", row_text(sigma));
  if (!monte_carlo) return;
  const ErrorDistribution& d = *monte_carlo;
  fmt::print("{:<24} mean  {}\n{:<24} sigma {}\n", fmt::format("Monte Carlo, {} runs", d.drift.size()), row_text(d.mean.col(end)), "",
             row_text(d.sigma.col(end)));
  fmt::print("{:<24} 5 %   {}\n{:<24} 50 %  {}\n{:<24} 95 %  {}\n", "", row_text(d.low.col(end)), "", row_text(d.median.col(end)), "",
             row_text(d.high.col(end)));
  fmt::print("\nhorizontal position: median {:.4g} m, 5..95 % {:.4g}..{:.4g} m; pure-inertial rate {:.3g} nmi/h RMS, CEP {:.3g} nmi/h, 95 % {:.3g} nmi/h\n",
             d.median(budget_quantities, end), d.low(budget_quantities, end), d.high(budget_quantities, end), d.drift_rms / nmi_per_h,
             d.drift_cep / nmi_per_h, d.drift_95 / nmi_per_h);
}

/// Above a tenth of a radian products of errors are some per cent of the errors.
void warn_of_large_angles(const ErrorBudget& b) {
  constexpr double largest = 0.1;
  for (std::size_t i = 0; i < b.time.size(); ++i)
    for (Eigen::Index q = 6; q < budget_quantities; ++q)
      if (std::hypot(b.mean(q, static_cast<Eigen::Index>(i)), std::sqrt(b.covariance[i](q, q))) > largest)
        return warn(fmt::format("from {:g} s on an attitude error is more than {:g} rad: the linear figures are rough, the Monte Carlo's are not", b.time[i], largest));
}

/// The mission's errors, or what the command line names in their place.
ErrorSpecification specification_of(const Options& o, const MissionFile& file) {
  if (!o.grade && !o.system && !o.calibration) {
    if (!file.errors) throw Error(o.mission + ": [errors] is missing, expected it, or --grade, --system or --calibration");
    return *file.errors;
  }
  ErrorSpecification s;
  if (file.errors) s.start = file.errors->start, s.barometer = file.errors->barometer, s.vertical = file.errors->vertical;
  s.grade = o.grade;
  s.system = o.system;
  if (o.calibration) s.calibration = std::filesystem::absolute(*o.calibration).string();
  if (o.calibration && file.errors)  // a calibration knows neither the noise nor the turn-on bias
    for (auto [to, from] : {std::pair{&s.gyro, &file.errors->gyro}, {&s.accel, &file.errors->accel}})
      to->N = from->N, to->B = from->B, to->K = from->K, to->Q = from->Q, to->R = from->R, to->turn_on = from->turn_on;
  return s;
}

void run(const Options& o) {
  if (o.catalogue) return print_catalogue();
  if (o.mission.empty()) throw Error("mission: expected the file of a mission, or --catalogue");
  if (!(o.every > 0)) throw Error("--every: expected a positive number of seconds");
  const MissionFile file = read_mission(o.mission);
  const ErrorSpecification specification = specification_of(o, file);
  const ErrorSources sources = read_error_sources(specification, o.mission);
  const NominalMotion motion = nominal_motion(trajectory_of(file.mission), 1 / file.mission.rate);
  StrapdownOptions strapdown;
  strapdown.vertical = specification.vertical;
  std::optional<NewFolder> folder;
  if (!o.folder.empty()) folder.emplace(o.folder);
  const ErrorBudget budget = error_budget(motion, sources, {.strapdown = strapdown, .output_interval = o.every});
  std::optional<ErrorDistribution> sampled;
  if (o.runs > 0) {
    Progress progress("Monte Carlo", o.runs);
    sampled = error_monte_carlo(motion, sources, {.strapdown = strapdown, .output_interval = o.every, .runs = o.runs, .seed = o.seed},
                                [&](std::uint64_t done) { progress.report(done); });
  }
  if (folder) {
    write_whole(folder->path() / "total.csv", total_csv(budget));
    write_whole(folder->path() / "sources.csv", sources_csv(budget));
    if (sampled) {
      write_whole(folder->path() / "monte_carlo.csv", distribution_csv(*sampled));
      write_whole(folder->path() / "runs.csv", runs_csv(*sampled));
    }
    folder->finish();
  }
  warn_of_large_angles(budget);
  if (o.json)
    fmt::print("{}", budget_json(budget, sampled));
  else
    print_budget(budget, sampled);
}

}  // namespace

void add_budget(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  CLI::App* const verb = app.add_subcommand("budget", "What the errors of sensors, start and barometer do to position, velocity and attitude, by source");
  verb->add_option("mission", o->mission, "the mission file: a motion, and its [errors]");
  auto* const grade = verb->add_option("--grade", o->grade, "a grade's sensors in place of the mission's");
  auto* const system = verb->add_option("--system", o->system, "an airliner's system's sensors in their place");
  auto* const calibration = verb->add_option("--calibration", o->calibration, "what a calibration leaves, in their place; noise stays the mission's");
  grade->excludes(system)->excludes(calibration);
  system->excludes(calibration);
  verb->add_option("--runs", o->runs, "Monte Carlo runs; 0: none")->capture_default_str()->check(CLI::Range(0., 1e7));
  verb->add_option("--seed", o->seed, "the same seed, the same bits")->capture_default_str();
  verb->add_option("--every", o->every, "seconds between rows of the files")->capture_default_str();
  verb->add_option("-o,--output", o->folder, "the folder to make: total.csv, sources.csv, monte_carlo.csv over time, runs.csv");
  verb->add_flag("--catalogue", o->catalogue, "list the grades and systems there are");
  verb->add_flag("--json", o->json, "the end, for machines");
  verb->callback([o] { run(*o); });
}

}  // namespace imulab::command
