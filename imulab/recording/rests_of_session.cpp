// The rests that a session declares, or else those that its recording shows.
#include "imulab/core/stamp_text.hpp"
#include "imulab/error.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/lost_rests.hpp"
#include "imulab/rests.hpp"
#include "imulab/session.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

namespace imulab {

namespace {

/// The holds of a rate table, centrifuge or chamber differ in their mounts, which methods that work on rests do not use.
void expect_axis_angles(const RecordingView& recording, const Session& session, const RecordingSource& source) {
  const std::string where = session.file + (recording.name.empty() ? "" : ": " + std::string(recording.name));
  const RigDeclaration* const rig = session.rig_of(source);
  if (rig != nullptr && rig->kind != RigKind::turntable && rig->kind != RigKind::none)
    throw Error(fmt::format("{}: recorded on a rig of kind \"{}\"; expected \"turntable\" or \"none\" (a hand)", where, to_string(rig->kind)));
  for (const Step& step : session.steps_of(source))
    if (step.kind == StepKind::spin)
      throw Error(fmt::format("{}: a step of kind \"spin\" at {} s; expected rests (hold) and turns (rotate)", where, stamp_text(step.start)));
}

/// Steps are declared to a tenth of a second, and a table comes to rest as much later: a sample of a turn at 10 deg/s is 6 deg/h in the mean of a
/// minute at 100 Hz.
constexpr double declared_to_s = 0.1;

bool has_holds(const std::vector<Step>& steps) {
  return std::any_of(steps.begin(), steps.end(), [](const Step& step) { return step.kind == StepKind::hold; });
}

}  // namespace

Rests rests_of(const Recording& recording, const Session& session) {
  validate(recording);
  validate(session);
  return rests_of(RecordingView(recording), session);
}

Rests rests_of(const RecordingView& recording, const Session& session) {
  LostRests lost;
  return rests_of(recording, session, lost);
}

Rests rests_of(const RecordingView& recording, const Session& session, LostRests& lost, const RestOptions& options) {
  lost = {};
  Rests rests;
  const RecordingSource source = session.source_of(recording.name);
  if (!session.steps.empty()) expect_axis_angles(recording, session, source);
  const std::vector<Step> steps = session.steps_of(source);
  if (!has_holds(steps)) {
    RestDetection detection = detect_rests(recording, options, lost);
    for (const Step& step : steps)  // a hand that takes a new grip
      std::erase_if(detection.rests, [&](Range r) { return recording.time_s(r.begin) > step.start && recording.time_s(r.end - 1) < step.end; });
    return {std::move(detection.rests), std::move(detection.notes), std::move(detection.motion)};
  }
  for (const Step& step : steps) {
    if (step.kind != StepKind::hold) continue;
    const double margin = recording.interval_s < 0.5 * declared_to_s ? std::min(declared_to_s, 0.05 * (step.end - step.start)) : 0;
    for (const Range& piece : without_interruptions(recording, recording.samples_in(step.start + margin, step.end - margin), still_s))
      if (piece.size() >= 2) rests.ranges.push_back(piece);
  }
  rests.notes.push_back(fmt::format("{} rests taken from the session's hold steps", rests.ranges.size()));
  return rests;
}

}  // namespace imulab
