// Any bytes as a calibration of another program: an Error is good, anything else is a finding. What is accepted must be a calibration that reads
// back.
#include "imulab/core/error.hpp"
#include "imulab/io/calibration/file.hpp"
#include "imulab/io/import/calibration.hpp"

#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string_view>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace imulab;
  std::optional<Imported> imported;
  try {
    imported = import_calibration_text({reinterpret_cast<const char*>(data), size}, "fuzzed");
  } catch (const Error&) {
    return 0;
  }
  parse_calibration(calibration_text(imported->calibration), "fuzzed");
  return 0;
}
