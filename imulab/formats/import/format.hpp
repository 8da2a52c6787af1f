// The formats that `imulab import` reads, in one table.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/sensor_model.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::import_io {

struct Source {
  std::string_view text;
  std::string file;  ///< its name in messages
  int instance = 0;
};

struct ImportedModel {
  SensorModel model;
  bool one_triad = false;                   ///< the file has one triad, in `model.accel`
  bool raw_known = true;                    ///< false: the file does not tell the readings' unit
  std::vector<std::string> not_determined;  ///< names of coefficients that the file says have starting values
  std::optional<RecordedAs> recorded_accel, recorded_gyro;
  std::vector<std::string> warnings;
};

/// A format. To add one: a source file of this folder that reads it, and its row in import_formats().
struct ImportFormat {
  std::string_view name, summary;
  bool (*recognizes)(std::string_view text);
  ImportedModel (*read)(const Source& source);
};
const std::vector<ImportFormat>& import_formats();

bool is_openvins(std::string_view text);
bool is_kalibr(std::string_view text);
bool is_imucal(std::string_view text);
bool is_json_matrix(std::string_view text);
bool is_csv_table(std::string_view text);
bool is_psins(std::string_view text);
bool is_px4(std::string_view text);
bool is_ardupilot(std::string_view text);
bool is_vectornav(std::string_view text);
bool is_imu_tk(std::string_view text);
bool is_plain_matrix(std::string_view text);

ImportedModel read_openvins(const Source& source);
ImportedModel read_kalibr(const Source& source);
ImportedModel read_imucal(const Source& source);
ImportedModel read_json_matrix(const Source& source);
ImportedModel read_csv_table(const Source& source);
ImportedModel read_psins(const Source& source);
ImportedModel read_px4(const Source& source);
ImportedModel read_ardupilot(const Source& source);
ImportedModel read_vectornav(const Source& source);
ImportedModel read_imu_tk(const Source& source);
ImportedModel read_plain_matrix(const Source& source);

/// Throws Error "FILE:LINE: TEXT" (without the line where it is 0).
[[noreturn]] void fail_at(const Source& source, int line, const std::string& text);

/// The inverse of a forward matrix; throws Error naming `what` where there is none.
Matrix3d inverse_at(const Source& source, int line, const std::string& what, const Matrix3d& matrix);

}  // namespace imulab::import_io
