// imulab-read PIPE MEMORY REQUEST: reads HDF5 and MATLAB files for imulab, which gives it three descriptors. It is the only program that is linked
// with the libraries for them; damaged files can crash these, and hostile ones might do more.
#include "imulab/error.hpp"
#include "imulab/formats/recording/child/read_program.hpp"

#include "apps/imulab_read/readers.hpp"
#include "apps/imulab_read/sandbox.hpp"
#include <array>
#include <cstdlib>
#include <iostream>
#include <malloc.h>
#include <string>
#include <unistd.h>

namespace {

using namespace imulab;
using namespace imulab::recording_io;

/// All of a descriptor.
std::string text_of(int descriptor) {
  std::string text;
  std::array<char, 4096> part;
  for (ssize_t got = 0; (got = ::pread(descriptor, part.data(), part.size(), static_cast<off_t>(text.size()))) > 0;)
    text.append(part.data(), static_cast<std::size_t>(got));
  return text;
}

void answer(const ReadRequest& request, int pipe, ToParent& to) {
  enter_sandbox(pipe, request.task.file);
#ifdef IMULAB_WITH_HDF5
  if (request.format == "HDF5") return answer_hdf5(request, to);
#endif
#ifdef IMULAB_WITH_MATIO
  if (request.format == "MATIO") return answer_matlab(request, to);
#endif
  throw Error(request.task.file.string() + ": imulab-read was built without " + request.task.library + "; expected one that has it");
}

}  // namespace

int main(int count, char** words) try {
  if (count != 4) {
    std::cerr << "imulab-read is run by imulab, to read HDF5 and MATLAB files\n";
    return 2;
  }
  const int pipe = std::atoi(words[1]), memory = std::atoi(words[2]), text = std::atoi(words[3]);
  ::mallopt(M_TRIM_THRESHOLD, 1 << 28), ::mallopt(M_MMAP_THRESHOLD, 1 << 28);  // piece after piece in the same memory, which the system clears once
  const ReadRequest request = read_request(text_of(text));
  answer_parent(pipe, memory, request.task, [&](ToParent& to) { answer(request, pipe, to); });
} catch (const std::exception& e) {
  std::cerr << e.what() << '\n';
  return 2;
}
