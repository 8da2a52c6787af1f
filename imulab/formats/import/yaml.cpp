#include "imulab/formats/import/yaml.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/import/numbers.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

namespace imulab::import_io {

namespace {

constexpr std::size_t largest_yaml = std::size_t{256} << 10;
constexpr int deepest = 20;
constexpr std::size_t most_keys = 1000;  // of one map

/// yaml-cpp calls itself for each level, so levels are counted in the text before: brackets that are open, "- - -" and "? ?" in one line, and columns
/// of indentation. A text in quotes may hold brackets; more than 20 of them are refused too.
void expect_shallow(const Source& source) {
  int line = 1, open = 0, marks = 0, indentation = 0;
  bool at_begin = true;
  for (const char c : source.text) {
    if (c == '\n') {
      ++line, marks = indentation = 0, at_begin = true;
      continue;
    }
    if (at_begin && c == ' ') ++indentation;
    if (at_begin && (c == '-' || c == '?' || c == ':')) ++marks;
    if (c != ' ' && c != '-' && c != '?' && c != ':') at_begin = false;
    if (c == '[' || c == '{') ++open;
    if ((c == ']' || c == '}') && open > 0) --open;
    if (open > deepest || marks > deepest || indentation > 10 * deepest)
      fail_at(source, line, fmt::format("nested deeper than {}; expected a calibration", deepest));
  }
}

/// Events to a tree. An alias would let a small text stand for a huge tree: refused.
class TreeBuilder : public YAML::EventHandler {
 public:
  explicit TreeBuilder(const Source& source) : source_(source) {}
  YamlNode root;

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { add(mark, YamlNode::Kind::nothing, ""); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { fail_at(source_, mark.line + 1, "an alias; expected values written out"); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t, const std::string& value) override {
    Level* level = levels_.empty() ? nullptr : &levels_.back();
    if (level != nullptr && level->node.kind == YamlNode::Kind::map && !level->key) {
      if (level->node.find(value) != nullptr) fail_at(source_, mark.line + 1, excerpt(value) + ": is given twice; expected each key once");
      if (level->node.keys.size() >= most_keys) fail_at(source_, mark.line + 1, fmt::format("more than {} keys; expected a calibration", most_keys));
      level->key = value;
      return;
    }
    add(mark, YamlNode::Kind::scalar, value);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    begin(mark, YamlNode::Kind::list);
  }
  void OnSequenceEnd() override { end(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    begin(mark, YamlNode::Kind::map);
  }
  void OnMapEnd() override { end(); }

 private:
  struct Level {
    YamlNode node;
    std::optional<std::string> key;
  };

  void begin(const YAML::Mark& mark, YamlNode::Kind kind) {
    if (levels_.size() >= deepest) fail_at(source_, mark.line + 1, fmt::format("nested deeper than {}; expected a calibration", deepest));
    if (!levels_.empty() && levels_.back().node.kind == YamlNode::Kind::map && !levels_.back().key)
      fail_at(source_, mark.line + 1, "a key that is no text; expected a name");
    levels_.push_back({{kind, mark.line + 1, {}, {}, {}}, {}});
  }
  void end() {
    YamlNode node = std::move(levels_.back().node);
    levels_.pop_back();
    place(std::move(node));
  }
  void add(const YAML::Mark& mark, YamlNode::Kind kind, const std::string& text) { place({kind, mark.line + 1, text, {}, {}}); }
  void place(YamlNode node) {
    if (levels_.empty()) {
      root = std::move(node);
    } else if (Level& level = levels_.back(); level.node.kind == YamlNode::Kind::list) {
      level.node.items.push_back(std::move(node));
    } else {
      if (!level.key) fail_at(source_, node.line, "a key that is no text; expected a name");
      level.node.keys.push_back(*level.key);
      level.node.items.push_back(std::move(node));
      level.key.reset();
    }
  }

  const Source& source_;
  std::vector<Level> levels_;
};

}  // namespace

const YamlNode* YamlNode::find(std::string_view key) const {
  const auto found = std::find(keys.begin(), keys.end(), key);
  return found == keys.end() ? nullptr : &items[static_cast<std::size_t>(found - keys.begin())];
}

YamlNode parse_yaml(const Source& source) {
  if (source.text.size() > largest_yaml) fail_at(source, 0, "is longer than 256 KiB; expected a calibration");
  expect_shallow(source);
  std::string text(source.text);
  if (text.starts_with("%YAML")) text[0] = '#';  // OpenCV's form of the directive is none of YAML
  std::istringstream stream(text);
  TreeBuilder builder(source);
  try {
    YAML::Parser parser(stream);
    if (!parser.HandleNextDocument(builder)) fail_at(source, 0, "has no content; expected a calibration");
  } catch (const YAML::Exception& e) {
    fail_at(source, e.mark.is_null() ? 0 : e.mark.line + 1, "not YAML: " + excerpt(e.msg) + "; expected a calibration");
  }
  return std::move(builder.root);
}

const YamlNode& field_of(const Source& source, const YamlNode& map, const std::string& path, std::string_view key) {
  const YamlNode* found = map.find(key);
  if (found == nullptr) fail_at(source, map.line, fmt::format("{}{}{}: is missing", path, path.empty() ? "" : ".", key));
  return *found;
}

double number_of(const Source& source, const YamlNode& node, const std::string& path) {
  const auto number = node.kind == YamlNode::Kind::scalar ? finite_number(node.text) : std::nullopt;
  if (!number)
    fail_at(source, node.line, path + ": expected a number" + (node.kind == YamlNode::Kind::scalar ? ", found \"" + excerpt(node.text) + "\"" : ""));
  return *number;
}

Eigen::MatrixXd matrix_of(const Source& source, const YamlNode& node, const std::string& path, int rows, int columns) {
  const YamlNode* list = &node;
  if (const YamlNode* data = node.find("data")) {
    if (number_of(source, field_of(source, node, path, "rows"), path + ".rows") != rows ||
        number_of(source, field_of(source, node, path, "cols"), path + ".cols") != columns)
      fail_at(source, node.line, fmt::format("{}: expected {} rows and {} columns", path, rows, columns));
    list = data;
  }
  const std::string expected = fmt::format("{}: expected {} rows of {} numbers", path, rows, columns);
  if (list->kind != YamlNode::Kind::list) fail_at(source, list->line, expected);
  std::vector<const YamlNode*> numbers;
  const bool by_rows = static_cast<int>(list->items.size()) == rows && list->items.front().kind == YamlNode::Kind::list;
  for (const YamlNode& item : list->items) {
    if (by_rows && (item.kind != YamlNode::Kind::list || static_cast<int>(item.items.size()) != columns)) fail_at(source, item.line, expected);
    if (!by_rows) numbers.push_back(&item);
    for (const YamlNode& element : item.items) numbers.push_back(&element);
  }
  if (static_cast<int>(numbers.size()) != rows * columns) fail_at(source, list->line, expected);
  Eigen::MatrixXd m(rows, columns);
  auto number = numbers.begin();
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) m(i, j) = number_of(source, **number++, fmt::format("{}[{}][{}]", path, i, j));
  return m;
}

}  // namespace imulab::import_io
