// The formats of aids' files, in one table.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/formats/aid/rows.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::aid_io {

struct AidRequest {
  std::filesystem::path file;
  AidKind kind = AidKind::gnss;
  std::string topic{};  ///< of a log that has several; empty: the one of this kind
};

/// A format. To add one: a source file of this folder that reads it, and its row in aid_formats().
struct AidFormat {
  std::string_view name;
  /// True if a file is in this format, by its first bytes: 4096, or all of a shorter file.
  bool (*recognizes)(std::string_view head);
  /// Throws Error with file and place for what is damaged, and for a kind of aid that the file does not have.
  AidRows (*read)(const AidRequest& request);
  bool has_topics = false;                                               ///< is a log of several tables
  bool (*recognizes_path)(const std::filesystem::path& path) = nullptr;  ///< of a log that is several files: a folder, or joined names
};

/// All formats. The first that recognizes a file reads it; CSV comes last.
const std::vector<AidFormat>& aid_formats();

AidFormat rtklib_format();
AidFormat nmea_format();
AidFormat novatel_solution_format();
AidFormat bag_aid_format();
AidFormat ulog_aid_format();
AidFormat dataflash_aid_format();
AidFormat tum_format();
AidFormat euroc_format();
AidFormat aid_csv_format();

/// True for poses as text, by their first row: a unit quaternion tells them from eight columns of an IMU.
bool is_trajectory(std::string_view head);

/// The aid that a file is which holds nothing else: a trajectory of poses, a receiver's positions, or a CSV with the columns and the time of an aid
/// and without an IMU's.
std::optional<AidKind> kind_of_aid(const std::filesystem::path& file);

/// Throws Error unless the aid is a receiver's: `what` has nothing else.
void expect_gnss(const AidRequest& request, std::string_view what);

/// The CSV of an aid that read_aids reads back: t on the recording's clock, then the columns of its kind, after a line of comment.
std::string aid_csv(const Aid& aid, std::string_view comment);

}  // namespace imulab::aid_io
