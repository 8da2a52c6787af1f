#include "imulab/report/calibration_facts.hpp"

#include "imulab/core/stamp_text.hpp"
#include "imulab/earth.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/report/html.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

namespace imulab::report {

namespace {

/// The row of the calibration's method; of one that is not known, a row without instruments.
const Method& method_of(const Calibration& c) {
  static constexpr Method unknown{};
  const Method* found = find_method(c.method);
  return found == nullptr ? unknown : *found;
}

}  // namespace

std::string gravity_text(const Site& site) {
  if (!site.given_gravity && !site.latitude) return {};
  return fmt::format("{:.6f} m/s² (u = {} m/s²), {}", site.gravity(), number_text(site.gravity_sigma(), 2),
                     site.given_gravity ? (site.given_gravity_sigma ? "declared" : "declared; its uncertainty is assumed")
                     : site.height      ? "WGS-84 normal gravity at latitude and height"
                                        : "WGS-84 normal gravity at latitude, height unknown");
}

namespace {

/// "angle 30 arcsec, timing 10 ms (one sigma, declared)"; empty: none are declared.
std::string declared_errors(const RigDeclaration& rig) {
  struct DeclaredError {
    const char* name;
    const Spread* size;
    double factor;
    const char* unit;
  };
  std::string text;
  for (const auto& [name, size, factor, unit] :
       {DeclaredError{"angle", &rig.angle, unit::arcsec, "arcsec"}, DeclaredError{"orthogonality", &rig.orthogonality, unit::arcsec, "arcsec"},
        DeclaredError{"zero", &rig.zero, unit::arcsec, "arcsec"}, DeclaredError{"timing", &rig.timing, 1e-3, "ms"},
        DeclaredError{"mount", &rig.mount, unit::arcsec, "arcsec"}, DeclaredError{"rate", &rig.rate, unit::ppm, "ppm"},
        DeclaredError{"radius", &rig.radius, 1e-3, "mm"}})
    if (size->value != 0) text += fmt::format("{}{} {} {}", text.empty() ? "" : ", ", name, number_text(size->value / factor, 4), unit);
  return text.empty() ? "" : ", " + text + " (one sigma, declared)";
}

}  // namespace

std::string rigs_text(const Session& session) {
  std::string text;
  for (const RigDeclaration& rig : session.rigs)
    if (rig.kind != RigKind::none)
      text += fmt::format("{}{}{}{}", text.empty() ? "" : "; ", rig.name.empty() ? "" : rig.name + ": ", to_string(rig.kind), declared_errors(rig));
  return text.empty() ? "none: turned by hand or on a support" : text;
}

std::string temperature_text(const TriadModel& m) {
  if (!m.temperature) return {};
  const ThermalReading& t = *m.temperature;
  return fmt::format("{} to {} {}, reference {}", number_text(t.range[0], 4), number_text(t.range[1], 4), t.unit, number_text(t.reference, 4));
}

std::string frame_text(const Calibration& c) {
  return c.frame == BodyFrame::rig ? "the rig's axes"
                                   : "x along the x accelerometer, y in the plane of the x and y accelerometers, z completes the right-handed triad";
}

std::string declared_name(const Calibration& c) {
  const bool of_log = !c.sources.empty() && c.session_file == c.sources.front().file;
  return of_log && c.imu == std::filesystem::path(c.session_file).stem() ? "" : c.imu;
}

std::string thermal_readings(const Calibration& c) {
  std::optional<std::array<double, 2>> all;
  for (const SourceFile& source : c.sources)
    for (const auto& range : {source.accel_temperature, source.gyro_temperature})
      if (range) all = all ? std::array{std::min((*all)[0], (*range)[0]), std::max((*all)[1], (*range)[1])} : *range;
  const std::string unit = c.model.accel.temperature  ? c.model.accel.temperature->unit
                           : c.model.gyro.temperature ? c.model.gyro.temperature->unit
                                                      : "";
  return all ? fmt::format("{} to {} {}", number_text((*all)[0], 4), number_text((*all)[1], 4), unit) : "";
}

bool has_estimated(const Calibration& c, Term term, Triad triad) {
  return std::any_of(c.estimated.begin(), c.estimated.end(),
                     [&](CoefficientIndex i) { return coefficient(i).term == term && coefficient(i).triad == triad; });
}

std::string model_equation(const Calibration& c) {
  std::string fixed;
  for (const Triad triad : {Triad::accel, Triad::gyro})
    for (const Term term : terms_of(triad))
      if (is_optional(term) && !has_estimated(c, term, triad))
        fixed += fmt::format("{}{}.{}", fixed.empty() ? "" : ", ", to_string(triad), to_string(term));
  std::string reference;
  for (const auto& [triad, name] : {std::pair{&c.model.accel, "accelerometers"}, {&c.model.gyro, "gyros"}})
    if (triad->temperature)
      reference +=
          fmt::format("{}{} {} ({})", reference.empty() ? "" : ", ", number_text(triad->temperature->reference, 6), triad->temperature->unit, name);
  return "<p><code>V = U − (c1 τ + c2 τ² + c3 τ³), τ = T − T0<br>a = S (A0 + A1 Va + A2 Va² + A3 Va³)<br>w = S (W0 + W1 Vg + W2 Vg² + W3 Vg³) + C "
         "a<br>S = I + M1 τ + M2 τ²</code></p>\n" +
         paragraph(
             "U: readings; V: readings less their temperature dependence; a: specific force; w: angular rate; offsets A0, W0; matrices A1, W1; "
             "quadratic and "
             "cubic terms diagonal; C: g-sensitivity, minus the false rate.") +
         (reference.empty() ? "" : paragraph("T0: " + reference + ".")) +
         (fixed.empty() ? "" : paragraph("Not estimated as a term of its own: " + fixed + "."));
}

std::string ranges_text(const CalibrationReport& report) {
  double rate = 0, force = 0;
  for (const RecordingEvidence& e : report.recordings) rate = std::max(rate, e.largest_rate), force = std::max(force, e.largest_force);
  return rate > 0 || force > 0 ? fmt::format("up to {} deg/s and {} g", number_text(rate / unit::deg), number_text(force / unit::g)) : "";
}

std::string test_text(const Calibration& c, const CalibrationReport& report) {
  const Method* method = find_method(c.method);
  if (method == nullptr) return "";
  if (!method->test.empty() || !report.session) return std::string(method->test);
  std::string text;
  for (const auto& [kind, name] : {std::pair{RigKind::chamber, "thermal soaks"},
                                   {RigKind::rate_table, "rate table: scale factor, nonlinearity, misalignment"},
                                   {RigKind::centrifuge, "centrifuge"},
                                   {RigKind::turntable, "multi-position (tumble)"}})
    if (std::any_of(report.session->rigs.begin(), report.session->rigs.end(), [k = kind](const RigDeclaration& rig) { return rig.kind == k; }))
      text += fmt::format("{}{}", text.empty() ? "" : "; ", name);
  return text;
}

std::string positions_text(const Quality& q) {
  double least = HUGE_VAL, most = 0, all = 0;
  std::size_t used = 0;
  for (const PartResidual& rest : q.rests) {
    if (!rest.used) continue;
    const double held = rest.end_s - rest.begin_s;
    least = std::min(least, held), most = std::max(most, held), all += held, ++used;
  }
  if (used == 0) return "";
  const std::string shortest = number_text(least), longest = number_text(most), range = shortest == longest ? shortest : shortest + " to " + longest;
  return fmt::format("{} rest{} of {} s, {} s together; {} rotation{}", used, used == 1 ? "" : "s", range, number_text(all), q.rotations.size(),
                     q.rotations.size() == 1 ? "" : "s");
}

std::string latitude_text(const Site& site) {
  if (!site.latitude) return "";
  const std::string sigma = site.latitude_sigma ? fmt::format(" (u = {} deg)", number_text(*site.latitude_sigma / unit::deg, 2)) : "";
  const Eigen::Vector3d rate = earth_rate_enu(*site.latitude) / unit::deg_per_h;
  return fmt::format("{} deg{}: the Earth turns by {} deg/h about north and {} deg/h about up", number_text(*site.latitude / unit::deg, 7), sigma,
                     number_text(rate.y(), 5), number_text(rate.z(), 5));
}

namespace {

/// By what the recorder's clock is read. Without the session by the uncertainty that a nominal rate alone has.
std::string clock_origin(const CalibrationReport& report) {
  const auto has_stamps = [](const RecordingSource& r) { return r.time.column.has_value(); };
  if (report.session) return std::ranges::all_of(report.session->recordings, has_stamps) ? ", as its stamps say" : ", as its nominal rate says";
  constexpr double nominal = 0.01;  // half of what state_clock allows a clock without stamps
  const std::optional<ClockScale>& clock = report.result.calibration.clock;
  return !clock ? "" : clock->sigma > nominal ? ", as its nominal rate says" : ", as its stamps say";
}

}  // namespace

bool calibrated_here(const Calibration& c) {
  return std::any_of(methods().begin(), methods().end(), [&c](const Method& method) { return method.name == c.method; });
}

std::vector<Origin> origins_of(const CalibrationReport& report) {
  const Calibration& c = report.result.calibration;
  if (!calibrated_here(c)) {
    constexpr const char* unknown = "not on record";
    return {{"acceleration", "acceleration", unknown, ""}, {"rotation", "angle and rate", unknown, ""}, {"time", "time", unknown, ""}};
  }
  const std::string g = report.session ? gravity_text(report.session->site) : "";
  const auto stop = [](const RigDeclaration& rig) {
    return rig.kind == RigKind::none && rig.angle.value != 0;
  };  // for turns by hand of a known angle
  using Instrument = Method::Instrument;
  const Instrument instrument = method_of(c).instrument;
  const bool machine = instrument == Instrument::always ||
                       (instrument == Instrument::where_declared && report.session && std::ranges::any_of(report.session->rigs, stop));
  const bool computed = report.session && !report.session->site.given_gravity;
  std::vector<Origin> out{
      {"acceleration", "acceleration", g.empty() ? "gravity at the site" : "gravity at the site: " + g,
       computed ? "not used: gravity was not declared but computed" : ""},
      {"rotation", "angle and rate", std::string(method_of(c).angle_source), machine ? "" : "not used: the method takes no angle from an instrument"},
      {"time", "time", "the recorder's clock" + clock_origin(report), ""}};
  if (c.model.accel.temperature || c.model.gyro.temperature) out.push_back({"temperature", "temperature", "the recording's own readings", ""});
  return out;
}

std::array<std::string, 2> measured_days(const Calibration& c) {
  if (!c.measured.empty()) return {c.measured.substr(0, 10), c.measured.substr(0, 10)};
  std::string first, last;
  for (const SourceFile& source : c.sources) {
    const std::string begin = date_text(source.first_s).substr(0, 10), end = date_text(source.last_s).substr(0, 10);
    if (begin.empty() || end.empty()) return {};
    if (first.empty() || begin < first) first = begin;
    last = std::max(last, end);
  }
  return {first, last};
}

std::string measured_text(const Calibration& c) {
  if (!c.measured.empty()) return c.measured;
  const auto [first, last] = measured_days(c);
  return first == last ? first : first + " to " + last;
}

std::string why_unused(const Origin& origin, const Reference& reference, const Calibration& c) {
  if (!origin.unused.empty()) return std::string(origin.unused);
  const std::string last = measured_days(c)[1];
  const auto issued = time_of(reference.date), measured = time_of(last);
  if (!issued || !measured || *issued <= *measured) return "";
  return fmt::format("not used: dated after the measurement of {}, for which it says nothing", last);
}

std::string certificate_text(const Reference& r, std::string_view unused) {
  std::string text = r.certificate + (r.date.empty() ? "" : " of " + r.date) + (r.statement.empty() ? "" : ": " + r.statement);
  return escaped(shortened(text, 1000)) + (unused.empty() ? "" : fmt::format(" ({})", unused));
}

std::string traceability_text(const std::string& with, const std::string& without, bool any) {
  if (with.empty() && any) return "Not traceable: no declared certificate is of what this calibration uses.";
  if (with.empty()) return "Not traceable: none of the references below has a certificate in the calibration or its session.";
  const std::string declared = fmt::format("Traceable as the session declares it, by certificates that imulab does not check: {}.", with);
  return without.empty() ? declared : fmt::format("{} Not traceable: {}.", declared, without);
}

}  // namespace imulab::report
