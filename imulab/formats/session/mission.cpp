#include "imulab/formats/session/mission.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/session/mission_tables.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/toml_fields.hpp"
#include "imulab/recording/aid_fields.hpp"
#include "imulab/recording/unit_names.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <cmath>

namespace imulab {
namespace {

using namespace motion;

using namespace session_io;

void read_start(TomlFields& f, FlightStart& start) {
  f.number("latitude_deg", start.latitude, within(-90, 90, unit::deg));
  const double limit = StrapdownOptions{}.latitude_limit;
  f.check(std::abs(start.latitude) <= limit, "latitude_deg", fmt::format("is at or near a pole; expected at most {:g}", limit / unit::deg));
  f.number("longitude_deg", start.longitude, within(-180, 360, unit::deg));
  f.number("height_m", start.height, within(-1e3, 100e3));
  start.speed = f.number_or("speed_mps", 0, within(0, 1e5));
  start.heading = f.number_or("heading_deg", 0, within(-360, 360, unit::deg));
  start.climb = f.number_or("climb_deg", 0, within(-89, 89, unit::deg));
}

void read_track(TomlFields& f, const std::filesystem::path& mission_file, Mission& mission, std::vector<std::filesystem::path>& files) {
  std::string file;
  f.text("file", file);
  mission.smoothing.position = f.number_or("position_sigma_m", 0, not_negative());
  mission.smoothing.attitude = f.number_or("attitude_sigma_arcsec", 0, not_negative(unit::arcsec));
  if (file.empty()) return;
  files.push_back(mission_file.parent_path() / file);
  mission.track = read_solution(files.back());
}

void read_carrier(TomlFields& f, Carrier& carrier) {
  std::string kind = "aircraft";
  f.choice("carrier", kind, {"aircraft", "vehicle"}, Presence::optional);
  carrier.banks = kind == "aircraft";
  carrier.bank_limit = f.number_or("bank_limit_deg", carrier.bank_limit, Number{unit::deg, 0, 85, true});
  carrier.lateral_limit = f.number_or("lateral_limit_mps2", carrier.lateral_limit, positive());
}

void read_point(TomlFields& f, UnitTemperature& profile) {
  double time = 0, celsius = 0;
  f.number("time_s", time, not_negative());
  f.number("degC", celsius, within(-273.15, 1000));
  f.check(profile.time.empty() || time > profile.time.back(), "time_s", "is not after the previous point; expected ascending times");
  profile.time.push_back(time);
  profile.celsius.push_back(celsius);
}

void read_reading(TomlFields& f, ThermalSource& source) {
  f.choice("unit", source.unit, unit_names(Quantity::temperature, false), Presence::optional);
  source.noise = f.number_or("noise", 0, not_negative());
  f.number("at_25_degC", source.at_25_degC, any_number());
  f.number("per_K", source.per_K, any_number());
  f.check(source.at_25_degC.has_value() == source.per_K.has_value(), source.per_K ? "at_25_degC" : "per_K",
          "is missing; expected at_25_degC and per_K, or neither");
  f.check(source.unit != "raw" || source.per_K, "per_K", "is missing; expected at_25_degC and per_K of a raw reading");
}

void read_temperature(TomlFields& f, std::optional<UnitTemperature>& temperature) {
  const bool profile = f.has("temperature");
  if (profile) f.consecutive_tables("temperature", [&, &out = temperature.emplace()](TomlFields& t) { read_point(t, out); });
  for (const char* key : {"gyro_temperature", "accel_temperature"}) {
    f.check(profile || !f.has(key), key, "is given without [[temperature]]; expected the temperature over time");
    f.table(key, Presence::optional, [&](TomlFields& t) { read_reading(t, key[0] == 'g' ? temperature->gyro : temperature->accel); });
  }
}

void read_motion(TomlFields& f, const std::filesystem::path& path, MissionFile& file) {
  Mission& mission = file.mission;
  mission.rate = f.number_or("rate_hz", mission.rate, within(1e-3, 1e6));
  const double every = mission.rate / f.number_or("truth_rate_hz", mission.rate, positive());
  f.check(every >= 1 && std::abs(every - std::round(every)) < 1e-9 * every, "truth_rate_hz",
          "does not divide rate_hz; expected rate_hz divided by a whole number");
  mission.truth_every = every < 1e7 ? static_cast<std::size_t>(std::round(every)) : 10'000'000;
  read_carrier(f, mission.carrier);
  f.table("imu", Presence::optional, [&](TomlFields& t) { t.text("name", mission.imu); });
  const bool segments = f.has("segment"), track = f.has("track");
  f.check(segments || track, "segment", "is missing; expected [[segment]] tables, or a [track]");
  f.check(!segments || !track, "track", "cannot be combined with [[segment]]; expected one of them");
  f.check(!track || !f.has("start"), "start", "cannot be combined with [track]; expected no start: the track has its own");
  f.table("start", segments ? Presence::required : Presence::optional, [&](TomlFields& t) { read_start(t, mission.start); });
  read_segments(f, mission);
  f.check(track || !mission.segments.empty(), "segment", "is empty; expected [[segment]] tables");
  f.table("track", Presence::optional, [&](TomlFields& t) { read_track(t, path, mission, file.files); });
  read_temperature(f, mission.temperature);
  f.tables("aid", [&](TomlFields& t) {
    session_fields::transfer(t, mission.aids.emplace_back());
    t.check(mission.aids.back().recording.empty(), "recording", "names a recording, of which a mission has none; expected no such key");
  });
}

}  // namespace

MissionFile read_mission(const std::filesystem::path& path) {
  const MappedFile mapped(path, Content::settings);
  return parse_mission(mapped.text(), path);
}

MissionFile parse_mission(std::string_view text, const std::filesystem::path& path) {
  TomlFields f(input_name(path), text);
  MissionFile file;
  file.sha256 = sha256(text);
  f.format("imulab.mission/1");
  read_motion(f, path, file);
  f.table_of<ErrorSpecification>("errors", file.errors, read_errors);
  f.done();
  if (file.errors)
    for (const auto& name : {file.errors->calibration, file.errors->noise})
      if (name) file.files.push_back(path.parent_path() / *name);
  return file;
}

namespace {

/// The analysis's terms where none is given; a grade gives what then is left.
ErrorSpecification with_noise(ErrorSpecification s, const std::string& file) {
  const ImuNoise noise = read_noise(file);
  const NoiseModels sizes = errors_at(file, [&] { return noise_sizes(noise); });
  for (const auto& [triad, size] : {std::pair{&s.gyro, &sizes.gyro}, std::pair{&s.accel, &sizes.accel}}) {
    triad->N = triad->N.value_or(size->N), triad->B = triad->B.value_or(size->B);
    triad->K = triad->K.value_or(size->K), triad->Q = triad->Q.value_or(size->Q);
    triad->R = triad->R.value_or(size->R);
  }
  return s;
}

}  // namespace

ErrorSourcesReading read_error_sources(const ErrorSpecification& given, const std::filesystem::path& mission) {
  const ErrorSpecification specification = given.noise ? with_noise(given, (mission.parent_path() / *given.noise).string()) : given;
  return errors_at(mission.string() + ": [errors]", [&]() -> ErrorSourcesReading {
    if (!specification.calibration) return {error_sources(specification), {}};
    const Calibration calibration = read_calibration(mission.parent_path() / *specification.calibration);
    if (calibration.estimated.empty())  // its errors would be none
      throw Error(fmt::format("{}: has no uncertainties; expected a calibration with its covariance", *specification.calibration));
    ErrorSourcesReading reading{error_sources(specification, &calibration), {}};
    if (const std::size_t count = calibration.quality.unobservable.size(); count > 0)
      reading.warnings.push_back(
          fmt::format("{}: {} coefficients were not determined (the first: {}); they count as exactly known, and their errors are missing here",
                      *specification.calibration, count, calibration.quality.unobservable.front()));
    return reading;
  });
}

}  // namespace imulab
