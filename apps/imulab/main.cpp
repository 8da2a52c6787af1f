#include "apps/imulab/command.hpp"
#include "imulab/io/text/unfinished.hpp"

int main(int argc, char** argv) {
  imulab::end_when_memory_ends("imulab: out of memory; expected less data, or a machine with more memory\n");
  return imulab::command::run({argv + 1, argv + argc});
}
