#include "imulab/inspection/evidence.hpp"

#include "imulab/estimate/method.hpp"
#include "imulab/inspection/names.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/clipping.hpp"
#include "imulab/recording/coverage.hpp"
#include "imulab/recording/resampling.hpp"
#include "imulab/recording/stuck_readings.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <stdexcept>

namespace imulab::inspection {

namespace {

/// The pair of triads that the data, or else the names, speak for.
class TriadSearch {
 public:
  TriadSearch(const SignalTable& table, const std::vector<std::int64_t>& time_ns, const std::vector<double>& scales)
      : table_(table), time_ns_(time_ns), scales_(scales) {}

  void consider(const SignalTriad& gyro, const SignalTriad& accel) {
    for (const std::size_t i : gyro)
      if (std::find(accel.begin(), accel.end(), i) != accel.end()) return;
    constexpr std::size_t samples = 200'000;  // enough to tell triads apart
    found_.push_back(evidence_for(table_, time_ns_, gyro, accel, scales_, samples));
  }
  std::size_t explained() const {
    return static_cast<std::size_t>(std::count_if(found_.begin(), found_.end(), [](const TriadEvidence& e) { return e.explained(); }));
  }

  /// Triads that would explain the turns, but for the accelerometers, which are a filter's.
  const TriadEvidence* filtered() const {
    const auto found = std::find_if(found_.begin(), found_.end(), [](const TriadEvidence& e) { return e.filtered && e.gyros_fit(); });
    return found == found_.end() ? nullptr : &*found;
  }
  /// "a.x, a.y, a.z or b.x, b.y, b.z": what explains the turns, of one sensor.
  std::string alternatives(SignalTriad TriadEvidence::*which) const {
    std::vector<std::string> names;
    for (const TriadEvidence& e : found_) {
      if (!e.explained()) continue;
      const SignalTriad& t = e.*which;
      std::string name = fmt::format("{}, {}, {}", column_name(table_, t[0]), column_name(table_, t[1]), column_name(table_, t[2]));
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(std::move(name));
    }
    return names.size() < 2 ? "" : fmt::format("{}", fmt::join(names, " or "));
  }

  /// The best of those considered that explains the turns: least unexplained, with the least spread of the norm. Of two for one triad of gyros, that
  /// whose norm changes in motion: a magnetometer's does not.
  std::optional<TriadEvidence> best() const {
    const TriadEvidence* best = nullptr;
    for (const TriadEvidence& e : found_) {
      if (!e.explained()) continue;
      if (best == nullptr || merit(e) < merit(*best)) best = &e;
    }
    if (best == nullptr) return std::nullopt;
    for (const TriadEvidence& e : found_)
      if (e.explained() && e.gyro == best->gyro && disjoint(e.accel, best->accel) && e.norm_in_motion > 2 * best->norm_in_motion &&
          merit(e) < merit(*best) + 0.1)
        best = &e;
    return *best;
  }

 private:
  static bool disjoint(const SignalTriad& a, const SignalTriad& b) {
    return std::none_of(a.begin(), a.end(), [&](std::size_t i) { return std::find(b.begin(), b.end(), i) != b.end(); });
  }
  static double merit(const TriadEvidence& e) { return e.error / e.turned + (e.norm_most - e.norm_least) / e.norm; }

