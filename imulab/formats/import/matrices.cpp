// Files of numbers: imu_tk's .calib (Kyle-ak/imu_tk: include/imu_tk/calibration.h, out = T K (u - b)), a matrix and a bias, and VectorNav's registers
// 25 and 84 (both: out = C (u - b)).
#include "imulab/formats/import/numbers.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>

namespace imulab::import_io {

namespace {

constexpr std::size_t matrix_and_bias = 12, imu_tk_numbers = 21;

/// The number of numbers in a text of numbers alone; 0 where it has anything else, or more than two triads of imu_tk.
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

struct TriadLines {
  bool beside;  ///< b is the fourth column: [C | b]
};

/// The triads of a text by its lines: nothing else than these layouts is a matrix and a bias. Numbers of another order would be taken for them.
std::vector<TriadLines> triads_of(const Source& s, const Numbers& n) {
  static const std::vector<std::vector<std::size_t>> layouts{{12}, {9, 3}, {3, 3, 3, 3}, {4, 4, 4}};
  std::vector<std::size_t> counts;
  for (std::size_t i = 0; i < n.lines.size(); ++i) {
    if (i == 0 || n.lines[i] != n.lines[i - 1]) counts.push_back(0);
    ++counts.back();
  }
  std::vector<TriadLines> out;
  for (auto at = counts.begin(); at != counts.end();) {
    const auto layout = std::find_if(layouts.begin(), layouts.end(), [&](const std::vector<std::size_t>& l) {
      return static_cast<std::size_t>(counts.end() - at) >= l.size() && std::equal(l.begin(), l.end(), at);
    });
    if (layout == layouts.end())
      fail_at(s, n.lines.front(),
              fmt::format("lines of {} numbers; expected C and b of a triad as one line of 12, lines of 9 and 3, four lines of 3 (the last is b), or "
                          "three lines of 4, [C | b]",
                          fmt::join(counts, ", ")));
    out.push_back({layout->size() == 3});
    at += static_cast<std::ptrdiff_t>(layout->size());
  }
  return out;
}

/// Checks the line's "*XX" (exclusive or of the bytes between $ and *) or "*XXXX" (CRC-16 of CCITT): VN-100 user manual UM001, sections 3.8.2, 3.8.3.
void check_sum(const Source& s, const Line& line, std::string_view number) {
  const std::size_t star = line.text.rfind('*'), dollar = line.text.find('$'), begin = dollar == std::string_view::npos ? 0 : dollar + 1;
  const std::string_view stated = star == std::string_view::npos ? "" : line.text.substr(star + 1);
  if (stated.size() != 2 && stated.size() != 4)
    fail_at(s, line.number, fmt::format("register {}: has no checksum, the line may be cut; expected *XX at its end", number));
  unsigned sum = 0;
  for (const char c : line.text.substr(begin, star - begin)) {
    const unsigned byte = static_cast<unsigned char>(c);
    if (stated.size() == 2) {
      sum ^= byte;
      continue;
    }
    sum = ((sum >> 8U) | (sum << 8U)) & 0xffffU;
    sum ^= byte;
    sum ^= (sum & 0xffU) >> 4U;
    sum = (sum ^ (sum << 12U)) & 0xffffU;
    sum = (sum ^ ((sum & 0xffU) << 5U)) & 0xffffU;
  }
  unsigned found = 0;
  const auto [end, error] = std::from_chars(stated.data(), stated.data() + stated.size(), found, 16);
  if (error != std::errc() || end != stated.data() + stated.size() || found != sum)
    fail_at(s, line.number,
            fmt::format("register {}: its checksum is {}, that of its text {:0{}X}; expected a line without damage", number, excerpt(stated), sum,
                        stated.size()));
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
  out.raw_known = false;
  const std::vector<TriadLines> triads = triads_of(s, n);
  out.one_triad = triads.size() == 1;
  const double* v = n.values.data();
  for (std::size_t k = 0; k < triads.size(); ++k, v += matrix_and_bias) {
    TriadModel& m = k == 0 ? out.model.accel : out.model.gyro;
    if (!triads[k].beside) {
      set_numbers(m, matrix_from(v), v + 9);
      continue;
    }
    const Eigen::Matrix<double, 3, 4, Eigen::RowMajor> both = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(v);
    const Vector3d b = both.col(3);
    set_numbers(m, both.leftCols<3>(), b.data());
  }
  if (std::any_of(triads.begin(), triads.end(), [](const TriadLines& t) { return t.beside; }))
    out.warnings.emplace_back("lines of four numbers: taken as C and b of C (u - b); where the fourth is added to the output, C u + t, b is -C^-1 t");
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
      if (!value) fail_at(s, line.number, fmt::format("\"{}\": expected a number", excerpt(words[i])));
      v.push_back(*value);
    }
    check_sum(s, line, words[1]);
    set_numbers(words[1] == "25" ? out.model.accel : out.model.gyro, matrix_from(v.data()), v.data() + 9);
  }
  if (!accel || !gyro) fail_at(s, 0, fmt::format("register {}: is missing; expected registers 25 and 84", accel ? 84 : 25));
  out.model.accel.raw_unit = "m/s^2";
  out.model.gyro.raw_unit = "rad/s";
  return out;
}

}  // namespace imulab::import_io
