#include "imulab/export/write.hpp"

#include "imulab/error.hpp"
#include "imulab/export/loss.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace imulab::export_io {

namespace {

std::string with_point(std::string text) {
  if (text.find('.') != std::string::npos) return text;
  const std::size_t exponent = text.find('e');
  text.insert(exponent == std::string::npos ? text.size() : exponent, ".0");
  return text;
}

/// Returns true for the calibration `none`, which changes nothing and has no origin.
bool is_noise_alone(const ExportInput& input) {
  const Calibration& c = input.calibration;
  return input.noise != nullptr && c.method.empty() && c.created.empty() && c.imu.empty() && c.estimated.empty() && losses(c.model, {}).empty();
}

}  // namespace

std::string exact_number(double value) { return with_point(fmt::format("{}", value + 0.0)); }  // no -0
std::string float_text(double value) {
  const auto single = static_cast<float>(value);
  if (!std::isfinite(single)) throw Error(fmt::format("{:g} is too large for single precision, which this target has; expected an IMU in SI", value));
  return with_point(fmt::format("{}", single + 0.0f));
}

std::string row_text(const Vector3d& row) { return fmt::format("[{}, {}, {}]", exact_number(row[0]), exact_number(row[1]), exact_number(row[2])); }

std::string matrix_text(std::string_view indent, std::string_view key, const Matrix3d& m) {
  std::string text = fmt::format("{}{}:\n", indent, key);
  for (int i = 0; i < 3; ++i) text += fmt::format("{}  - {}\n", indent, row_text(m.row(i).transpose()));
  return text;
}

std::string topic_text(const ExportInput& input) {
  std::string topic = input.options.topic;
  for (const SourceFile& source : input.calibration.sources)
    if (topic.empty()) topic = source.topic;
  if (topic.empty()) return "/imu0";
  const auto is_plain = [](unsigned char c) { return std::isalnum(c) != 0 || c == '/' || c == '_'; };
  if (topic.front() == '/' && std::all_of(topic.begin(), topic.end(), is_plain)) return topic;
  std::string quoted = "\"";
  for (const char c : topic) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      quoted += {'\\', c};
    else
      quoted += code < 0x20 || code == 0x7f ? fmt::format("\\x{:02X}", code) : std::string(1, c);
  }
  return quoted + "\"";
}

std::string plain(std::string_view text) {
  constexpr std::size_t longest = 120;
  std::string out;
  for (const char c : text.substr(0, longest)) out += c >= ' ' && c <= '~' ? c : ' ';
  return out;
}

std::string calibration_of_text(const Calibration& c, std::string (*clean)(std::string_view)) {
  std::string text = "Calibration of " + (c.imu.empty() ? "an unnamed IMU" : "\"" + clean(c.imu) + "\"") + ", ";
  if (!c.method.empty()) text += "method " + clean(c.method) + ", ";
  return c.created.empty() ? text : text + clean(c.created) + ", ";
}

std::vector<std::string> not_determined(const Calibration& calibration) {
  std::vector<std::string> names = calibration.quality.unobservable;
  for (const std::string& name : unusable(calibration))
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  for (std::string& name : names) name = plain(name);
  return names;
}

std::string comment_head(const ExportInput& input, std::string_view program, const std::vector<std::string>& facts,
                         const std::vector<std::string>& lost) {
  const Calibration& c = input.calibration;
  std::string text =
      fmt::format("# {}for {}.\n# Written by {}.\n#\n", is_noise_alone(input) ? "Noise of an IMU without a calibration, " : calibration_of_text(c),
                  program, plain(c.software.empty() ? "imulab" : c.software));
  for (const std::string& fact : facts) text += "# " + fact + "\n";
  const std::vector<std::string> undetermined = not_determined(c);
  if (!undetermined.empty()) text += "# NOT DETERMINED by the data, starting values that compensate nothing:\n";
  for (std::size_t i = 0; i < undetermined.size(); i += 5)
    text += fmt::format("#   {}\n", fmt::join(undetermined.begin() + static_cast<std::ptrdiff_t>(i),
                                              undetermined.begin() + static_cast<std::ptrdiff_t>(std::min(i + 5, undetermined.size())), ", "));
  text += lost.empty()            ? "# Nothing is left out.\n"
          : is_noise_alone(input) ? "# Not held by this file:\n"
                                  : "# Not held by this file, with its largest effect for this calibration:\n";
  for (const std::string& sentence : lost) text += "# - " + sentence + "\n";
  return text + "#\n";
}

std::string in_comments(std::string_view mark, std::string_view head) {
  std::string out;
  for (std::size_t end = 0; (end = head.find('\n')) != std::string_view::npos; head.remove_prefix(end + 1))
    out += fmt::format("{}{}\n", mark, head.substr(1, end - 1));
  return out;
}

}  // namespace imulab::export_io
