// The conclusion of an answer as the begin of its JSON: "verdict", "headline", "warnings" (docs/reference/results.md).
#pragma once

#include "imulab/formats/text/json.hpp"
#include "imulab/model/conclusion.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Where the keys of a conclusion stand: a file that has its own fields first, calibration.json, has them at its end.
enum class ConclusionPlace { begin, end };

/// The text of a JSON object with its conclusion: "verdict" (null: nothing was judged), "headline", "warnings", and "requirements" where there are
/// any. Lists stay as they are.
std::string with_conclusion(const std::string& json, const Conclusion& conclusion, const std::vector<std::string>& warnings,
                            ConclusionPlace place = ConclusionPlace::begin);

/// The text of a saved result: "format": "imulab.KIND/1", then the fields of an object.
std::string result_text(std::string_view kind, JsonValue object, JsonLayout layout = JsonLayout::indented);

/// Of a saved result; empty where it is of an earlier version. Throws Error that names the key that is wrong.
Conclusion conclusion_of(const json_io::Field& root);

}  // namespace imulab
