// VectorNav: the user's compensation of accelerometers and gyros as commands, registers 25 and 84 (VN-100 user manual UM001: 12 numbers C00 C01 ...
// C22 B0 B1 B2, output = C (input - B); section 3.8.2: the checksum).
#include "imulab/export/device_axes.hpp"
#include "imulab/export/loss.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>

#include <cstdint>

namespace imulab::export_io {

namespace {

constexpr Held vectornav_holds{.accel_matrix = true, .gyro_matrix = true, .accel_scale = true, .gyro_scale = true, .bias = true};

/// "$BODY*XX": the checksum is the exclusive or of the body's bytes.
std::string command(const std::string& body) {
  std::uint8_t checksum = 0;
  for (const char c : body) checksum = static_cast<std::uint8_t>(checksum ^ static_cast<std::uint8_t>(c));
  return fmt::format("${}*{:02X}\r\n", body, checksum);
}

std::string write_register(int number, const ConsumerTriad& m) {
  std::string body = fmt::format("VNWRG,{}", number);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) body += "," + float_text(m.C(i, j));
  for (int i = 0; i < 3; ++i) body += "," + float_text(m.b[i]);
  return command(body);
}

}  // namespace

std::string vectornav_text(const ExportInput& input) {
  expect_si_readings(input.calibration.model);
  const DeviceAxes axes = device_axes(input.calibration);
  const ConsumerModel m = device_model(input.calibration.model, axes);
  Sentences facts{"Holds: offsets and whole matrices.",
                  "output = C (input - B): C is the correction matrix, B [m/s^2, rad/s] is subtracted from readings. Register 25: "
                  "accelerometers, 84: gyros.",
                  "Input: what the device gives with these registers at their default, which is what the calibration's recording must hold."};
  const Sentences more = input_facts(input.calibration);
  facts.insert(facts.end(), more.begin(), more.end());
  facts.emplace_back(axes.turned() ? "Output: along x, y, z of the body, not along the device's own axes: C and B are turned for them."
                                   : "Output: along x, y, z of the body.");
  facts.emplace_back("Numbers are in single precision. Send the lines that begin with $; the last one stores the registers.");
  return comment_head(input, "VectorNav", facts, left_out_of_vectornav(input)) + write_register(25, m.accel) + write_register(84, m.gyro) +
         command("VNWNV");
}

Sentences left_out_of_vectornav(const ExportInput& input) { return losses(input.calibration.model, vectornav_holds); }

}  // namespace imulab::export_io
