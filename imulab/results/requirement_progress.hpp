// A requirement in a line of JSON of a stream: without its limit, which the text has.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/formats/text/json_fields.hpp"

#include <vector>

namespace imulab {

struct RequirementProgress {
  RequirementProgress(const RequirementResult& r) : requirement(r) {}
  RequirementResult requirement;
};

template <class Fields>
void describe(Fields& f, const RequirementProgress& p) {
  const RequirementResult& r = p.requirement;
  f("text", r.text), f("coefficient", r.coefficient), f("reached", r.reached), f("met", r.met);
}

}  // namespace imulab
