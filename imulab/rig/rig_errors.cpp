#include "imulab/rig/rig_errors.hpp"

#include "imulab/core/random.hpp"
#include "imulab/grade.hpp"
#include "imulab/rig/machine.hpp"
#include "imulab/simulate.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <cmath>
#include <numbers>

namespace imulab {

namespace {

RigErrorSource known(RigErrorKind kind, double value) {
  RigErrorSource source;
  source.kind = kind;
  source.known = value;
  return source;
}

/// Errors of the table itself: the same in every recording.
void add_table_errors(const RigDeclaration& rig, const std::array<bool, 3>& used, std::vector<RigErrorSource>& sources) {
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t element = 0; element < 2 && used[a]; ++element) {
      const auto& given = rig.given_orthogonality[a];
      RigErrorSource source =
          given ? known(RigErrorKind::orthogonality, (*given)[element]) : declared(RigErrorKind::orthogonality, rig.orthogonality);
      source.axis = a, source.element = element;
      sources.push_back(source);
    }
  bool any_zero_given = false;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto& given = rig.given_zero[a];
    any_zero_given = any_zero_given || given.has_value();
    RigErrorSource source = given ? known(RigErrorKind::zero, *given) : declared(RigErrorKind::zero, rig.zero);
    source.axis = a;
    sources.push_back(source);
  }
  for (std::size_t direction = 0; direction < 2; ++direction) {
    RigErrorSource source = any_zero_given ? known(RigErrorKind::tilt, 0) : declared(RigErrorKind::tilt, rig.zero);
    source.axis = direction;
    sources.push_back(source);
  }
}

void add_step_errors(const RigDeclaration& rig, std::span<const Step> steps, const std::vector<AxisCommand>& commands,
                     const std::array<bool, 3>& used, std::vector<RigErrorSource>& sources) {
  const auto add_angle = [&](std::size_t axis, std::size_t step) {
    RigErrorSource source = declared(RigErrorKind::angle, rig.angle);
    source.axis = axis, source.step = step;
    sources.push_back(source);
  };
  for (std::size_t a = 0; a < 3; ++a)
    if (used[a]) add_angle(a, RigErrorSource::at_start);
  for (std::size_t k = 0; k < steps.size(); ++k) {
    for (std::size_t a = 0; a < 3; ++a)
      if (commands[k].moves[a]) add_angle(a, k);
    if (steps[k].kind != StepKind::rotate) continue;
    RigErrorSource source = declared(RigErrorKind::timing, rig.timing);
    source.axis = static_cast<std::size_t>(steps[k].axis), source.step = k;
    sources.push_back(source);
  }
}

}  // namespace

RigErrorSource declared(RigErrorKind kind, const Spread& spread) {
  RigErrorSource source;
  source.kind = kind;
  (spread.fixed ? source.known : source.sigma) = spread.value;
  return source;
}

std::vector<AxisCommand> commands_of(std::span<const Step> steps) {
  std::vector<AxisCommand> commands;
  std::array<double, 3> now{};
  if (!steps.empty() && steps.front().kind == StepKind::hold && steps.front().start < same_time) now = steps.front().angles;
  for (const Step& step : steps) {
    AxisCommand command{.before = now, .after = now, .moves = {}};
    if (step.kind == StepKind::hold) {
      command.after = step.angles;
      for (std::size_t a = 0; a < 3; ++a) command.moves[a] = std::abs(std::remainder(step.angles[a] - now[a], 2 * std::numbers::pi)) >= same_angle;
    } else if (step.kind == StepKind::rotate) {
      const auto axis = static_cast<std::size_t>(step.axis);
      command.after[axis] += step.angle;
      command.moves[axis] = true;
    }
    now = command.after;
    commands.push_back(command);
  }
  return commands;
}

std::string RigErrorSource::name() const {
  const std::string_view axis_name = to_string(static_cast<RigAxis>(axis));
  switch (kind) {
    case RigErrorKind::orthogonality:
      return fmt::format("orthogonality.{}.{}", axis_name, element + 1);
    case RigErrorKind::zero:
      return fmt::format("zero.{}", axis_name);
    case RigErrorKind::tilt:
      return axis == 0 ? "tilt.east" : "tilt.north";
    case RigErrorKind::angle:
      return fmt::format("angle.{}.{}", axis_name, step == at_start ? "start" : fmt::format("{}", step + 1));
    case RigErrorKind::mount:
      return fmt::format("mount.{}.{}", mount_name(place), "xyz"[axis]);
    case RigErrorKind::rate:
      return "rate";
    case RigErrorKind::radius:
      return "radius." + mount_name(place);
    case RigErrorKind::timing:
      break;
  }
  return fmt::format("timing.{}", step + 1);
}

