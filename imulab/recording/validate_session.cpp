// A session that was made in memory is checked by the tables of a session file, each number by its range.
#include "imulab/core/stamp_text.hpp"
#include "imulab/error.hpp"
#include "imulab/recording/aid_fields.hpp"
#include "imulab/recording/session_fields.hpp"
#include "imulab/recording/validate.hpp"
#include "imulab/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <string_view>
#include <tuple>
#include <utility>

namespace imulab {

namespace {

using namespace session_fields;

/// The counterpart of TomlFields for values that are there already: collects what is out of its range.
class RangeCheck {
 public:
  static constexpr bool of_arrays = true;  ///< a session made in memory may be of arrays, which have no columns in a file

  RangeCheck(std::string place, std::vector<std::string>& problems) : place_(std::move(place)), problems_(problems) {}

  void number(std::string_view key, double value, const Number& kind) {
    const double in_unit = value / kind.factor, rounded = 1e-12 * std::abs(in_unit);  // of the conversion to SI and back
    if (std::isfinite(value) && (in_range(in_unit, kind) || in_range(in_unit - rounded, kind) || in_range(in_unit + rounded, kind))) return;
    std::string problem = std::isfinite(value) ? out_of_range(in_unit, kind) : fmt::format("{} is not finite; expected a finite number", value);
    if (kind.factor != 1) problem += fmt::format(" (in memory it is in SI units and radians: {:g})", value);
    add(key, problem);
  }
  void number(std::string_view key, const std::optional<double>& value, const Number& kind) {
    if (value) number(key, *value, kind);
  }
  template <std::size_t N>
  void numbers(std::string_view key, const std::array<double, N>& values, const Number& kind) {
    for (const double value : values) number(key, value, kind);
  }
  void pair(std::string_view key, const std::optional<std::array<double, 2>>& values, const Number& kind) {
    if (values) numbers(key, *values, kind);
  }
  void triple(std::string_view key, const std::optional<std::array<double, 3>>& values, const Number& kind) {
    if (values) numbers(key, *values, kind);
  }
  void pairs(std::string_view key, const std::vector<std::array<double, 2>>& values, const Number& kind) {
    for (const std::array<double, 2>& each : values) numbers(key, each, kind);
  }
  void spread(std::string_view key, const Spread& value, double factor) {
    number(key, value.value, value.fixed ? any_number(factor) : not_negative(factor));
  }
  template <class Body>
  void table(std::string_view key, Presence, const Body& body) {
    RangeCheck inner(place_of(key), problems_);
    body(inner);
  }
  template <class T, class Body>
  void table_of(std::string_view key, std::optional<T>& value, const Body& body) {
    if (value) table(key, Presence::required, [&](RangeCheck& inner) { body(inner, *value); });
  }
  void check(bool good, std::string_view key, const std::string& message) {
    if (!good) add(key, message);
  }
  // Texts and columns have no range.
  template <class Value>
  void text(std::string_view, const Value&) {}
  template <class Value>
  void column(std::string_view, const Value&) {}
  void columns(std::string_view, const std::vector<Column>&, const std::vector<std::size_t>&) {}
  void axes(std::string_view key, const std::optional<std::array<BodyAxis, 3>>& axes) {
    check(!axes || are_body_axes(*axes), key, "are no body axes; expected each of the indices 0, 1, 2 once, with the sign 1 or -1");
  }
  template <class Enum>
  void choice(std::string_view key, Enum value, const std::vector<Enum>& values, Presence = Presence::required) {
    std::vector<std::string_view> names;
    for (const Enum each : values) names.push_back(to_string(each));
    check(std::find(values.begin(), values.end(), value) != values.end(), key,
          fmt::format("is not allowed; expected one of {}", fmt::join(names, ", ")));
  }
  void choice(std::string_view key, const std::string& value, const std::vector<std::string_view>& names, Presence presence) {
    check((value.empty() && presence == Presence::optional) || std::find(names.begin(), names.end(), value) != names.end(), key,
          fmt::format("\"{}\" is not allowed; expected one of {}", value, fmt::join(names, ", ")));
  }
  void clock_zero(std::string_view, std::int64_t, int) {}

 private:
  std::string place_of(std::string_view key) const { return place_.empty() ? std::string(key) : fmt::format("{}.{}", place_, key); }
  void add(std::string_view key, const std::string& problem) { problems_.push_back(fmt::format("{}: {}", place_of(key), problem)); }