  const SignalTable& table_;
  const std::vector<std::int64_t>& time_ns_;
  const std::vector<double>& scales_;
  std::vector<TriadEvidence> found_;
};

}  // namespace

bool has_role(const SignalTable& table, const SignalTriad& triad, Role role) {
  return std::all_of(triad.begin(), triad.end(), [&](std::size_t i) { return hint_in(table, i).role == role; });
}

namespace {

/// Those of a sensor whose axes are all named, where there is one: of its columns no other three are meant.
std::vector<SignalTriad> named_triads(const SignalTable& table, const std::vector<SignalTriad>& triads, Role role) {
  std::vector<SignalTriad> named, complete;
  for (const SignalTriad& triad : triads) {
    if (!has_role(table, triad, role)) continue;
    named.push_back(triad);
    const std::string sensor = hint_in(table, triad[0]).sensor;
    bool in_order = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const NameHint hint = hint_in(table, triad[axis]);
      in_order = in_order && hint.axis == static_cast<int>(axis) && hint.sensor == sensor;
    }
    if (in_order) complete.push_back(triad);
  }
  return complete.empty() ? named : complete;
}

/// Apps of phones give what a filter makes of the accelerometers' readings: gravity, and what is left without it.
bool is_gravity(const SignalTable& table, std::size_t column) { return hint_in(table, column).sensor.find("gravity") != std::string::npos; }
bool is_without_gravity(const SignalTable& table, std::size_t column) {
  const std::string sensor = hint_in(table, column).sensor;
  return sensor.find("linear") != std::string::npos || sensor.find("user") != std::string::npos;
}

/// The accelerometers alone: their rests are found by them.
TriadEvidence accel_alone(const SignalTable& table, const std::vector<std::int64_t>& time_ns, const SignalTriad& accel) {
  TriadEvidence evidence = evidence_for(table, time_ns, accel, accel, {}, time_ns.size());
  evidence.has_gyro = false;
  evidence.gyro_matrix.reset();
  evidence.turns = 0;
  return evidence;
}

TriadEvidence gyro_alone(const SignalTriad& gyro) {
  TriadEvidence evidence;
  evidence.gyro = gyro;
  evidence.has_accel = false;
  return evidence;
}

/// The only triad that there is, where there is but one: by its name, as declared, or by gravity at rest.
std::optional<TriadEvidence> triad_alone(const SignalTable& table, const std::vector<std::int64_t>& time_ns, const std::vector<SignalTriad>& triads,
                                         const std::vector<SignalTriad>& gyros, const std::vector<SignalTriad>& accels, Inspection& result) {
  if (triads.empty()) return std::nullopt;
  const SignalTriad& first = !gyros.empty() ? gyros.front() : !accels.empty() ? accels.front() : triads.front();
  for (const SignalTriad& other : triads)
    if (std::none_of(other.begin(), other.end(), [&](std::size_t i) { return std::find(first.begin(), first.end(), i) != first.end(); }))
      return std::nullopt;
  const auto is_named = [&](Role role) {  // a sensor whose readings cannot be used is no reason to take the other alone
    for (std::size_t i = 0; i < table.signals.size(); ++i)
      if (const NameHint hint = hint_in(table, i); hint.role == role && hint.axis >= 0) return true;
    return false;
  };
  if (is_named(Role::gyro) && is_named(Role::accel)) return std::nullopt;
  if (!accels.empty() && gyros.empty()) return accel_alone(table, time_ns, first);
  if (!gyros.empty()) return gyro_alone(first);
  TriadEvidence evidence = accel_alone(table, time_ns, first);
  const double interval_s = 1e-9 * static_cast<double>(time_ns.back() - time_ns.front()) / static_cast<double>(time_ns.size());
  constexpr std::size_t many = 6;  // rests, in different directions: what reads the same length in all of them is gravity
  const bool gravity = evidence.rests.size() >= many && evidence.norm_most - evidence.norm_least < 0.2 * evidence.norm &&
                       accel_unit(evidence.norm, evidence.norm_least, evidence.norm_most, interval_s, "", false).open.empty();
  if (!gravity)
    result.ambiguous.push_back(
        "accel.columns, gyro.columns: one triad, whose names and readings do not say of which sensor; declare one of the two keys (files "
        "of one recording are read together: inspect A B -o session.toml)");
  return evidence;
}

}  // namespace

const SignalTable& with_sums(const SignalTable& table, SignalTable& own) {
  const SignalTriad *gravity = nullptr, *motion = nullptr;
  bool any = false;
  for (std::size_t i = 0; i < table.signals.size(); ++i) any = any || is_gravity(table, i);
  if (!any) return table;
  const std::vector<SignalTriad> accels = named_triads(table, possible_triads(table, {}), Role::accel);
  for (const SignalTriad& triad : accels) {
    if (is_gravity(table, triad[0]))
      gravity = &triad;
    else if (is_without_gravity(table, triad[0]))
      motion = &triad;
    else
      return table;  // an accelerometer
  }
  if (gravity == nullptr || motion == nullptr) return table;
  std::vector<Signal> sums;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Signal &a = table.signals[(*gravity)[axis]], &b = table.signals[(*motion)[axis]];
    const std::string *const first = std::get_if<std::string>(&a.column), *const second = std::get_if<std::string>(&b.column);
    const bool alike = a.table == b.table && a.unit == b.unit && hint_in(table, (*gravity)[axis]).unit == hint_in(table, (*motion)[axis]).unit;
    if (!alike || first == nullptr || second == nullptr) return table;
    Signal sum = a;
    sum.name = a.name + std::string(sum_sign) + b.name;
    sum.column = *first + std::string(sum_sign) + *second;
    std::transform(a.values.begin(), a.values.end(), b.values.begin(), sum.values.begin(), std::plus<>());
    sums.push_back(std::move(sum));
  }
  if (&table != &own) own = table;
  own.signals.insert(own.signals.end(), sums.begin(), sums.end());
  return own;
}

