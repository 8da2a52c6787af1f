#include "imulab/io/mission_fields.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/io/solution_file.hpp"
#include "imulab/io/text.hpp"
#include "imulab/io/unit_names.hpp"

#include <fmt/format.h>

#include <cmath>
#include <functional>

namespace imulab {
namespace {

const Number turning{unit::deg, 0, 1e4, true};

/// What a segment's keys say, to be made once the speed at its begin is known.
using Make = std::function<Segment(double speed)>;

double duration_of(TomlFields& f) {
  double duration = 0;
  f.number("duration_s", duration, positive());
  return duration;
}

/// In SI, as the value that stands where there is none.
double number_or(TomlFields& f, std::string_view key, double otherwise, const Number& kind) {
  std::optional<double> given;
  f.number(key, given, kind);
  return given.value_or(otherwise);
}

void read_sway(TomlFields& f, std::string_view size_key, const Number& size_kind, std::string_view frequency_key, double& size, double& frequency) {
  std::optional<double> given_size, given_frequency;
  f.number(size_key, given_size, size_kind);
  f.number(frequency_key, given_frequency, Number{1, 0, 1000, true});
  f.check(given_size.has_value() == given_frequency.has_value(), given_size ? frequency_key : size_key,
          fmt::format("is missing, expected {} and {}, or neither", size_key, frequency_key));
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
    if (!(speed > 0)) throw Error("straight at no speed: expected to accelerate before it, or a rest");
    return straight(duration);
  };
}

Make read_accelerate(TomlFields& f) {
  const double duration = duration_of(f);
  double to = 0;
  f.number("to_mps", to, not_negative());
  return [=](double speed) {
    if (!(to > speed)) throw Error(fmt::format("accelerate from {:g} to {:g} m/s: expected a higher speed (a lower one: brake)", speed, to));
    return accelerate(to - speed, duration);
  };
}

Make read_brake(TomlFields& f) {
  const double duration = duration_of(f), to = number_or(f, "to_mps", 0, not_negative());
  return [=](double speed) {
    if (!(to < speed)) throw Error(fmt::format("brake from {:g} to {:g} m/s: expected a lower speed (a higher one: accelerate)", speed, to));
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
  f.number("angle_deg", t.angle, any_number(unit::deg));
  f.check(t.angle != 0, "angle_deg", "is 0, expected a turn");
  f.number("rate_dps", t.rate, turning);
  f.number("radius_m", t.radius, positive());
  f.check(t.rate || t.radius, "rate_dps", "is missing, expected rate_dps or radius_m");
  f.check(!t.rate || !t.radius, "radius_m", "stands beside rate_dps, expected one of them");
  t.roll_time = number_or(f, "roll_s", t.roll_time, positive());
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
  const double duration = duration_of(f), pitch_time = number_or(f, "pitch_s", 4, positive());
  double angle = 0;
  f.number("angle_deg", angle, Number{unit::deg, 0, 80, true});
  return [=](double) { return climb(sign * angle, duration, pitch_time); };
}

Make read_pitch(TomlFields& f) {
  const double pitch_time = number_or(f, "pitch_s", 1, positive());
  double angle = 0, rate = 0;
  f.number("angle_deg", angle, any_number(unit::deg));
  f.check(angle != 0, "angle_deg", "is 0, expected a change of climb");
  f.number("rate_dps", rate, turning);
  return [=](double) { return pitch(angle, rate, pitch_time); };
}

Make read_rotate(TomlFields& f) {
  std::string axis = "z";
  double angle = 0, rate = 0;
  f.choice("axis", axis, {"x", "y", "z"}, Presence::required);
  f.number("angle_deg", angle, any_number(unit::deg));
  f.check(angle != 0, "angle_deg", "is 0, expected a turn");
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
  f.check(value == std::floor(value), key, fmt::format("{:g}, expected a whole number", value));
  return value;
}

double speed_change(const Segment& s) { return s.change(Pulse::Of::speed); }

/// The last segments again, so that they run `times` times in all.
void read_repeat(TomlFields& f, std::vector<Segment>& segments) {
  constexpr std::size_t most = 100'000;
  const auto last = static_cast<std::size_t>(whole_number(f, "last", 1, most)), times = static_cast<std::size_t>(whole_number(f, "times", 2, most));
  f.check(last <= segments.size(), "last", fmt::format("{} segments, but {} before this one", last, segments.size()));
  f.check(segments.size() + last * (times - 1) <= most, "times", fmt::format("would make more than {} segments", most));
  if (last > segments.size() || last * times > 2 * most) return;  // a key is missing, and said so
  const std::vector<Segment> again(segments.end() - static_cast<std::ptrdiff_t>(last), segments.end());
  double change = 0;
  for (const Segment& s : again) change += speed_change(s);
  f.check(std::abs(change) < 1e-9, "last",
          fmt::format("the last {} segments change the speed by {:g} m/s, expected to end at the speed they begin with", last, change));
  for (std::size_t i = 1; i < times; ++i) segments.insert(segments.end(), again.begin(), again.end());
}

bool changes_speed(const Segment& s, double t) { return pulses_at(s, Pulse::Of::speed, t).first != 0; }

/// The segment that begins `at` seconds after the last one's beginning, and goes together with it.
void join(const Make& make, double at, Mission& mission, double& speed) {
  if (mission.segments.empty()) throw Error("at_s: expected a segment before this one, with which it goes together");
  Segment& last = mission.segments.back();
  const double begin = speed - speed_change(last), then = begin + pulses_at(last, Pulse::Of::speed, at).value;
  const Segment added = make(then);
  if (speed_change(added) != 0 && (changes_speed(last, at) || std::abs(begin + speed_change(last) - then) > 1e-9))
    throw Error("at_s: two changes of speed at the same time, expected one after the other");
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
  f.check(f.has("kind"), "kind", "is missing, expected one of " + listed(names));
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

void read_start(TomlFields& f, FlightStart& start) {
  f.number("latitude_deg", start.latitude, within(-90, 90, unit::deg));
  const double limit = StrapdownOptions{}.latitude_limit;
  f.check(std::abs(start.latitude) <= limit, "latitude_deg", fmt::format("is a pole or near it, expected {:g} at most", limit / unit::deg));
  f.number("longitude_deg", start.longitude, within(-180, 360, unit::deg));
  f.number("height_m", start.height, within(-1e3, 100e3));
  start.speed = number_or(f, "speed_mps", 0, not_negative());
  start.heading = number_or(f, "heading_deg", 0, within(-360, 360, unit::deg));
  start.climb = number_or(f, "climb_deg", 0, within(-89, 89, unit::deg));
}

void read_track(TomlFields& f, const std::filesystem::path& mission_file, Mission& mission) {
  std::string file;
  f.text("file", file);
  mission.smoothing.position = number_or(f, "position_sigma_m", 0, not_negative());
  mission.smoothing.attitude = number_or(f, "attitude_sigma_arcsec", 0, not_negative(unit::arcsec));
  if (!file.empty()) mission.track = read_solution(mission_file.parent_path() / file);
}

void read_carrier(TomlFields& f, Carrier& carrier) {
  std::string kind = "aircraft";
  f.choice("carrier", kind, {"aircraft", "vehicle"}, Presence::optional);
  carrier.banks = kind == "aircraft";
  carrier.bank_limit = number_or(f, "bank_limit_deg", carrier.bank_limit, Number{unit::deg, 0, 85, true});
  carrier.lateral_limit = number_or(f, "lateral_limit_mps2", carrier.lateral_limit, positive());
}

void read_point(TomlFields& f, UnitTemperature& course) {
  double time = 0, celsius = 0;
  f.number("time_s", time, not_negative());
  f.number("degC", celsius, within(-273.15, 1000));
  f.check(course.time.empty() || time > course.time.back(), "time_s", "is not after the point before, expected ascending times");
  course.time.push_back(time);
  course.celsius.push_back(celsius);
}

void read_reading(TomlFields& f, ThermalSource& source) {
  if (f.has("unit")) f.choice("unit", source.unit, unit_names(Quantity::temperature, false), Presence::optional);
  source.noise = number_or(f, "noise", 0, not_negative());
  f.number("at_25_degC", source.at_25_degC, any_number());
  f.number("per_K", source.per_K, any_number());
  f.check(source.at_25_degC.has_value() == source.per_K.has_value(), source.per_K ? "at_25_degC" : "per_K",
          "is missing, expected at_25_degC and per_K, or neither");
  f.check(source.unit != "raw" || source.per_K, "per_K", "is missing, expected at_25_degC and per_K of a raw reading");
}

void read_temperature(TomlFields& f, std::optional<UnitTemperature>& temperature) {
  const bool course = f.has("temperature");
  if (course) f.tables("temperature", [&, &out = temperature.emplace()](TomlFields& t) { read_point(t, out); });
  for (const char* key : {"gyro_temperature", "accel_temperature"}) {
    f.check(course || !f.has(key), key, "stands without [[temperature]], expected the course of the temperature");
    f.table(key, Presence::optional, [&](TomlFields& t) { read_reading(t, key[0] == 'g' ? temperature->gyro : temperature->accel); });
  }
}

}  // namespace

void describe(TomlFields& f, Mission& mission, const std::filesystem::path& path) {
  mission.rate = number_or(f, "rate_hz", mission.rate, Number{1, 0, 1e6, true});
  const double every = mission.rate / number_or(f, "truth_rate_hz", mission.rate, positive());
  f.check(every >= 1 && std::abs(every - std::round(every)) < 1e-9 * every, "truth_rate_hz", "expected rate_hz, or a whole part of it");
  mission.truth_every = every < 1e7 ? static_cast<std::size_t>(std::round(every)) : 10'000'000;
  read_carrier(f, mission.carrier);
  f.table("imu", Presence::optional, [&](TomlFields& t) { t.text("name", mission.imu); });
  const bool segments = f.has("segment"), track = f.has("track");
  f.check(segments || track, "segment", "is missing, expected [[segment]] tables, or a [track]");
  f.check(!segments || !track, "track", "stands beside [[segment]], expected one of them");
  f.check(!track || !f.has("start"), "start", "stands beside [track], which has a start of its own");
  f.table("start", segments ? Presence::required : Presence::optional, [&](TomlFields& t) { read_start(t, mission.start); });
  double speed = mission.start.speed;
  f.tables("segment", [&](TomlFields& t) { read_segment(t, mission, speed); });
  f.check(track || !mission.segments.empty(), "segment", "is empty, expected [[segment]] tables");
  f.table("track", Presence::optional, [&](TomlFields& t) { read_track(t, path, mission); });
  read_temperature(f, mission.temperature);
}

}  // namespace imulab
