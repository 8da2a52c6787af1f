// Files of other programs in tests/imports.
#pragma once

#include "imulab/exchange.hpp"

#include "tests/run_command.hpp"
#include <string>

namespace imulab::export_test {

inline std::string import_file(const std::string& name) { return read_text(IMULAB_SOURCE "/tests/imports/" + name); }

inline const std::string imucal_text = import_file("imucal.json"), psins_text = import_file("psins.txt"), chain = import_file("opencv.yaml");

inline Imported import(const std::string& text, const ImportOptions& options = {}) { return import_calibration_text(text, "file", options); }

}  // namespace imulab::export_test
