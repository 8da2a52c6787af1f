// Pictures from the recordings, and the residuals.
#include "imulab/earth.hpp"
#include "imulab/recording/coverage.hpp"
#include "imulab/report/calibration_parts.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/pictures.hpp"
#include "imulab/report/plot.hpp"
#include "imulab/results/live.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace imulab::report {

namespace {

double root_mean_square(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, values.size())));
}

std::vector<double> counted(std::size_t n) {
  std::vector<double> out(n);
  std::iota(out.begin(), out.end(), 1.0);
  return out;
}

std::string size_text(double value, double small, std::string_view small_name, double large, std::string_view large_name) {
  return std::abs(value) < large ? fmt::format("{} {}", number_text(value / small), small_name)
                                 : fmt::format("{} {}", number_text(value / large), large_name);
}

std::string acceleration_text(double v) { return size_text(v, unit::ug, "µg", 1e3 * unit::ug, "mg"); }
std::string angle_text(double v) {
  return v < 0.1 * unit::deg ? size_text(v, unit::arcsec, "arcsec", 0.1 * unit::deg, "") : number_text(v / unit::deg) + " deg";
}

/// At most so many: the greatest of each group of neighbors.
std::vector<double> thinned(const std::vector<double>& values, std::size_t most) {
  const std::size_t step = std::max<std::size_t>(1, (values.size() + most - 1) / most);
  std::vector<double> out;
  for (std::size_t i = 0; i < values.size(); i += step)
    out.push_back(*std::max_element(values.begin() + static_cast<std::ptrdiff_t>(i),
                                    values.begin() + static_cast<std::ptrdiff_t>(std::min(values.size(), i + step))));
  return out;
}

constexpr std::size_t most_dots = 2000;
/// The sentence of a caption about dots that were left out.
std::string thinned_text(std::size_t parts) {
  return parts > most_dots ? fmt::format(" The worst of every {} is shown.", (parts + most_dots - 1) / most_dots) : "";
}

/// Errors at `at` without and with something, on a logarithmic axis.
std::string two_sizes(const Axis& x, const std::vector<double>& at, const std::string& y, std::vector<double> without, std::vector<double> with,
                      const std::string& without_name = "before", const std::string& with_name = "after") {
  const std::vector<double> n = thinned(at, most_dots);
  without = thinned(without, most_dots), with = thinned(with, most_dots);
  std::vector<double> all = without;
  all.insert(all.end(), with.begin(), with.end());
  Plot plot(x, axis_over(y, all, true), y);
  plot.dots(n, without, color::orange, true);
  plot.dots(n, with, color::blue);
  return plot.svg() + key({{without_name, color::orange}, {with_name, color::blue}});
}

std::string two_sizes(const std::string& x, const std::string& y, const std::vector<double>& before, const std::vector<double>& after) {
  return two_sizes({x, 0, static_cast<double>(before.size() + 1)}, counted(before.size()), y, before, after);
}

std::optional<double> gravity_of(const CalibrationReport& report) {
  if (!report.session || (!report.session->site.given_gravity && !report.session->site.latitude)) return {};
  return report.session->site.gravity();
}

std::string gravity_figure(const CalibrationReport& report, double g) {
  std::vector<double> before, after;
  for (const RecordingEvidence& e : report.recordings)
    for (const GravityAtRest& rest : e.rests) {
      before.push_back(std::abs(rest.before - g) / unit::ug);
      after.push_back(std::abs(rest.after - g) / unit::ug);
    }
  if (before.empty()) return {};
  return figure(two_sizes("rest", "error of gravity [µg]", before, after),
                fmt::format("Gravity at rest: the size of the mean force, less g = {:.5f} m/s². RMS {} before, {} after.", g,
                            acceleration_text(root_mean_square(before) * unit::ug), acceleration_text(root_mean_square(after) * unit::ug)) +
                    thinned_text(before.size()));
}

