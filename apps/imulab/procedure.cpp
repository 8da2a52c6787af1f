#include "imulab/rig/procedure.hpp"

#include "apps/imulab/command.hpp"
#include "imulab/io/file.hpp"
#include "imulab/io/session_file.hpp"

#include <fmt/core.h>

#include <memory>

namespace imulab::command {

void add_procedure(CLI::App& app) {
  CLI::App* const verb = app.add_subcommand("procedure", "A standard procedure as TOML, ready to edit");
  verb->require_subcommand(1);

  struct Arguments {
    HandHeldOptions options;
    std::uint64_t seed = 1;
    std::string output = "-";
  };
  const auto a = std::make_shared<Arguments>();
  CLI::App* const hand_held = verb->add_subcommand("hand-held", "A unit turned by hand: rests at random attitudes, no rig");
  hand_held->add_option("--poses", a->options.poses, "number of rests")->capture_default_str();
  hand_held->add_option("--seed", a->seed, "another seed, other attitudes")->capture_default_str();
  hand_held->add_option("-o,--output", a->output, "the file to write; - for standard output")->capture_default_str();
  hand_held->callback([a] {
    const std::string text = session_text(hand_held_procedure(a->options, a->seed));
    if (a->output == "-") fmt::print("{}", text);
    else write_whole(a->output, text);
  });
}

}  // namespace imulab::command
