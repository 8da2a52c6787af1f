// imulab export CALIBRATION --to FORMAT
#include "apps/imulab/command.hpp"
#include "imulab/core/error.hpp"
#include "imulab/io/c_header.hpp"
#include "imulab/io/calibration_file.hpp"
#include "imulab/io/file.hpp"

#include <fmt/core.h>

#include <functional>
#include <map>
#include <memory>

namespace imulab::command {

namespace {

struct Options {
  std::string calibration, format, output = "-";
};

const std::map<std::string, std::function<std::string(const Calibration&)>> formats{{"c-header", c_header}};

void run(const Options& o) {
  const Calibration calibration = read_calibration(o.calibration);
  const std::string text = [&] {
    try {
      return formats.at(o.format)(calibration);
    } catch (const Error& e) {
      throw Error(fmt::format("{}: {}", o.calibration, e.what()));
    }
  }();
  if (!calibration.model.lever_arm.isZero(0)) warn(o.calibration + ": lever arms are not exported: the forces are those where the accelerometers sit");
  if (o.output == "-")
    fmt::print("{}", text);
  else
    write_whole(o.output, text);
}

}  // namespace

void add_export(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  CLI::App* const verb = app.add_subcommand("export", "A calibration for other programs");
  std::vector<std::string> names;
  for (const auto& [name, text] : formats) names.push_back(name);
  verb->add_option("CALIBRATION", o->calibration, "calibration.json")->required();
  verb->add_option("--to", o->format, "c-header: compensation for firmware, one header without a library")->required()->check(CLI::IsMember(names));
  verb->add_option("-o,--output", o->output, "the file to write; - for standard output")->capture_default_str();
  verb->callback([o] { run(*o); });
}

}  // namespace imulab::command
