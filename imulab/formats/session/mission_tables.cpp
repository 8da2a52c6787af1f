#include "imulab/formats/session/mission_tables.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <cmath>
#include <functional>

namespace imulab::session_io {
namespace {

using namespace motion;

const Number turning{unit::deg, 0, 1e4, true};

/// A segment as its keys state it, made once the speed at its start is known.
using Make = std::function<Segment(double speed)>;

double duration_of(TomlFields& f) {
  double duration = 0;
  f.number("duration_s", duration, positive());
  return duration;
}

void read_sway(TomlFields& f, std::string_view size_key, const Number& size_kind, std::string_view frequency_key, double& size, double& frequency) {
  std::optional<double> given_size, given_frequency;
  f.number(size_key, given_size, size_kind);
  f.number(frequency_key, given_frequency, Number{1, 0, 1000, true});
  f.check(given_size.has_value() == given_frequency.has_value(), given_size ? frequency_key : size_key,
          fmt::format("is missing; expected {} and {}, or neither", size_key, frequency_key));
  size = given_size.value_or(size);
  frequency = given_frequency.value_or(frequency);
}

Make read_rest(TomlFields& f) {
  const double duration = duration_of(f);
  Sway sway;
  read_sway(f, "sway_angle_deg", within(0, 45, unit::deg), "sway_angle_hz", sway.angle, sway.angle_frequency);
  read_sway(f, "sway_m", within(0, 100), "sway_hz", sway.displacement, sway.displacement_frequency);
  return [=](double) { return rest(duration, sway); };
}

Make read_straight(TomlFields& f) {
  const double duration = duration_of(f);
  return [=](double speed) {
    if (!(speed > 0)) throw Error("straight at speed 0; expected accelerate before it, or a rest");
    return straight(duration);
  };
}

Make read_accelerate(TomlFields& f) {
  const double duration = duration_of(f);
  double to = 0;
  f.number("to_mps", to, within(0, 1e5));
  return [=](double speed) {
    if (!(to > speed)) throw Error(fmt::format("accelerate from {:g} to {:g} m/s; expected a higher speed (to slow down: brake)", speed, to));
    return accelerate(to - speed, duration);
  };
}

Make read_brake(TomlFields& f) {
  const double duration = duration_of(f), to = f.number_or("to_mps", 0, within(0, 1e5));
  return [=](double speed) {
    if (!(to < speed)) throw Error(fmt::format("brake from {:g} to {:g} m/s; expected a lower speed (to speed up: accelerate)", speed, to));
    return accelerate(to - speed, duration);
  };
}

struct TurnText {
  double angle = 0, roll_time = 3;
  std::optional<double> rate, radius;

