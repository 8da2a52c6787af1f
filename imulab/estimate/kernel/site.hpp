// The site of a session as effects of the table: the latitude rotates the Earth's rate, and changes gravity if that is computed from it; a machine
// whose zero angle is not north rotates the Earth's horizontal rate. A method supplies the attitude of an observation, or its mean:
//
//   const SiteChanges site(session.site);
//   site.fill(state, C_bn);
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/session.hpp"

namespace imulab::kernel {

class SiteChanges {
 public:
  /// Uses this site: the declared one, or that moved by the estimated latitude (`farther_north`).
  explicit SiteChanges(const Site& site);
  /// Sets `by_latitude`, `by_heading` and `horizontal` of an observation; for a turning body, `C_bn` may be the mean.
  void fill(EffectState& state, const Matrix3d& C_bn) const;

 private:
  OutputChange by_latitude_, by_heading_;  // east-north-up
};

/// Returns the site moved north by an angle [rad], at most to a pole. The equations are nonlinear far from the declared latitude.
Site farther_north(Site site, double angle);

/// Returns the site for a fit that estimates the latitude as an effect: an exact latitude, with the total uncertainty of gravity.
Site beside_effects(Site site);

}  // namespace imulab::kernel
