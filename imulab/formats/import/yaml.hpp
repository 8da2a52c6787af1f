// YAML as a tree with lines; one source knows yaml-cpp.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/formats/import/format.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::import_io {

struct YamlNode {
  enum class Kind { nothing, scalar, list, map };
  Kind kind = Kind::nothing;
  int line = 0;  ///< from 1
  std::string text;
  std::vector<YamlNode> items;    ///< of a list; values of a map
  std::vector<std::string> keys;  ///< of a map, one an item

  const YamlNode* find(std::string_view key) const;  ///< null: not there, or no map
};

/// The first document. OpenCV's "%YAML:1.0" is accepted, tags are ignored. Throws Error with file and line where the text is no YAML, names a key
/// twice, refers to anchors, is longer than 256 KiB or nested deeper than 20.
YamlNode parse_yaml(const Source& source);

/// The value of a key of a map; throws Error where it is missing. `path` is that of the map, for messages.
const YamlNode& field_of(const Source& source, const YamlNode& map, const std::string& path, std::string_view key);
double number_of(const Source& source, const YamlNode& node, const std::string& path);
/// Rows of numbers, one list row by row, or OpenCV's matrix (rows, cols, data).
Eigen::MatrixXd matrix_of(const Source& source, const YamlNode& node, const std::string& path, int rows, int columns);

}  // namespace imulab::import_io
