#include "imulab/recording/rests.hpp"

#include "imulab/core/error.hpp"

#include <fmt/core.h>

namespace imulab {

namespace {

/// The holds of a rate table, centrifuge or chamber differ in their mounts, which methods that work on rests do not use.
void expect_axis_angles(const Recording& recording, const Session& session, const RecordingSource& source) {
  const std::string where = session.file + (recording.name.empty() ? "" : ": " + recording.name);
  const RigDeclaration* const rig = session.rig_of(source);
  if (rig != nullptr && rig->kind != RigKind::turntable && rig->kind != RigKind::none)
    throw Error(fmt::format("{}: recorded on a rig of kind \"{}\"; expected \"turntable\" or \"none\" (a hand)", where, to_string(rig->kind)));
  for (const Step& step : session.steps_of(source))
    if (step.kind == StepKind::spin)
      throw Error(fmt::format("{}: a step of kind \"spin\" at {:g} s; expected rests (hold) and turns (rotate)", where, step.start));
}

}  // namespace

Rests rests_of(const Recording& recording, const Session& session) {
  Rests rests;
  if (session.steps.empty()) {
    RestDetection detection = detect_rests(recording);
    return {std::move(detection.rests), std::move(detection.notes)};
  }
  const RecordingSource source = session.source_of(recording.name);
  expect_axis_angles(recording, session, source);
  for (const Step& step : session.steps_of(source)) {
    if (step.kind != StepKind::hold) continue;
    for (const Range& piece : without_interruptions(recording, recording.samples_in(step.start, step.end), still_s))
      if (piece.size() >= 2) rests.ranges.push_back(piece);
  }
  rests.notes.push_back(fmt::format("{} rests taken from the session's hold steps", rests.ranges.size()));
  return rests;
}

}  // namespace imulab
