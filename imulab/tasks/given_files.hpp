// What files are that are given together: recordings of one unit, the files of receivers and other aids, a session. Of each only the begin is read.
#pragma once

#include "imulab/aid.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// True where a text is a session and no recording: a line of its first 64 KiB begins with format = "imulab.session/, which no row of numbers does.
bool is_session_text(std::string_view text);

struct GivenFiles {
  std::vector<std::string> recordings;
  std::vector<Aid> aids;  ///< their kinds and files
  std::string session;    ///< empty where there is none
};

/// Throws Error for a saved result, with the verbs that take it, for two sessions, and for settings that are none.
GivenFiles given_files(const std::vector<std::string>& files);

}  // namespace imulab
