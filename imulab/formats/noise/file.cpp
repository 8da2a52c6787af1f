#include "imulab/formats/text/file.hpp"

#include "imulab/files.hpp"
#include "imulab/formats/text/json_fields.hpp"
#include "imulab/noise/noise_fields.hpp"

namespace imulab {

namespace {

/// Erases what only a log has: curves, spectrum, the fit.
void erase_fields_of_log(JsonFields& json) {
  const auto of_log = [](const std::pair<std::string, JsonValue>& field) {
    const auto* const list = std::get_if<std::vector<JsonValue>>(&field.second.is);
    return field.first == "deviation" || field.first == "mean" || field.first == "still" || field.first == "spectrum" || field.first == "fit" ||
           field.first == "resolution" || (list != nullptr && list->empty());
  };
  std::erase_if(json.fields, of_log);
  for (auto& [key, value] : json.fields)
    if (key == "axes")
      for (JsonValue& axis : std::get<std::vector<JsonValue>>(value.is)) std::erase_if(std::get<JsonFields>(axis.is).fields, of_log);
}

}  // namespace

std::string noise_json(const NoiseAnalysis& analysis) {
  JsonValue json = written(analysis);
  auto& object = std::get<JsonFields>(json.is);
  std::erase_if(object.fields, [](const auto& field) { return field.first == "warnings"; });  // the answer's own have them
  if (analysis.from_data_sheet()) erase_fields_of_log(object);
  return json_text(json);
}
std::string noise_json(const NoiseBatch& batch) { return json_text(written(batch)); }

ImuNoise read_noise(const std::string& path) {
  const MappedFile file(path, Content::settings);
  return parse_noise(file.text(), input_name(path));
}

ImuNoise parse_noise(std::string_view text, const std::string& file) {
  const JsonValue json = json_io::parse_json(text, file, "noise.json as imulab noise writes it");
  const json_io::Field root(json, file, "");
  if (!root.has("format") || root["format"].text() != "imulab.noise/1") root.fail("expected \"format\": \"imulab.noise/1\"");
  NoiseAnalysis analysis;
  read_into(root, analysis);
  ImuNoise out{.recording = analysis.recording, .interval_s = analysis.interval_s, .gyro_unit = {}, .accel_unit = {}, .gyro = {}, .accel = {}};
  out.from_data_sheet = analysis.from_data_sheet(), out.has_moving = analysis.moving.has_value();
  for (const NoiseAxis& axis : analysis.axes) {
    const bool gyro = axis.name.starts_with("gyro.");
    (gyro ? out.gyro_unit : out.accel_unit) = axis.unit;
    if (axis.fit) (gyro ? out.gyro : out.accel)[static_cast<std::size_t>(axis.name.back() - 'x')] = *axis.fit;
  }
  return out;
}

}  // namespace imulab
