// The Earth in a strapdown integration, one step of it, and rates of attitude angles.
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

/// Returns the body's rate relative to east-north-up in body axes (w_nb_b), from the angles and their time derivatives.
Eigen::Vector3d attitude_rate(const EulerAngles& angles, const EulerAngles& derivative);

}  // namespace imulab

namespace imulab::integration {

/// Returns the Earth at a place, with the gravity of the options if given.
LocalEarth earth_at(double latitude, double height, const StrapdownOptions& options);
/// Throws Error if the latitude [rad] is beyond the limit north or south.
void expect_latitude(double latitude, double limit = StrapdownOptions{}.latitude_limit);

/// Returns the sum of gravity and Coriolis acceleration [m/s^2].
Eigen::Vector3d slow_acceleration(const LocalEarth& earth, const Eigen::Vector3d& velocity);
/// Returns the Earth half a step ahead of a state, or `ahead` [s] if it is used for longer.
LocalEarth earth_ahead(const NavigationState& state, double ahead, const LocalEarth& near, const StrapdownOptions& options);
/// Advances a state by one step with the Earth at its middle. `slow` is the slow acceleration at the middle of the last step, then of this one.
/// `level`: without vertical velocity.
void advance(NavigationState& state, const BodyStep& body, double interval, const LocalEarth& earth, Eigen::Vector3d& slow, bool level = false);

}  // namespace imulab::integration
