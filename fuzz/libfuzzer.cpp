// libFuzzer's entry: the target that the environment names in FUZZ_TARGET. With --targets: a line a target with its name, dictionary and seeds.
#include "fuzz/targets.hpp"
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

using imulab::fuzz::Target;

const Target* chosen() {
  const char* const name = std::getenv("FUZZ_TARGET");
  for (const Target& target : imulab::fuzz::targets())
    if (name != nullptr && std::strcmp(target.name, name) == 0) return &target;
  return nullptr;
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* count, char*** arguments) {
  const bool list = *count == 2 && std::strcmp((*arguments)[1], "--targets") == 0;
  if (list)
    for (const Target& target : imulab::fuzz::targets())
      std::printf("%s %s %s\n", target.name, target.dictionary[0] == '\0' ? "-" : target.dictionary, target.seeds);
  if (!list && chosen() == nullptr) std::fputs("FUZZ_TARGET names no target; expected one of imulab_fuzz --targets\n", stderr);
  if (list || chosen() == nullptr) std::exit(list ? 0 : 2);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static void (*const run)(std::string_view) = chosen()->run;
  run({reinterpret_cast<const char*>(data), size});
  return 0;
}
