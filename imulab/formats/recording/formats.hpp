// The rows of the table of formats (format.cpp), each from its own file.
#pragma once

#include "imulab/formats/recording/format.hpp"

namespace imulab::recording_io {

RecordingFormat numpy_format();
RecordingFormat matlab_format();
RecordingFormat hdf5_format();
RecordingFormat binary_rows_format();
RecordingFormat ulog_format();
RecordingFormat dataflash_format();
RecordingFormat text_format();

}  // namespace imulab::recording_io
