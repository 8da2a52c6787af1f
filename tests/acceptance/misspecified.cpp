// Every method with its defaults on units and data that are not ideal (docs/evidence/accuracy.md): all terms of the model, correlated noise, a
// delay between the triads, late stamps, a bumped rest. What is stated has to hold all the same.
#include "imulab/coefficient.hpp"
#include "imulab/core/decomposition.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/model/sensor_noise.hpp"
#include "imulab/simulate.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/acceptance/shared_runs.hpp"
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

namespace imulab::acceptance {

namespace {

using Eigen::Index;

/// The optional terms by their prior, times a factor between 0.37 and 1.83, so that sizes spread about what the data can show. Its mean square is 1:
/// the terms are as large as the prior says. All terms of a session have the same one; by the golden ratio it is spread evenly over any seeds in a
/// row, as drawn ones would scatter the mean square of all errors more than chi-square does.
void add_optional_terms(SensorModel& model, const ImuDeclaration& imu, std::uint64_t seed, const RandomStream& random) {
  const kernel::PriorSizes sizes =
      kernel::optional_priors(kernel::of_likeliest_grade(imu, {.accel_offset = model.accel.offset.norm() / std::sqrt(3.0)}));
  const double turns = std::numbers::phi * static_cast<double>(seed), factor = 0.366 * std::pow(5.0, turns - std::floor(turns));
  for (const CoefficientIndex index : coefficient_indices()) {
    const Coefficient& c = coefficient(index);
    if (c.term == Term::offset || c.term == Term::matrix || c.term == Term::thermal || coefficient_value(model, index) != 0) continue;
    const TriadModel& triad = c.triad == Triad::accel ? model.accel : model.gyro;
    set_coefficient(model, index,
                    factor * kernel::prior_sigma(sizes, c, triad.matrix.row(c.row).norm()) * random.normal(static_cast<std::uint64_t>(index)));
  }
}

/// The accelerometers a part of a sample late, each reading a mixture with the one before.
void delay_accelerometers(Recording& r, double part) {
  for (auto& column : r.accel)
    for (std::size_t i = column.size(); i-- > 1;) column[i] += part * (column[i - 1] - column[i]);
}

/// Stamps that a buffer makes late, by up to a fifth of an interval.
void make_stamps_late(Recording& r, const RandomStream& random) {
  for (std::size_t i = 0; i < r.size(); ++i) r.time_ns[i] += std::llround(0.2e9 * r.interval_s * random.uniform(i));
}

/// Somebody touches the table: a fifth of a second in the middle of a rest, ten times the noise of a sample.
void bump(Recording& r, const Step& rest, const Truth& truth, const RandomStream& random) {
  const double middle = 0.5 * (rest.start + rest.end), rate = 1 / std::sqrt(r.interval_s);
  const Range range = r.samples_in(middle, middle + 0.2);
  for (std::size_t k = 0; k < 3; ++k) {
    const double accel = 10 * truth.accel_noise.N * rate * random.normal(k) / truth.model.accel.matrix(static_cast<Index>(k), static_cast<Index>(k));
    const double gyro = 10 * truth.gyro_noise.N * rate * random.normal(3 + k) / truth.model.gyro.matrix(static_cast<Index>(k), static_cast<Index>(k));
    for (std::size_t i = range.begin; i < range.end; ++i) {
      const double shape = std::sin(std::numbers::pi * static_cast<double>(i - range.begin + 1) / static_cast<double>(range.size() + 1));
      r.accel[k][i] += accel * shape;
      r.gyro[k][i] += gyro * shape;
    }
  }
}

/// The model with the offsets that this recording has: their mean over it.
SensorModel with_recorded_offsets(const Truth& truth, const Recording& r, std::uint64_t seed) {
  SensorModel model = truth.model;
  for (const Triad triad : {Triad::accel, Triad::gyro})
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> slow(r.size(), 0.0);
      const std::string purpose = fmt::format("{}.{} noise of {}", to_string(triad), "xyz"[axis], r.name);
      AxisNoise(triad == Triad::accel ? truth.accel_noise : truth.gyro_noise, r.interval_s, seed, purpose).add_slow(slow);
      const double mean = std::accumulate(slow.begin(), slow.end(), 0.0) / static_cast<double>(slow.size());
      (triad == Triad::accel ? model.accel : model.gyro).offset[axis] -= mean;
    }
  return model;
}

struct MisspecifiedRun {
  bool determined = false, good = false;
  std::vector<CoefficientIndex> indices;
  Eigen::VectorXd error;
  Eigen::MatrixXd covariance;
  std::string refused = {};  ///< why
  void fields(auto&& visit) { visit(determined, good, indices, error, covariance, refused); }
};

MisspecifiedRun run(const Method& method, std::uint64_t seed) {
  Session session = method.example({.by_hand = {.poses = 30}, .on_table = {.rest = 30, .rate_hz = 50}, .on_machines = {.record = 2}, .seed = seed});
  session.imu.noise = NoiseTerms::full;
  const RandomStream random(seed, "misspecified");
  Truth truth = draw_truth(session, seed);
  add_optional_terms(truth.model, session.imu, seed, random);
  truth.accel_noise.turn_on = truth.gyro_noise.turn_on = {};  // part of this recording's offsets, not of the truth
  std::vector<Recording> recordings;
  for (std::size_t k = 0; k < session.recordings.size(); ++k) {
    const RecordingSource& source = session.recordings[k];
    Recording r = simulate_recording(session, source, truth, seed, draw_rig_errors(session, source, seed));
    const std::vector<Step> steps = session.steps_of(source);
    const Step& bumped = steps[static_cast<std::size_t>(random.uniform(2000 + k) * static_cast<double>(steps.size()))];
    if (!method.takes_several) {
      delay_accelerometers(r, 0.2 * random.uniform(3000));
      make_stamps_late(r, RandomStream(seed, "late stamps"));
      if (bumped.kind == StepKind::hold) bump(r, bumped, truth, RandomStream(seed, "bump"));
    }
    recordings.push_back(std::move(r));
  }
  if (method.support) session.steps.clear();  // it finds the rests in the recording
  const Calibration c = calibrate(method, {session, recordings}).calibration;
  const SensorModel exact = method.takes_several ? truth.model : with_recorded_offsets(truth, recordings.front(), seed);
  MisspecifiedRun out{true, c.quality.verdict == Verdict::good, c.estimated, Eigen::VectorXd(c.estimated.size()), c.covariance};
  for (std::size_t i = 0; i < c.estimated.size(); ++i)
    out.error[static_cast<Index>(i)] = coefficient_value(c.model, c.estimated[i]) - coefficient_value(exact, c.estimated[i]);
  return out;
}

/// Statistics of the runs with one verdict.
std::vector<Check> judge_runs(const std::vector<MisspecifiedRun>& runs, bool good) {
  const std::string which = good ? "good: " : "doubtful: ";
  double inside = 0, all = 0, chi2 = 0, count = 0, sessions = 0;
  std::map<std::string, std::array<double, 2>> groups;
  for (const MisspecifiedRun& r : runs) {
    if (!r.determined || r.good != good || r.indices.empty()) continue;
    ++sessions;
    chi2 += squared_norm_in(r.covariance, r.error);
    count += static_cast<double>(r.error.size());
    for (Index i = 0; i < r.error.size(); ++i) {
      const Coefficient& c = coefficient(r.indices[static_cast<std::size_t>(i)]);
      const bool within = std::abs(r.error[i]) <= 1.959963985 * std::sqrt(r.covariance(i, i));
      auto& group = groups[std::string(to_string(c.triad)) + "." + std::string(to_string(c.term))];
      group[0] += within, group[1] += 1;
      inside += within, all += 1;
    }
  }
  const double total = static_cast<double>(runs.size());
  std::vector<Check> checks{{which + "share of the sessions", sessions / total, 0, 1}};
  if (sessions < 20) return checks;  // too few to tell 93 % from 97 %
  checks.push_back({which + "coverage", inside / all, 0.93, 0.97});
  for (const auto& [name, counts] : groups) checks.push_back({which + "coverage " + name, counts[0] / counts[1], 0, 1});  // shown, not judged
  checks.push_back({which + "consistency", chi2 / count, chi_square_quantile(0.0005, count) / count, chi_square_quantile(0.9995, count) / count});
  return checks;
}

}  // namespace

std::vector<Check> misspecified(const Method& method, int count) {
  const auto runs = runs_of<MisspecifiedRun>(fmt::format("misspecified {}", method.name), count, [&](std::size_t i) {
    try {
      return run(method, i + 1);
    } catch (const std::exception& e) {
      MisspecifiedRun none;
      none.refused = e.what();
      return none;
    }
  });
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (!runs[i].refused.empty() && tells()) fmt::print("  {} seed {}: {}\n", method.name, i + 1, runs[i].refused);
  std::vector<Check> checks = judge_runs(runs, true);
  for (const Check& c : judge_runs(runs, false)) checks.push_back(c);
  return checks;
}

}  // namespace imulab::acceptance
