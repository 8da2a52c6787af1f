// Fusion (xioTechnologies/Fusion, commit d69784c: Fusion/FusionModel.h, FusionModelInertial; FusionCalibrationInertial in versions 1.x):
// calibrated = misalignment (sensitivity o (uncalibrated - offset)), single precision; deg/s and g for the AHRS.
#include "imulab/export/device_axes.hpp"
#include "imulab/export/loss.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

namespace imulab::export_io {

namespace {

constexpr Held fusion_holds{.accel_matrix = true, .gyro_matrix = true, .accel_scale = true, .gyro_scale = true, .bias = true};

std::string constants(const char* triad, const ConsumerTriad& m, double output_unit) {
  std::string matrix;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) matrix += fmt::format("{}.{}{} = {}f", i + j > 0 ? ", " : "", "xyz"[i], "xyz"[j], float_text(m.C(i, j)));
  const auto vector = [](const Vector3d& v) {
    return fmt::format("{{.axis = {{.x = {}f, .y = {}f, .z = {}f}}}}", float_text(v[0]), float_text(v[1]), float_text(v[2]));
  };
  return fmt::format(
      "static const FusionMatrix {0}Misalignment = {{.element = {{{1}}}}};\nstatic const FusionVector {0}Sensitivity = {2};\n"
      "static const FusionVector {0}Offset = {3};\n",
      triad, matrix, vector(Vector3d::Constant(1 / output_unit)), vector(m.b));
}

}  // namespace

std::string fusion_text(const ExportInput& input) {
  expect_si_readings(input.calibration.model);
  const ConsumerModel m = device_model(input.calibration.model, device_axes(input.calibration));
  Sentences facts{"Holds: offsets and whole matrices: calibrated = misalignment (sensitivity o (uncalibrated - offset)).",
                  "Input: rad/s and m/s^2, along the device's axes. Output: deg/s and g, along x, y, z of the body.",
                  "FusionModelInertial(gyroscope, gyroscopeMisalignment, gyroscopeSensitivity, gyroscopeOffset), and the same of the accelerometer."};
  const Sentences more = input_facts(input.calibration);
  facts.insert(facts.end(), more.begin(), more.end());
  return in_comments("//", comment_head(input, "Fusion (x-io)", facts, left_out_of_fusion(input))) + "#pragma once\n\n#include \"Fusion.h\"\n\n" +
         constants("gyroscope", m.gyro, unit::deg) + constants("accelerometer", m.accel, unit::g);
}

Sentences left_out_of_fusion(const ExportInput& input) { return losses(input.calibration.model, fusion_holds); }

}  // namespace imulab::export_io
