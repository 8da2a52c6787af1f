#include "imulab/inspection/support.hpp"

#include "imulab/core/units.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/recording/clipping.hpp"
#include "imulab/recording/coverage.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace imulab::inspection {
namespace {

/// The smallest step between different readings.
double resolution(const std::vector<double>& values) {
  double least = 0;
  const std::size_t n = std::min<std::size_t>(values.size(), 100'000);
  for (std::size_t i = 1; i < n; ++i)
    if (const double step = std::abs(values[i] - values[i - 1]); step > 0 && (least == 0 || step < least)) least = step;
  return least;
}

/// The part of the rows in which all six readings are those of the row before.
double repeated_part(const SignalTable& table, const TriadEvidence& triads) {
  std::size_t same = 0;
  for (std::size_t i = 1; i < table.rows(); ++i) {
    bool equal = true;
    for (const SignalTriad* triad : {&triads.gyro, &triads.accel})
      for (const std::size_t c : *triad) equal = equal && table.signals[c].values[i] == table.signals[c].values[i - 1];
    same += equal;
  }
  return static_cast<double>(same) / static_cast<double>(table.rows());
}

void add_readings(const SignalTable& table, const TriadEvidence& triads, Inspection& result) {
  std::string clipped;
  for (const auto& [triad, name] : {std::pair{&triads.accel, "accel"}, {&triads.gyro, "gyro"}}) {
    double step = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Signal& signal = table.signals[(*triad)[axis]];
      step = std::max(step, resolution(signal.values));
      if (const auto samples = clipped_samples(signal.values); !samples.empty())
        clipped += fmt::format("{}{}.{} at {:.6g} in {} samples", clipped.empty() ? "" : ", ", name, "xyz"[axis], signal.values[samples.front()],
                               samples.size());
    }
    const double least_of_gravity = triads.norm > 0 ? step / triads.norm : 0;
    if (triad == &triads.accel && least_of_gravity > 1e-3)
      result.evidence.push_back(fmt::format("resolution: accelerometers {:.4g}, {:.2g} of gravity: coarse", step, least_of_gravity));
  }
  if (!clipped.empty()) result.evidence.push_back("saturated: " + clipped);
  if (const double part = repeated_part(table, triads); part > 0.2)
    result.evidence.push_back(
        fmt::format("{:.0f} % of the rows repeat all readings of the row before: the sensor is slower than the log", 100 * part));
}

std::string counted(std::size_t n, const std::string& what) { return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s"); }

std::string axis_text(const Vector3d& up) {
  Eigen::Index axis = 0;
  up.cwiseAbs().maxCoeff(&axis);
  return fmt::format("{}{}", up[axis] > 0 ? '+' : '-', "xyz"[axis]);
}

}  // namespace

void add_support(const SignalTable& table, const TriadEvidence& triads, Inspection& result) {
  add_readings(table, triads, result);
  const std::size_t rests = triads.rests.size();
  if (!triads.up.empty())
    result.evidence.push_back(fmt::format("up at the first rest: about {} (if it was the other side, the accelerometers' signs are reversed)",
                                          axis_text(triads.up.front())));
  const std::vector<double> parts = leverages(triads.up);
  const double determined = std::accumulate(parts.begin(), parts.end(), 0.0);
  result.evidence.push_back(fmt::format("rests: {} found{}, {} between them{}", rests,
                                        rests > 0 ? fmt::format(", whose directions determine {:.0f} of 9 accelerometer parameters", determined) : "",
                                        counted(triads.turns, "turn"),
                                        triads.turning > 0 ? fmt::format("; {} quiet parts are steady turns", triads.turning) : ""));
  const RestEvidence evidence{rests, triads.turns, determined, triads.explained()};
  for (const Method& method : methods_by_equipment()) {
    const MethodSupport support = method.support ? method.support(evidence) : MethodSupport{false, fmt::format("needs {}", method.needs)};
    result.methods.push_back({std::string(method.name), support.supported, support.why});
  }
}

void add_clock(const ClockQuality& clock, Inspection& result) {
  result.jitter_s = clock.scatter_s;
  result.gaps = clock.gaps;
  if (clock.interval_s == 0) return;
  std::string text = fmt::format("clock: {:.6g} Hz", clock.rate_hz);
  if (clock.scatter_s > 0) text += fmt::format(", stamps scatter by {:.2g} ms", 1e3 * clock.scatter_s);
  text += clock.gaps == 0 ? ", no gap" : fmt::format(", {} gap{}, the longest {:.4g} s", clock.gaps, clock.gaps == 1 ? "" : "s", clock.largest_gap_s);
  if (clock.repeated > 0) text += fmt::format(", {} stamps repeated", clock.repeated);
  result.evidence.push_back(text);
}

}  // namespace imulab::inspection
