// The parts of an exported header after its compensation.
#pragma once

#include "imulab/export/c_header_input.hpp"

#include <string>

namespace imulab::firmware {

/// imulab_filter, imulab_filter_init, imulab_filter_push, imulab_filter_flush.
std::string filter_text();

/// imulab_selftest: samples with what the library makes of them.
std::string selftest_text(const SensorModel& model, const Input& accel, const Input& gyro);

struct FixedWords;
/// imulab_compensate_fixed and imulab_selftest_fixed; of 16 bits imulab_compensate_q15 and imulab_selftest_q15.
std::string fixed_text(const SensorModel& model, const Input& accel, const Input& gyro, const CHeaderOptions& options, const FixedWords& words);

/// imulab_filter_fixed and its functions; comes after fixed_text, which includes <stdint.h>.
std::string fixed_filter_text();

}  // namespace imulab::firmware
