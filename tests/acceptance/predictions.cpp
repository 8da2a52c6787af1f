// Do predictions agree with what calibrate states of simulated sessions, and with the scatter of its estimates?
#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/grade.hpp"
#include "imulab/model/relative_uncertainty.hpp"

#include <fmt/core.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/acceptance/shared_runs.hpp"
#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::acceptance {

namespace {

/// A short procedure for a method, with the unit's noise declared.
Session predicted_case(const Method& method) {
  ExampleSize size{.by_hand = {.poses = 25, .first_rest = 10}, .on_table = {.rest = 30, .rate_hz = 50}};
  if (method.equipment == 0) size.by_hand.grade = "navigation";  // rests alone need gyros that resolve Earth's rate
  Session s = method.example(size);
  if (method.equipment >= 2) return s;
  s.imu.accel_noise_density = grade(size.by_hand.grade).accel_noise.N, s.imu.gyro_noise_density = grade(size.by_hand.grade).gyro_noise.N;
  return s;
}

/// A unit whose terms are all as uncertain as the priors say, in a place whose gravity is.
Truth drawn_truth(const Session& of, std::uint64_t seed) {
  Truth truth = draw_truth(of, seed);
  const Grade& by = grade(*of.imu.grade);
  if (by.ranges) return truth;
  const TermSizes& sizes = by.terms;
  const RandomStream draws(seed, "terms of a prediction's test");
  for (std::uint64_t k = 0; k < 9; ++k)
    truth.model.g_sensitivity(static_cast<int>(k / 3), static_cast<int>(k % 3)) = sizes.g_sensitivity * draws.normal(12 + k);
  constexpr double lever_arm = 0.05;  // m: the prior where none is declared; on a table every turn shows it
  if (!of.rigs.empty() && of.rigs.front().kind == RigKind::turntable)
    for (std::uint64_t k = 0; k < 9; ++k) truth.model.lever_arm(static_cast<int>(k / 3), static_cast<int>(k % 3)) = lever_arm * draws.normal(21 + k);
  for (std::uint64_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    truth.model.accel.quadratic[i] = sizes.accel_quadratic * draws.normal(4 * axis);
    truth.model.accel.cubic[i] = sizes.accel_cubic * draws.normal(4 * axis + 1);
    truth.model.gyro.quadratic[i] = sizes.gyro_quadratic * draws.normal(4 * axis + 2);
    truth.model.gyro.cubic[i] = sizes.gyro_cubic * draws.normal(4 * axis + 3);
  }
  return truth;
}

/// Stated over predicted uncertainties, and the squares of the errors in predicted sigmas, by coefficient.
struct Outcome {
  std::vector<double> stated, squares;
  bool widened = false;  ///< chance made a term larger than its prior by so much that calibrate widened it: what it states is then larger, too
  void fields(auto&& visit) { visit(stated, squares, widened); }
};

Outcome session_of(const Method& method, const Session& of, const Prediction& p, std::uint64_t seed) {
  const Truth truth = drawn_truth(of, seed);
  std::vector<Recording> recordings;
  for (const RecordingSource& source : of.recordings)
    recordings.push_back(simulate_recording(of, source, truth, seed, draw_rig_errors(of, source, seed)));
  CalibrationOptions options;
  options.whole_unit.full = true;
  options.effects = false;
  const Calibration c = calibrate(method, {of, recordings}, options).calibration;
  Outcome out;
  for (const std::string& warning : c.quality.findings.warnings())
    out.widened = out.widened || warning.find("is larger than expected of this IMU") != std::string::npos;
  for (std::size_t i = 0; i < p.coefficients.size(); ++i) {
    const CoefficientIndex index = p.coefficients[i];
    const double sigma = p.sigma[static_cast<Eigen::Index>(i)];
    out.stated.push_back(relative_uncertainty(c, index) / sigma);  // of raw readings they differ by the drawn unit's scales
    out.squares.push_back(std::pow((coefficient_value(c.model, index) - coefficient_value(truth.model, index)) / sigma, 2));
  }
  return out;
}

}  // namespace

std::vector<Check> predictions(const Method& method, int sessions) {
  const Session of = predicted_case(method);
  const Prediction p = predict(method, of, {.effects = false});  // none are drawn
  auto all = runs_of<Outcome>(fmt::format("predictions {}", method.name), sessions, [&](std::size_t i) { return session_of(method, of, p, i + 1); });
  const auto widened = static_cast<double>(std::ranges::count_if(all, &Outcome::widened));
  std::erase_if(all, [](const Outcome& s) { return s.widened; });
  const double n = static_cast<double>(all.size()), m = static_cast<double>(p.coefficients.size());
  std::vector<double> stated, squares(p.coefficients.size(), 0.0);
  for (const Outcome& s : all) {
    stated.insert(stated.end(), s.stated.begin(), s.stated.end());
    for (std::size_t i = 0; i < squares.size(); ++i) squares[i] += s.squares[i] / n;
  }
  const auto name = [&](auto at) { return std::string(coefficient(p.coefficients[static_cast<std::size_t>(at - squares.begin())]).name); };
  // Lever arms show in the ramps of turns, of ten samples each; what integration misses there adds to the noise, and is not in their uncertainty.
  double of_arms = 1;
  for (std::size_t i = 0; i < squares.size(); ++i)
    if (coefficient(p.coefficients[i]).term == Term::lever_arm) of_arms = std::max(of_arms, std::exchange(squares[i], 1));
  const auto least = std::min_element(squares.begin(), squares.end()), most = std::max_element(squares.begin(), squares.end());
  // The drawn unit's scales are off by 1 %, and where a coefficient rests on few rests its uncertainty changes by several times that; noise is
  // measured; a spread beyond it is found by chance in a session in six, and only enlarges. The sums of squares are chi-square distributed: outside
  // once in a thousand runs of all coefficients together.
  // A prior is widened by chance once in a thousand, and there are seven terms.
  return {{"sessions with a widened prior", widened, 0, std::max(2.0, 0.03 * sessions)},
          {"stated over predicted, median", median(stated), 0.99, 1.01},
          {"stated over predicted, least", *std::min_element(stated.begin(), stated.end()), 0.8, 1.05},
          {"least scatter " + name(least), std::sqrt(*least), std::sqrt(chi_square_quantile(0.0005 / m, n) / n), 1},
          {"largest scatter of lever arms", std::sqrt(of_arms), 1, 1.25 * std::sqrt(chi_square_quantile(1 - 0.0005 / m, n) / n)},
          {"largest scatter " + name(most), std::sqrt(*most), 1, std::sqrt(chi_square_quantile(1 - 0.0005 / m, n) / n)}};
}

}  // namespace imulab::acceptance
