// The formats of recording files, in one table.
#pragma once

#include "imulab/formats/recording/table.hpp"
#include "imulab/session.hpp"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

namespace bag {
struct BagFormat;
}

/// A table of a recording file.
struct TableRequest {
  std::filesystem::path file;
  std::string topic{};   ///< its name; empty: the only table of the file
  std::string layout{};  ///< of rows of binary numbers, as declared: "f8 f4x6"
};

namespace recording_io {

/// The columns, and stamps, that are read of a table.
struct Wanted {
  std::vector<Column> columns;  ///< one may be requested twice
  bool in_pieces = false;       ///< by a format that can; else all rows are one piece
  /// The stamps, for a format that adds them itself (text).
  TimeSource time{.column = std::nullopt};
  std::optional<double> rate_hz = 1;
};

class TextTable;

/// Takes pieces of neighboring rows, in the order of the file; false where no more are needed.
using PieceSink = std::function<bool(TableRows&&)>;

}  // namespace recording_io

/// A format. To add one: a source file in the folder of its family that reads it, and its row in recording_formats().
struct RecordingFormat {
  std::string_view name;
  /// True if a file is in this format, by its first bytes: 4096, or all of a shorter file.
  bool (*recognizes)(std::string_view head);
  /// The tables of a file, for people who have to choose among them. Throws Error where the file is damaged.
  std::vector<recording_io::TableDescription> (*describe)(const TableRequest& request);
  /// Gives the columns of a table to `sink`, as they are in the file and in the order requested. Only they, or those of a piece, are in memory.
  /// Throws Error with file and place for a table or column that is not there (naming those that are) and for a damaged file.
  void (*read)(const TableRequest& request, const recording_io::Wanted& wanted, const recording_io::PieceSink& sink);
  bool in_pieces = false;               ///< reads in pieces, so that a table is never in memory as a whole
  bool of_layout = false;               ///< reads files whose layout is declared, and no other
  bool is_text = false;                 ///< adds the stamps itself and checks the rows, line by line; may come as a stream
  const bag::BagFormat* bag = nullptr;  ///< of a bag: how it is opened, and copied with other readings
  /// Of recordings that are several files: true for a folder, or joined names, in this format.
  bool (*recognizes_path)(const std::filesystem::path& path) = nullptr;
  recording_io::TextTable (*open_text)(const TableRequest& request) = nullptr;  ///< of recordings whose tables are texts: gives one as a file
};

/// All formats. The first that recognizes a file reads it; text comes last, since other formats may begin like text.
const std::vector<RecordingFormat>& recording_formats();

/// The format of a file. Throws Error that names the formats where none is recognized.
const RecordingFormat& format_of(const TableRequest& request, const std::vector<RecordingFormat>& formats = recording_formats());

namespace recording_io {

/// Of positions of a receiver, by the first bytes of their file: "RTKLIB's .pos", "NMEA 0183"; empty for all else.
std::string_view solution_kind(std::string_view head);

RecordingFormat ros1_bag_format();
RecordingFormat mcap_format();
RecordingFormat ros2_database_format();
RecordingFormat split_bag_format();
RecordingFormat kitti_oxts_format();
RecordingFormat workbook_format();
RecordingFormat novatel_format();
RecordingFormat text_folder_format();
RecordingFormat text_archive_format();
RecordingFormat numpy_format();
RecordingFormat matlab_format();
RecordingFormat hdf5_format();
RecordingFormat ulog_format();
RecordingFormat dataflash_format();
RecordingFormat binary_rows_format();
RecordingFormat text_format();

}  // namespace recording_io

}  // namespace imulab
