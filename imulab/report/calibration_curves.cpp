// Curves: convergence of the hybrid method, temperature and nonlinearity with their bands.
#include "imulab/coefficient.hpp"
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
#include <limits>
#include <optional>
#include <utility>

namespace imulab::report {

namespace {

constexpr double band_sigmas = 2;

/// One of the small pictures beside each other. Those of one family have one axis, so that they compare.
struct SmallCurve {
  std::string family, name, x_label, y_label;
  std::vector<double> x, y, low, high, shown;  ///< `shown`: what the axis holds
  std::string_view color;
  double first = std::numeric_limits<double>::infinity();  ///< where the axis begins before the curve does
};

std::string grid(const std::vector<SmallCurve>& curves) {
  std::string out;
  for (const SmallCurve& c : curves) {
    std::vector<double> shown{0};
    for (const SmallCurve& other : curves)
      if (other.family == c.family && other.y_label == c.y_label) shown.insert(shown.end(), other.shown.begin(), other.shown.end());
    const double first = std::min(c.first, c.x.empty() ? 0 : c.x.front()), last = c.x.empty() ? 1 : c.x.back();
    Plot plot({c.x_label, first, last}, axis_over(c.y_label, shown), c.name, small_plot);
    plot.band(c.x, c.low, c.high, c.color);
    plot.line(c.x, c.y, c.color);
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
  // The first half, before anything is known, would flatten all that follows.
  for (std::size_t i = t.size() / 2; i < t.size(); ++i) out.shown.insert(out.shown.end(), {low[i], high[i]});
  return out;
}

/// Coefficients of one curve.
using CurveTerms = std::vector<CoefficientIndex>;

/// Their covariance; zero where they were not estimated.
Eigen::MatrixXd covariance_of(const Calibration& c, const CurveTerms& terms) {
  const auto place = [&](CoefficientIndex index) { return std::find(c.estimated.begin(), c.estimated.end(), index) - c.estimated.begin(); };
  const auto n = static_cast<std::ptrdiff_t>(c.estimated.size());
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(std::ssize(terms), std::ssize(terms));
  for (std::size_t i = 0; i < terms.size(); ++i)
    for (std::size_t j = 0; j < terms.size(); ++j)
      if (const auto a = place(terms[i]), b = place(terms[j]); a < n && b < n)
        out(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = c.covariance(a, b);
  return out;
}

/// A sum of coefficients times powers of x from `lowest` on, with its band.
struct Curve {
  std::vector<double> x, y, low, high;
};

Curve curve_of(const Calibration& c, const CurveTerms& terms, int lowest, double from, double to, double zero, double factor) {
  constexpr int points = 60;
  const Eigen::VectorXd value = factor * coefficient_values(c.model, terms);
  const Eigen::MatrixXd covariance = factor * factor * covariance_of(c, terms);
  Curve out;
  for (int i = 0; i <= points; ++i) {
    const double x = from + (to - from) * i / points;
    Eigen::VectorXd b(std::ssize(terms));
    for (Eigen::Index k = 0; k < b.size(); ++k) b[k] = std::pow(x - zero, static_cast<double>(lowest + k));
    const double y = b.dot(value), s = band_sigmas * std::sqrt(std::max(0.0, b.dot(covariance * b)));
    out.x.push_back(x);
    out.y.push_back(y);
    out.low.push_back(y - s), out.high.push_back(y + s);
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

bool any_estimated(const Calibration& c, const CurveTerms& terms) {
  return std::ranges::any_of(terms, [&](CoefficientIndex index) { return contains(c.estimated, index); });
}

/// Over the calibrated temperatures; `factor`: of the coefficients.
std::optional<SmallCurve> curve_over_temperature(const Calibration& c, Triad triad, int axis, const CurveTerms& terms, double factor,
                                                 const std::string& unit) {
  const TriadModel& m = triad_model(c.model, triad);
  if (!m.temperature || m.temperature->range[0] >= m.temperature->range[1] || !any_estimated(c, terms)) return {};
  const auto [low, high] = m.temperature->range;
  return small_curve(curve_of(c, terms, 1, low, high, m.temperature->reference, factor), triad, axis, m.temperature->unit, unit);
}

std::optional<SmallCurve> thermal_curve(const Calibration& c, Triad triad, int axis) {
  CurveTerms terms;
  for (int order = 1; order <= 3; ++order) terms.push_back(coefficient_index(triad, Term::thermal, axis, order));
  const double unit = triad == Triad::accel ? unit::ug : unit::deg_per_h;
  return curve_over_temperature(c, triad, axis, terms, triad_model(c.model, triad).matrix(axis, axis) / unit, output_unit(triad));
}

std::optional<SmallCurve> scale_curve(const Calibration& c, Triad triad, int axis) {
  const CurveTerms terms{coefficient_index(triad, Term::matrix_thermal1, axis, axis), coefficient_index(triad, Term::matrix_thermal2, axis, axis)};
  return curve_over_temperature(c, triad, axis, terms, 1 / unit::ppm, "ppm");
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
  const CurveTerms terms{coefficient_index(triad, Term::quadratic, axis, axis), coefficient_index(triad, Term::cubic, axis, axis)};
  const double most = full_scale(report, triad, axis), scale = m.matrix(axis, axis);
  if (!any_estimated(c, terms) || !(most > 0) || scale == 0) return {};
  const bool accel = triad == Triad::accel;
  const double in = accel ? unit::g : unit::deg, out = accel ? unit::ug : unit::deg_per_h;
  Curve curve = curve_of(c, terms, 2, -most / scale, most / scale, 0, 1 / out);
  for (double& x : curve.x) x *= scale / in;
  return small_curve(curve, triad, axis, accel ? "g" : "deg/s", output_unit(triad));
}

}  // namespace

std::string convergence_section(const CalibrationResult& result) {
  std::vector<SmallCurve> curves;
  for (const ConvergenceCurve& curve : result.curves) curves.push_back(convergence_curve(result, curve));
  if (curves.empty()) return {};
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

std::string thermal_section(const Calibration& c) {
  const auto curves = curves_of_axes([&](Triad triad, int axis) { return thermal_curve(c, triad, axis); });
  const auto scales = curves_of_axes([&](Triad triad, int axis) { return scale_curve(c, triad, axis); });
  std::string out;
  if (!curves.empty())
    out +=
        section("thermal", "Temperature", "What temperature adds to each axis, relative to the reference temperature, with two sigma.", grid(curves));
  if (!scales.empty())
    out += section("thermal-scales", "Scales over temperature",
                   "How each axis' scale differs from that at the reference temperature, with two sigma.", grid(scales));
  return out;
}

std::string nonlinearity_section(const CalibrationReport& report) {
  const auto curves = curves_of_axes([&](Triad triad, int axis) { return nonlinearity_curve(report, triad, axis); });
  if (curves.empty()) return {};
  return section("nonlinearity", "Nonlinearity", "What the quadratic and the cubic term add to each axis over the range of the data, with two sigma.",
                 grid(curves));
}

}  // namespace imulab::report
