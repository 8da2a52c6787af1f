#include "imulab/recording/session.hpp"

#include "imulab/core/error.hpp"
#include "imulab/earth/earth.hpp"

namespace imulab {

double Site::gravity() const {
  if (given_gravity) return *given_gravity;
  if (latitude) return normal_gravity(*latitude, height.value_or(0.0));
  throw Error("[site]: neither gravity_mps2 nor latitude_deg is given; gravity is the accelerometers' scale, so one of them is needed");
}

double Site::gravity_sigma() const {
  if (given_gravity_sigma) return *given_gravity_sigma;
  if (given_gravity) return 1e-5;
  return height ? 3e-4 : 3e-3;
}

std::string_view to_string(NoiseTerms terms) { return terms == NoiseTerms::white ? "white" : "full"; }

std::string_view to_string(Extent extent) { return extent == Extent::all ? "all" : "steps"; }

std::string_view to_string(RigKind kind) {
  switch (kind) {
    case RigKind::turntable: return "turntable";
    case RigKind::rate_table: return "rate_table";
    case RigKind::centrifuge: return "centrifuge";
    case RigKind::chamber: return "chamber";
    case RigKind::none: break;
  }
  return "none";
}

std::string_view to_string(RigAxis axis) {
  switch (axis) {
    case RigAxis::outer: return "outer";
    case RigAxis::middle: return "middle";
    case RigAxis::inner: break;
  }
  return "inner";
}

std::string_view to_string(StepKind kind) {
  switch (kind) {
    case StepKind::hold: return "hold";
    case StepKind::rotate: return "rotate";
    case StepKind::spin: break;
  }
  return "spin";
}

}  // namespace imulab
