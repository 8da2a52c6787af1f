#include "imulab/results/conclusion.hpp"

#include "imulab/formats/text/json_fields.hpp"
#include "imulab/model/calibration_fields.hpp"

#include <fmt/format.h>

#include <array>
#include <string_view>
#include <utility>

namespace imulab {
namespace {

constexpr std::array judged_verdicts{Verdict::met, Verdict::not_met, Verdict::good, Verdict::doubtful};

/// The fields of one object and then those of another, of texts of one layout.
std::string joined_objects(std::string first, std::string_view second) {
  first.erase(first.find_last_of('}'));
  second.remove_prefix(second.find('{') + 1);
  const std::size_t last = first.find_last_not_of(" \t\n");
  const bool empty = second.substr(second.find_first_not_of(" \t\n"), 1) == "}";
  if (empty) return first + "}" + (second.ends_with('\n') ? "\n" : "");
  if (first[last] == '{') return first.substr(0, last + 1) + std::string(second);
  return first.substr(0, last + 1) + "," + std::string(second);
}

}  // namespace

std::string with_conclusion(const std::string& json, const Conclusion& c, const std::vector<std::string>& warnings, ConclusionPlace place) {
  if (!json.starts_with('{')) return json;
  JsonFields head{
      {{"verdict", c.verdict == Verdict::none ? JsonValue() : JsonValue(to_string(c.verdict))}, {"headline", c.headline}, {"warnings", warnings}}};
  if (!c.requirements.empty()) head.fields.emplace_back("requirements", written(c.requirements));
  const bool one_line = json.find('\n') + 1 >= json.size();
  const std::string text = json_text(head, one_line ? JsonLayout::one_line : JsonLayout::indented);
  return place == ConclusionPlace::begin ? joined_objects(text, json) : joined_objects(json, text);
}

std::string result_text(std::string_view kind, JsonValue object, JsonLayout layout) {
  auto& fields = std::get<JsonFields>(object.is).fields;
  fields.emplace(fields.begin(), "format", fmt::format("imulab.{}/1", kind));
  return json_text(object, layout);
}

Conclusion conclusion_of(const json_io::Field& root) {
  Conclusion out;
  if (root.has("verdict") && !root["verdict"].is_null()) {
    JsonReader reader(root);
    fields::choice(reader, "verdict", out.verdict, judged_verdicts, "met, not met, good, doubtful or null");
  }
  if (root.has("headline") && !root["headline"].is_null()) out.headline = root["headline"].text();
  if (!root.has("requirements")) return out;
  const json_io::Field requirements = root["requirements"];  // those of a plan are texts
  const std::size_t count = requirements.size();
  if (count > 0 && requirements.item(0, count, "requirements").has("met")) {
    JsonReader reader(root);
    reader("requirements", out.requirements);
  }
  return out;
}

}  // namespace imulab
