#include "imulab/tasks/content.hpp"

#include "imulab/files.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/text/file.hpp"

namespace imulab {

std::string content_of(const std::filesystem::path& file) { return std::filesystem::exists(file) ? file_sum(file).sha256 : "absent"; }

std::vector<IdentityField> content_of(const Session& session) {
  return {{"session", session.sha256.empty() ? sha256(session_text(session)) : session.sha256},
          {"noise", session.noise_taken ? content_of(session_path(session, *session.noise_taken)) : ""}};
}

}  // namespace imulab
