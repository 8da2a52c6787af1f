// The sessions of docs/reference/recordings.md read the files of tests/recordings/.
#include "imulab/files.hpp"
#include "imulab/formats/recording/reader.hpp"

#include <gmock/gmock.h>

#include "tests/recording_files.hpp"
#include <regex>

namespace imulab {
namespace {

TEST(DocumentedFormats, EverySessionReads) {
  const std::string section = file_bytes(IMULAB_SOURCE "/docs/reference/recordings.md");
  const std::regex block("```toml\n([^`]*)```"), file("file += \"([^\"]+)\"");
  std::size_t sessions = 0;
  for (std::sregex_iterator i(section.begin(), section.end(), block), last; i != last; ++i, ++sessions) {
    const std::string text = (*i)[1];
    const TemporaryFolder folder;
    std::smatch named;
    ASSERT_TRUE(std::regex_search(text, named, file)) << text;
    std::filesystem::copy(recording_file(named[1]), folder / named[1].str());
    const Session session = read_session(folder.write("session.toml", text));
    if (error_of({.file = folder / named[1].str()}, {1}).find("built without") != std::string::npos) continue;
    const Recording recording = read_recording(session, session.recordings.at(0)).recording;
    ASSERT_GE(recording.size(), 37u) << text;
    EXPECT_NEAR(recording.interval_s, 0.008, 1e-12) << text;
    for (std::size_t k = 0; k < 3; ++k) {  // increments are divided by the interval again
      EXPECT_NEAR(recording.gyro[k][5], fixture_gyro(5, k), 1e-12) << text;
      EXPECT_NEAR(recording.accel[k][5], fixture_accel(5, k), 1e-12) << text;
    }
  }
  EXPECT_GE(sessions, 8u);
}

}  // namespace
}  // namespace imulab
