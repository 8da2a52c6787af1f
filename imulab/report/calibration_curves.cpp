// Curves: convergence of the hybrid method, temperature and nonlinearity with their bands.
#include "imulab/coefficient.hpp"
#include "imulab/compensate.hpp"
#include "imulab/error.hpp"
#include "imulab/model/compensation_derivatives.hpp"
#include "imulab/predict.hpp"
#include "imulab/procedure.hpp"
#include "imulab/report/calibration_parts.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/plot.hpp"
#include "imulab/units.hpp"

#include <Eigen/Core>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <optional>
#include <utility>

namespace imulab::report {

namespace {

constexpr double band_sigmas = 2;
constexpr std::size_t most_dots_of_curve = 300;  // of a picture

/// One of the small pictures beside each other. Those of one family have one axis with zero on it, so that they compare.
struct SmallCurve {
  std::string family, name, x_label, y_label;
  std::vector<double> x, y, low, high, shown;  ///< `shown`: what the axis holds
  std::string_view color;
  double first = std::numeric_limits<double>::infinity();  ///< where the axis begins before the curve does
  std::vector<double> dots_x = {}, dots_y = {};            ///< what the data show
};

std::string grid(const std::vector<SmallCurve>& curves) {
  std::string out;
  for (const SmallCurve& c : curves) {
    std::vector<double> shown(c.family.empty() ? 0 : 1);
    for (const SmallCurve& other : curves)
      if ((c.family.empty() ? &other == &c : other.family == c.family) && other.y_label == c.y_label)
        shown.insert(shown.end(), other.shown.begin(), other.shown.end());
    const double first = std::min(c.first, c.x.empty() ? 0 : c.x.front()), last = c.x.empty() ? 1 : c.x.back();
    Plot plot({c.x_label, first, last}, axis_over(c.y_label, shown), c.name, small_plot);
    plot.band(c.x, c.low, c.high, c.color);
    plot.line(c.x, c.y, c.color);
    plot.dots(c.dots_x, c.dots_y, c.color);
    plot.rule(0, color::gray);
    out += "<figure>" + plot.svg() + "<figcaption>" + escaped(c.name) + "</figcaption></figure>\n";
  }
  return out.empty() ? out : "<div class=\"small\">" + out + "</div>\n";
}

/// Every k-th value, so that about `count` remain, and the last.
std::vector<double> every(const std::vector<double>& values, std::size_t count) {
  const std::size_t step = std::max<std::size_t>(1, values.size() / count);
  std::vector<double> out;
  for (std::size_t i = 0; i < values.size(); i += step) out.push_back(values[i]);
  return out;
}

/// The convergence is drawn from the recording's first stamp on; its points come later.
double curve_start(const CalibrationResult& result) {
  const std::vector<SourceFile>& sources = result.calibration.sources;
  const double first_point = result.curve_time.empty() ? 0 : result.curve_time.front();
  return sources.size() == 1 && sources[0].first_s <= first_point ? sources[0].first_s : first_point;
}

SmallCurve convergence_curve(const CalibrationResult& result, const ConvergenceCurve& curve) {
  constexpr std::size_t points = 120;
  const CoefficientIndex index = coefficient_index(curve.name);
  const Calibration& c = result.calibration;
  const TriadModel& triad = triad_model(c.model, coefficient(index).triad);
  const UserUnit unit = user_unit(coefficient(index), curve.sigma.empty() ? 1 : curve.sigma.back(), triad);
  const double scale = coefficient(index).term == Term::matrix ? std::abs(triad.matrix(coefficient(index).row, coefficient(index).row)) : 1;
  std::vector<double> t = every(result.curve_time, points), y = every(curve.residual, points), s = every(curve.sigma, points), low, high;
  const double start = curve_start(result);
  for (std::size_t i = 0; i < t.size(); ++i) {
    t[i] = (t[i] - start) / 60;
    y[i] /= unit.size * scale, s[i] /= unit.size * scale;
    low.push_back(y[i] - s[i]), high.push_back(y[i] + s[i]);
  }
  SmallCurve out{.family = curve.name.substr(0, curve.name.rfind('.')),
                 .name = curve.name,
                 .x_label = "min",
                 .y_label = readable_unit(unit.name),
                 .x = t,
                 .y = y,
                 .low = low,
                 .high = high,
                 .shown = {},
                 .color = color::blue,
                 .first = 0};
  // The first half of a convergence, before anything is known, would flatten all that follows.
  for (std::size_t i = c.method == "reference" ? 0 : t.size() / 2; i < t.size(); ++i) out.shown.insert(out.shown.end(), {low[i], high[i]});
  return out;
}

/// The value of a curve somewhere, and its derivatives by the estimated coefficients.
struct CurvePoint {
  double value;
  Eigen::VectorXd derivatives;
};

/// A sum of coefficients times weights.
CurvePoint weighted(const Calibration& c, std::initializer_list<std::pair<CoefficientIndex, double>> terms) {
  CurvePoint out{0, Eigen::VectorXd::Zero(std::ssize(c.estimated))};
  for (const auto& [index, weight] : terms) {
    out.value += weight * coefficient_value(c.model, index);
    const auto place = std::find(c.estimated.begin(), c.estimated.end(), index) - c.estimated.begin();
    if (place < out.derivatives.size()) out.derivatives[place] = weight;
  }
  return out;
}

/// A curve with its band.
struct Curve {
  std::vector<double> x, y, low, high;
};

Curve curve_of(const Calibration& c, double from, double to, const auto& point_at) {
  constexpr int points = 60;
  Curve out;
  for (int i = 0; i <= points; ++i) {
    const double x = from + (to - from) * i / points;
    const CurvePoint p = point_at(x);
    const double s = band_sigmas * std::sqrt(std::max(0.0, p.derivatives.dot(c.covariance * p.derivatives)));
    out.x.push_back(x);
    out.y.push_back(p.value);
    out.low.push_back(p.value - s), out.high.push_back(p.value + s);
  }
  return out;
}

/// The curve of an axis of a triad.
SmallCurve small_curve(const Curve& c, Triad triad, int axis, const std::string& x_label, const std::string& y_label) {
  SmallCurve out{.family = std::string(to_string(triad)),
                 .name = fmt::format("{} {}", triad == Triad::accel ? "accelerometer" : "gyro", "xyz"[axis]),
                 .x_label = x_label,
                 .y_label = y_label,
                 .x = c.x,
                 .y = c.y,
                 .low = c.low,
                 .high = c.high,
                 .shown = c.low,
                 .color = color::series(static_cast<std::size_t>(axis))};
  out.shown.insert(out.shown.end(), c.high.begin(), c.high.end());
  return out;
}

const char* output_unit(Triad triad) { return triad == Triad::accel ? "µg" : "deg/h"; }

bool any_estimated(const Calibration& c, const std::vector<CoefficientIndex>& terms) {
  return std::ranges::any_of(terms, [&](CoefficientIndex index) { return contains(c.estimated, index); });
}

/// True if any of these terms was estimated over a range of temperatures.
bool is_over_temperature(const Calibration& c, Triad triad, const std::vector<CoefficientIndex>& terms) {
  const auto& t = triad_model(c.model, triad).temperature;
  return t && t->range[0] < t->range[1] && any_estimated(c, terms);
}

/// The bias of an axis at a temperature: its reading at zero input; of SI readings in output units, as offset states it.
CurvePoint bias_at(const Calibration& c, Triad triad, Eigen::Index axis, double temperature) {
  const TriadModel& m = triad_model(c.model, triad);
  const bool accel = triad == Triad::accel, counts = m.raw_unit == "count";
  const Vector3d tau = Vector3d::Constant(m.temperature->tau(temperature));
  const RawSample zero = decompensate(c.model, {}, accel ? Vector3d::Zero() : tau, accel ? tau : Vector3d::Zero());
  const CompensationDerivatives d = compensation_derivatives(c.model, zero);
  const Eigen::Index row = accel ? 3 : 0;
  const Eigen::RowVector3d out = (counts ? Matrix3d(Matrix3d::Identity()) : m.matrix).row(axis),
                           by_output = out * d.raw.block<3, 3>(row, row).inverse();
  CurvePoint p{out.dot(accel ? zero.accel : zero.gyro), Eigen::VectorXd::Zero(std::ssize(c.estimated))};
  for (Eigen::Index k = 0; k < p.derivatives.size(); ++k) {
    const CoefficientIndex index = c.estimated[static_cast<std::size_t>(k)];
    if (coefficient(index).triad == triad && (counts || coefficient(index).term != Term::matrix))
      p.derivatives[k] = -by_output.dot(d.coefficients.col(index).segment<3>(row));
  }
  return p;
}

std::optional<SmallCurve> bias_curve(const CalibrationReport& report, Triad triad, int axis) {
  const Calibration& c = report.result.calibration;
  const TriadModel& m = triad_model(c.model, triad);
  std::vector<CoefficientIndex> terms;
  for (int order = 1; order <= 3; ++order) terms.push_back(coefficient_index(triad, Term::thermal, axis, order));
  if (!is_over_temperature(c, triad, terms)) return {};
  const auto [low, high] = m.temperature->range;
  const bool counts = m.raw_unit == "count";
  const Curve curve = curve_of(c, low, high, [&](double x) { return bias_at(c, triad, axis, x); });
  const CoefficientIndex offset = coefficient_index(triad, Term::offset, axis, axis);
  const UserUnit unit = counts ? UserUnit{"counts", 1} : user_unit(coefficient(offset), std::abs(curve.y.front()));
  SmallCurve out = small_curve(curve, triad, axis, m.temperature->unit, readable_unit(unit.name));
  out.family.clear();
  if (!contains(c.estimated, offset)) out.name += ", change";  // the bias itself is not determined
  for (const RecordingEvidence& e : report.recordings)
    for (const RestOverTemperature& rest : e.sweep) {
      const TriadAtRest& r = triad == Triad::accel ? rest.accel : rest.gyro;
      if (!std::isfinite(r.error[axis])) continue;
      out.dots_x.push_back(r.temperature[axis]);
      out.dots_y.push_back(bias_at(c, triad, axis, r.temperature[axis]).value + r.error[axis] / (counts ? m.matrix(axis, axis) : 1));
    }
  out.dots_x = every(out.dots_x, most_dots_of_curve), out.dots_y = every(out.dots_y, most_dots_of_curve);
  out.shown.insert(out.shown.end(), out.dots_y.begin(), out.dots_y.end());
  for (auto* values : {&out.y, &out.low, &out.high, &out.shown, &out.dots_y})
    for (double& v : *values) v /= unit.size;
  return out;
}

/// The correction of an axis' scale; of readings in counts relative to that at the reference temperature.
std::optional<SmallCurve> scale_curve(const Calibration& c, Triad triad, int axis) {
  const TriadModel& m = triad_model(c.model, triad);
  const CoefficientIndex first = coefficient_index(triad, Term::matrix_thermal1, axis, axis),
                         second = coefficient_index(triad, Term::matrix_thermal2, axis, axis);
  if (!is_over_temperature(c, triad, {first, second})) return {};
  const double scale = m.matrix(axis, axis), factor = m.raw_unit == "count" ? 1 / scale : 1;
  const auto [low, high] = m.temperature->range;
  const Curve curve = curve_of(c, low, high, [&](double x) {
    const double tau = m.temperature->tau(x), in = factor / unit::ppm;
    CurvePoint p =
        weighted(c, {{coefficient_index(triad, Term::matrix, axis, axis), in}, {first, in * scale * tau}, {second, in * scale * tau * tau}});
    p.value -= 1 / unit::ppm;
    return p;
  });
  SmallCurve out = small_curve(curve, triad, axis, m.temperature->unit, "ppm");
  out.family.clear();
  return out;
}

/// The largest force or rate of an axis: as the fit states it, else of the recordings.
double full_scale(const CalibrationReport& report, Triad triad, int axis) {
  for (const FitResidual& f : report.result.calibration.quality.fit_residuals)
    if (f.axis == fmt::format("{}.{}", to_string(triad), "xyz"[axis]) && f.full_scale > 0) return f.full_scale;
  double most = 0;
  for (const RecordingEvidence& e : report.recordings) most = std::max(most, triad == Triad::accel ? e.largest_force : e.largest_rate);
  return most;
}

std::optional<SmallCurve> nonlinearity_curve(const CalibrationReport& report, Triad triad, int axis) {
  const Calibration& c = report.result.calibration;
  const TriadModel& m = triad_model(c.model, triad);
  const CoefficientIndex quadratic = coefficient_index(triad, Term::quadratic, axis, axis), cubic = coefficient_index(triad, Term::cubic, axis, axis);
  const double most = full_scale(report, triad, axis), scale = m.matrix(axis, axis);
  if (!any_estimated(c, {quadratic, cubic}) || !(most > 0) || scale == 0) return {};
  const bool accel = triad == Triad::accel;
  const double in = accel ? unit::g : unit::deg, out = accel ? unit::ug : unit::deg_per_h;
  Curve curve = curve_of(c, -most / scale, most / scale, [&](double x) { return weighted(c, {{quadratic, x * x / out}, {cubic, x * x * x / out}}); });
  for (double& x : curve.x) x *= scale / in;
  return small_curve(curve, triad, axis, accel ? "g" : "deg/s", output_unit(triad));
}

}  // namespace

std::string convergence_section(const CalibrationResult& result) {
  std::vector<SmallCurve> curves;
  for (const ConvergenceCurve& curve : result.curves) curves.push_back(convergence_curve(result, curve));
  if (curves.empty()) return {};
  if (result.calibration.method == "reference")
    return section("offsets", "Offsets over time", "What the offsets of some seconds depart from those of the result, with one sigma.", grid(curves));
  return section("convergence", "Convergence",
                 "What each coefficient is still off by after the data up to that minute, relative to the coarse solution, with one sigma.",
                 grid(curves));
}

namespace {

/// Of all axes that have one.
std::vector<SmallCurve> curves_of_axes(const auto& curve_of_axis) {
  std::vector<SmallCurve> out;
  for (const Triad triad : {Triad::accel, Triad::gyro})
    for (int axis = 0; axis < 3; ++axis)
      if (auto curve = curve_of_axis(triad, axis)) out.push_back(std::move(*curve));
  return out;
}

}  // namespace

std::string thermal_section(const CalibrationReport& report) {
  const Calibration& c = report.result.calibration;
  const auto biases = curves_of_axes([&](Triad triad, int axis) -> std::optional<SmallCurve> {
    try {
      return bias_curve(report, triad, axis);
    } catch (const Error&) {  // a model that cannot be inverted has no reading at zero input
      return {};
    }
  });
  const auto scales = curves_of_axes([&](Triad triad, int axis) { return scale_curve(c, triad, axis); });
  const std::string figures = sweep_figures(report);
  const bool dots = std::ranges::any_of(biases, [](const SmallCurve& curve) { return !curve.dots_x.empty(); });
  std::string out;
  if (!biases.empty() || !figures.empty())
    out += section("thermal", "Biases over temperature",
                   std::string("What each axis reads at zero input over the calibrated temperatures, with two sigma.") +
                       (dots ? " Dots: rests in which the axis is within 45° of the vertical, or whose temperature changes; what they show if all "
                               "other terms are right."
                             : ""),
                   grid(biases) + figures);
  if (!scales.empty())
    out += section("thermal-scales", "Scales over temperature",
                   "The correction of each axis' scale over the calibrated temperatures, with two sigma; for readings in counts, relative to the "
                   "reference temperature.",
                   grid(scales));
  return out;
}

std::string nonlinearity_section(const CalibrationReport& report) {
  const auto curves = curves_of_axes([&](Triad triad, int axis) { return nonlinearity_curve(report, triad, axis); });
  if (curves.empty()) return {};
  return section("nonlinearity", "Nonlinearity", "What the quadratic and the cubic term add to each axis over the range of the data, with two sigma.",
                 grid(curves));
}

}  // namespace imulab::report