std::string turns_figure(const CalibrationReport& report) {
  std::vector<double> before, after;
  for (const RecordingEvidence& e : report.recordings)
    for (const TurnError& turn : e.turns) {
      before.push_back(turn.before / unit::deg);
      after.push_back(turn.after / unit::deg);
    }
  if (before.empty()) return {};
  return figure(
      two_sizes("turn between two rests", "error of direction [deg]", before, after),
      fmt::format(
          "Rotation: the direction of gravity after a turn, as the gyros take it along and as the accelerometers measure it. RMS {} before, {} "
          "after.",
          angle_text(root_mean_square(before) * unit::deg), angle_text(root_mean_square(after) * unit::deg)) +
          thinned_text(before.size()));
}

/// The errors of the size of a triad's output at rest; where its offsets are not known the changes of the size.
std::string sweep_figure(const CalibrationReport& report, Triad triad, double truth) {
  const bool accel = triad == Triad::accel;
  const TriadModel& model = triad_model(report.result.calibration.model, triad);
  const double unit = accel ? unit::ug : unit::deg_per_h;
  std::vector<double> at, without, with;
  for (const RecordingEvidence& e : report.recordings)
    for (const RestOverTemperature& rest : e.sweep) {
      const TriadAtRest& r = accel ? rest.accel : rest.gyro;
      at.push_back(r.temperature.mean());
      without.push_back(r.size_at_reference);
      with.push_back(r.size);
    }
  if (at.empty() || !model.varies() || !model.temperature) return {};
  const bool known = contains(report.result.calibration.estimated, coefficient_index(triad, Term::offset, 0, 0));
  for (auto* sizes : {&without, &with}) {
    const double less = known ? truth : std::accumulate(sizes->begin(), sizes->end(), 0.0) / static_cast<double>(sizes->size());
    for (double& v : *sizes) v = std::abs(v - less) / unit;
  }
  const auto text = [&](const std::vector<double>& errors) {
    const double rms = root_mean_square(errors) * unit;
    return accel ? acceleration_text(rms) : number_text(rms / unit) + " deg/h";
  };
  return figure(two_sizes(axis_over(model.temperature->unit, at), at, accel ? "error of gravity [µg]" : "error of the rate at rest [deg/h]", without,
                          with, "values of the reference temperature", "terms over temperature"),
                fmt::format("{} at rest: the size of the mean {}, less {}. RMS {} with the values of the reference temperature alone, {} with the "
                            "terms over temperature.",
                            accel ? "Gravity" : "Rate", accel ? "force" : "rate",
                            !known  ? "its mean"
                            : accel ? "g"
                                    : "the Earth's",
                            text(without), text(with)) +
                    thinned_text(at.size()));
}

std::vector<MarkedTime> marks_of(const Calibration& calibration, const RecordingEvidence& e, bool only_one) {
  std::vector<MarkedTime> marks;
  if (only_one)
    for (const auto* parts : {&calibration.quality.rests, &calibration.quality.rotations})
      for (const PartResidual& part : *parts)
        if (parts == &calibration.quality.rests || !part.used) marks.push_back({part.begin_s, part.end_s, part.used ? Mark::rest : Mark::dropped});
  if (marks.empty())
    for (const GravityAtRest& rest : e.rests) marks.push_back({rest.begin_s, rest.end_s, Mark::rest});
  if (marks.size() > most_dots) std::erase_if(marks, [](const MarkedTime& m) { return m.mark == Mark::rest; });  // too fine to be seen
  return marks;
}

std::vector<std::vector<double>> scaled(const Columns3& columns, double unit) {
  std::vector<std::vector<double>> out;
  for (const auto& column : columns) {
    out.push_back(column);
    for (double& v : out.back()) v /= unit;
  }
  return out;
}

