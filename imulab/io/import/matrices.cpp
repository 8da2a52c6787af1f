// Files of numbers: imu_tk's .calib (Kyle-ak/imu_tk: include/imu_tk/calibration.h, out = T K (u - b)), a matrix and a bias, and VectorNav's registers
// 25 and 84 (both: out = C (u - b)).
#include "imulab/io/import/numbers.hpp"

#include <fmt/format.h>

namespace imulab::import_io {

namespace {

constexpr std::size_t matrix_and_bias = 12, imu_tk_numbers = 21;

/// How many numbers a text of numbers alone has; 0 where it has anything else, or more than two triads of imu_tk.
std::size_t count_of_numbers(std::string_view text) {
  std::size_t count = 0;
  for (const Line& line : lines_of(text))
    for (const std::string_view word : words_of(line.text))
      if (!finite_number(word) || ++count > 2 * imu_tk_numbers) return 0;
  return count;
}

void set_numbers(TriadModel& m, const Matrix3d& C, const double* b) {
  m.matrix = C;
  m.offset = -C * Eigen::Map<const Vector3d>(b);
}

/// A text that begins with a number, of at most `most` of them: one that is damaged is told where.
bool begins_with_number(std::string_view text) {
  const auto lines = lines_of(text);
  return !lines.empty() && finite_number(words_of(lines.front().text).empty() ? "" : words_of(lines.front().text).front()).has_value();
}

}  // namespace

bool is_imu_tk(std::string_view text) { return count_of_numbers(text) == imu_tk_numbers; }
bool is_plain_matrix(std::string_view text) { return begins_with_number(text); }
bool is_vectornav(std::string_view text) { return text.find("VNWRG,") != std::string_view::npos || text.find("VNRRG,") != std::string_view::npos; }

ImportedModel read_imu_tk(const Source& s) {
  const Numbers n = numbers_of(s, imu_tk_numbers);
  const double* v = n.values.data();
  const Matrix3d T = matrix_from(v), K = matrix_from(v + 9);
  if (!K.isDiagonal(0)) fail_at(s, n.lines[9], "the second matrix of imu_tk holds scales; expected a diagonal matrix");
  ImportedModel out;
  out.one_triad = true;
  out.raw_known = false;
  set_numbers(out.model.accel, T * K, v + 18);
  return out;
}

ImportedModel read_plain_matrix(const Source& s) {
  const Numbers n = numbers_of(s, 2 * matrix_and_bias);
  if (n.values.size() != matrix_and_bias && n.values.size() != 2 * matrix_and_bias)
    fail_at(s, n.lines.back(),
            fmt::format("{} numbers; expected 12 (a matrix by rows, then a bias), 24 (accelerometers, then gyros), or imu_tk's 21", n.values.size()));
  ImportedModel out;
  out.one_triad = n.values.size() == matrix_and_bias;
  out.raw_known = false;
  const double* v = n.values.data();
  set_numbers(out.model.accel, matrix_from(v), v + 9);
  if (!out.one_triad) set_numbers(out.model.gyro, matrix_from(v + matrix_and_bias), v + matrix_and_bias + 9);
  return out;
}

ImportedModel read_vectornav(const Source& s) {
  ImportedModel out;
  bool accel = false, gyro = false;
  for (const Line& line : lines_of(s.text)) {
    const auto words = words_of(line.text, " \t\r,*$");
    if (words.size() < 2 || (words[0] != "VNWRG" && words[0] != "VNRRG") || (words[1] != "25" && words[1] != "84")) continue;
    bool& seen = words[1] == "25" ? accel : gyro;
    if (seen) fail_at(s, line.number, fmt::format("register {}: is given twice; expected each register once", words[1]));
    seen = true;
    if (words.size() < 2 + matrix_and_bias || words.size() > 3 + matrix_and_bias)
      fail_at(s, line.number, fmt::format("register {}: expected 12 numbers", words[1]));
    std::vector<double> v;
    for (std::size_t i = 2; i < 2 + matrix_and_bias; ++i) {
      const auto value = finite_number(words[i]);
      if (!value) fail_at(s, line.number, fmt::format("\"{}\": expected a number", printable(words[i])));
      v.push_back(*value);
    }
    set_numbers(words[1] == "25" ? out.model.accel : out.model.gyro, matrix_from(v.data()), v.data() + 9);
  }
  if (!accel || !gyro) fail_at(s, 0, fmt::format("register {}: is missing; expected registers 25 and 84", accel ? 84 : 25));
  out.model.accel.raw_unit = "m/s^2";
  out.model.gyro.raw_unit = "rad/s";
  return out;
}

}  // namespace imulab::import_io