std::vector<RigErrorSource> table_error_sources(const RigDeclaration& rig, std::span<const Step> steps) {
  const std::vector<AxisCommand> commands = commands_of(steps);
  std::array<bool, 3> used{};
  for (std::size_t a = 0; a < 3; ++a) {
    used[a] = !commands.empty() && std::abs(commands.front().before[a]) >= same_angle;
    for (const AxisCommand& command : commands) used[a] = used[a] || command.moves[a];
  }
  std::vector<RigErrorSource> sources;
  add_table_errors(rig, used, sources);
  add_step_errors(rig, steps, commands, used, sources);
  return sources;
}

std::vector<RigErrorSource> rig_error_sources(const Session& session, const RecordingSource& source) {
  const RigDeclaration* const rig = session.rig_of(source);
  if (rig == nullptr || rig->kind == RigKind::none) return {};
  const std::vector<Step> steps = session.steps_of(source);
  return is_machine(rig->kind) ? machine_error_sources(*rig, steps) : table_error_sources(*rig, steps);
}

std::string problem_of(const RigErrorSource& source, std::size_t steps) {
  const std::size_t axes = source.kind == RigErrorKind::tilt ? 2 : 3;
  const bool by_step = source.kind == RigErrorKind::timing || (source.kind == RigErrorKind::angle && source.step != RigErrorSource::at_start);
  if (source.kind < RigErrorKind::orthogonality || source.kind > RigErrorKind::radius) return "an error of the rig has no kind of RigErrorKind";
  if (source.axis >= axes) return fmt::format("an error of the rig is of axis {}; expected less than {}", source.axis, axes);
  if (source.element >= 2) return fmt::format("an error of the rig is of element {}; expected 0 or 1", source.element);
  if (by_step && source.step >= steps) return fmt::format("an error of the rig is of step {}; expected one of {}, from 0", source.step, steps);
  return "";
}

RigErrorIndex index_of(std::span<const RigErrorSource> sources, std::size_t steps) {
  RigErrorIndex index;
  index.angle_before.assign(steps, index.zero);  // none
  index.angle_after = index.angle_before;
  index.timing.assign(steps, RigErrorIndex::none);
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const RigErrorSource& source = sources[i];
    const int here = static_cast<int>(i);
    switch (source.kind) {
      case RigErrorKind::orthogonality:
        index.orthogonality[source.axis][source.element] = here;
        break;
      case RigErrorKind::zero:
        index.zero[source.axis] = here;
        break;
      case RigErrorKind::tilt:
        index.tilt[source.axis] = here;
        break;
      case RigErrorKind::timing:
        index.timing[source.step] = here;
        break;
      case RigErrorKind::mount:
      case RigErrorKind::rate:
      case RigErrorKind::radius:
        break;                     // of machines, which have no steps of their own
      case RigErrorKind::angle: {  // until the axis moves again, when its next source overwrites this one
        const bool at_start = source.step == RigErrorSource::at_start;
        for (std::size_t k = at_start ? 0 : source.step; k < steps; ++k) {
          index.angle_after[k][source.axis] = here;
          if (at_start || k > source.step) index.angle_before[k][source.axis] = here;
        }
      }
    }
  }
  return index;
}

RigErrors draw_rig_errors(const Session& session, const RecordingSource& source, std::uint64_t seed) {
  RigErrors errors{rig_error_sources(session, source), {}};
  const RigDeclaration* const rig = session.rig_of(source);
  for (const RigErrorSource& e : errors.sources) {
    const bool of_the_table = e.kind != RigErrorKind::angle && e.kind != RigErrorKind::timing;
    const RandomStream draws(seed, fmt::format("rig error {} of {}", e.name(), of_the_table ? rig->name : source.file));
    errors.values.push_back(e.known + e.sigma * draws.normal(0));
  }
  return errors;
}

ErrorInWords in_words(const RigErrorSource& source) {
  const std::string mount = "mount " + mount_name(source.place);
  switch (source.kind) {
    case RigErrorKind::rate:
      return {"rate", 1e-2, "%", 0.1};
    case RigErrorKind::radius:
      return {"radius of " + mount, 1e-3, "mm", 1};
    case RigErrorKind::mount:
      return {fmt::format("{}, turned about {}", mount, "xyz"[source.axis]), unit::deg, "deg", 10 * unit::deg};
    default:
      return {fmt::format("its axis, towards {}", source.axis == 0 ? "south" : "east"), unit::deg, "deg", 10 * unit::deg};
  }
}

}  // namespace imulab
