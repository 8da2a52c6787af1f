// The sessions below folders, and the occasion of each.
#include "imulab/files.hpp"
#include "imulab/session.hpp"
#include "imulab/tasks/fleet.hpp"

#include <gmock/gmock.h>

#include "tests/temporary_folder.hpp"
#include <filesystem>
#include <string>
#include <vector>

namespace imulab {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::UnorderedElementsAre;

TEST(FleetSessions, AreFoundBehindLinksEachOnce) {
  const TemporaryFolder folder, archive;
  for (const fs::path& place : {folder / "week/a", folder / "week/b/c", archive / "unit"}) {
    fs::create_directories(place);
    write_whole(place / "session.toml", "");
  }
  fs::create_directory_symlink(archive / "unit", folder / "week/linked");
  fs::create_directory_symlink(archive / "unit", folder / "week/linked-again");
  fs::create_directory_symlink(folder / "week/a", folder / "week/0");  // beside the folder itself
  fs::create_directory_symlink(folder / "week", folder / "week/b/round");
  const auto found = [&](const std::vector<fs::path>& places) {
    std::vector<std::string> out;
    for (const fs::path& file : sessions_below(places)) out.push_back(file.lexically_relative(folder.path()).parent_path().string());
    return out;
  };
  EXPECT_THAT(found({folder / "week"}), ElementsAre("week/a", "week/b/c", "week/linked"));
  EXPECT_THAT(found({folder / "week/b/c", folder / "week", folder / "week/linked"}), ElementsAre("week/b/c", "week/a", "week/linked"));
  fs::create_symlink(folder / "week/a/session.toml", folder / "week/b/session.toml");  // beside recordings of its own
  EXPECT_THAT(found({folder / "week/b"}), UnorderedElementsAre("week/b", "week/b/c", "week/b/round/a", "week/b/round/linked"));
}

TEST(FleetSessions, TheirOwnOperatorStands) {
  Session session;
  EXPECT_EQ(occasion_of(session, {}, {.station = "2", .operated_by = "Ada"}).operated_by, "Ada");
  session.operated_by = "Grace", session.station = "1";
  const FleetOccasion own = occasion_of(session, {}, {.station = "2", .operated_by = "Ada"});
  EXPECT_EQ(own.operated_by, "Grace");
  EXPECT_EQ(own.station, "2");
}

}  // namespace
}  // namespace imulab
