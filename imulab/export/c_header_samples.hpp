// Samples for the self-tests of an exported header.
#pragma once

#include "imulab/export/c_header_input.hpp"
#include "imulab/model/compensate.hpp"

#include <array>

namespace imulab::firmware {

constexpr int sample_count = 4;

/// A sign and a size within [-1, 1], other for each sample and channel.
double fraction(int sample, int channel);

/// The thermal reading of a test sample: within the calibrated range, or 10 about the reference.
double test_temperature(const TriadModel& model, double fraction);

/// The model's sample of readings as the header takes them, six readings and six temperatures.
RawSample raw_sample(const SensorModel& model, const Input& accel, const Input& gyro, const std::array<double, 12>& in);

}  // namespace imulab::firmware
