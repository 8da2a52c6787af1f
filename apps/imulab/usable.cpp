#include "apps/imulab/usable.hpp"

#include "imulab/core/error.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/tasks/usable.hpp"

namespace imulab::command {

void add_allow_undetermined(Verb& verb, bool& allowed) {
  verb.flag("--allow-undetermined", allowed, "use a calibration though the data did not determine some of its offsets or matrices");
}

void expect_usable(const Calibration& calibration, const std::string& file, bool allowed) {
  const Usability found = usability(calibration, file);
  for (const std::string& text : found.warnings) warn(text);
  if (found.undetermined.empty()) return;
  if (!allowed) throw Unsupported(found.undetermined + "; expected a calibration from more data, or --allow-undetermined");
  warn(found.undetermined);
}

Calibration read_usable(const std::string& file, bool allowed) {
  Calibration calibration = read_calibration(file);
  expect_usable(calibration, file, allowed);
  return calibration;
}

}  // namespace imulab::command
