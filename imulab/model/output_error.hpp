// A sensor model whose output has an error that is a model itself.
#pragma once

#include "imulab/model/sensor_model.hpp"

namespace imulab {

/// The model whose output is that of `model` less df = ba + Ma f + q f^2, dw = bg + Mg w + C f of `error`, to first order: A0 <- (I - Ma) A0 - ba,
/// A1 <- (I - Ma) A1, gyros likewise. The error of a lever arm is added. Cubic and thermal terms of `error` do not count.
SensorModel without_error(const SensorModel& model, const SensorModel& error);

}  // namespace imulab
