#include "imulab/formats/session/mission_errors.hpp"

#include "imulab/core/units.hpp"

namespace imulab::session_io {

namespace {

using namespace unit;

void spread(TomlFields& f, std::string_view key, std::optional<Spread>& value, double factor) {
  if (f.has(key)) f.spread(key, value.emplace(), factor);
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
  f.check(!s.aligned_over || (s.attitude[0].value == 0 && s.attitude[2].value == 0), "aligned_over_s",
          "cannot be combined with tilt_arcmin or heading_arcmin; expected an alignment or given errors");
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