  std::string place_;
  std::vector<std::string>& problems_;
};

template <class Table, class... Context>
void check(std::string place, Table table, std::vector<std::string>& problems, Context... context) {
  RangeCheck fields(std::move(place), problems);
  transfer(fields, table, context...);
}

/// No step has an enumerator that there is not.
bool is_known(const Step& step) {
  return step.kind >= StepKind::hold && step.kind <= StepKind::spin && step.axis >= RigAxis::outer && step.axis <= RigAxis::inner;
}

/// The fault of a step by itself; empty where it has none.
std::string problem_of(const Step& step) {
  const auto finite = [](double value) { return std::isfinite(value) && std::abs(value) <= clock_time().high; };
  if (!finite(step.start) || !finite(step.end)) return "it begins or ends at no time that a clock can show; expected seconds";
  if (!is_known(step)) return "its kind or axis is none; expected those of StepKind and RigAxis";
  if (step.end <= step.start) return fmt::format("it ends at {} s, not after its begin; expected later", stamp_text(step.end));
  if (!std::all_of(step.angles.begin(), step.angles.end(), finite)) return "an angle is not finite; expected radians";
  if (step.kind == StepKind::rotate && !(finite(step.angle) && step.angle != 0))
    return fmt::format("its angle is {:g} rad; expected a turn", step.angle);
  if (step.kind == StepKind::rotate && !(step.rate > 0 && finite(step.rate)))
    return fmt::format("its rate is {:g} rad/s; expected more than 0", step.rate);
  if (step.kind == StepKind::spin && !finite(step.rate)) return fmt::format("its rate is {:g} rad/s; expected a finite one", step.rate);
  if (step.acceleration && !(*step.acceleration > 0))
    return fmt::format("its acceleration is {:g} rad/s^2; expected more than 0", *step.acceleration);
  for (const double radius : step.radius)
    if (!(radius >= 0 && finite(radius))) return fmt::format("a radius is {:g} m; expected 0 or more", radius);
  if (step.mount && !(is_body_axis(step.mount->up) && is_body_axis(step.mount->outward)))
    return "the mount has no body axes; expected indices from 0 to 2 with the sign 1 or -1";
  if (step.mount && step.mount->up.index == step.mount->outward.index) return "the mount's outward axis is parallel to up; expected one across";
  if (step.temperature && !(*step.temperature >= -273.15 && *step.temperature <= 1000))
    return fmt::format("its temperature is {:g} degC; expected -273.15 to 1000", *step.temperature);
  return "";
}

/// Sizes of effects, by name.
void check_effects(std::string_view key, const EffectSigmas& sizes, std::vector<std::string>& problems) {
  for (const auto& [name, sigma] : sizes)
    if (find_effect(name) == nullptr) problems.push_back(fmt::format("{}: \"{}\" is no effect; expected one of docs/theory/effects.md", key, name));
}

/// Densities that are declared in memory among the other terms.
void check_densities(const ImuDeclaration& imu, std::vector<std::string>& problems) {
  for (const auto& [key, terms, density] :
       {std::tuple{"gyro_noise", &imu.gyro_noise, &imu.gyro_noise_density}, std::tuple{"accel_noise", &imu.accel_noise, &imu.accel_noise_density}}) {
    if (!*terms || (*terms)->N == 0) continue;
    RangeCheck(fmt::format("imu.{}", key), problems).number("N", (*terms)->N, not_negative());
    if (*density && **density != (*terms)->N)
      problems.push_back(fmt::format("imu.{0}: N is {1:g}, and {0}_density {2:g}; expected one of them", key, (*terms)->N, **density));
  }
}

/// Recordings name rigs of the session, steps name recordings of it.
void check_names(const Session& session, std::vector<std::string>& problems) {
  for (const RecordingSource& r : session.recordings)
    if (!r.rig.empty() && std::none_of(session.rigs.begin(), session.rigs.end(), [&](const RigDeclaration& rig) { return rig.name == r.rig; }))
      problems.push_back(fmt::format("recording {}: \"{}\" is not a rig of this session", r.file, r.rig));
  if (session.recordings.size() < 2) return;  // of a single one, whatever its name
  for (std::size_t k = 0; k < session.steps.size(); ++k)
    if (std::none_of(session.recordings.begin(), session.recordings.end(),
                     [&](const RecordingSource& r) { return r.file == session.steps[k].recording; }))
      problems.push_back(fmt::format("{}: \"{}\" is not a recording of this session", step_name(session.steps[k], k), session.steps[k].recording));
}

/// Columns of an aid's record: as long as its stamps, which ascend, or empty.
void check_record(const Aid& aid, std::size_t number, std::vector<std::string>& problems) {
  const AidRecord& r = aid.record;
  const auto expect = [&](bool good, std::string_view problem) {
    if (!good) problems.push_back(fmt::format("aid {} ({}): {}", number, to_string(aid.kind), problem));
  };
  for (const std::size_t size : {r.position.size(), r.position_sigma.size(), r.velocity.size(), r.velocity_sigma.size(), r.value.size(),
                                 r.value_sigma.size(), r.place.size(), r.attitude.size()})
    if (size != 0 && size != r.time.size())
      return expect(false, fmt::format("a column has {} rows; expected {}, one for each stamp, or none", size, r.time.size()));
  expect(std::is_sorted(r.time.begin(), r.time.end(), std::less_equal()), "its stamps do not ascend");
  if (r.time.empty()) return;
  const bool of_receiver = aid.kind == AidKind::gnss;
  expect(has_record(aid.kind), "it has a record; expected none of this kind");
  if (has_attitude(aid.kind)) {
    expect(!r.attitude.empty(), "its record has no attitudes");
    expect(aid.kind == AidKind::attitude || !r.place.empty(), "its record has no positions");
  } else {
    expect(of_receiver ? !r.position.empty() || !r.velocity.empty() : !r.value.empty() || !has_record(aid.kind),
           of_receiver ? "its record has neither positions nor velocities" : "its record has no values");
  }
  expect(std::none_of(r.position.begin(), r.position.end(), [](const Eigen::Vector3d& at) { return std::abs(at.x()) > std::numbers::pi / 2; }),
         "a latitude is beyond a pole; expected radians");
}

/// At most one reference of each quantity.
void check_references(const std::vector<Reference>& references, std::vector<std::string>& problems) {
  for (std::size_t k = 0; k < references.size(); ++k) {
    check(fmt::format("reference {}", k + 1), references[k], problems);
    if (std::any_of(references.begin(), references.begin() + static_cast<std::ptrdiff_t>(k),
                    [&](const Reference& r) { return r.quantity == references[k].quantity; }))
      problems.push_back(fmt::format("reference {}: repeats the quantity of an earlier reference; expected each once", k + 1));
  }
}

void check_steps(const Session& session, std::vector<std::string>& problems) {
  std::map<std::string_view, double> ends;  // of the last step, by recording
  for (std::size_t k = 0; k < session.steps.size(); ++k) {
    const Step& step = session.steps[k];
    std::string problem = problem_of(step);
    const auto [before, first] = ends.try_emplace(step.recording, step.end);
    if (problem.empty() && !first && step.start < before->second)
      problem = fmt::format("it begins before the end of the previous step; expected {} s or later", stamp_text(before->second));
    before->second = step.end;
    if (!problem.empty()) problems.push_back(step_name(step, k) + ": " + problem);
  }
}

}  // namespace

void validate(const Session& session) {
  std::vector<std::string> problems;
  check("", session, problems);
  check("imu", session.imu, problems);
  check_densities(session.imu, problems);
  check_names(session, problems);
  check_effects("imu.effect_sigmas", session.imu.effect_sigmas, problems);
  check_effects("imu.simulated_effects", session.imu.simulated_effects.value_or(EffectSigmas{}), problems);
  check("site", session.site, problems);
  for (const RigDeclaration& rig : session.rigs) check("rig", rig, problems, session.rigs.size() > 1);
  for (const RecordingSource& recording : session.recordings) check("recording", recording, problems);
  check_references(session.references, problems);
  if (session.initial) check("initial", *session.initial, problems);
  for (std::size_t k = 0; k < session.aids.size(); ++k) {
    check("aid", session.aids[k], problems);
    check_record(session.aids[k], k + 1, problems);
  }
  RangeCheck navigation("navigation", problems);
  Session copy = session;
  transfer_navigation(navigation, copy);
  check_steps(session, problems);
  throw_problems(session.file.empty() ? "the session" : session.file, problems);
}

}  // namespace imulab
