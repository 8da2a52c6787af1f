#include "imulab/results/extrinsics.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/finding_code.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/json_fields.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/model/calibration_fields.hpp"
#include "imulab/results/conclusion.hpp"
#include "imulab/results/thinned.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab {
namespace {

constexpr double mm = 1e-3, ms = 1e-3, ppm = 1e-6;

BodyRates rates_of_picture(const BodyRates& rates) {
  constexpr std::size_t most = 1500;
  BodyRates out{.time = result_io::thinned_rows(rates.time, most), .first = {}, .second = {}, .residual = {}};
  for (const auto member : {&BodyRates::first, &BodyRates::second, &BodyRates::residual})
    for (std::size_t axis = 0; axis < 3; ++axis) (out.*member)[axis] = result_io::thinned_rows((rates.*member)[axis], most);
  return out;
}

}  // namespace

template <class Fields>
void describe(Fields& f, Mounting& m) {
  f("from", m.from), f("to", m.to), f("rotation", m.rotation), f("lever_arm_m", m.lever_arm);
  f("clock_offset_s", m.clock_offset), f("clock_drift_ppm", m.clock_drift, fields::in(ppm)), f("accel_delay_s", m.accel_delay);
  fields::derived(f, "matrix", Eigen::MatrixXd(m.matrix()));
  if constexpr (!Fields::reads)
    f.table("standard_uncertainty", [&](auto& u) {
      u("rotation_deg", m.uncertainties(Mounting::rotation_row), fields::in(unit::deg)), u("lever_arm_m", m.uncertainties(Mounting::lever_arm_row));
      u("clock_offset_s", m.uncertainty(Mounting::clock_offset_row)), u("clock_drift_ppm", m.uncertainty(Mounting::clock_drift_row), fields::in(ppm));
      u("accel_delay_s", m.uncertainty(Mounting::accel_delay_row));
    });
  else
    f.knows("standard_uncertainty");
  f("not_shown", m.not_shown);
}

template <class Fields>
void describe(Fields& f, BodyResidual& r) {
  f("gyro_deg_per_s", r.gyro, fields::in(unit::deg)), f("accel_mps2", r.accel), f("samples", r.samples);
}

template <class Fields>
void describe(Fields& f, BodyRates& r) {
  constexpr fields::How columns{.size = unit::deg, .things = "lists of numbers", .digits = 6};
  f("time_s", r.time, {.digits = result_io::stamp_digits});
  f("first_deg_per_s", r.first, columns), f("second_deg_per_s", r.second, columns), f("residual_deg_per_s", r.residual, columns);
  for (const Columns3* lists : {&r.first, &r.second, &r.residual})
    for (const auto& list : *lists) fields::check(f, list.size() == r.time.size(), "time_s", "expected as many numbers as in the lists of rates");
}

template <class Fields>
void describe(Fields& f, Extrinsics& e) {
  double epoch = e.from_first.empty() ? 0 : e.from_first.front().epoch;
  f("imus", e.imus), f("duration_s", e.duration), f("used_s", e.used), f("epoch_s", epoch);
  f("mountings", e.from_first);
  const auto rows = Mounting::rows * std::ssize(e.from_first);
  if constexpr (Fields::reads) e.covariance.resize(rows, rows);
  f("covariance", e.covariance);
  f("residuals", e.residuals), f("agreement", e.agreement), f("findings", e.findings, fields::if_any), f("rates", e.rates, fields::optional);
  const auto others = e.from_first.size();
  fields::check(f, others > 0 && e.imus.size() == others + 1, "mountings", fmt::format("expected {} mountings of {} IMUs", others, others + 1));
  fields::check(f, e.covariance.size() == 0 || e.covariance.diagonal().minCoeff() >= 0, "covariance", "has a negative variance");
  fields::check(f, e.residuals.size() == others + 1 && e.agreement.size() == others, "residuals", "expected one of each IMU");
  if constexpr (Fields::reads)
    for (std::size_t k = 0; k < others; ++k) {
      const auto row = static_cast<Eigen::Index>(Mounting::rows * k);
      e.from_first[k].covariance = e.covariance.block<Mounting::rows, Mounting::rows>(row, row);
      e.from_first[k].epoch = epoch;
    }
}

Extrinsics result_io::extrinsics_of(const json_io::Field& root) {
  Extrinsics out;
  read_into(root, out);
  out.verdict = out.findings.doubtful() ? Verdict::doubtful : Verdict::good;
  return out;
}

