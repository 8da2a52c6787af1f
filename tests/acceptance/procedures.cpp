// Every cell of the table in docs/start/choose.md is what `predict` gives.
#include "imulab/tasks/procedures.hpp"

#include <fmt/core.h>

#include "tests/acceptance/acceptance.hpp"
#include <fstream>
#include <sstream>

namespace imulab::acceptance {

std::vector<Check> procedures() {
  std::ostringstream page;
  page << std::ifstream(std::string(IMULAB_SOURCE) + "/docs/start/choose.md").rdbuf();
  std::vector<Check> checks;
  for (const ProcedureChoice& choice : procedure_choices()) {
    const std::string row = procedure_row(choice, predict(choice));
    const bool found = page.str().find(row) != std::string::npos;
    if (!found) fmt::print("not on the page: {}", row);
    checks.push_back({fmt::format("{}, {}", choice.rig, choice.sensors), found ? 1.0 : 0.0, 1, 1});
  }
  return checks;
}

}  // namespace imulab::acceptance
