// imulab_accept [COUNT] [NAME] [METHOD]: the acceptance test at full size; docs/evidence has its figures. Before these, --checkpoint
// DIR goes on from where it ended, and --part K/N -o FILE does a part of every test; imulab_accept --join FILE... tells what came out.
#include "imulab/core/part_file.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/files.hpp"

#include <fmt/format.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/acceptance/shared_runs.hpp"
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace {

using namespace imulab::acceptance;

/// Where only a part is done, nothing is reported.
bool report(const std::string& title, const std::function<std::vector<Check>()>& test) {
  std::vector<Check> checks;
  by_part([&] { checks = test(); });
  if (!tells()) return true;
  fmt::print("{}\n{}", title, describe(checks));
  std::fflush(stdout);
  return std::all_of(checks.begin(), checks.end(), [](const Check& c) { return c.passed(); });
}

/// Takes --checkpoint DIR, --part K/N -o FILE, or --join FILE... off; the words of the tests are left. Returns the file of the part.
std::string take_sharing(std::vector<std::string>& words) {
  using namespace imulab;
  std::string output;
  std::optional<PartNumber> part;
  if (!words.empty() && words[0] == "--join") {
    std::vector<PartReader::Source> files;
    for (auto name = words.begin() + 1; name != words.end(); ++name) files.push_back(PartReader::file(*name));
    shared_runs().joined = std::make_shared<PartReader>(std::move(files));
    words.clear();
    std::istringstream command(shared_runs().joined->command());
    for (std::string word; std::getline(command, word);) words.push_back(word);
    return output;
  }
  while (words.size() >= 2 && words[0].starts_with('-')) {
    if (words[0] == "--checkpoint")
      shared_runs().checkpoint = words[1];
    else if (words[0] == "--part")
      part = part_named(words[1]);
    else if (words[0] == "-o")
      output = words[1];
    else
      throw Error(words[0] + ": expected --checkpoint DIR, --part K/N -o FILE, or --join FILE...");
    words.erase(words.begin(), words.begin() + 2);
  }
  if (part.has_value() == output.empty()) throw Error("--part: expected K/N, and its file as -o FILE");
  if (part) shared_runs().part = std::make_shared<PartWriter>(*part, fmt::format("{}", fmt::join(words, "\n")));
  return output;
}

/// The exit code: 0 where all that was asked for passed.
int run(int argc, char** argv) {
  std::vector<std::string> names(argv + 1, argv + argc);
  const std::string part = take_sharing(names);
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
                         [&] { return judge(run_all(c.run, count(c.count), std::string(c.name))); });
  if (chosen("misspecified"))
    for (const imulab::Method& method : imulab::methods())
      if (method.example && (of_method.empty() || of_method == method.name))
        passed &= report(fmt::format("misspecified {}: {} sessions, seeds 1..{}", method.name, count(500), count(500)),
                         [&] { return misspecified(method, count(500)); });
  if (chosen("predictions"))
    for (const imulab::Method& method : imulab::methods())
      if (method.example && (of_method.empty() || of_method == method.name))
        passed &= report(fmt::format("predictions {}: {} sessions, seeds 1..{}", method.name, count(200), count(200)),
                         [&] { return predictions(method, count(200)); });
  if (chosen("procedures")) passed &= report("procedures: every cell of docs/start/choose.md\n", [&] { return procedures(); });
  if (chosen("noise")) passed &= report(fmt::format("noise: {} logs, seeds 1..{}", count(500), count(500)), [&] { return noise_logs(count(500)); });
  if (chosen("noise-bounds")) passed &= report(fmt::format("noise-bounds: {} units", count(500)), [&] { return noise_bounds(count(500)); });
  if (chosen("noise-lengths"))
    passed &= report(fmt::format("noise-lengths: {} logs of each length", count(400)), [&] { return noise_lengths(count(400)); });
  if (chosen("sweeps"))
    passed &= report(fmt::format("sweeps: {} warm-ups by hand, seeds 1..{}", count(40), count(40)), [&] { return sweeps(count(40)); });
  if (chosen("error-growth")) passed &= report(fmt::format("error-growth: {} runs, seed 1", count(2000)), [&] { return error_growth(count(2000)); });
  if (chosen("whole-unit"))
    passed &=
        report(fmt::format("whole-unit outputs: {} sessions, seeds 1..{}", count(200), count(200)), [&] { return whole_unit_outputs(count(200)); });
  if (chosen("fleet")) {
    const int by_hand = std::max(1, count(600) / 60);  // a session takes a thousand times as long as a drawn calibration
    passed &= report(fmt::format("fleet: {} fleets, seeds 1..{}", count(600), count(600)), [&] { return fleets(count(600)); });
    passed &= report(fmt::format("fleet by hand: {} fleets, seeds 1..{}", by_hand, by_hand), [&] { return fleets_by_hand(by_hand); });
  }
  if (chosen("aided"))
    passed &= report(fmt::format("aided: {} drives and flights, seeds 1..{}", count(300), count(300)), [&] { return aided_runs(count(300)); });
  if (chosen("aided-effects"))
    passed &= report(fmt::format("aided-effects: {} drives and flights of IMUs with effects, seeds 1..{}", count(300), count(300)),
                     [&] { return aided_runs(count(300), true); });
  if (chosen("aided-bound"))
    passed &= report(fmt::format("aided-bound: {} flights, seeds 1..{}", count(100), count(100)), [&] { return aided_bound(count(100)); });
  if (chosen("drives")) {
    by_part([&] {
      const std::string rates = describe(drives(count(200)));
      fmt::print("drives: {} drives, seeds 1..{}\n{}", count(200), count(200), rates);
    });
  }
  if (chosen("dai-flight")) {
    by_part([&] {
      const DaiFlights flown = dai_flights(count(200));
      for (const auto& [name, flights] : {std::pair{"dai-flight", &flown.with_roll}, std::pair{"dai-flight without its roll", &flown.without_roll}})
        passed &= report(fmt::format("{}: {} flights, seeds 1..{}\n{}", name, count(200), count(200), describe_flights(*flights)),
                         [of = flights] { return judge_flights(*of); });
    });
  }
  if (!any) throw imulab::Error(only + ": is no test; expected one of docs/evidence");
  if (!part.empty()) imulab::write_whole(part, shared_runs().part->bytes());
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
