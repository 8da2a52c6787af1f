#include "imulab/tasks/recordings.hpp"

#include "imulab/core/error.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/format.h>

#include <string_view>
#include <vector>

namespace imulab {
namespace {

void check_thermal_unit(const TriadModel& model, const std::optional<ThermalSource>& source, const std::string& file, const char* triad) {
  if (model.temperature && source && model.temperature->unit != source->unit)
    throw Error(
        fmt::format("{}: the {} temperature is in {}; expected {} as in the calibration", file, triad, source->unit, model.temperature->unit));
}

}  // namespace

const RecordingSource& choose_recording(const Session& session, const std::string& name) {
  std::vector<std::string_view> files;
  for (const RecordingSource& source : session.recordings) {
    if (source.file == name || (name.empty() && session.recordings.size() == 1)) return source;
    files.push_back(source.file);
  }
  if (files.empty()) throw Error(session.file + ": has no recordings; expected at least one [[recording]]");
  throw Error(fmt::format("{}: {}; expected one of {}", session.file, name.empty() ? "has several recordings" : "has no recording " + name,
                          text::listed(files)));
}

void check_thermal_units(const Calibration& calibration, const RecordingSource& source) {
  check_thermal_unit(calibration.model.accel, source.accel_temperature, source.file, "accelerometer");
  check_thermal_unit(calibration.model.gyro, source.gyro_temperature, source.file, "gyro");
}

}  // namespace imulab