std::string recording_charts(const Calibration& calibration, const RecordingEvidence& e, bool only_one) {
  const std::vector<MarkedTime> marks = marks_of(calibration, e, only_one);
  std::string out = only_one ? "" : "<h3>" + escaped(e.file) + "</h3>\n";
  out += paragraph(fmt::format("{}: {} samples at {} Hz, {} s; {} at a limit, {} gaps. {}", e.file, e.samples, number_text(e.rate_hz, 5),
                               number_text(e.duration_s, 6), e.saturated, e.gaps,
                               e.overview.samples_per_interval > 1
                                   ? fmt::format("The charts show the least and the greatest of every {} samples.", e.overview.samples_per_interval)
                                   : "The charts show every sample."));
  const auto chart = [&](const std::string& title, const std::string& label, const Columns3& columns, double unit) {
    if (columns[0].empty()) return std::string();
    TimeChart c{.title = title,
                .y_label = label,
                .start = e.overview.first_s,
                .x = e.overview.time,
                .names = {"x", "y", "z"},
                .y = scaled(columns, unit),
                .marks = marks,
                .group = e.file};
    return time_chart(c);
  };
  const auto& t = calibration.model.accel.temperature ? calibration.model.accel.temperature : calibration.model.gyro.temperature;
  out += chart("Angular rate, calibrated", "deg/s", e.overview.rate, unit::deg) + chart("Specific force, calibrated", "m/s²", e.overview.force, 1) +
         chart("Thermal reading", t ? t->unit : "", e.overview.temperature, 1);
  return out;
}

/// The worst of each group of neighbors where there are very many.
std::vector<PartResidual> worst_parts(const std::vector<PartResidual>& parts) {
  const std::size_t step = std::max<std::size_t>(1, (parts.size() + most_dots - 1) / most_dots);
  std::vector<PartResidual> out;
  for (std::size_t i = 0; i < parts.size(); i += step) {
    const auto first = parts.begin() + static_cast<std::ptrdiff_t>(i),
               last = parts.begin() + static_cast<std::ptrdiff_t>(std::min(parts.size(), i + step));
    out.push_back(*std::max_element(first, last, [](const PartResidual& a, const PartResidual& b) { return a.residual < b.residual; }));
  }
  return out;
}

std::string residual_bars(const std::vector<PartResidual>& all, const std::string& what) {
  if (all.empty()) return {};
  const std::vector<PartResidual> parts = worst_parts(all);
  std::vector<double> sizes{0}, used, outliers;
  std::size_t dropped = 0;
  for (const PartResidual& p : parts) {
    sizes.push_back(p.residual);
    used.push_back(p.used ? p.residual : NAN);
    outliers.push_back(p.used ? NAN : p.residual);
  }
  for (const PartResidual& p : all) dropped += !p.used;
  Axis y = axis_over("residual [σ]", sizes);
  y.low = 0, y.high = std::max(y.high, 1.5);
  Plot plot({what, 0.3, static_cast<double>(parts.size()) + 0.7}, y, "residuals by " + what);
  plot.bars(counted(parts.size()), used, 0.7, color::blue);
  if (dropped > 0) plot.bars(counted(parts.size()), outliers, 0.7, color::vermilion);
  plot.rule(1, color::gray);
  const std::string colors = dropped > 0 ? key({{"used", color::blue}, {"dropped as an outlier", color::vermilion}}) : "";
  return figure(plot.svg() + colors,
                fmt::format("About 1 is expected (dashed). {} of {} were dropped as outliers.{}", dropped, all.size(), thinned_text(all.size())));
}

}  // namespace

std::string before_and_after(const CalibrationReport& report) {
  const auto g = gravity_of(report);
  const std::string figures = beside({g ? gravity_figure(report, *g) : "", turns_figure(report)});
  if (figures.empty()) return {};
  const SensorModel& m = report.result.calibration.model;
  const bool counts = m.accel.raw_unit == "count" || m.gyro.raw_unit == "count";
  return section(
      "before-after", "Before and after",
      counts ? "Readings in counts have no scale of their own: before means one scale for the three axes of a triad and the biases found here."
             : "Before means the readings as they are in the recording.",
      figures);
}

std::string sweep_figures(const CalibrationReport& report) {
  const auto g = gravity_of(report);
  return beside({g ? sweep_figure(report, Triad::accel, *g) : "", sweep_figure(report, Triad::gyro, earth_rate)});
}

