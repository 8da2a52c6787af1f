// The evidence of an inspection: what the readings are worth, and what the data can support.
#include "imulab/estimate/method.hpp"
#include "imulab/inspection/evidence.hpp"
#include "imulab/inspection/purpose.hpp"
#include "imulab/model/finding_table.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/clipping.hpp"
#include "imulab/recording/coverage.hpp"
#include "imulab/recording/resampling.hpp"
#include "imulab/recording/stuck_readings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

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

std::vector<const SignalTriad*> triads_there(const TriadEvidence& triads) {
  std::vector<const SignalTriad*> there;
  if (triads.has_gyro) there.push_back(&triads.gyro);
  if (triads.has_accel) there.push_back(&triads.accel);
  return there;
}

/// The part of the rows in which all readings are those of the row before.
double repeated_part(const SignalTable& table, const TriadEvidence& triads) {
  std::size_t same = 0;
  for (std::size_t i = 1; i < table.rows(); ++i) {
    bool equal = true;
    for (const SignalTriad* triad : triads_there(triads))
      for (const std::size_t c : *triad) equal = equal && table.signals[c].values[i] == table.signals[c].values[i - 1];
    same += equal;
  }
  return static_cast<double>(same) / static_cast<double>(table.rows());
}

void add_readings(const SignalTable& table, const TriadEvidence& triads, Inspection& result) {
  std::string clipped, stuck;
  for (const SignalTriad* triad : triads_there(triads)) {
    const char* const name = triad == &triads.gyro ? "gyro" : "accel";
    double step = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Signal& signal = table.signals[(*triad)[axis]];
      step = std::max(step, resolution(signal.values));
      if (const std::vector<Range> stretches = stuck_stretches(signal.values); !stretches.empty())
        stuck += fmt::format("{}{}.{} {}", stuck.empty() ? "" : ", ", name, "xyz"[axis], said_of_stuck(stretches));
      if (const auto samples = clipped_samples(signal.values); !samples.empty())
        clipped += fmt::format("{}{}.{} at {:.6g} in {} samples", clipped.empty() ? "" : ", ", name, "xyz"[axis], signal.values[samples.front()],
                               samples.size());
    }
    const double least_of_gravity = triads.norm > 0 ? step / triads.norm : 0;
    if (triad == &triads.accel && least_of_gravity > 1e-3)
      result.note(fmt::format("resolution: accelerometers {:.4g}, {:.2g} of gravity: coarse", step, least_of_gravity));
  }
  if (!clipped.empty()) result.note("saturated: " + clipped);
  if (!stuck.empty()) result.note(stuck + ": the sensor or its driver hangs");
  if (const double part = repeated_part(table, triads); part > 0.2)
    result.note(fmt::format("{:.0f} % of the rows repeat all readings of the row before: the sensor is slower than the log", 100 * part));
}

std::string counted(std::size_t n, const std::string& what) { return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s"); }

std::string axis_text(const Vector3d& up) {
  Eigen::Index axis = 0;
  up.cwiseAbs().maxCoeff(&axis);
  return fmt::format("{}{}", up[axis] > 0 ? '+' : '-', "xyz"[axis]);
}

/// The readings in SI, as gravity at rest and the turns show their scales; accelerometers whose zero is far off stay counts.
Recording in_si(const SignalTable& table, const std::vector<std::int64_t>& time_ns, const TriadEvidence& triads) {
  constexpr std::size_t most = 1'000'000;
  const std::size_t n = std::min(time_ns.size(), most);
  const auto scaled = [&](const SignalTriad& triad, double scale) {
    Columns3 out;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t i = 0; i < n; ++i) out[axis].push_back(scale * table.signals[triad[axis]].values[i]);
    return out;
  };
  RecordingOptions options{.name = table.file};
  if (triads.offset_taken_out) options.accel.unit = "count";
  const double of_accel = triads.offset_taken_out ? 1 : gravity_anywhere / triads.norm;
  Nanoseconds stamps{{time_ns.begin(), time_ns.begin() + static_cast<std::ptrdiff_t>(n)}};
  return with_short_gaps_filled(make_recording(std::move(stamps), scaled(triads.gyro, triads.gyro_scale()), scaled(triads.accel, of_accel), options))
      .recording;
}

/// Whether a calibration of these readings leaves no coefficient open: few rests that a rule on their number would refuse.
bool determined_by(const Method& method, const SignalTable& table, const std::vector<std::int64_t>& time_ns, const TriadEvidence& triads) {
  Session session;
  session.site.given_gravity = gravity_anywhere, session.site.given_gravity_sigma = gravity_anywhere_sigma;
  try {
    const Recording recording = in_si(table, time_ns, triads);
    std::vector<Range> rests;  // short gaps are filled
    const auto place = [&](std::size_t row) { return std::ranges::lower_bound(recording.time_ns, time_ns[row]) - recording.time_ns.begin(); };
    for (const Range& rest : triads.rests)
      rests.push_back({static_cast<std::size_t>(place(rest.begin)), static_cast<std::size_t>(place(rest.end - 1)) + 1});
    const Quality quality = calibrate(method, {session, {&recording, 1}, rests}).calibration.quality;
    return quality.converged && quality.unobservable.empty();
  } catch (const Error&) {
    return false;
  } catch (const Unsupported&) {
    return false;
  }
}

}  // namespace

void add_support(const SignalTable& table, const std::vector<std::int64_t>& time_ns, const TriadEvidence& triads, Inspection& result) {
  add_readings(table, triads, result);
  const std::size_t rests = triads.rests.size();
  if (!triads.up.empty()) result.findings.add<Code::up_at_first_rest>(axis_text(triads.up.front()));
  const std::vector<double> parts = leverages(triads.up);
  const double determined = std::accumulate(parts.begin(), parts.end(), 0.0);
  result.findings.add<Code::rests_found>(
      rests, rests > 0 ? fmt::format(", whose directions determine {:.0f} of 9 accelerometer parameters", determined) : "",
      counted(triads.turns, "turn"), triads.turning > 0 ? fmt::format("; {} quiet parts are steady turns", triads.turning) : "");
  const RestEvidence evidence{rests, triads.turns, determined, triads.explained(), sweeps_in_one_attitude(table, triads, result)};
  constexpr std::size_t few = 5;  // with four turns between them not even the accelerometers are determined
  for (const Method& method : methods_by_equipment()) {
    MethodSupport support = method.support ? method.support(evidence) : MethodSupport{false, fmt::format("needs {}", method.needs)};
    const bool by_turns = method.support && !method.takes_accel_alone && triads.explained() && rests >= few;
    if (!support.supported && by_turns && determined_by(method, table, time_ns, triads))
      support = {true, fmt::format("{}, {}, which determine all together", counted(rests, "rest"), counted(triads.turns, "turn"))};
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
  result.note(text);
}

}  // namespace imulab::inspection
