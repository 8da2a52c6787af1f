// Extrinsics as JSON, and as a table of the terminal.
#pragma once

#include "imulab/extrinsics.hpp"
#include "imulab/formats/text/json.hpp"
#include "imulab/model/conclusion.hpp"

#include <string>

namespace imulab {

/// "b relative to a: rotation to 0.31 deg, lever arm to 1.2 mm, clock to 0.03 ms"; of several the worst.
Conclusion conclusion_of(const Extrinsics& extrinsics);
std::string extrinsics_json(const Extrinsics& extrinsics);
std::string extrinsics_text(const Extrinsics& extrinsics, bool details);

namespace result_io {
Extrinsics extrinsics_of(const json_io::Field& root);
}

}  // namespace imulab
