#include "apps/imulab/command.hpp"
#include "imulab/core/error.hpp"

#include <fmt/core.h>

#include <cstdio>
#include <exception>

namespace imulab::command {

void warn(const std::string& text) { fmt::print(stderr, "imulab: warning: {}\n", text); }

}  // namespace imulab::command

int main(int argc, char** argv) {
  using namespace imulab;
  CLI::App app{"The laboratory for inertial measurement units: calibrate, compensate, and know how sure you are."};
  app.name("imulab");
  app.require_subcommand(1);
  app.set_version_flag("--version", "imulab " IMULAB_VERSION);
  command::add_procedure(app);
  command::add_simulate(app);
  command::add_calibrate(app);
  command::add_compensate(app);
  command::add_compare(app);
  command::add_demo(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  } catch (const command::ExitCode& code) {
    return code.value;
  } catch (const Unsupported& e) {
    fmt::print(stderr, "imulab: {}\n", e.what());
    return 1;
  } catch (const Error& e) {
    fmt::print(stderr, "imulab: {}\n", e.what());
    return 2;
  } catch (const std::exception& e) {
    fmt::print(stderr, "imulab: {}\n", e.what());
    return 2;
  }
  return 0;
}
