#include "imulab/io/calibration/file.hpp"

#include <array>
#include <ctime>

namespace imulab {

std::string software() { return "imulab " IMULAB_VERSION; }

void add_provenance(Calibration& calibration, const Session& session) {
  const std::time_t now = std::time(nullptr);
  std::array<char, 32> text;
  const std::size_t size = std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", std::gmtime(&now));
  calibration.created.assign(text.data(), size);
  calibration.software = software();
  calibration.session_file = session.file;
  calibration.session_sha256 = session.sha256;
}

}  // namespace imulab
