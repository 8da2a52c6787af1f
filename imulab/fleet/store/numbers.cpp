#include "imulab/fleet/store/numbers.hpp"

#include "imulab/error.hpp"
#include "imulab/frame.hpp"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <zlib.h>

namespace imulab::fleet {

namespace {

void append(std::string& bytes, double value) {
  static_assert(std::endian::native == std::endian::little, "the bytes of a store are in this order");
  std::array<char, sizeof(double)> b;
  std::memcpy(b.data(), &value, sizeof(double));
  bytes.append(b.data(), b.size());
}

}  // namespace

Numbers numbers_of(const Calibration& given) {
  if (given.estimated.empty()) throw Error("has no uncertainties; expected a calibration with its covariance");
  const Calibration c = in_accelerometer_frame(given);
  const auto n = static_cast<Eigen::Index>(c.estimated.size());
  Numbers out{c.estimated, Eigen::VectorXd(n), c.covariance, c.constant_covariance.diagonal()};
  for (Eigen::Index i = 0; i < n; ++i) {
    const CoefficientIndex index = c.estimated[static_cast<std::size_t>(i)];
    out.values[i] = coefficient_value(c.model, index);
    if (!(c.covariance(i, i) > 0))
      throw Error(fmt::format("{}: its variance is {}; expected it above 0", coefficient(index).name, c.covariance(i, i)));
  }
  if (!out.values.allFinite() || !out.covariance.allFinite() || !out.constant.allFinite()) throw Error("has a number that is not finite");
  return out;
}

std::string packed(const Numbers& numbers) {
  std::string bytes;
  bytes.reserve(sizeof(double) * (packed_numbers(numbers.estimated.size()) + static_cast<std::size_t>(numbers.constant.size())));
  for (const double value : numbers.values) append(bytes, value);
  for (Eigen::Index i = 0; i < numbers.values.size(); ++i)
    for (Eigen::Index j = 0; j <= i; ++j) append(bytes, numbers.covariance(i, j));
  for (const double variance : numbers.constant) append(bytes, variance);
  return bytes;
}

double packed_number(std::string_view data, std::size_t place) {
  double value = 0;
  std::memcpy(&value, data.data() + place * sizeof(double), sizeof(double));
  return value;
}

Numbers unpacked(std::string_view data, const std::vector<CoefficientIndex>& estimated) {
  const auto n = static_cast<Eigen::Index>(estimated.size());
  Numbers out{estimated, Eigen::VectorXd(n), Eigen::MatrixXd(n, n), {}};
  std::size_t place = 0;
  for (double& value : out.values) value = packed_number(data, place++);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) out.covariance(i, j) = out.covariance(j, i) = packed_number(data, place++);
  if (data.size() > place * sizeof(double)) out.constant.resize(n);
  for (double& variance : out.constant) variance = packed_number(data, place++);
  return out;
}

std::string layout_text(const std::vector<CoefficientIndex>& estimated) {
  std::string text;
  for (const CoefficientIndex index : estimated) text += fmt::format("{}{}", text.empty() ? "" : " ", coefficient(index).name);
  return text;
}

std::vector<CoefficientIndex> parse_layout(std::string_view text) {
  std::vector<CoefficientIndex> out;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const CoefficientIndex index = coefficient_index(text.substr(begin, end - begin));
    if (contains(out, index)) throw Error(fmt::format("{}: is there twice", coefficient(index).name));
    out.push_back(index);
    begin = end + 1;
  }
  return out;
}

std::int64_t crc32_of(std::string_view bytes) {
  return static_cast<std::int64_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::string deflated(std::string_view text) {
  uLongf size = compressBound(text.size());
  std::string out(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(text.data()), text.size(), Z_DEFAULT_COMPRESSION) != Z_OK)
    throw Error("cannot be compressed");
  out.resize(size);
  return out;
}

std::string inflated(std::string_view data, std::size_t bytes) {
  constexpr std::size_t most_per_byte = 1100;  // deflate's limit is 1032
  if (bytes > data.size() * most_per_byte) throw Error("its text is damaged");
  std::string out(bytes, '\0');
  uLongf size = bytes;
  if (uncompress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(data.data()), data.size()) != Z_OK || size != bytes)
    throw Error("its text is damaged");
  return out;
}

}  // namespace imulab::fleet
