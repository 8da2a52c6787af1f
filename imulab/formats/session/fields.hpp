// The tables of a session file: those of a session, and a step as the file states it.
#pragma once

#include "imulab/formats/text/toml_fields.hpp"
#include "imulab/recording/aid_fields.hpp"
#include "imulab/recording/session_fields.hpp"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::session_io {

using namespace text;
using namespace session_fields;

inline constexpr std::string_view session_format = "imulab.session/1";

/// A step as the file states it: in the file's units; what is absent follows from the step before.
struct StepText {
  StepKind kind = StepKind::hold;
  std::optional<std::string> recording;
  std::optional<double> start_s, end_s, duration_s, move_s;
  std::array<std::optional<double>, 3> angles_deg;  // by RigAxis
  RigAxis axis = RigAxis::outer;
  double angle_deg = 0, rate_dps = 0;
  std::optional<double> acceleration_dps2, temperature_degC;
  std::optional<BodyAxis> up, outward;
  std::array<double, 3> radius_m{0, 0, 0};
};

template <class Fields>
void transfer(Fields& f, StepText& step) {
  f.choice("kind", step.kind, std::vector{StepKind::hold, StepKind::rotate, StepKind::spin});
  f.text("recording", step.recording);
  f.number("start_s", step.start_s, clock_time());
  f.number("end_s", step.end_s, clock_time());
  if (step.kind != StepKind::rotate) {
    f.number("duration_s", step.duration_s, positive());
    f.number("move_s", step.move_s, not_negative());
  }
  if (step.kind == StepKind::hold) {
    f.number("outer_deg", step.angles_deg[static_cast<std::size_t>(RigAxis::outer)], turn_number());
    f.number("middle_deg", step.angles_deg[static_cast<std::size_t>(RigAxis::middle)], turn_number());
    f.number("inner_deg", step.angles_deg[static_cast<std::size_t>(RigAxis::inner)], turn_number());
  }
  if (step.kind == StepKind::rotate) {
    f.choice("axis", step.axis, std::vector{RigAxis::outer, RigAxis::middle, RigAxis::inner});
    f.number("angle_deg", step.angle_deg, turn_number());
    f.check(step.angle_deg != 0, "angle_deg", "is 0; expected a turn");
    f.number("rate_dps", step.rate_dps, positive());
    f.number("acceleration_dps2", step.acceleration_dps2, positive());
  } else {
    f.axis("up", step.up);
    f.axis("outward", step.outward);
    f.check(step.up.has_value() == step.outward.has_value(), step.up ? "up" : "outward", "is given alone; expected both up and outward, or neither");
    f.check(!step.up || step.up->index != step.outward->index, "outward", "is parallel to up; expected a body axis perpendicular to it");
  }
  if (step.kind == StepKind::spin) {
    f.number("rate_dps", step.rate_dps, turn_number());
    f.number_or_numbers("radius_m", step.radius_m, or_default(not_negative()));
  }
  f.number("temperature_degC", step.temperature_degC, within(-273.15, 1000));
}

}  // namespace imulab::session_io
