#include "imulab/results/grades.hpp"

#include "imulab/core/units.hpp"
#include "imulab/model/grade.hpp"

#include <fmt/format.h>

#include <array>

namespace imulab {
namespace {

std::string range(const std::array<double, 2>& r, double unit) {
  return r[0] == 0 ? fmt::format("below {:g}", r[1] / unit) : fmt::format("{:g}..{:g}", r[0] / unit, r[1] / unit);
}

}  // namespace

std::string grade_catalogue() {
  std::string text = "Grades as published (Xu 2024, table 1)\n\n";
  text += fmt::format("  {:<12} {:>12} {:>13} {:>10} {:>13} {:>10}\n", "", "rate nmi/h", "gyro deg/h", "accel ug", "misal. arcsec", "scale ppm");
  for (const PublishedGrade& g : published_grades())
    text += fmt::format(
        "  {:<12} {:>12} {:>13} {:>10} {:>13} {:>10}\n", g.name,
        g.position_rate[0] == 0 ? fmt::format("{:.0f} m/h", g.position_rate[1] * unit::hour) : range(g.position_rate, unit::nmi_per_h),
        range(g.gyro_bias, unit::deg_per_h), range(g.accel_bias, unit::ug), range(g.misalignment, unit::arcsec), range(g.scale, unit::ppm));
  text += fmt::format("\nAirliners' systems as published (Xu 2024, table 2)\n\n  {:<12} {:<9} {:>10} {:>11}  {}\n", "", "gyro", "rate nmi/h",
                      "gyro deg/h", "aircraft");
  for (const AirlinerSystem& s : airliner_systems())
    text += fmt::format("  {:<12} {:<9} {:>10.2g} {:>11.2g}  {}\n", s.name, s.gyro, s.position_rate / unit::nmi_per_h, s.gyro_bias / unit::deg_per_h,
                        s.aircraft);
  text += fmt::format(
      "\nGrades to draw from (one sigma of each coefficient)\n\n  {:<12} {:>10} {:>8} {:>8} {:>9} {:>11} {:>10}\n  {:<12} {:>10} {:>8} {:>8} {:>9} "
      "{:>11} {:>10}\n",
      "", "gyro", "accel", "misal.", "scale", "ARW", "VRW", "", "deg/h", "ug", "arcsec", "ppm", "deg/sqrt(h)", "ug/sqrt(Hz)");
  for (const Grade& g : grades())
    text += fmt::format("  {:<12} {:>10.3g} {:>8.3g} {:>8.3g} {:>9.3g} {:>11.3g} {:>10.3g}\n", g.name, g.gyro_bias / unit::deg_per_h,
                        g.accel_bias / unit::ug, g.gyro_misalignment / unit::arcsec, g.gyro_scale / unit::ppm, g.gyro_noise.N / unit::deg_per_sqrt_h,
                        g.accel_noise.N / unit::ug_per_sqrt_hz);
  return text;
}

}  // namespace imulab
