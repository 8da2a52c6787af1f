// imulab_accept [COUNT] [METHOD]: the acceptance test at full size; its figures stand in docs/validation.md.
#include "tests/acceptance/acceptance.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <string>

int main(int argc, char** argv) {
  using namespace imulab::acceptance;
  const int count = argc > 1 ? std::atoi(argv[1]) : 500;
  const std::string only = argc > 2 ? argv[2] : "";
  bool passed = true;
  for (const auto& [name, run] : {std::pair{"handheld", &handheld_run}, std::pair{"static", &static_run}, std::pair{"turntable-2-arcsec", &arcsecond_table_run},
                                 std::pair{"turntable-1-arcmin", &arcminute_table_run}}) {
    if (!only.empty() && only != name) continue;
    const auto checks = judge(run_all(run, count));
    fmt::print("{}: {} sessions, seeds 1..{}\n{}", name, count, count, describe(checks));
    passed = passed && std::all_of(checks.begin(), checks.end(), [](const Check& c) { return c.passed(); });
  }
  return passed ? 0 : 1;
}
