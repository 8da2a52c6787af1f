#include "imulab/inspection/evidence.hpp"

#include "imulab/inspection/names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

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

/// True if the names of the columns are x, y and z of one sensor.
bool of_axes(const SignalTable& table, const SignalTriad& triad) {
  const std::string sensor = hint_in(table, triad[0]).sensor;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (const NameHint hint = hint_in(table, triad[axis]); hint.axis != static_cast<int>(axis) || hint.sensor != sensor) return false;
  return true;
}

/// Those of a sensor whose axes are all named, where there is one: of its columns no other three are meant.
std::vector<SignalTriad> named_triads(const SignalTable& table, const std::vector<SignalTriad>& triads, Role role) {
  std::vector<SignalTriad> named, complete;
  for (const SignalTriad& triad : triads) {
    if (!has_role(table, triad, role)) continue;
    named.push_back(triad);
    if (of_axes(table, triad)) complete.push_back(triad);
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
    result.ask({"accel.columns, gyro.columns",
                "one triad, whose names and readings do not say of which sensor; declare one of the two keys (files of one recording are read "
                "together: inspect A B -o session.toml)"});
  return evidence;
}

}  // namespace

const SignalTable& with_sums(const SignalTable& table, SignalTable& own) {
  bool any = false;
  for (std::size_t i = 0; i < table.signals.size(); ++i) any = any || is_gravity(table, i);
  if (!any) return table;
  const std::vector<SignalTriad> triads = possible_triads(table, {});
  const SignalTriad *gravity = nullptr, *motion = nullptr;
  for (const SignalTriad& triad : triads) {
    if (!of_axes(table, triad)) continue;
    if (is_gravity(table, triad[0]))
      gravity = &triad;
    else if (is_without_gravity(table, triad[0]))
      motion = &triad;
    else if (has_role(table, triad, Role::accel))
      return table;  // an accelerometer
  }
  if (gravity == nullptr || motion == nullptr) return table;
  std::vector<Signal> sums;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Signal &a = table.signals[(*motion)[axis]], &b = table.signals[(*gravity)[axis]];
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
    const bool both = !of_gyro.empty() && !of_accel.empty();
    result.ask(
        {both               ? "gyro.columns, accel.columns"
         : of_accel.empty() ? "gyro.columns"
                            : "accel.columns",
         fmt::format("{} pairs of triads fit each other: {}{}{}; name the columns to use", named.explained(), of_gyro, both ? "; " : "", of_accel)});
  }
  const auto ask_for_sum = [&](const TriadEvidence& filtered) {
    const SignalTriad& t = filtered.accel;
    result.ask({"accel.columns",
                fmt::format("{}, {}, {} have the same norm, {:.6g}, at rest and in motion: a filter's estimate of gravity, which has no error to "
                            "calibrate; name the columns of the accelerometers, or write a session with sums of it and the acceleration without "
                            "gravity: columns = [\"A + B\", ...]",
                            column_name(table, t[0]), column_name(table, t[1]), column_name(table, t[2]), filtered.norm)});
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
    result.ask({"gyro.columns, accel.columns",
                fmt::format("{} triads are named gyros and {} accelerometers, and no turns between rests distinguish them; name the columns",
                            gyros.size(), accels.size())});
  return evidence_for(table, time_ns, gyros.front(), accels.front(), scales, all);
}

}  // namespace imulab::inspection
