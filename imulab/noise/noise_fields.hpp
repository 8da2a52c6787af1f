// The fields of noise.json, each defined once (core/fields.hpp): the noise of an IMU from one or several logs.
#pragma once

#include "imulab/core/fields.hpp"
#include "imulab/noise.hpp"
#include "imulab/noise/moving_fields.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace imulab {

/// Returns true for "gyro.x" to "accel.z".
inline bool is_axis_name(std::string_view name) {
  constexpr std::array<std::string_view, 6> names{"gyro.x", "gyro.y", "gyro.z", "accel.x", "accel.y", "accel.z"};
  return std::ranges::find(names, name) != names.end();
}

inline std::string_view to_string(DeviationKind kind) { return deviation_names[static_cast<std::size_t>(kind)]; }

template <class Fields>
void describe(Fields& f, NoiseCoefficient& c) {
  f("value", c.value, fields::or_nan), f("standard_uncertainty", c.standard_uncertainty, fields::or_infinity);  // infinite: without an upper bound
  f("lower", c.lower), f("upper", c.upper, fields::or_infinity), f("determined", c.determined);
  if (Fields::reads || c.bounded) f("bounded", c.bounded, fields::optional);
  if (Fields::reads && !c.determined && std::isinf(c.standard_uncertainty)) c.standard_uncertainty = NAN;
  fields::check(f, !c.determined || (std::isfinite(c.value) && c.standard_uncertainty > 0), "",
                "is determined without a value; expected value and a positive standard_uncertainty");
  fields::check(f, c.lower <= c.upper, "", "expected an upper bound not below the lower one");
}

/// Describes a size, which is not negative; a ramp has a sign.
template <class Fields>
void describe_size(Fields& f, const char* key, NoiseCoefficient& c) {
  f(key, c);
  fields::check(f, !(c.upper < 0 || (c.determined && c.value < 0)), key, "expected a size from 0 on");
}

template <class Fields>
void describe(Fields& f, MarkovTerm& term) {
  describe_size(f, "sigma", term.sigma), describe_size(f, "time", term.time);
}

template <class Fields>
void describe(Fields& f, NoiseLine& line) {
  f("hz", line.hz), f("amplitude", line.amplitude);
}

template <class Fields>
void describe(Fields& f, BoundProcess& process) {
  f("sigma", process.sigma), f("time", process.time);
  fields::check(f, process.sigma > 0 && process.time > 0, "", "expected a sigma and a time above zero");
}

template <class Fields>
void describe(Fields& f, BoundCoast& coast) {
  f("time_s", coast.time_s), f("ratio", coast.ratio);
}

template <class Fields>
void describe(Fields& f, NoiseBound& bound) {
  f("N", bound.N), f("markov", bound.markov), f("K", bound.K), f("start_sigma", bound.start_sigma), f("confidence", bound.confidence);
  f("horizon_s", bound.horizon_s), f("tightness", bound.tightness), f("coast", bound.coast);
  f("in_motion", bound.in_motion, fields::optional);
  f.table("upper", [&](auto& t) {
    fields::column(t, "hz", bound.upper, true, {}, [](UpperDensity& u) -> double& { return u.hz; });
    fields::column(t, "density", bound.upper, false, {}, [](UpperDensity& u) -> double& { return u.density; });
  });
  fields::check(f, bound.N >= 0 && bound.K >= 0 && bound.start_sigma >= 0 && bound.N + bound.K > 0, "",
                "expected sizes from 0 on, not all of them 0");
  fields::check(f, bound.confidence > 0.5 && bound.confidence < 1, "confidence", "expected a number from 0.5 to 1");
  fields::check(f, bound.horizon_s > 0, "horizon_s", "expected a positive time");
  const auto positive = [](const UpperDensity& u) { return u.hz > 0 && u.density > 0; };
  const auto rises = [](const UpperDensity& a, const UpperDensity& b) { return a.hz < b.hz; };
  constexpr std::size_t most = 1000;  // of a year at 1 MHz: 140
  fields::check(f,
                bound.upper.size() >= 2 && bound.upper.size() <= most && std::ranges::all_of(bound.upper, positive) &&
                    std::ranges::is_sorted(bound.upper, rises),
                "upper", "expected densities above zero at two to 1000 rising frequencies");
}

template <class Fields>
void describe(Fields& f, JointNoise& joint) {
  f("tau_s", joint.tau_s), f("deviation", joint.deviation);
  fields::check(f, joint.tau_s > 0, "tau_s", "expected a positive time");
}

template <class Fields>
void describe(Fields& f, LowPass& filter) {
  f("order", filter.order), f("digital", filter.digital), f("cutoff_hz", filter.cutoff_hz);
}

template <class Fields>
void describe(Fields& f, NoiseMisfit& misfit) {
  f("low_hz", misfit.low_hz), f("high_hz", misfit.high_hz), f("ratio", misfit.ratio, fields::or_nan);
}

