// HDF5 files: datasets of numbers, in one or two dimensions or of compound elements. So are MATLAB's files of version 7.3. imulab-read reads them
// (apps/imulab_read/hdf5_reader.cpp).
#include "imulab/formats/recording/child/read_program.hpp"
#include "imulab/formats/recording/format.hpp"

namespace imulab::recording_io {
namespace {

constexpr ProgramFormat hdf5{"HDF5", "HDF5", "libhdf5", "libhdf5-dev"};

/// The signature stands at the beginning, or after a block of the user of 512 bytes or a power of two more.
bool is_hdf5(std::string_view head) {
  constexpr std::string_view signature("\x89HDF\r\n\x1A\n", 8);
  for (const std::size_t at : {0u, 512u, 1024u, 2048u})
    if (head.size() >= at && head.substr(at).starts_with(signature)) return true;
  return false;
}

std::vector<TableDescription> describe_hdf5(const TableRequest& request) { return describe_by_program(hdf5, request); }
void read_hdf5(const TableRequest& request, const Wanted& wanted, const PieceSink& sink) { sink(columns_by_program(hdf5, request, wanted.columns)); }

}  // namespace

RecordingFormat hdf5_format() { return {.name = "HDF5 or MATLAB 7.3", .recognizes = is_hdf5, .describe = describe_hdf5, .read = read_hdf5}; }

}  // namespace imulab::recording_io
