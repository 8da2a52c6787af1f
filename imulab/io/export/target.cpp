#include "imulab/io/export/target.hpp"

#include "imulab/core/error.hpp"
#include "imulab/io/export/c_header.hpp"
#include "imulab/io/text/names.hpp"

#include <fmt/core.h>

namespace imulab {

const std::vector<ExportTarget>& export_targets() {
  static const std::vector<ExportTarget> targets{
      {"c-header", "compensation for firmware, one header without a library", c_header, left_out_of_c_header},
  };
  return targets;
}

const ExportTarget& export_target(std::string_view name, const std::vector<ExportTarget>& targets) {
  std::vector<std::string_view> names;
  for (const ExportTarget& target : targets) {
    if (target.name == name) return target;
    names.push_back(target.name);
  }
  throw Error(fmt::format("{} is not an export target; expected one of {}", name, text::listed(names)));
}

}  // namespace imulab
