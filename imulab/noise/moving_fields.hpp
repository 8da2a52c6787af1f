// The fields of `moving` in noise.json, each defined once (core/fields.hpp).
#pragma once

#include "imulab/core/fields.hpp"
#include "imulab/noise.hpp"

namespace imulab {

template <class Fields>
void describe(Fields& f, MovingCause& c) {
  f("cause", c.name), f("parameter", c.parameter), f("factor", c.factor), f("size", c.size, fields::or_nan);
  f("hz", c.hz, fields::if_any), f("stamps_s", c.stamps_s, fields::if_any), f("temperature_change", c.temperature_change, fields::if_any);
  f("file", c.file, fields::if_any), f("reason", c.reason, fields::if_any);
}

template <class Fields>
void describe(Fields& f, MovingTotal& t) {
  f("factor", t.factor, fields::or_nan), f("value", t.value, fields::or_nan);
}

template <class Fields>
void describe(Fields& f, MovingAxis& axis) {
  f("name", axis.name), f("unit", axis.unit), f("causes", axis.causes);
  f("N", axis.N), f("slow_N", axis.slow_N), f("K", axis.K), f("bias", axis.bias);
}

template <class Fields>
void describe(Fields& f, MovingNoise& moving) {
  f("files", moving.files), f("axes", moving.axes);
}

}  // namespace imulab
