// The parts of an exported header (c_header.hpp): pieces of C source, the readings that it takes, its filters, integers and self-tests, and its
// names.
#pragma once

#include "imulab/coefficient.hpp"
#include "imulab/compensate.hpp"
#include "imulab/export/c_header.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace imulab::firmware {

// Pieces of C source.

constexpr std::array<const char*, 3> axis_names{"x", "y", "z"};

/// As a literal of the header's number type, exact in double. Throws Error where it is not finite.
std::string literal(double value);
/// An integer constant of up to 62 bits that every C and C++ reads, C++98 included.
std::string literal(std::int64_t value);

/// A text from outside for a comment or between quotes: one line of ASCII that ends neither; other characters become '_', and a long one is cut.
std::string harmless(std::string_view text);

/// A unit as part of a name: "deg/s" is "deg_per_s".
std::string unit_in_name(std::string_view unit);

// The readings that an exported header takes, and how they become those of the model.

struct Input {
  RecordedAs as;
  Triad triad;
  double factor = 1;           ///< from a reading to the model's raw reading, but for the sign
  std::array<int, 3> column;   ///< the reading along each body axis
  std::array<double, 3> sign;  ///< and its sign
  std::string parameter;       ///< "accel_deg_per_s"
  std::string unit;            ///< for people: "g", "counts, 4096 to one g"
  bool counts = false;         ///< integers, as a converter gives them
  const char* triad_name() const { return triad == Triad::accel ? "accel" : "gyro"; }
  const char* sensors() const { return triad == Triad::accel ? "accelerometers" : "gyros"; }
};

/// Throws Error where the given or recorded readings do not fit the model.
Input input_of(const Calibration& calibration, const CHeaderOptions& options, Triad triad);

/// imulab_filter, imulab_filter_init, imulab_filter_push, imulab_filter_flush.
std::string filter_text();

/// imulab_selftest: samples with what the library makes of them.
std::string selftest_text(const SensorModel& model, const Input& accel, const Input& gyro);

struct FixedWords;
/// imulab_compensate_fixed and imulab_selftest_fixed; of 16 bits imulab_compensate_q15 and imulab_selftest_q15.
std::string fixed_text(const SensorModel& model, const Input& accel, const Input& gyro, const CHeaderOptions& options, const FixedWords& words);

/// imulab_filter_fixed and its functions; comes after fixed_text, which includes <stdint.h>.
std::string fixed_filter_text();

// Samples for the self-tests of an exported header.

constexpr int sample_count = 4;

/// A sign and a size within [-1, 1], other for each sample and channel.
double fraction(int sample, int channel);

/// The thermal reading of a test sample: within the calibrated range, or 10 about the reference.
double test_temperature(const TriadModel& model, double fraction);

/// The model's sample of readings as the header takes them, six readings and six temperatures.
RawSample raw_sample(const SensorModel& model, const Input& accel, const Input& gyro, const std::array<double, 12>& in);

// The names of an exported header, and what keeps two headers with the same names apart.

/// Throws Error where names that begin with it would not be C's and C++'s to give: expected are letters, digits and single underscores between them,
/// a letter first.
void expect_prefix(std::string_view prefix);

/// As the header's macros begin: "IMU1" of "imu1".
std::string macro_prefix(std::string_view prefix);

/// C source in which every name that begins with imulab_ or IMULAB_ begins with the prefix instead.
std::string with_prefix(std::string_view source, std::string_view prefix);

/// The comment and the source of a header with its guards: it may be included twice, but another one with the same prefix is a compile error, since
/// either would be used for both IMUs.
std::string guarded(const std::string& comment, const std::string& source, std::string_view prefix);

}  // namespace imulab::firmware
