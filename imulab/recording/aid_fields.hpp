// The table [[aid]] of a session or mission, as session_fields.hpp has the others: the keys of each kind, their units and ranges.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/recording/session_fields.hpp"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::session_fields {

/// The standard deviation of the one value that the kind has, under its own name.
template <class Fields>
void transfer_value_sigma(Fields& f, Aid& aid) {
  switch (aid.kind) {
    case AidKind::vehicle:
      return f.number("side_slip_sigma_mps", aid.value_sigma, positive());
    case AidKind::wheels:
      return f.number("speed_sigma_mps", aid.value_sigma, positive());
    case AidKind::barometer:
      return f.number("height_sigma_m", aid.value_sigma, positive());
    case AidKind::heading:
      return f.number("heading_sigma_deg", aid.value_sigma, Number{unit::deg, 0, 360, true});
    case AidKind::pose:
    case AidKind::attitude:
    case AidKind::odometry:
      return f.number("attitude_sigma_deg", aid.value_sigma, Number{unit::deg, 0, 360, true});
    case AidKind::gnss:
    case AidKind::zero_velocity:
      break;
  }
}

/// Spans of the recording's time, each after the one before.
template <class Fields>
void transfer_spans(Fields& f, std::string_view key, std::vector<Outage>& spans) {
  std::vector<std::array<double, 2>> pairs;
  for (const Outage& span : spans) pairs.push_back({span.begin, span.end});
  f.pairs(key, pairs, clock_time());
  spans.clear();
  for (const auto& [begin, end] : pairs) {
    f.check(begin < end && (spans.empty() || begin >= spans.back().end), key, "are not in order; expected [[begin, end], ...] in seconds, ascending");
    spans.push_back({begin, end});
  }
}

/// What is known of the frame and the scale of poses.
template <class Fields>
void transfer_frame(Fields& f, Aid& aid) {
  f.choice("frame", aid.frame, std::vector{AidFrame::free, AidFrame::level, AidFrame::north}, Presence::optional);
  if (aid.kind == AidKind::attitude) return;
  std::string scale(aid.scale_known ? "" : "unknown");
  f.choice("scale", scale, {"known", "unknown"}, Presence::optional);
  aid.scale_known = scale != "unknown";
}

template <class Fields>
void transfer(Fields& f, Aid& aid) {
  f.choice("kind", aid.kind,
           std::vector{AidKind::gnss, AidKind::vehicle, AidKind::wheels, AidKind::barometer, AidKind::heading, AidKind::zero_velocity, AidKind::pose,
                       AidKind::attitude, AidKind::odometry});
  const bool gnss = aid.kind == AidKind::gnss, zero_velocity = aid.kind == AidKind::zero_velocity;
  const bool poses = aid.kind == AidKind::pose || aid.kind == AidKind::odometry;
  if (has_record(aid.kind)) transfer_name(f, "file", aid.file);
  transfer_name(f, "recording", aid.recording);
  if (!zero_velocity && aid.kind != AidKind::heading && aid.kind != AidKind::attitude) {
    std::optional<std::array<double, 3>> arm;
    if (aid.lever_arm) arm = {aid.lever_arm->x(), aid.lever_arm->y(), aid.lever_arm->z()};
    f.triple("lever_arm_m", arm, within(-1e3, 1e3));
    if (arm) aid.lever_arm = Eigen::Vector3d((*arm)[0], (*arm)[1], (*arm)[2]);
    f.number("lever_arm_sigma_m", aid.lever_arm_sigma, within(0, 1e3));
  }
  if (has_record(aid.kind)) {
    f.number("delay_s", aid.delay, within(-60, 60));
    f.number("delay_sigma_s", aid.delay_sigma, within(0, 60));
  }
  if (gnss || poses) f.number("position_sigma_m", aid.position_sigma, positive());
  if (gnss || zero_velocity) f.number("velocity_sigma_mps", aid.velocity_sigma, positive());
  transfer_value_sigma(f, aid);
  if (has_attitude(aid.kind)) transfer_frame(f, aid);
  if (!zero_velocity) f.number("correlation_s", aid.correlation, positive());
  if (has_record(aid.kind)) {
    transfer_spans(f, "outages_s", aid.outages);
    f.number("rate_hz", aid.rate, within(1e-3, 1e4));
  }
  if (gnss) {
    transfer_spans(f, "jumps_s", aid.jumps);
    f.number("jump_m", aid.jump, within(0, 1e6));
    f.check(aid.jumps.empty() || aid.jump, "jump_m", "is missing; expected the displacement of positions during jumps_s");
  }
}

}  // namespace imulab::session_fields
