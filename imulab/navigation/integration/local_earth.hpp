// The Earth of a strapdown integration, a step of it, and the rates of its attitude angles.
#pragma once

#include "imulab/earth.hpp"
#include "imulab/eigen.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/integration/increment.hpp"

#include <Eigen/Geometry>

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace imulab {

/// Rate of the body against east-north-up, in body axes (w_nb_b), from the angles and their time derivatives.
Eigen::Vector3d attitude_rate(const EulerAngles& angles, const EulerAngles& derivative);

}  // namespace imulab

namespace imulab::integration {

/// The Earth at a place, with the options' gravity where they have one.
LocalEarth earth_at(double latitude, double height, const StrapdownOptions& options);
/// Throws Error beyond the limit (either way from the equator) [rad].
void expect_latitude(double latitude, double limit = StrapdownOptions{}.latitude_limit);

/// Gravity and Coriolis acceleration [m/s^2].
Eigen::Vector3d slow_acceleration(const LocalEarth& earth, const Eigen::Vector3d& velocity);
/// The Earth half a step ahead of a state, or farther where it has to serve longer [s].
LocalEarth earth_ahead(const NavigationState& state, double ahead, const LocalEarth& near, const StrapdownOptions& options);
/// A step with the Earth at its middle. `slow`: the slow acceleration at the last step's middle, then at this one's. `level`: without vertical
/// velocity.
void advance(NavigationState& state, const BodyStep& body, double interval, const LocalEarth& earth, Eigen::Vector3d& slow, bool level = false);

}  // namespace imulab::integration
