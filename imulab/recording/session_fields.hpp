// The tables of a session, each stated once: key, place, unit, range. transfer(fields, table) reads a file's table where `fields` is a TomlFields,
// writes it where it is a TomlText, and checks a session in memory where it is a RangeCheck.
#pragma once

#include "imulab/core/fields.hpp"
#include "imulab/core/stamp_text.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/recording/unit_names.hpp"
#include "imulab/session.hpp"
#include "imulab/units.hpp"

#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace imulab {

inline std::string_view to_string(Output output) { return output == Output::rate ? "rate" : "increment"; }

}  // namespace imulab

namespace imulab::session_fields {

using namespace fields;

/// Stamps are 64-bit nanoseconds, half of whose range is for sums: 146 years, also of a clock that counts from 1970.
inline Number clock_time() { return within(-4.6e9, 4.6e9); }
inline Number sampling_rate() { return within(1e-3, 1e6); }  // Hz
inline Number turn_number() { return within(-1e6, 1e6); }    // deg or deg/s

/// A number of at least 0; absent: 0.
template <class Fields>
void transfer_size(Fields& f, std::string_view key, double& value, double factor = 1) {
  std::optional<double> given = value == 0 ? std::nullopt : std::optional(value);
  f.number(key, given, not_negative(factor));
  value = given.value_or(0);
}

/// A text that may be absent: empty then.
template <class Fields>
void transfer_name(Fields& f, std::string_view key, std::string& value) {
  std::optional<std::string> given = value.empty() ? std::nullopt : std::optional(value);
  f.text(key, given);
  value = given.value_or("");
}

/// Noise terms of a triad, except N: the densities have keys of their own.
template <class Fields>
void transfer(Fields& f, NoiseModel& noise) {
  f.spread("turn_on", noise.turn_on, 1);
  transfer_size(f, "quantization", noise.Q);
  transfer_size(f, "bias_instability", noise.B);
  transfer_size(f, "rate_random_walk", noise.K);
  f.spread("rate_ramp", noise.R, 1);
  transfer_size(f, "resolution", noise.resolution);
  transfer_size(f, "range", noise.range);
}

/// "white", "full", or the file of an analysis.
template <class Fields>
void transfer_noise(Fields& f, ImuDeclaration& imu) {
  std::optional<std::string> noise = imu.noise_file;
  if (imu.noise == NoiseTerms::full) noise = to_string(imu.noise);
  f.text("noise", noise);
  if (!noise) return;
  const bool named = *noise == "white" || *noise == "full", file = noise->ends_with(".json");
  f.check(named || file, "noise", "\"" + *noise + "\" is not allowed; expected white, full, or the file of an analysis, noise.json");
  imu.noise = *noise == "full" ? NoiseTerms::full : NoiseTerms::white;
  if (file) imu.noise_file = *noise;
}

/// Written where it is not the default.
template <class Fields>
void transfer_clock(Fields& f, std::string& clock) {
  std::optional<std::string> named;
  if (clock != "own") named = clock;
  f.text("clock", named);
  f.check(!named || *named == "own" || *named == "true", "clock", "\"" + named.value_or("") + "\" is not allowed; expected own or true");
  clock = named.value_or("own");
}

/// The size of an effect, among those by name; 0: the effect is absent.
template <class Fields>
void transfer_effect(Fields& f, std::string_view key, const Effect& effect, EffectSigmas& sizes) {
  std::optional<double> sigma;
  if (const auto at = sizes.find(effect.name); at != sizes.end()) sigma = at->second;
  f.number(key, sigma, within(0, 1e6, effect.unit));  // in these units far beyond any sensor
  if (sigma) sizes[std::string(effect.name)] = *sigma;
}

template <class Fields>
void transfer(Fields& f, ImuDeclaration& imu) {
  f.text("name", imu.name);
  f.text("serial", imu.serial);
  f.text("firmware", imu.firmware);
  f.text("filter", imu.filter);
  f.text("grade", imu.grade);
  f.text("truth", imu.truth);
  transfer_clock(f, imu.clock);
  f.number("accel_noise_density", imu.accel_noise_density, not_negative());
  f.number("gyro_noise_density", imu.gyro_noise_density, not_negative());
  TermSigmas& sigmas = imu.term_sigmas;
  const auto size = [](double factor) { return Number{factor, 0, 1e6, true}; };  // in these units far beyond any sensor
  f.number("quadratic_sigma_ug_per_g2", sigmas.accel_quadratic, size(unit::ug / (unit::g * unit::g)));
  f.number("cubic_sigma_ug_per_g3", sigmas.accel_cubic, size(unit::ug / (unit::g * unit::g * unit::g)));
  f.number("gyro_quadratic_sigma_ppm_per_dps", sigmas.gyro_quadratic, size(unit::ppm / unit::deg));
  f.number("gyro_cubic_sigma_ppb_per_dps2", sigmas.gyro_cubic, size(1e-9 / (unit::deg * unit::deg)));
  f.number("g_sensitivity_sigma_deg_per_h_per_g", sigmas.g_sensitivity, size(unit::deg_per_h / unit::g));
  f.number("lever_arm_sigma_mm", sigmas.lever_arm, size(1e-3));
  f.number("delay_sigma_ms", sigmas.delay, size(1e-3));
  for (const Effect& effect : effects()) transfer_effect(f, effect.declared(), effect, imu.effect_sigmas);
  transfer_noise(f, imu);
  f.template table_of<NoiseModel>("accel_noise", imu.accel_noise, [](Fields& t, NoiseModel& n) { transfer(t, n); });
  f.template table_of<NoiseModel>("gyro_noise", imu.gyro_noise, [](Fields& t, NoiseModel& n) { transfer(t, n); });
  f.template table_of<EffectSigmas>("effects", imu.simulated_effects, [](Fields& t, EffectSigmas& sizes) {
    for (const Effect& effect : effects()) transfer_effect(t, effect.simulated(), effect, sizes);
  });
}

template <class Fields>
void transfer(Fields& f, Reference& reference) {
  f.choice("quantity", reference.quantity, {"acceleration", "rotation", "time", "temperature"}, Presence::required);
  f.text("instrument", reference.instrument);
  f.text("certificate", reference.certificate);
  transfer_name(f, "date", reference.date);
  transfer_name(f, "statement", reference.statement);
  f.check(!reference.instrument.empty(), "instrument", "is empty; expected make, type and serial number");
  f.check(!reference.certificate.empty(), "certificate", "is empty; expected its number");
  f.check(reference.date.empty() || is_date(reference.date), "date", "is no date; expected one as in \"2026-03-31\"");
}

/// Who measured, where and when: the keys of a session before its tables.
template <class Fields>
void transfer(Fields& f, Session& session) {
  f.text("operator", session.operated_by);
  f.text("station", session.station);
  f.text("measured", session.measured);
  f.check(!session.measured || time_of(*session.measured), "measured", "is no time; expected UTC as in \"2026-03-31\" or \"2026-03-31T12:00:00Z\"");
  f.text("valid_until", session.valid_until);
  f.check(!session.valid_until || is_date(*session.valid_until), "valid_until", "is no date; expected one as in \"2026-03-31\"");
  f.text("warm_up", session.warm_up);
  f.text("power_cycles", session.power_cycles);
}

/// The treatment of the height and its aid.
template <class Fields>
void transfer_navigation(Fields& f, Session& session) {
  std::string vertical(session.vertical ? to_string(*session.vertical) : "");
  f.choice("vertical", vertical, {"free", "fixed", "aided", "held"}, Presence::optional);
  for (const VerticalChannel each : {VerticalChannel::free, VerticalChannel::fixed, VerticalChannel::aided, VerticalChannel::held})
    if (vertical == to_string(each)) session.vertical = each;
  f.text("barometer", session.barometer_file);
}

template <class Fields>
void transfer(Fields& f, Site& site) {
  f.number("latitude_deg", site.latitude, within(-90, 90, unit::deg));
  f.number("latitude_sigma_deg", site.latitude_sigma, within(0, 90, unit::deg));
  f.number("longitude_deg", site.longitude, within(-180, 360, unit::deg));
  f.number("height_m", site.height, within(-12e3, 100e3));
  f.number("gravity_mps2", site.given_gravity, within(9, 10.5));  // not 1 (g), not 980 (cm/s^2)
  f.number("gravity_sigma_mps2", site.given_gravity_sigma, not_negative());
}

/// The fields of a turntable, or of a hand.
template <class Fields>
void transfer_axes(Fields& f, RigDeclaration& rig) {
  f.spread("angle_sigma_arcsec", rig.angle, unit::arcsec);
  f.spread("orthogonality_sigma_arcsec", rig.orthogonality, unit::arcsec);
  for (const auto& [key, angle] : {std::pair{"angle_sigma_arcsec", &rig.angle}, std::pair{"orthogonality_sigma_arcsec", &rig.orthogonality}})
    f.check(angle->value <= 45 * unit::deg, key, "is beyond 45 deg; expected the error of a turntable or a hand (in memory it is in radians)");
  f.spread("timing_sigma_ms", rig.timing, 1e-3);
  const std::vector axes{RigAxis::inner, RigAxis::middle, RigAxis::outer};
  f.table("orthogonality_arcsec", Presence::optional, [&](Fields& t) {
    for (const RigAxis a : axes) t.pair(to_string(a), rig.given_orthogonality[static_cast<std::size_t>(a)], any_number(unit::arcsec));
  });
  f.table("zero_arcsec", Presence::optional, [&](Fields& t) {
    for (const RigAxis a : axes) t.number(to_string(a), rig.given_zero[static_cast<std::size_t>(a)], any_number(unit::arcsec));
  });
}

/// The fields of a rate table, centrifuge or chamber.
template <class Fields>
void transfer_machine(Fields& f, RigDeclaration& rig) {
  f.spread("mount_sigma_arcsec", rig.mount, unit::arcsec);
  if (rig.kind != RigKind::chamber) {
    f.spread("rate_sigma_ppm", rig.rate, unit::ppm);
    f.spread("radius_sigma_mm", rig.radius, 1e-3);
  } else {
    transfer_size(f, "ramp_K_per_min", rig.ramp, 1.0 / 60);
    transfer_size(f, "time_constant_s", rig.time_constant);
    transfer_size(f, "hysteresis_K", rig.hysteresis);
  }
}

template <class Fields>
void transfer(Fields& f, RigDeclaration& rig, bool several) {
  transfer_name(f, "name", rig.name);
  f.choice("kind", rig.kind, std::vector{RigKind::turntable, RigKind::rate_table, RigKind::centrifuge, RigKind::chamber, RigKind::none});
  f.check(!several || !rig.name.empty(), "name", "is missing; expected because there are several rigs");
  f.spread("zero_sigma_arcsec", rig.zero, unit::arcsec);
  if (rig.kind == RigKind::turntable || rig.kind == RigKind::none) {
    transfer_axes(f, rig);
  } else {
    transfer_machine(f, rig);
  }
}

template <class Fields>
void transfer(Fields& f, TimeSource& time) {
  std::vector<std::string_view> units = unit_names(Quantity::time, false);
  units.insert(units.end(), {"tick", "sample"});
  f.column("column", time.column);
  f.choice("unit", time.unit, units, Presence::required);
  f.check(time.column || time.unit == "sample", "column", "is missing; expected the column of the stamps (or unit = \"sample\" and rate_hz)");
  f.column("fraction_column", time.fraction_column);
  if (time.fraction_column) {
    f.check(time.unit == "s", "fraction_column", "is added to seconds; expected unit = \"s\"");
    f.choice("fraction_unit", time.fraction_unit, {"ms", "us", "ns"}, Presence::required);
  }
  f.number("ticks_per_s", time.ticks_per_s, within(1e-3, 1e12));
  f.check((time.unit == "tick") == time.ticks_per_s.has_value(), "ticks_per_s",
          time.unit == "tick" ? "is missing; expected because the unit is tick" : "is of unit = \"tick\"; expected none");
  std::optional<double> bits = time.wrap_bits;
  f.number("wrap_bits", bits, within(8, 32));
  f.check(!bits || *bits == std::floor(*bits), "wrap_bits", "is no whole number; expected 16, 32 or another from 8 to 32");
  if (bits) time.wrap_bits = static_cast<int>(*bits);
  f.clock_zero("zero", time.zero, time_exponent(time.unit));
  f.check(time.zero >= 0, "zero",
          "is negative, but it is subtracted from every stamp; expected the stamp from which times count, as the first one, in the column's unit");
  f.choice("scale", time.scale, std::vector{TimeScale::own, TimeScale::gps, TimeScale::utc}, Presence::optional);
  f.choice("stamps", time.stamps, std::vector{Stamps::automatic, Stamps::recorded, Stamps::uniform}, Presence::optional);
}

/// The file, topic and clock of a triad or thermometer that has its own.
template <class Fields, class Source>
void transfer_place(Fields& f, Source& source) {
  f.text("file", source.file);
  f.text("topic", source.topic);
  f.template table_of<TimeSource>("time", source.time, [](Fields& t, TimeSource& time) { transfer(t, time); });
}

template <class Fields>
void transfer(Fields& f, TriadSource& triad, Quantity quantity) {
  transfer_place(f, triad);
  f.columns("columns", triad.columns, {3});
  f.axes("axes", triad.axes);
  f.choice("output", triad.output, std::vector{Output::rate, Output::increment});
  f.choice("unit", triad.unit, unit_names(quantity, triad.output == Output::increment), Presence::required);
  f.choice("integers", triad.integers,
           std::vector{Integers::as_written, Integers::int16, Integers::uint16, Integers::int24, Integers::uint24, Integers::int32, Integers::uint32},
           Presence::optional);
  f.number("counts_per_unit", triad.counts_per_unit, positive());
  f.check(!triad.counts_per_unit || triad.unit != "count", "counts_per_unit", "is of counts; expected the physical unit that so many counts are");
  f.pair("limits", triad.limits, any_number());
  f.check(!triad.limits || (*triad.limits)[0] < (*triad.limits)[1], "limits", "are not in order; expected [lower, upper]");
}

/// True for the check of sessions that were made in memory, and may be of arrays.
template <class Fields>
inline constexpr bool is_of_arrays = requires {
  Fields::of_arrays;
};

/// A triad that a recording of a file may lack: it then has no columns, as no triad of arrays has. Returns whether it is there.
template <class Fields>
bool transfer_triad(Fields& f, std::string_view key, TriadSource& triad, Quantity quantity) {
  std::optional<TriadSource> given;
  if (!triad.columns.empty() || is_of_arrays<Fields>) given = triad;
  f.template table_of<TriadSource>(key, given, [quantity](Fields& t, TriadSource& source) { transfer(t, source, quantity); });
  if (given) triad = *given;
  return given.has_value();
}

template <class Fields>
void transfer(Fields& f, ThermalSource& thermal) {
  transfer_place(f, thermal);
  f.columns("columns", thermal.columns, {1, 3});
  f.choice("unit", thermal.unit, unit_names(Quantity::temperature, false), Presence::required);
  transfer_size(f, "noise", thermal.noise);
  f.number("at_25_degC", thermal.at_25_degC, any_number());
  f.number("per_K", thermal.per_K, any_number());
  f.check(thermal.at_25_degC.has_value() == thermal.per_K.has_value(), thermal.per_K ? "per_K" : "at_25_degC",
          "is given alone; expected both at_25_degC and per_K, or neither");
  f.check(thermal.per_K != 0.0, "per_K", "is 0; expected a reading that changes with temperature");
}

template <class Fields>
void transfer(Fields& f, RecordingSource& recording) {
  f.text("file", recording.file);
  transfer_name(f, "topic", recording.topic);
  transfer_name(f, "imu", recording.imu);
  transfer_name(f, "layout", recording.layout);
  transfer_name(f, "rig", recording.rig);
  f.number("rate_hz", recording.rate_hz, sampling_rate());
  f.choice("extent", recording.extent, std::vector{Extent::all, Extent::steps}, Presence::optional);
  f.table("time", Presence::required, [&](Fields& t) { transfer(t, recording.time); });
  f.check(recording.time.unit != "sample" || recording.rate_hz, "rate_hz", "is missing; expected because time is in samples");
  const bool gyro = transfer_triad(f, "gyro", recording.gyro, Quantity::gyro), accel = transfer_triad(f, "accel", recording.accel, Quantity::accel);
  f.check(gyro || accel || is_of_arrays<Fields>, "gyro", "is missing; expected the columns of gyro, of accel, or of both");
  f.template table_of<ThermalSource>("gyro_temperature", recording.gyro_temperature, [](Fields& t, ThermalSource& s) { transfer(t, s); });
  f.template table_of<ThermalSource>("accel_temperature", recording.accel_temperature, [](Fields& t, ThermalSource& s) { transfer(t, s); });
}

template <class Fields>
void transfer(Fields& f, InitialState& initial) {
  f.number("time_s", initial.time, or_default(clock_time()));
  f.number("latitude_deg", initial.latitude, within(-90, 90, unit::deg));
  f.number("longitude_deg", initial.longitude, within(-180, 360, unit::deg));
  f.number("height_m", initial.height, within(-12e3, 1e6));
  f.numbers("velocity_enu_mps", initial.velocity_enu, within(-1e5, 1e5));
  f.number("roll_deg", initial.roll, within(-360, 360, unit::deg));
  f.number("pitch_deg", initial.pitch, within(-90, 90, unit::deg));
  f.number("heading_deg", initial.heading, within(-360, 360, unit::deg));
}

}  // namespace imulab::session_fields
