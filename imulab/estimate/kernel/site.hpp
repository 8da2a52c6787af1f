// The place of a session as effects of the table: the latitude turns the Earth's rate, and changes gravity where that follows from it; a machine
// whose zero angle is not north turns the Earth's horizontal rate. A method supplies the attitude in an observation, or its mean:
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
  /// At this site, which may be the declared one moved by the estimated latitude (`farther_north`).
  explicit SiteChanges(const Site& site);
  /// Sets `by_latitude`, `by_heading` and `horizontal` of an observation; `C_bn` may be the mean of a turning body's.
  void fill(EffectState& state, const Matrix3d& C_bn) const;

 private:
  OutputChange by_latitude_, by_heading_;  // east-north-up
};

/// The site farther north by an angle [rad], at most at a pole: where the latitude is far from the declared one, nothing is linear in it.
Site farther_north(Site site, double angle);

/// The site beside a latitude that is estimated as an effect: at that latitude exactly, with what is not known of gravity there.
Site beside_effects(Site site);

}  // namespace imulab::kernel
