#include "apps/imulab/command.hpp"
#include "imulab/formats/text/unfinished.hpp"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace {

/// Arrays as long as a recording are made and freed one after the other: the memory of one is kept for the next, where the system would have to clear
/// every page again.
void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int kept = 1 << 27;  // bytes: longer ones go back, for what grows leaves holes
  mallopt(M_MMAP_THRESHOLD, kept);
  mallopt(M_TRIM_THRESHOLD, kept);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  imulab::end_when_memory_ends("imulab: out of memory; expected less data, or a machine with more memory\n");
  keep_freed_memory();
  return imulab::command::run({argv + 1, argv + argc}, argv[0]);
}
