// A calibration for people: every coefficient with its uncertainty in user units, then how good it is and why.
#include "apps/imulab/calibrate.hpp"

#include "imulab/core/units.hpp"
#include "imulab/model/coefficient.hpp"

#include <fmt/core.h>

#include <cmath>

namespace imulab::command {

namespace {

struct UserUnit {
  double factor;  ///< SI = user x factor
  const char* name;
};

/// Matrix elements are shown relative to their row's diagonal: a scale's uncertainty in ppm, a misalignment as an angle.
UserUnit user_unit(const Coefficient& c, const SensorModel& model) {
  const bool accel = c.triad == Triad::accel;
  switch (c.term) {
    case Term::offset: return accel ? UserUnit{unit::ug, "ug"} : UserUnit{unit::deg_per_h, "deg/h"};
    case Term::matrix: {
      const double scale = std::abs((accel ? model.accel : model.gyro).matrix(c.row, c.row));
      return c.row == c.column ? UserUnit{scale * unit::ppm, "ppm"} : UserUnit{scale * unit::arcsec, "arcsec"};
    }
    case Term::g_sensitivity: return {unit::deg_per_h / unit::g, "deg/h/g"};
    default: return {1, ""};
  }
}

void print_row(const Calibration& calibration, int index) {
  const Coefficient& c = coefficient_table()[static_cast<std::size_t>(index)];
  const auto sigma = standard_uncertainty(calibration, index);
  const double value = coefficient_value(calibration.model, index);
  const UserUnit user = user_unit(c, calibration.model);
  const bool scale = c.term == Term::matrix && c.row == c.column;
  const std::string value_in_user = scale ? "" : fmt::format("{:.5g}", value / user.factor);
  fmt::print("  {:<24} {:>14.7g} {:>10} {:>14} {:>10} {}\n", c.name, value, sigma ? fmt::format("{:.2g}", *sigma) : "-", value_in_user,
             sigma ? fmt::format("{:.2g}", *sigma / user.factor) : "-", user.name);
}

}  // namespace

void print_calibration(const Calibration& calibration) {
  const Quality& quality = calibration.quality;
  fmt::print("{}{}method {}, frame: {}\n\n", calibration.imu, calibration.imu.empty() ? "" : ", ", calibration.method, calibration.frame);
  fmt::print("  {:<24} {:>14} {:>10} {:>14} {:>10}\n", "coefficient", "value (SI)", "+/-", "in user units", "+/-");
  for (const int index : calibration.estimated) print_row(calibration, index);

  fmt::print("\n");
  for (const std::string& note : quality.notes) fmt::print("  {}\n", note);
  for (const UncertaintySource& source : quality.sources) fmt::print("  {}\n", source.consequence);
  for (const TermTest& test : quality.term_tests)
    fmt::print("  {}: {} (chi2 {:.4g} with {} degrees of freedom, probability by chance {:.2g})\n", test.term,
               test.kept ? "significant, estimated" : "not significant, left at zero", test.statistic, test.degrees_of_freedom, test.p_value);
  fmt::print("  residuals: chi2 per degree of freedom {:.3g} against {} ({} degrees of freedom); condition {:.3g}\n", quality.chi2_per_dof,
             calibration.method == "turntable" ? "the noise and the declared table errors" : "the sample noise alone", quality.degrees_of_freedom, quality.condition);
  fmt::print("\n{}\n", quality.verdict);
}

}  // namespace imulab::command
