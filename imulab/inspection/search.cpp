#include "imulab/inspection/search.hpp"

#include "imulab/inspection/names.hpp"

#include <fmt/core.h>

#include <algorithm>

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
  return std::all_of(triad.begin(), triad.end(), [&](std::size_t i) { return hint_of(table.signals[i].name).role == role; });
}

namespace {

/// Those of a sensor whose axes are all named, where there is one: of its columns no other three are meant.
std::vector<SignalTriad> named_triads(const SignalTable& table, const std::vector<SignalTriad>& triads, Role role) {
  std::vector<SignalTriad> named, complete;
  for (const SignalTriad& triad : triads) {
    if (!has_role(table, triad, role)) continue;
    named.push_back(triad);
    const std::string sensor = hint_of(table.signals[triad[0]].name).sensor;
    bool in_order = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const NameHint hint = hint_of(table.signals[triad[axis]].name);
      in_order = in_order && hint.axis == static_cast<int>(axis) && hint.sensor == sensor;
    }
    if (in_order) complete.push_back(triad);
  }
  return complete.empty() ? named : complete;
}

}  // namespace

std::optional<TriadEvidence> find_triads(const SignalTable& table, const std::vector<std::int64_t>& time_ns, const TimeGuess& time,
                                         const DeclaredColumns& declared, const std::vector<double>& scales, Inspection& result) {
  std::vector<std::size_t> taken;
  for (const auto& index : {time.column, time.fraction})
    if (index) taken.push_back(*index);
  std::vector<SignalTriad> triads = possible_triads(table, taken);
  for (const auto& triad : {declared.gyro, declared.accel})
    if (triad && std::find(triads.begin(), triads.end(), *triad) == triads.end()) triads.push_back(*triad);
  std::vector<SignalTriad> gyros = named_triads(table, triads, Role::gyro), accels = named_triads(table, triads, Role::accel);
  if (declared.gyro) gyros = {*declared.gyro};
  if (declared.accel) accels = {*declared.accel};
  const std::size_t all = time_ns.size();
  TriadSearch named(table, time_ns, scales);
  for (const SignalTriad& g : gyros)
    for (const SignalTriad& a : accels) named.consider(g, a);
  if (named.explained() > 1)
    result.ambiguous.push_back(
        fmt::format("gyro.columns, accel.columns: {} pairs of triads fit each other; name the columns to use", named.explained()));
  if (const auto best = named.best()) return evidence_for(table, time_ns, best->gyro, best->accel, scales, all);
  if (!(declared.gyro && declared.accel)) {
    TriadSearch search(table, time_ns, scales);
    for (const SignalTriad& g : triads)
      for (const SignalTriad& a : triads)
        if ((!declared.gyro || g == *declared.gyro) && (!declared.accel || a == *declared.accel)) search.consider(g, a);
    if (const auto best = search.best()) return evidence_for(table, time_ns, best->gyro, best->accel, scales, all);
  }
  if (gyros.empty() || accels.empty()) return std::nullopt;
  if (gyros.size() > 1 || accels.size() > 1)
    result.ambiguous.push_back(fmt::format(
        "gyro.columns, accel.columns: {} triads are named gyros and {} accelerometers, and no turns between rests distinguish them; name the columns",
        gyros.size(), accels.size()));
  return evidence_for(table, time_ns, gyros.front(), accels.front(), scales, all);
}

}  // namespace imulab::inspection