std::optional<TriadEvidence> find_triads(const SignalTable& table, const std::vector<std::int64_t>& time_ns, const TimeGuess& time,
                                         const DeclaredColumns& declared, const std::vector<double>& scales, Inspection& result) {
  std::vector<std::size_t> taken;
  for (const auto& index : {time.column, time.fraction})
    if (index) taken.push_back(*index);
  std::vector<SignalTriad> triads = possible_triads(table, taken);
  for (const auto& triad : {declared.gyro, declared.accel})
    if (triad && std::find(triads.begin(), triads.end(), *triad) == triads.end()) triads.push_back(*triad);
  std::vector<SignalTriad> gyros = named_triads(table, triads, Role::gyro), accels = named_triads(table, triads, Role::accel);
  const auto by_a_filter = [&](const SignalTriad& triad) { return is_gravity(table, triad[0]) || is_without_gravity(table, triad[0]); };
  if (!std::all_of(accels.begin(), accels.end(), by_a_filter)) std::erase_if(accels, by_a_filter);
  if (declared.gyro) gyros = {*declared.gyro};
  if (declared.accel) accels = {*declared.accel};
  const std::size_t all = time_ns.size();
  if (const auto alone = triad_alone(table, time_ns, triads, gyros, accels, result)) return alone;
  TriadSearch named(table, time_ns, scales);
  for (const SignalTriad& g : gyros)
    for (const SignalTriad& a : accels) named.consider(g, a);
  if (named.explained() > 1) {
    const std::string of_gyro = named.alternatives(&TriadEvidence::gyro), of_accel = named.alternatives(&TriadEvidence::accel);
    result.ambiguous.push_back(fmt::format("{}{}{}: {} pairs of triads fit each other: {}{}{}; name the columns to use",
                                           of_gyro.empty() ? "" : "gyro.columns", of_gyro.empty() || of_accel.empty() ? "" : ", ",
                                           of_accel.empty() ? "" : "accel.columns", named.explained(), of_gyro,
                                           of_gyro.empty() || of_accel.empty() ? "" : "; ", of_accel));
  }
  const auto ask_for_sum = [&](const TriadEvidence& filtered) {
    const SignalTriad& t = filtered.accel;
    result.ambiguous.push_back(fmt::format(
        "accel.columns: {}, {}, {} have the same norm, {:.6g}, at rest and in motion: a filter's estimate of gravity, which has no error to "
        "calibrate; name the columns of the accelerometers, or add it to the acceleration without gravity that is beside it, row by row in one "
        "unit, in a file with these sums",
        column_name(table, t[0]), column_name(table, t[1]), column_name(table, t[2]), filtered.norm));
    return std::nullopt;
  };
  if (const auto best = named.best()) return evidence_for(table, time_ns, best->gyro, best->accel, scales, all);
  if (!(declared.gyro && declared.accel)) {
    TriadSearch search(table, time_ns, scales);
    for (const SignalTriad& g : triads)
      for (const SignalTriad& a : triads)
        if ((!declared.gyro || g == *declared.gyro) && (!declared.accel || a == *declared.accel)) search.consider(g, a);
    if (const auto best = search.best()) return evidence_for(table, time_ns, best->gyro, best->accel, scales, all);
    if (const TriadEvidence* filtered = search.filtered()) return ask_for_sum(*filtered);
  }
  if (const TriadEvidence* filtered = named.filtered()) return ask_for_sum(*filtered);
  if (declared.gyro && accels.empty()) return gyro_alone(*declared.gyro);
  if (declared.accel && gyros.empty()) return accel_alone(table, time_ns, *declared.accel);
  if (gyros.empty() || accels.empty()) return std::nullopt;
  if (gyros.size() > 1 || accels.size() > 1)
    result.ambiguous.push_back(fmt::format(
        "gyro.columns, accel.columns: {} triads are named gyros and {} accelerometers, and no turns between rests distinguish them; name the columns",
        gyros.size(), accels.size()));
  return evidence_for(table, time_ns, gyros.front(), accels.front(), scales, all);
}

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
      result.evidence.push_back(fmt::format("resolution: accelerometers {:.4g}, {:.2g} of gravity: coarse", step, least_of_gravity));
  }
  if (!clipped.empty()) result.evidence.push_back("saturated: " + clipped);
  if (!stuck.empty()) result.evidence.push_back(stuck + ": the sensor or its driver hangs");
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
  } catch (const std::runtime_error&) {
    return false;
  }
}

}  // namespace

void add_support(const SignalTable& table, const std::vector<std::int64_t>& time_ns, const TriadEvidence& triads, Inspection& result) {
  add_readings(table, triads, result);
  const std::size_t rests = triads.rests.size();
  if (!triads.up.empty())
    result.evidence.push_back(
        fmt::format("up at the first rest: about {} (if it was the other side: --set accel.axes=-x,-y,-z)", axis_text(triads.up.front())));
  const std::vector<double> parts = leverages(triads.up);
  const double determined = std::accumulate(parts.begin(), parts.end(), 0.0);
  result.evidence.push_back(fmt::format("rests: {} found{}, {} between them{}", rests,
                                        rests > 0 ? fmt::format(", whose directions determine {:.0f} of 9 accelerometer parameters", determined) : "",
                                        counted(triads.turns, "turn"),
                                        triads.turning > 0 ? fmt::format("; {} quiet parts are steady turns", triads.turning) : ""));
  const RestEvidence evidence{rests, triads.turns, determined, triads.explained()};
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
  result.evidence.push_back(text);
}

}  // namespace imulab::inspection
