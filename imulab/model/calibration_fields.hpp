// The fields of a calibration in its file, each defined once (core/fields.hpp; docs/reference/calibration-file.md).
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"
#include "imulab/core/fields.hpp"
#include "imulab/units.hpp"

#include <algorithm>

namespace imulab {

inline constexpr std::array quality_verdicts{Verdict::none, Verdict::good, Verdict::doubtful};
inline constexpr std::array body_frames{BodyFrame::accelerometers, BodyFrame::rig};

template <class Fields>
void describe(Fields& f, Reference& r) {
  f("quantity", r.quantity), f("instrument", r.instrument), f("certificate", r.certificate), f("date", r.date, fields::or_empty);
  f("statement", r.statement, fields::or_empty);
}

template <class Fields>
void describe(Fields& f, SourceFile& s) {
  f("file", s.file), f("sha256", s.sha256), f("bytes", s.bytes), f("first_s", s.first_s), f("last_s", s.last_s);
  f("accel_temperature", s.accel_temperature, fields::optional), f("gyro_temperature", s.gyro_temperature, fields::optional);
  f("topic", s.topic, fields::if_any);
}

template <class Fields>
void describe(Fields& f, RecordedAs& r) {
  f("unit", r.unit), f("counts_per_unit", r.counts_per_unit), f("interval_s", r.interval_s, fields::or_empty);
  f("axes", r.axes, {.things = "axes"});
}

template <class Fields>
void describe(Fields& f, ThermalReading& t) {
  f("unit", t.unit);
  fields::expect(f, t.unit == "degC" || t.unit == "K" || t.unit == "raw", "unit", "degC, K or raw");
  f("reference", t.reference), f("range", t.range, fields::optional);  // absent: unknown
  fields::expect(f, t.range[0] <= t.range[1], "range", "[lowest, highest]");
}

template <class Fields>
void describe(Fields& f, RequirementResult& r) {
  f("requirement", r.text), f("coefficient", r.coefficient), f("limit", r.limit), f("reached", r.reached, fields::or_infinity), f("met", r.met);
  f("note", r.note, fields::if_any);
}

template <class Fields>
void describe(Fields& f, TermTest& t) {
  f("term", t.term), f("statistic", t.statistic, fields::or_nan), f("degrees_of_freedom", t.degrees_of_freedom);
  f("p_value", t.p_value, fields::or_nan), f("kept", t.kept), f("cross_validation_with", t.cross_validation_with, fields::or_empty);
  f("cross_validation_without", t.cross_validation_without, fields::or_empty);
}

template <class Fields>
void describe(Fields& f, UncertaintySource& s) {
  f("name", s.name), f("relative", s.relative, fields::or_nan), f("consequence", s.consequence);
}

template <class Fields>
void describe(Fields& f, FitResidual& r) {
  f("axis", r.axis), f("rms", r.rms, fields::or_nan), f("largest", r.largest, fields::or_nan), f("full_scale", r.full_scale, fields::or_nan);
}

template <class Fields>
void describe(Fields& f, RigErrorEstimate& e) {
  f("name", e.name), f("declared_sigma", e.declared_sigma, fields::or_nan), f("value", e.value, fields::or_nan);
  f("standard_uncertainty", e.uncertainty, fields::or_nan);
}

template <class Fields>
void describe(Fields& f, PartResidual& p) {
  f("begin_s", p.begin_s), f("end_s", p.end_s), f("residual", p.residual, fields::or_nan), f("used", p.used);
  f("recording", p.recording, fields::if_any);
}

template <class Fields>
void describe(Fields& f, EffectEstimate& e) {
  f("name", e.name), f("unit", e.unit), f("values", e.values), f("sigma", e.sigma, fields::or_nan), f("significant", e.significant);
}

template <class Fields>
void describe(Fields& f, UnitSize& u) {
  f("factor", u.factor), f("factor_sigma", u.factor_sigma), f("grade", u.grade), f("weights", u.weights, fields::if_any);
}

template <class Fields>
void describe(Fields& f, SecondOpinion& s) {
  f("method", s.method), f("coefficient", s.coefficient), f("sigmas", s.sigmas, fields::or_nan);
}

template <class Fields>
void describe(Fields& f, Finding& x) {
  fields::via(
      f, "code", [&] { return std::string(name_of(x.code)); }, [&](const std::string& name) { x.code = code_of(name); });
  fields::choice(f, "severity", x.severity, std::array{Severity::note, Severity::warning, Severity::doubt}, "note, warning or doubt");
  f("subject", x.subject, fields::if_any), f("numbers", x.numbers, fields::if_any), f("text", x.text), f("advice", x.advice, fields::if_any);
  f("place", x.place, fields::if_any);
}

/// Describes the findings and their sentences by severity. A sentence without a finding, as in files of earlier versions, becomes one without a code.
template <class Fields>
void describe_findings(Fields& f, Quality& q) {
  std::vector<std::string> warnings = q.findings.warnings(), because = q.findings.reasons(), notes = q.findings.notes();
  f("warnings", warnings, fields::optional);
  fields::choice(f, "verdict", q.verdict, quality_verdicts, "good or doubtful", fields::optional);
  f("because", because, fields::optional), f("notes", notes, fields::optional), f("findings", q.findings, fields::if_any);
  if constexpr (Fields::reads) {
    const auto complete = [&](Severity severity, std::vector<std::string> texts, const std::vector<std::string>& known) {
      std::erase_if(texts, [&](const std::string& text) { return std::ranges::find(known, text) != known.end(); });
      q.findings.append(severity, texts);
    };
    complete(Severity::doubt, because, q.findings.reasons()), complete(Severity::warning, warnings, q.findings.warnings());
    complete(Severity::note, notes, q.findings.notes());
  }
}

/// Describes the quality; files of earlier versions, and files written by hand, lack optional fields.
template <class Fields>
void describe(Fields& f, Quality& q) {
  f("chi2_per_dof", q.chi2_per_dof, fields::if_known), f("degrees_of_freedom", q.degrees_of_freedom, fields::optional);
  f("condition", q.condition, fields::if_known), f("converged", q.converged, fields::optional), f("unobservable", q.unobservable, fields::optional);
  describe_findings(f, q);
  f("requirements", q.requirements, fields::optional), f("considered", q.considered, fields::optional);
  f("rotation_residual_deg", q.rotation_residual_deg, fields::optional), f("term_tests", q.term_tests, fields::optional);
  f("effects", q.effects, fields::if_any), f("unit_size", q.unit_size, fields::if_any), f("cause", q.cause, fields::if_any),
      f("second_opinion", q.second_opinion, fields::optional);
  f("sources", q.sources, fields::optional), f("fit_residuals", q.fit_residuals, fields::optional), f("rig_errors", q.rig_errors, fields::optional);
  f("rests", q.rests, fields::optional), f("rotations", q.rotations, fields::optional);
}

/// Describes thermal terms. Files of earlier versions have none of the third order.
template <class Fields>
void describe_thermal(Fields& f, TriadModel& m) {
  if constexpr (Fields::reads) {
    bool earlier = false;
    f.attempt([&] { earlier = f.at().has("thermal") && f.at()["thermal"].item(0, 3, "rows of 4 numbers").size() == 3; });
    if (earlier) {
      Matrix3d terms = Matrix3d::Zero();
      f("thermal", terms);
      m.thermal << terms, Vector3d::Zero();
    } else {
      f("thermal", m.thermal, fields::optional);
    }
    for (std::size_t axis = 0; axis < 3 && f.at().has("thermal"); ++axis)
      f.attempt([&] {
        const auto constant = f.at()["thermal"].item(axis, 3, "rows of 4 numbers").item(0, earlier ? 3 : 4, "numbers");
        if (constant.number() != 0) constant.expected("0: the constant of the thermal polynomial is zero by definition (it belongs in the offset)");
      });
  } else {
    f("thermal", m.thermal);
  }
  f("matrix_thermal1", m.matrix_thermal1, fields::if_any), f("matrix_thermal2", m.matrix_thermal2, fields::if_any);
}

/// Describes a triad. The matrix is required; other missing terms are zero. `coupling` is the accelerometers' lever arm or the gyros' g-sensitivity.
template <class Fields>
void describe_triad(Fields& f, TriadModel& m, const char* coupling_key, Matrix3d& coupling) {
  f("offset", m.offset, fields::optional), f("matrix", m.matrix), f("quadratic", m.quadratic, fields::optional);
  f("cubic", m.cubic, fields::optional);
  describe_thermal(f, m);
  f(coupling_key, coupling, fields::optional), f("raw", m.raw_unit, fields::if_any), f("temperature", m.temperature, fields::optional);
  if constexpr (Fields::reads) {
    const std::string why = "expected a reading with its reference, because the thermal terms are not zero";
    const bool there = f.at().has("temperature"), wrong = !m.temperature && m.varies() && (!there || f.at()["temperature"].is_null());
    fields::check(f, !wrong, there ? "temperature" : "", there ? why : "temperature: is missing; " + why);
  }
  fields::known_keys_only(f);
}

template <class Fields>
void describe(Fields& f, SensorModel& model) {
  f.table("accel", [&](auto& triad) { describe_triad(triad, model.accel, "lever_arm", model.lever_arm); });
  f.table("gyro", [&](auto& triad) { describe_triad(triad, model.gyro, "g_sensitivity", model.g_sensitivity); });
  fields::known_keys_only(f);
}

template <class Fields>
void describe(Fields& f, ClockScale& c) {
  f("seconds", c.seconds), f("gain_ppm", c.gain, fields::in(unit::ppm)), f("sigma_ppm", c.sigma, fields::in(unit::ppm));
  fields::expect(f, c.seconds == "own" || c.seconds == "true", "seconds", "\"own\" or \"true\"");
}

template <class Fields>
void describe(Fields& f, RestNoise& n) {
  f("accel", n.accel), f("gyro", n.gyro), f("interval_s", n.interval_s), f("rests", n.rests), f("seconds", n.seconds);
  fields::expect(f, n.accel.minCoeff() >= 0, "accel", "densities from 0 on");
  fields::expect(f, n.gyro.minCoeff() >= 0, "gyro", "densities from 0 on");
  fields::expect(f, n.interval_s > 0, "interval_s", "a positive time");
}

template <class Fields>
void describe(Fields& f, TurnOn& t) {
  f("accel", t.accel), f("gyro", t.gyro);
  fields::expect(f, t.accel >= 0 && t.gyro >= 0, "accel", "sigmas from 0 on");
}

/// Describes a calibration. describe_uncertainties(fields, calibration), next to each visitor, has the uncertainties and the covariance.
template <class Fields>
void describe(Fields& f, Calibration& c) {
  fields::derived(f, "format", "imulab.calibration/1");
  f("imu", c.imu, fields::optional), f("serial", c.serial, fields::or_empty), f("operator", c.operated_by, fields::or_empty);
  f("station", c.station, fields::or_empty), f("measured", c.measured, fields::or_empty), f("firmware", c.firmware, fields::or_empty);
  f("filter", c.filter, fields::or_empty), f("valid_until", c.valid_until, fields::or_empty), f("warm_up", c.warm_up, fields::or_empty);
  f("power_cycles", c.power_cycles, fields::or_empty), f("references", c.references, fields::optional), f("method", c.method, fields::optional);
  f("created", c.created, fields::optional), f("software", c.software, fields::optional);
  const auto session = [&](auto& t) { t("file", c.session_file, fields::optional), t("sha256", c.session_sha256, fields::optional); };
  f.table("session", session, fields::optional);
  f("sources", c.sources, fields::optional), f("options", c.options, fields::optional);
  if (Fields::reads) c.frame = BodyFrame::rig;
  fields::choice(f, "frame", c.frame, body_frames, "\"accelerometers\" or \"rig\"", fields::optional);
  f("clock", c.clock, fields::if_any);
  f("model", c.model);
  describe_uncertainties(f, c);
  f("quality", c.quality, fields::optional);
  f("turn_on", c.turn_on, fields::if_any);
  f("standard_uncertainty_next_switch_on", c.next_switch_on, fields::if_any);
  const std::vector<CoefficientIndex> offsets = select_each({"accel.offset", "gyro.offset"});
  for (const auto& next : c.next_switch_on)
    fields::expect(f, next.second >= 0 && std::ranges::any_of(offsets, [&](CoefficientIndex k) { return coefficient(k).name == next.first; }),
                   "standard_uncertainty_next_switch_on", "uncertainties of offsets, from 0 on");
  f("rest_noise", c.rest_noise, fields::if_any);
  const auto recorded = [&](auto& t) { t("accel", c.recorded_accel, fields::if_any), t("gyro", c.recorded_gyro, fields::if_any); };
  if (Fields::reads || c.recorded_accel || c.recorded_gyro) f.table("recorded", recorded, fields::optional);
  fields::derived(f, "rig", std::map<std::string, double>(), fields::if_any);  // present in the truth of a simulation
  fields::known_keys_only(f, true);
}

}  // namespace imulab
