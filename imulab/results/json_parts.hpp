// What the sources that write results as JSON share. Slow to compile: for them, no others.
#pragma once

#include "imulab/formats/text/json_dump.hpp"

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace imulab::result_io {

using Json = nlohmann::ordered_json;

/// As dump(2), but a list of many numbers is one line.
inline void write_json(std::string& out, const Json& json, std::size_t indent = 0) {
  constexpr std::size_t many = 16;
  const auto plain = [](const Json& j) { return dump_json(j, -1); };
  const bool numbers =
      json.is_array() && json.size() >= many && std::all_of(json.begin(), json.end(), [](const Json& j) { return j.is_number() || j.is_null(); });
  if (!json.is_structured() || json.empty() || numbers) {
    out += plain(json);
    return;
  }
  out += json.is_array() ? '[' : '{';
  const char* separator = "\n";
  for (const auto& item : json.items()) {
    out += separator + std::string(indent + 2, ' ');
    if (json.is_object()) out += plain(item.key()) + ": ";
    write_json(out, item.value(), indent + 2);
    separator = ",\n";
  }
  out += '\n' + std::string(indent, ' ') + (json.is_array() ? ']' : '}');
}

inline std::string json_text_of(const Json& json) {
  std::string text;
  write_json(text, json);
  return text + "\n";
}

/// Numbers for pictures, with this number of digits.
inline double with_digits(double value, int digits = 6) {
  if (value == 0 || !std::isfinite(value)) return value;
  const double size = std::pow(10.0, digits - 1 - static_cast<int>(std::floor(std::log10(std::abs(value)))));
  return std::isfinite(size) && size > 0 ? std::round(value * size) / size : value;
}

/// `count` numbers: number(i).
template <class Number>
Json picture_list(std::size_t count, const Number& number, int digits = 6) {
  Json list = Json::array();
  for (std::size_t i = 0; i < count; ++i) list.push_back(with_digits(number(i), digits));
  return list;
}

/// Indices of at most about `most` of `count` things, the last included.
inline std::vector<std::size_t> thinned(std::size_t count, std::size_t most) {
  const std::size_t step = std::max<std::size_t>(1, (count + most - 1) / most);
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < count; i += step) indices.push_back(i);
  if (count > 0 && indices.back() != count - 1) indices.push_back(count - 1);
  return indices;
}

}  // namespace imulab::result_io
