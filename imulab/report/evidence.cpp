#include "imulab/report/evidence.hpp"

#include "imulab/core/error.hpp"
#include "imulab/recording/rests.hpp"

#include <algorithm>
#include <cmath>

namespace imulab {

namespace {

/// Points of all charts of one quantity: two for each of these intervals.
constexpr std::size_t all_intervals = 1500, least_intervals = 50;

std::vector<Range> ranges_of(const Calibration& calibration, const Session& session, const Recording& recording, bool only_one) {
  if (!only_one || calibration.quality.rests.empty()) return rests_of(recording, session).ranges;
  std::vector<Range> ranges;
  const double first = recording.time_s(0) - recording.interval_s, last = recording.time_s(recording.size() - 1) + recording.interval_s;
  for (const PartResidual& rest : calibration.quality.rests)  // of a file that anybody may have written
    if (first <= rest.begin_s && rest.begin_s < rest.end_s && rest.end_s <= last) ranges.push_back(recording.samples_in(rest.begin_s, rest.end_s));
  return ranges;
}

double largest(const Columns3& columns) {
  double most = 0;
  for (const auto& column : columns)
    for (const double v : column) most = std::max(most, std::abs(v));
  return most;
}

}  // namespace

RecordingEvidence evidence_of(const Calibration& calibration, const Session& session, const Recording& recording, std::size_t recordings) {
  RecordingEvidence e;
  e.file = recording.name;
  e.samples = recording.size();
  e.saturated = recording.saturated.size();
  e.gaps = recording.gaps.size();
  if (recording.size() == 0) return e;
  e.rate_hz = 1 / recording.interval_s;
  e.duration_s = recording.time_s(recording.size() - 1) - recording.time_s(0) + recording.interval_s;
  e.overview = overview(calibration.model, recording, std::max(least_intervals, all_intervals / std::max<std::size_t>(1, recordings)));
  e.largest_rate = largest(e.overview.rate);
  e.largest_force = largest(e.overview.force);
  const RigDeclaration* rig = session.rig_of(session.source_of(recording.name));
  if (rig != nullptr && rig->kind != RigKind::none && rig->kind != RigKind::turntable) {
    e.without_rests = std::string(to_string(rig->kind)) + " recordings have no rests in free directions";
    return e;
  }
  try {
    const SensorModel before = uncalibrated(calibration.model);
    e.rests = gravity_at_rests(recording, ranges_of(calibration, session, recording, recordings == 1), before, calibration.model);
    e.turns = turn_errors(recording, e.rests, before, calibration.model);
  } catch (const Error& error) {
    e.without_rests = error.what();
  }
  if (e.rests.empty() && e.without_rests.empty()) e.without_rests = "none were found";
  return e;
}

}  // namespace imulab