  double rate_at(double speed) const { return radius ? turning_rate(*radius, speed) : rate.value_or(0); }
};

TurnText read_turn_text(TomlFields& f) {
  TurnText t;
  f.number("angle_deg", t.angle, within(-1e6, 1e6, unit::deg));
  f.check(t.angle != 0, "angle_deg", "is 0; expected a turn");
  f.number("rate_dps", t.rate, turning);
  f.number("radius_m", t.radius, positive());
  f.check(t.rate || t.radius, "rate_dps", "is missing; expected rate_dps or radius_m");
  f.check(!t.rate || !t.radius, "radius_m", "cannot be combined with rate_dps; expected one of them");
  t.roll_time = f.number_or("roll_s", t.roll_time, positive());
  return t;
}

Make read_turn(TomlFields& f) {
  const TurnText t = read_turn_text(f);
  return [=](double speed) { return turn(t.angle, t.rate_at(speed), t.roll_time); };
}

Make read_s_turn(TomlFields& f) {
  const TurnText t = read_turn_text(f);
  return [=](double speed) { return s_turn(t.angle, t.rate_at(speed), t.roll_time); };
}

Make read_climb(TomlFields& f, double sign) {
  const double duration = duration_of(f), pitch_time = f.number_or("pitch_s", 4, positive());
  double angle = 0;
  f.number("angle_deg", angle, Number{unit::deg, 0, 80, true});
  return [=](double) { return climb(sign * angle, duration, pitch_time); };
}

Make read_pitch(TomlFields& f) {
  const double pitch_time = f.number_or("pitch_s", 1, positive());
  double angle = 0, rate = 0;
  f.number("angle_deg", angle, within(-1e6, 1e6, unit::deg));
  f.check(angle != 0, "angle_deg", "is 0; expected a change of the climb angle");
  f.number("rate_dps", rate, turning);
  return [=](double) { return pitch(angle, rate, pitch_time); };
}

Make read_rotate(TomlFields& f) {
  std::string axis = "z";
  double angle = 0, rate = 0;
  f.choice("axis", axis, {"x", "y", "z"}, Presence::required);
  f.number("angle_deg", angle, within(-1e6, 1e6, unit::deg));
  f.check(angle != 0, "angle_deg", "is 0; expected a turn");
  f.number("rate_dps", rate, turning);
  return [=](double) { return rotate(Eigen::Vector3d::Unit(axis[0] - 'x'), angle, rate); };
}

const std::vector<std::pair<std::string_view, std::function<Make(TomlFields&)>>>& segment_kinds() {
  static const std::vector<std::pair<std::string_view, std::function<Make(TomlFields&)>>> kinds{
      {"rest", read_rest},
      {"straight", read_straight},
      {"accelerate", read_accelerate},
      {"brake", read_brake},
      {"turn", read_turn},
      {"s_turn", read_s_turn},
      {"climb", [](TomlFields& f) { return read_climb(f, 1); }},
      {"dive", [](TomlFields& f) { return read_climb(f, -1); }},
      {"pitch", read_pitch},
      {"rotate", read_rotate}};
  return kinds;
}

double whole_number(TomlFields& f, std::string_view key, double low, double high) {
  double value = low;
  f.number(key, value, within(low, high));
  f.check(value == std::floor(value), key, fmt::format("{:g} is not a whole number; expected one", value));
  return value;
}

double speed_change(const Segment& s) { return s.change(Pulse::Of::speed); }

/// The last segments again, so that they run `times` times in all.
void read_repeat(TomlFields& f, std::vector<Segment>& segments) {
  constexpr std::size_t most = 100'000;
  const auto last = static_cast<std::size_t>(whole_number(f, "last", 1, most)), times = static_cast<std::size_t>(whole_number(f, "times", 2, most));
  f.check(last <= segments.size(), "last",
          fmt::format("{} segments, but there are {} before this one; expected at most those", last, segments.size()));
  f.check(segments.size() + last * (times - 1) <= most, "times", fmt::format("makes more than {} segments; expected fewer", most));
  const std::vector<Segment> again(segments.end() - static_cast<std::ptrdiff_t>(last), segments.end());
  double change = 0;
  for (const Segment& s : again) change += speed_change(s);
  f.check(std::abs(change) < 1e-9, "last",
          fmt::format("the last {} segments change the speed by {:g} m/s; expected to end at the speed they begin with", last, change));
  for (std::size_t i = 1; i < times; ++i) segments.insert(segments.end(), again.begin(), again.end());
}

bool changes_speed(const Segment& s, double t) { return pulses_at(s, Pulse::Of::speed, t).first != 0; }

/// The segment that begins `at` seconds after the begin of the last one, and overlaps it.
void join(const Make& make, double at, Mission& mission, double& speed) {
  if (mission.segments.empty()) throw Error("at_s: no previous segment; expected one that this segment overlaps");
  Segment& last = mission.segments.back();
  const double begin = speed - speed_change(last), then = begin + pulses_at(last, Pulse::Of::speed, at).value;
  const Segment added = make(then);
  if (speed_change(added) != 0 && (changes_speed(last, at) || std::abs(begin + speed_change(last) - then) > 1e-9))
    throw Error("at_s: two changes of speed at the same time; expected one after the other");
  const Segment both = together(last, added, at);
  check_segment(both, begin, mission.carrier);
  last = both;
  speed = begin + speed_change(both);
}

void read_segment(TomlFields& f, Mission& mission, double& speed) {
  std::vector<std::string_view> names;
  for (const auto& kind : segment_kinds()) names.push_back(kind.first);
  names.push_back("repeat");
  std::string name;
  f.check(f.has("kind"), "kind", "is missing; expected one of " + listed(names));
  f.choice("kind", name, names, Presence::required);
  if (name == "repeat") return read_repeat(f, mission.segments);
  for (const auto& [kind, read] : segment_kinds()) {
    if (kind != name) continue;
    const Make make = read(f);
    std::optional<double> at;
    f.number("at_s", at, not_negative());
    try {
      if (at) {
        join(make, *at, mission, speed);
      } else {
        const Segment segment = make(speed);
        check_segment(segment, speed, mission.carrier);
        mission.segments.push_back(segment);
        speed += speed_change(segment);
      }
      if (std::abs(speed) < 1e-9) speed = 0;
    } catch (const Error& e) {
      f.check(false, "kind", e.what());
    }
  }
}

}  // namespace

void read_segments(TomlFields& f, motion::Mission& mission) {
  double speed = mission.start.speed;
  f.consecutive_tables("segment", [&](TomlFields& t) { read_segment(t, mission, speed); });
}

namespace {

using namespace unit;

void spread(TomlFields& f, std::string_view key, std::optional<Spread>& value, double factor) {
  Spread given;
  f.spread(key, given, factor);
  if (f.has(key)) value = given;
}

void read_shared(TomlFields& f, TriadErrors& t) {
  spread(f, "scale_ppm", t.scale, ppm);
  spread(f, "misalignment_arcsec", t.misalignment, arcsec);
  spread(f, "nonorthogonality_arcsec", t.nonorthogonality, arcsec);
}

void read_gyro(TomlFields& f, TriadErrors& t) {
  spread(f, "bias_deg_per_h", t.bias, deg_per_h);
  read_shared(f, t);
  spread(f, "g_sensitivity_deg_per_h_per_g", t.g_sensitivity, deg_per_h / g);
  spread(f, "quadratic_ppm_per_deg_per_s", t.quadratic, ppm / deg);
  spread(f, "turn_on_deg_per_h", t.turn_on, deg_per_h);
  spread(f, "rate_ramp_deg_per_h_per_h", t.R, deg_per_h / hour);
  f.number("angle_random_walk_deg_per_sqrt_h", t.N, not_negative(deg_per_sqrt_h));
  f.number("bias_instability_deg_per_h", t.B, not_negative(deg_per_h));
  f.number("rate_random_walk_deg_per_h_per_sqrt_h", t.K, not_negative(deg_per_h / 60));
  f.number("quantization_arcsec", t.Q, not_negative(arcsec));
}

void read_accel(TomlFields& f, TriadErrors& t) {
  spread(f, "bias_ug", t.bias, ug);
  read_shared(f, t);
  spread(f, "quadratic_ug_per_g2", t.quadratic, ug / (g * g));
  spread(f, "turn_on_ug", t.turn_on, ug);
  spread(f, "rate_ramp_ug_per_h", t.R, ug / hour);
  f.number("velocity_random_walk_ug_per_sqrt_hz", t.N, not_negative(ug_per_sqrt_hz));
  f.number("bias_instability_ug", t.B, not_negative(ug));
  f.number("rate_random_walk_ug_per_sqrt_h", t.K, not_negative(ug / 60));
  f.number("quantization_m_per_s", t.Q, not_negative());
}

void read_start(TomlFields& f, StartErrors& s) {
  Spread velocity, position;
  f.spread("tilt_arcmin", s.attitude[0], 60 * arcsec);
  s.attitude[1] = s.attitude[0];
  f.spread("heading_arcmin", s.attitude[2], 60 * arcsec);
  f.spread("velocity_mps", velocity, 1);
  f.spread("position_m", position, 1);
  s.velocity.fill(velocity);
  s.position.fill(position);
  f.number("aligned_over_s", s.aligned_over, Number{1, 0, 1e5, true});  // a day
  f.check(!s.aligned_over || s.attitude[0].value == 0, "aligned_over_s",
          "cannot be combined with tilt_arcmin; expected an alignment or a given level (heading_arcmin beside it: a given heading)");
}

}  // namespace

void read_errors(TomlFields& f, ErrorSpecification& errors) {
  f.text("grade", errors.grade);
  f.text("system", errors.system);
  f.text("calibration", errors.calibration);
  f.text("noise", errors.noise);
  f.choice("vertical", errors.vertical, std::vector{VerticalChannel::free, VerticalChannel::fixed, VerticalChannel::aided, VerticalChannel::held},
           Presence::optional);
  f.table("gyro", Presence::optional, [&](TomlFields& t) { read_gyro(t, errors.gyro); });
  f.table("accel", Presence::optional, [&](TomlFields& t) { read_accel(t, errors.accel); });
  f.table("start", Presence::optional, [&](TomlFields& t) { read_start(t, errors.start); });
  f.table("barometer", Presence::optional, [&](TomlFields& t) {
    t.spread("bias_m", errors.barometer.bias, 1);
    t.number("noise_m", errors.barometer.noise, or_default(not_negative()));
    t.number("time_constant_s", errors.barometer.time_constant, or_default(positive()));
  });
}

}  // namespace imulab::session_io
