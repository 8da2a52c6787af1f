#include "imulab/estimate/kernel/prior.hpp"

#include <cmath>

namespace imulab::kernel {

double prior_sigma(const PriorSizes& sizes, const Coefficient& c, double scale, double thermal_range) {
  const TriadPrior& t = c.triad == Triad::accel ? sizes.accel : sizes.gyro;
  switch (c.term) {
    case Term::offset: return t.offset;
    case Term::matrix: return (c.row == c.column ? t.scale : t.misalignment) * scale;
    case Term::quadratic: return t.quadratic * scale * scale;
    case Term::cubic: return t.cubic * scale * scale * scale;
    case Term::thermal: return t.drift / scale / std::pow(thermal_range, c.column);
    case Term::g_sensitivity: return sizes.g_sensitivity;
    case Term::lever_arm: break;
  }
  return sizes.lever_arm;
}

double needed_sigma(const Coefficient& c, double prior) {
  const bool basic = c.term == Term::offset || (c.term == Term::matrix && c.row == c.column);
  return (basic ? 0.05 : 0.5) * prior;
}

}  // namespace imulab::kernel
