#include "imulab/io/export/write.hpp"

#include <fmt/format.h>

namespace imulab::export_io {

namespace {

std::string with_point(std::string text) {
  if (text.find('.') != std::string::npos) return text;
  const std::size_t exponent = text.find('e');
  text.insert(exponent == std::string::npos ? text.size() : exponent, ".0");
  return text;
}

}  // namespace

std::string number_text(double value) { return with_point(fmt::format("{}", value + 0.0)); }  // no -0
std::string float_text(double value) { return with_point(fmt::format("{}", static_cast<float>(value) + 0.0f)); }

std::string row_text(const Vector3d& row) { return fmt::format("[{}, {}, {}]", number_text(row[0]), number_text(row[1]), number_text(row[2])); }

std::string matrix_text(std::string_view indent, std::string_view key, const Matrix3d& m) {
  std::string text = fmt::format("{}{}:\n", indent, key);
  for (int i = 0; i < 3; ++i) text += fmt::format("{}  - {}\n", indent, row_text(m.row(i).transpose()));
  return text;
}

std::string plain(std::string_view text) {
  constexpr std::size_t longest = 120;
  std::string out;
  for (const char c : text.substr(0, longest)) out += c >= ' ' && c <= '~' ? c : ' ';
  return out;
}

std::string comment_head(const ExportInput& input, std::string_view program, const std::vector<std::string>& facts,
                         const std::vector<std::string>& lost) {
  const Calibration& c = input.calibration;
  std::string text = fmt::format("# Calibration of \"{}\", method {}, {}, for {}.\n# Written by {}.\n#\n", plain(c.imu), plain(c.method),
                                 plain(c.created), program, plain(c.software.empty() ? "imulab" : c.software));
  for (const std::string& fact : facts) text += "# " + fact + "\n";
  text += lost.empty() ? "# Nothing of this calibration is lost.\n" : "# Not held by this file, with its largest effect for this calibration:\n";
  for (const std::string& sentence : lost) text += "# - " + sentence + "\n";
  return text + "#\n";
}

}  // namespace imulab::export_io
