// imulab-read, the program that reads HDF5 and MATLAB files: the only one that is linked with their libraries, in a process that can do nothing else.
#pragma once

#include "imulab/formats/recording/child/child.hpp"
#include "imulab/formats/recording/format.hpp"
#include "imulab/formats/recording/table.hpp"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::recording_io {

/// What imulab-read is asked for: the tables of a file, or columns of one.
struct ReadRequest {
  std::string format;  ///< "HDF5" or "MATIO", by the name of its library in build()
  ChildTask task;
  bool describes = false;
  std::string topic{};
  std::vector<Column> columns{};
};
std::string to_text(const ReadRequest& request);
/// Throws Error for a text of another form.
ReadRequest read_request(std::string_view text);

/// A format whose files imulab-read reads.
struct ProgramFormat {
  std::string_view name, noun, library, package;  ///< "HDF5", "HDF5", "libhdf5", "libhdf5-dev"
};
std::vector<TableDescription> describe_by_program(const ProgramFormat& format, const TableRequest& request);
TableRows columns_by_program(const ProgramFormat& format, const TableRequest& request, const std::vector<Column>& columns);

/// libexec/imulab-read: in the folder of the program or module `own`, or the nearest one above it, where that folder, libexec and imulab-read belong
/// to root or to the owner of `own` and not everybody may write to them; then where imulab was configured to be installed, /usr, and the file that
/// IMULAB_READ names. Throws Error where there is none, which lists these places and why a file there is not taken.
std::filesystem::path find_read_program(const std::filesystem::path& own);

}  // namespace imulab::recording_io
