#include "imulab/io/mission_file.hpp"

#include "imulab/io/file.hpp"
#include "imulab/io/mission_fields.hpp"

#include <fmt/format.h>

namespace imulab {
namespace {

constexpr std::string_view mission_format = "imulab.mission/1";

void read_format(TomlFields& f) {
  std::string format;
  f.text("format", format);
  const bool newer = format.starts_with("imulab.mission/");
  f.check(format == mission_format, "format",
          fmt::format("\"{}\" is {}, expected \"{}\"", format, newer ? "a format this version does not know" : "not a mission", mission_format));
}

}  // namespace

Mission read_mission(const std::filesystem::path& path) {
  const MappedFile mapped(path);
  TomlFields f(path.string(), mapped.text());
  Mission mission;
  read_format(f);
  describe(f, mission, path);
  f.done();
  return mission;
}

}  // namespace imulab
