// Trajectories of poses as text: "time x y z qx qy qz qw" in seconds (TUM RGB-D benchmark, evo), and comma-separated nanoseconds with the quaternion
// as w, x, y, z (ground truth of EuRoC and TUM-VI). The quaternion turns axes of the tracked body to those of the frame.
#include "imulab/error.hpp"
#include "imulab/formats/aid/format.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/core.h>

#include <array>
#include <charconv>
#include <cmath>

namespace imulab::aid_io {
namespace {

constexpr std::size_t numbers = 8;

struct PoseLayout {
  std::string_view separators;
  bool empty;  ///< parts between two separators may be empty
  bool nanoseconds;
  std::size_t more;                   ///< parts that may follow
  std::array<Eigen::Index, 4> order;  ///< element of x, y, z, w of each part of the quaternion
};
constexpr PoseLayout tum{" \t", false, false, 0, {0, 1, 2, 3}}, euroc{",", true, true, 64, {3, 0, 1, 2}};

bool is_comment(std::string_view line) { return line.empty() || line.front() == '#'; }

std::string_view trimmed(std::string_view part) {
  while (part.starts_with(' ')) part.remove_prefix(1);
  while (part.ends_with(' ')) part.remove_suffix(1);
  return part;
}

std::optional<AidRow> row_in(std::string_view line, const PoseLayout& layout) {
  const std::vector<std::string_view> parts = parts_of(line, layout.separators, layout.empty);
  if (parts.size() < numbers || parts.size() > numbers + layout.more) return std::nullopt;
  AidRow row;
  const std::string_view stamp = trimmed(parts[0]);
  if (layout.nanoseconds) {
    const auto [end, error] = std::from_chars(stamp.data(), stamp.data() + stamp.size(), row.time);
    if (error != std::errc() || end != stamp.data() + stamp.size()) return std::nullopt;
  } else if (const auto ns = nanoseconds_of_text(stamp)) {
    row.time = *ns;
  } else {
    return std::nullopt;
  }
  for (std::size_t k = 1; k < numbers; ++k) {
    const auto number = number_of(trimmed(parts[k]));
    if (!number) return std::nullopt;
    k < 4 ? row.place[static_cast<Eigen::Index>(k) - 1] = *number : row.attitude[layout.order[k - 4]] = *number;
  }
  return row;
}

/// The first line that is no comment, if it is such a row.
std::optional<AidRow> first_pose(std::string_view head, const PoseLayout& layout) {
  for (AidLines lines(head); lines.next();)
    if (!is_comment(lines.line())) return row_in(lines.line(), layout);
  return std::nullopt;
}

AidRows read_poses(const AidRequest& request, const PoseLayout& layout) {
  const MappedFile file(request.file);
  AidRows out{.file = input_name(request.file)};
  if (!has_attitude(request.kind))
    throw Error(fmt::format("{}: is a trajectory of poses, and the aid's kind is {}; expected kind = \"pose\"", out.file, to_string(request.kind)));
  for (AidLines lines(file.text()); lines.next();) {
    if (is_comment(lines.line())) continue;
    std::optional<AidRow> row = row_in(lines.line(), layout);
    if (!row && lines.is_cut()) {
      out.warnings.push_back(fmt::format("{}:{}: the last line is cut off and is left out", out.file, lines.number()));
      break;
    }
    if (!row)
      throw Error(fmt::format("{}:{}: {} is no pose; expected {}", out.file, lines.number(), excerpt(lines.line()),
                              layout.nanoseconds ? "nanoseconds, x, y, z, qw, qx, qy, qz" : "seconds x y z qx qy qz qw"));
    row->line = lines.number();
    if (request.kind == AidKind::attitude) row->place.setConstant(AidRow::none);
    out.rows.push_back(*row);
  }
  return out;
}

}  // namespace

bool is_trajectory(std::string_view head) {
  constexpr double rounding = 0.01;  // of a quaternion's length
  const auto is_pose = [](const std::optional<AidRow>& row) { return row && std::abs(row->attitude.norm() - 1) < rounding; };
  return is_pose(first_pose(head, tum)) || (head.starts_with('#') && is_pose(first_pose(head, euroc)));
}

AidFormat tum_format() {
  return {"a trajectory of poses (TUM)", [](std::string_view head) { return first_pose(head, tum).has_value(); },
          [](const AidRequest& request) { return read_poses(request, tum); }};
}

AidFormat euroc_format() {
  return {"ground truth (EuRoC)", [](std::string_view head) { return head.starts_with('#') && first_pose(head, euroc).has_value(); },
          [](const AidRequest& request) { return read_poses(request, euroc); }};
}

}  // namespace imulab::aid_io
