// The formats of imulab-read: each opens the file, closes the sandbox, and answers a request. Throws Error as the format's read does.
#pragma once

#include "imulab/formats/recording/child/read_program.hpp"

namespace imulab::recording_io {

void answer_hdf5(const ReadRequest& request, ToParent& to);
void answer_matlab(const ReadRequest& request, ToParent& to);

}  // namespace imulab::recording_io
