// Small results as JSON: what a verb wrote or found.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace imulab {

struct JsonFields;
/// An object in an object.
struct JsonObject {
  std::vector<JsonFields> one;
};
using JsonValue =
    std::variant<bool, std::uint64_t, double, std::string, std::vector<std::string>, std::vector<double>, std::vector<JsonFields>, JsonObject>;

/// An object's keys and values, in their order. Numbers that are not finite become null.
struct JsonFields {
  std::vector<std::pair<std::string, JsonValue>> fields;
};

/// On lines of their own, or all on one; with a new line at the end.
std::string fields_json(const JsonFields& object, bool one_line = false);

}  // namespace imulab
