#include "imulab/recording/rests.hpp"

#include "imulab/core/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab {

namespace {

/// Samples whose interval lies inside (start, end]; a sample belongs to the interval that ends at its stamp.
Range samples_between(const Recording& recording, double start_s, double end_s) {
  const auto ns = [](double s) { return static_cast<std::int64_t>(std::llround(1e9 * s)); };
  const auto first = std::upper_bound(recording.time_ns.begin(), recording.time_ns.end(), ns(start_s + 0.5 * recording.interval_s));
  const auto last = std::upper_bound(first, recording.time_ns.end(), ns(end_s) + 1);  // a nanosecond for the stamps' rounding
  return {static_cast<std::size_t>(first - recording.time_ns.begin()), static_cast<std::size_t>(last - recording.time_ns.begin())};
}

/// A rate table's, centrifuge's or chamber's holds are told apart by mounts, which methods that work on rests do not know.
void expect_axis_angles(const Recording& recording, const Session& session) {
  const std::string where = session.file + (recording.name.empty() ? "" : ": " + recording.name);
  std::string_view rig_name;
  for (const RecordingSource& source : session.recordings)
    if (source.file == recording.name) rig_name = source.rig;
  for (const RigDeclaration& rig : session.rigs)
    if ((rig_name.empty() || rig.name == rig_name) && rig.kind != RigKind::turntable && rig.kind != RigKind::none)
      throw Error(fmt::format("{}: recorded on a rig of kind \"{}\": \"turntable\" or \"none\" (a hand) was expected", where, to_string(rig.kind)));
  for (const Step& step : session.steps)
    if (step.kind == StepKind::spin && (session.recordings.size() < 2 || step.recording == recording.name))
      throw Error(fmt::format("{}: a step of kind \"spin\" at {:g} s: rests (hold) and turns (rotate) were expected", where, step.start));
}

}  // namespace

Rests rests_of(const Recording& recording, const Session& session) {
  Rests rests;
  if (session.steps.empty()) {
    RestDetection detection = detect_rests(recording);
    return {std::move(detection.rests), std::move(detection.notes)};
  }
  expect_axis_angles(recording, session);
  for (const Step& step : session.steps) {
    if (step.kind != StepKind::hold || step.recording != recording.name) continue;
    const Range whole = samples_between(recording, step.start, step.end);
    for (const Range& piece : without_interruptions(recording, whole, still_s))
      if (piece.size() >= 2) rests.ranges.push_back(piece);
  }
  rests.notes.push_back(fmt::format("{} rests taken from the session's hold steps", rests.ranges.size()));
  return rests;
}

}  // namespace imulab