std::string recordings_section(const CalibrationReport& report) {
  if (report.recordings.empty()) return {};
  std::string out;
  for (const RecordingEvidence& e : report.recordings) out += recording_charts(report.result.calibration, e, report.recordings.size() == 1);
  for (const RecordingEvidence& e : report.recordings)
    if (!e.without_rests.empty()) out += paragraph(e.file + ": no pictures of gravity at rest: " + e.without_rests + ".");
  return section("recording", "The recording", "", out + "<p class=\"screen\">Drag to zoom, double-click for all.</p>\n");
}

std::string residuals_section(const Calibration& calibration) {
  const Quality& q = calibration.quality;
  const std::string figures = beside({residual_bars(q.rests, "rest"), residual_bars(q.rotations, "rotation")});
  if (q.degrees_of_freedom == 0 && figures.empty()) return {};
  Table axes{.head = {"axis", "RMS", "largest", "full scale", ""}, .rows = {}, .left = {4}};
  for (const FitResidual& f : q.fit_residuals) {
    const bool accel = f.axis.starts_with("accel");
    const double small = accel ? unit::ug : unit::deg_per_h, large = accel ? unit::g : unit::deg;
    axes.rows.push_back({escaped(f.axis), number_text(f.rms / small), number_text(f.largest / small), number_text(f.full_scale / large),
                         accel ? "µg; full scale in g" : "deg/h; full scale in deg/s"});
  }
  return section("residuals", "Residuals",
                 fmt::format("Chi-square per degree of freedom {} with {} degrees of freedom; 1 is expected. Condition of the normal equations {}.",
                             number_text(q.chi2_per_dof), q.degrees_of_freedom, number_text(q.condition)),
                 figures + (axes.rows.empty() ? "" : table(axes)));
}

std::vector<Vector3d> rest_directions(const CalibrationReport& report) {
  std::vector<Vector3d> out;
  for (const RecordingEvidence& e : report.recordings)
    for (const GravityAtRest& rest : e.rests)
      if (rest.force.norm() > 0 && rest.force.allFinite()) out.push_back(rest.force);
  return out;
}

std::string coverage_section(const CalibrationReport& report) {
  const std::vector<Vector3d> directions = rest_directions(report);
  if (directions.empty()) return {};
  constexpr double least = 30 * unit::deg;
  std::vector<SphereMark> marks;
  for (const Vector3d& d : directions) marks.push_back({d});
  std::string gaps;
  for (const CoverageGap& gap : coverage_gaps(directions, least)) {
    marks.push_back({gap.direction, true});
    gaps +=
        fmt::format("{}{} ({:.0f}° from the nearest rest)", gaps.empty() ? "" : ", ", direction_text(gap.direction) + " up", gap.angle / unit::deg);
  }
  const std::vector<double> parts = leverages(directions);
  Plot plot({"rest", 0.3, static_cast<double>(parts.size()) + 0.7}, {"parameters determined", 0, 1.05}, "what each rest contributes");
  std::vector<double> alone = parts, shared = parts;
  for (std::size_t k = 0; k < parts.size(); ++k) (parts[k] > 0.95 ? shared[k] : alone[k]) = NAN;
  plot.bars(counted(parts.size()), shared, 0.7, color::green);
  plot.bars(counted(parts.size()), alone, 0.7, color::vermilion);
  const double sum = std::accumulate(parts.begin(), parts.end(), 0.0);
  return section(
      "coverage", "Directions of gravity", "",
      beside({figure(sphere(marks, "directions of gravity at rest"),
                     fmt::format("Up in the IMU's axes at each rest, on the two halves of the sphere (equal-area). {}",
                                 gaps.empty() ? "No direction is farther than 30° from a rest." : "Largest gaps (crosses): " + gaps + ".")),
              figure(plot.svg() + key({{"checked by other rests", color::green}, {"checked by none", color::vermilion}}),
                     fmt::format(
                         "What each rest contributes to the nine accelerometer parameters (biases, scale factors, misalignments), all rests counting "
                         "alike: its leverage. The sum is {}{}. At 1, no other rest checks it.",
                         number_text(sum), sum < 8.9 ? ", so these rests alone leave some of the nine open" : ""))}));
}

}  // namespace imulab::report
