// imulab_accept [--checkpoint DIR] [COUNT] [NAME] [METHOD]: the acceptance test at full size; docs/validation.md has its figures. With a folder it
// goes on from where it ended, and several processes share the work; the first one tells what came out.
#include "imulab/core/error.hpp"
#include "imulab/estimate/method.hpp"

#include <fmt/core.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/acceptance/shared_runs.hpp"
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace {

using namespace imulab::acceptance;

bool report(const std::string& title, const std::vector<Check>& checks) {
  if (tells()) fmt::print("{}\n{}", title, describe(checks));
  std::fflush(stdout);
  return std::all_of(checks.begin(), checks.end(), [](const Check& c) { return c.passed(); });
}

/// The exit code: 0 where all that was asked for passed.
int run(int argc, char** argv) {
  std::vector<std::string> names(argv + 1, argv + argc);
  if (names.size() >= 2 && names[0] == "--checkpoint") {
    kept_runs() = names[1];
    names.erase(names.begin(), names.begin() + 2);
  }
  const int wanted = names.empty() ? 0 : std::atoi(names[0].c_str());
  if (wanted > 0) names.erase(names.begin());
  const std::string only = names.empty() ? "" : names[0], of_method = names.size() > 1 ? names[1] : "";
  bool any = false;
  const auto chosen = [&](std::string_view name) {
    const bool is = only.empty() || only == name;
    any = any || is;
    return is;
  };
  if (!of_method.empty()) imulab::method(of_method);  // throws where there is none
  const auto count = [&](int usual) { return wanted > 0 ? wanted : usual; };
  bool passed = true;
  for (const imulab::Method& method : imulab::methods())
    for (const Case& c : cases())
      if (c.method == method.name && (chosen(c.name) || chosen(method.name)))
        passed &= report(fmt::format("{}: {} sessions, seeds 1..{}", c.name, count(c.count), count(c.count)),
                         judge(run_all(c.run, count(c.count), std::string(c.name))));
  if (chosen("misspecified"))
    for (const imulab::Method& method : imulab::methods())
      if (of_method.empty() || of_method == method.name)
        passed &=
            report(fmt::format("misspecified {}: {} sessions, seeds 1..{}", method.name, count(500), count(500)), misspecified(method, count(500)));
  if (chosen("predictions"))
    for (const imulab::Method& method : imulab::methods())
      if (of_method.empty() || of_method == method.name)
        passed &=
            report(fmt::format("predictions {}: {} sessions, seeds 1..{}", method.name, count(200), count(200)), predictions(method, count(200)));
  if (chosen("procedures")) passed &= report("procedures: every cell of docs/procedures.md\n", procedures());
  if (chosen("noise")) passed &= report(fmt::format("noise: {} logs, seeds 1..{}", count(500), count(500)), noise_logs(count(500)));
  if (chosen("noise-lengths")) passed &= report(fmt::format("noise-lengths: {} logs of each length", count(400)), noise_lengths(count(400)));
  if (chosen("error-growth")) passed &= report(fmt::format("error-growth: {} runs, seed 1", count(2000)), error_growth(count(2000)));
  if (chosen("whole-unit"))
    passed &= report(fmt::format("whole-unit outputs: {} sessions, seeds 1..{}", count(200), count(200)), whole_unit_outputs(count(200)));
  if (chosen("fleet")) {
    const int by_hand = std::max(1, count(600) / 60);  // a session takes a thousand times as long as a drawn calibration
    passed &= report(fmt::format("fleet: {} fleets, seeds 1..{}", count(600), count(600)), fleets(count(600)));
    passed &= report(fmt::format("fleet by hand: {} fleets, seeds 1..{}", by_hand, by_hand), fleets_by_hand(by_hand));
  }
  if (chosen("drives")) {
    const std::string rates = describe(drives(count(200)));
    if (tells()) fmt::print("drives: {} drives, seeds 1..{}\n{}", count(200), count(200), rates);
  }
  if (chosen("dai-flight")) {
    const DaiFlights flown = dai_flights(count(200));
    for (const auto& [name, flights] : {std::pair{"dai-flight", &flown.with_roll}, std::pair{"dai-flight without its roll", &flown.without_roll}})
      passed &=
          report(fmt::format("{}: {} flights, seeds 1..{}\n{}", name, count(200), count(200), describe_flights(*flights)), judge_flights(*flights));
  }
  if (!any) throw imulab::Error(only + ": is no test; expected one of docs/validation.md");
  return passed ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& e) {
    fmt::print(stderr, "imulab_accept: {}\n", e.what());
    return 2;
  }
}