std::string extrinsics_json(const Extrinsics& extrinsics) {
  Extrinsics shown = extrinsics;
  std::transform(shown.rates.begin(), shown.rates.end(), shown.rates.begin(), rates_of_picture);
  return result_text("extrinsics", written(shown), JsonLayout::long_lists);
}

Conclusion conclusion_of(const Extrinsics& extrinsics) {
  double rotation = 0, arm = 0, clock = 0;
  for (const Mounting& m : extrinsics.from_first)
    rotation = std::max(rotation, m.uncertainties(Mounting::rotation_row).maxCoeff()),
    arm = std::max(arm, m.uncertainties(Mounting::lever_arm_row).maxCoeff()), clock = std::max(clock, m.uncertainty(Mounting::clock_offset_row));
  const std::string of = extrinsics.imus.size() == 2 ? excerpt(extrinsics.imus[1]) : fmt::format("{} IMUs", extrinsics.imus.size() - 1);
  const std::vector<std::string> reasons = extrinsics.findings.reasons();
  const std::string because = reasons.empty() ? "" : fmt::format("; because {}", fmt::join(reasons, "; "));
  const bool predicted = extrinsics.findings.has(Code::mounting_predicted);
  return {extrinsics.verdict, fmt::format("{}{} relative to {}: rotation to {} deg, lever arm to {} mm, clock to {} ms (1 sigma){}",
                                          predicted ? "predicted for " : "", of, excerpt(extrinsics.imus.front()),
                                          text::two_digits(rotation / unit::deg), text::two_digits(arm / mm), text::two_digits(clock / ms), because)};
}

namespace {

std::string uncertainty_text(std::string_view name, const Vector3d& sigma) {
  return fmt::format("  {:<24} {:>11} {:>11} {:>11}", name, text::two_digits(sigma[0]), text::two_digits(sigma[1]), text::two_digits(sigma[2]));
}

std::string row_text(std::string_view name, const Vector3d& value, const Vector3d& sigma, std::string_view unit_name) {
  std::string values = fmt::format("  {:<24}", name);
  for (int i = 0; i < 3; ++i) values += fmt::format(" {:>11}", text::to_digits_of(sigma[i], value[i]));
  return fmt::format("{}  {}\n{}\n", values, unit_name, uncertainty_text("u", sigma));
}

std::string row_text(std::string_view name, double value, double sigma, std::string_view unit_name) {
  return fmt::format("  {:<24} {:>11}  {}, u = {}\n", name, text::to_digits_of(sigma, value), unit_name, text::two_digits(sigma));
}

}  // namespace

std::string extrinsics_text(const Extrinsics& extrinsics, bool details) {
  std::string out;
  for (std::size_t k = 0; k < extrinsics.from_first.size(); ++k) {
    const Mounting& m = extrinsics.from_first[k];
    out += fmt::format("{}\n  {:<24} {:>11} {:>11} {:>11}\n", excerpt(m.to) + " relative to " + excerpt(m.from), "", "x", "y", "z");
    if (extrinsics.findings.has(Code::mounting_predicted)) {
      out += uncertainty_text("u of the rotation", m.uncertainties(Mounting::rotation_row) / unit::deg) + "  deg\n";
      out += uncertainty_text("u of the lever arm", m.uncertainties(Mounting::lever_arm_row) / mm) + "  mm\n";
      continue;
    }
    out += row_text("rotation vector", rotation_log(m.rotation) / unit::deg, m.uncertainties(Mounting::rotation_row) / unit::deg, "deg");
    out += row_text("lever arm", m.lever_arm / mm, m.uncertainties(Mounting::lever_arm_row) / mm, "mm");
    out += row_text("clock offset", m.clock_offset / ms, m.uncertainty(Mounting::clock_offset_row) / ms, "ms");
    out += row_text("clock drift", m.clock_drift / ppm, m.uncertainty(Mounting::clock_drift_row) / ppm, "ppm");
    out += row_text("accelerometers' delay", m.accel_delay / ms, m.uncertainty(Mounting::accel_delay_row) / ms, "ms");
    if (details) {
      const BodyResidual& r = extrinsics.residuals[k + 1];
      out += fmt::format("  residuals of {} samples: {:.3g} deg/s, {:.3g} m/s^2 (RMS); agreement of rates {:.4f}\n", r.samples, r.gyro / unit::deg,
                         r.accel, extrinsics.agreement[k]);
    }
  }
  out += fmt::format("{:.0f} s of {:.0f} s in common were used\n", extrinsics.used, extrinsics.duration);
  for (const std::string& note : extrinsics.findings.notes())
    if (details) out += text::wrapped("note: ", note);
  return out;
}

}  // namespace imulab