template <class Fields>
void describe(Fields& f, NoiseFit& fit) {
  using P = SpectrumPoint;
  f.table("coefficients", [&](auto& t) {
    describe_size(t, "N", fit.N), describe_size(t, "B", fit.B), describe_size(t, "K", fit.K), describe_size(t, "Q", fit.Q), t("R", fit.R);
  });
  f("markov", fit.markov, fields::optional), f("lines", fit.lines, fields::optional);
  f("joint", fit.joint, fields::if_any), f("bound", fit.bound, fields::if_any), f("low_pass", fit.low_pass, fields::if_any),
      f("resolution", fit.resolution, fields::optional);
  const auto spectrum = [&](auto& t) {
    fields::column(t, "hz", fit.spectrum, true, {}, [](P& p) -> double& { return p.hz; });
    fields::column(t, "density", fit.spectrum, false, fields::or_nan, [](P& p) -> double& { return p.density; });
    fields::column(t, "model", fit.spectrum, false, fields::or_nan, [](P& p) -> double& { return p.model; });
    fields::column(t, "count", fit.spectrum, false, fields::optional, [](P& p) -> double& { return p.count; });
  };
  f.table("spectrum", spectrum, fields::optional);
  const auto quality = [&](auto& t) {
    t("chi2_per_dof", fit.chi2_per_dof, fields::or_nan), fields::derived(t, "accepted", fit.accepted());
    t("highest_hz", fit.highest_hz), t("misfits", fit.misfits);
  };
  f.table("fit", quality, fields::optional);
}

template <class Fields>
void describe(Fields& f, NoiseAxis& axis) {
  using P = DeviationPoint;
  f("name", axis.name);
  fields::expect(f, is_axis_name(axis.name), "name", "gyro.x to accel.z");
  f("unit", axis.unit);
  f("mean", axis.mean, fields::if_known);
  const auto column = [&](const char* key, auto member) {
    const bool first = key == std::string_view("tau");
    fields::column(f, key, axis.deviation, first, fields::if_known, [member](P& p) -> decltype(auto) { return (p.*member); });
  };
  column("tau", &P::tau), column("deviation", &P::deviation), column("terms", &P::terms), column("noise_type", &P::noise_type),
      column("edf", &P::edf);
  column("lower", &P::lower_95), column("upper", &P::upper_95), column("lower_68", &P::lower_68), column("upper_68", &P::upper_68);
  if constexpr (Fields::reads)
    if (f.at().has("coefficients")) axis.fit.emplace();
  if (axis.fit)
    describe(f, *axis.fit);
  else
    f("problem", axis.problem, fields::optional);
}

template <class Fields>
void describe(Fields& f, SheetComparison& c) {
  f("name", c.name);
  constexpr std::array<std::string_view, 4> terms{"N", "B", "K", "stability"};
  const std::string_view name = c.name, axis = name.substr(0, name.rfind('.')), term = name.substr(std::min(axis.size() + 1, name.size()));
  fields::expect(f, is_axis_name(axis) && std::ranges::find(terms, term) != terms.end(), "name", "an axis and a term, as in gyro.x.N");
  f("sheet", c.sheet), f("value", c.value, fields::or_nan), f("lower", c.lower), f("upper", c.upper, fields::or_infinity);
  fields::derived(f, "ratio", c.ratio(), fields::or_nan), fields::derived(f, "contained", c.contained());
}

template <class Fields>
void describe(Fields& f, NoiseAnalysis& analysis) {
  using enum DeviationKind;
  fields::derived(f, "format", "imulab.noise/1");
  f("source", analysis.source, fields::if_any);
  fields::expect(f, analysis.source.empty() || analysis.source == "data sheet", "source", "\"data sheet\", or none for a log");
  f("recording", analysis.recording, fields::optional), f("interval_s", analysis.interval_s);
  fields::expect(f, analysis.interval_s > 0 || (analysis.from_data_sheet() && analysis.interval_s == 0), "interval_s", "a positive time");
  const auto still = [&](auto& t) { t("begin_s", analysis.begin_s), t("end_s", analysis.end_s), t("samples", analysis.samples); };
  f.table("still", still, fields::optional);
  fields::choice(f, "deviation", analysis.kind, std::array{overlapping_allan, allan, modified_allan, hadamard, overlapping_hadamard, total},
                 "the name of a deviation", fields::optional);
  f("axes", analysis.axes);
  fields::expect(f, !analysis.from_data_sheet() || std::ranges::all_of(analysis.axes, [](const NoiseAxis& axis) { return axis.fit.has_value(); }),
                 "axes", "coefficients of every axis of a data sheet");
  f("data_sheet", analysis.sheet, fields::if_any), f("moving", analysis.moving, fields::if_any), f("notes", analysis.notes, fields::optional),
      f("warnings", analysis.warnings, fields::optional);
}

/// Describes a coefficient of several logs.
template <class Fields>
void describe(Fields& f, BatchCoefficient& c) {
  describe(f, c.mean);
  f("logs", c.determined), f("spread", c.spread, fields::or_nan), f("worst", c.worst), f("worst_log", c.worst_log);
}

template <class Fields>
void describe(Fields& f, BatchAxis& axis) {
  auto& [Q, N, B, K, R] = axis.coefficients;
  f("name", axis.name), f("unit", axis.unit);
  f.table("coefficients", [&, &q = Q, &n = N, &b = B, &k = K, &r = R](auto& t) { t("N", n), t("B", b), t("K", k), t("Q", q), t("R", r); });
  f("bound", axis.bound, fields::if_any);
}

template <class Fields>
void describe(Fields& f, NoiseBatch& batch) {
  fields::derived(f, "format", "imulab.noise/1"), fields::derived(f, "recording", std::to_string(batch.logs.size()) + " logs");
  fields::derived(f, "interval_s", batch.logs.empty() ? 0 : batch.logs.front().interval_s);
  f("axes", batch.axes), f("logs", batch.logs);
}

}  // namespace imulab
