#include "imulab/core/units.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/results/prediction.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

namespace imulab {
namespace {

/// Three digits, the last rounded down: still within a limit.
std::string rounded_down(double x) {
  if (x <= 0) return "0";
  const double step = std::pow(10, std::floor(std::log10(x)) - 2), rounded = step * std::floor(x / step + 1e-9);
  return x >= 100 && x < 1e7 ? fmt::format("{:.0f}", rounded) : fmt::format("{:.3g}", rounded);
}

/// With the source that has the largest share.
std::string requirement_text(const Shortfall& s) {
  const UserUnit& unit = s.requirement.unit;
  const std::string required = fmt::format("{} <= {:g} {}", s.requirement.selector, s.requirement.limit / unit.size, unit.name);
  const auto name = coefficient(s.coefficient).name;
  if (!std::isfinite(s.sigma)) return fmt::format("{}: the procedure does not determine {}", required, name);
  return fmt::format("{}: {} has {:.3g} {}, most of it from {}", required, name, s.sigma / unit.size, unit.name, s.source);
}

std::string table_text(const turntable::ErrorSizes& s) {
  const std::array<std::pair<const char*, double>, 3> parts{{{"angle", s.angle}, {"orthogonality", s.orthogonality}, {"zero", s.zero}}};
  std::string text;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (parts[k].second == 0) continue;
    const bool shared = k + 1 < parts.size() && parts[k + 1].second == parts[k].second;
    text += parts[k].first + (shared ? std::string(", ") : fmt::format(" {} arcsec, ", rounded_down(parts[k].second / unit::arcsec)));
  }
  return text.substr(0, text.size() - 2);
}

std::string noise_text(const turntable::ErrorSizes& s) {
  std::string text = fmt::format("noise {} deg/sqrt(h) and {} ug/sqrt(Hz)", rounded_down(s.gyro_noise / unit::deg_per_sqrt_h),
                                 rounded_down(s.accel_noise / unit::ug_per_sqrt_hz));
  if (s.gyro_turn_on > 0 || s.accel_turn_on > 0)
    text += fmt::format(", turn-on {} deg/h and {} ug", rounded_down(s.gyro_turn_on / unit::deg_per_h), rounded_down(s.accel_turn_on / unit::ug));
  return text;
}

std::string setting_text(turntable::Knob knob, const turntable::ErrorSizes& s) {
  std::string timing = fmt::format("timing {} ms", rounded_down(1e3 * s.timing));
  if (knob == turntable::Knob::table) return table_text(s);
  if (knob == turntable::Knob::timing) return timing;
  if (knob == turntable::Knob::imu) return noise_text(s);
  return table_text(s) + "; " + timing + "; " + noise_text(s);
}

std::string title(turntable::Knob knob) {
  if (knob == turntable::Knob::table) return "coarsest table";
  if (knob == turntable::Knob::timing) return "longest timing error of a turn";
  if (knob == turntable::Knob::imu) return "noisiest unit";
  return "table, timing and unit together, all times one factor";
}

std::string answer(const char* first, turntable::Knob knob, const turntable::Tolerance& t) {
  if (t.factor)
    return text::wrapped(
        first, fmt::format("{}{} x declared: {}", t.unlimited ? "any, tried up to " : "", rounded_down(*t.factor), setting_text(knob, t.sizes)));
  std::string text = std::string(first) + "none: not even ";
  if (knob == turntable::Knob::table) text += "a perfect table";
  if (knob == turntable::Knob::timing) text += "perfect timing";
  if (knob == turntable::Knob::imu) text += "a hundredth of the noise";
  if (knob == turntable::Knob::all) text += "a hundredth of all";
  text += "\n";
  for (const Shortfall& s : t.shortfalls) text += text::wrapped("      ", requirement_text(s));
  return text;
}

}  // namespace

std::string tolerance_table(const turntable::Plan& plan, const std::vector<Shortfall>& missed, const std::vector<KnobAnswer>& answers) {
  std::string text = fmt::format("As declared, {}\n", missed.empty() ? "every requirement is met." : "these requirements are not met:");
  for (const Shortfall& s : missed) text += text::wrapped("  ", requirement_text(s));
  text += "\nWhat meets every requirement:\n";
  for (const KnobAnswer& a : answers) {
    text += fmt::format("  {}\n", title(a.knob));
    if (a.knob == turntable::Knob::timing && plan.parts.turns.empty()) {
      text += "    the procedure has no turns\n";
      continue;
    }
    if (a.alone) text += answer("    all else perfect      ", a.knob, *a.alone);
    text += answer(a.alone ? "    all else as declared  " : "    ", a.knob, a.declared);
  }
  text += text::wrapped("", "Perfect: a millionth of the table's and the timing's errors, a hundredth of the noise, g and latitude exact.");
  const turntable::ErrorSizes s = turntable::error_sizes(plan);
  if ((s.angle == 0 && s.orthogonality == 0 && s.zero == 0) || s.timing == 0)
    text += "Where no error is declared, factors are those of 1 arcsec and 1 ms.\n";
  return text;
}

}  // namespace imulab
