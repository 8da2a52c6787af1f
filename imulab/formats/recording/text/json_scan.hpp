// A flat view of JSON for long texts of rows: values in their order, each with its path, without a tree in memory.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

namespace imulab::recording_io {

enum class JsonEnd { whole, cut, wrong };

/// A value that is no array and no object: as it is written, a string without its quotes.
struct JsonScalar {
  std::string_view text;
  bool is_string = false;
};

/// The end of the value that begins at `place`, of any depth up to 64.
struct JsonExtent {
  JsonEnd how = JsonEnd::wrong;
  std::size_t end = 0;
};
JsonExtent skip_json(std::string_view text, std::size_t place);
std::size_t skip_json_blanks(std::string_view text, std::size_t place);

/// Calls `each` with the scalars of a value, in order: "acc.x" for {"acc": {"x": 1}}, "acc.2" for the second of an array. `text` is one whole value.
/// False where it is no JSON or deeper than eight.
bool for_json_scalars(std::string_view text, const std::function<void(std::string_view path, const JsonScalar& value)>& each);

/// Calls `each` with the members of an object, or the elements of an array without keys; `text` is one whole value.
bool for_json_members(std::string_view text, const std::function<void(std::string_view key, std::string_view value)>& each);

/// Appends a scalar as a field of a text between commas: true is 1, null is nothing, a comma or the end of a line in a string is a blank.
void append_json_field(const JsonScalar& value, std::string& out);

}  // namespace imulab::recording_io
