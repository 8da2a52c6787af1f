#include "imulab/tasks/aid_files.hpp"

#include "imulab/files.hpp"
#include "imulab/formats/aid/format.hpp"

#include <fmt/format.h>

#include <map>

namespace imulab {

std::vector<SimulatedAid> simulate_aids(Session& session, const std::vector<Aid>& declared, const motion::Trajectory& motion, std::uint64_t seed) {
  std::vector<SimulatedAid> out;
  std::map<AidKind, int> counts;
  session.aids.clear();
  for (std::size_t k = 0; k < declared.size(); ++k) {
    Aid& aid = session.aids.emplace_back(declared[k]);
    if (!has_record(aid.kind)) continue;
    out.push_back(simulate_aid(aid, k, motion, seed));
    out.back().aid.file = fmt::format("{}_{}.csv", to_string(aid.kind), ++counts[aid.kind]);
    aid = out.back().aid;
  }
  return out;
}

void write_aids(const std::filesystem::path& folder, const std::vector<SimulatedAid>& aids) {
  for (const SimulatedAid& each : aids) {
    const Eigen::Vector3d& arm = each.lever_arm;
    write_whole(folder / each.aid.file,
                aid_io::aid_csv(each.aid, fmt::format("simulated with lever_arm_m = [{:.6g}, {:.6g}, {:.6g}], delay_s = {:.6g}", arm.x(), arm.y(),
                                                      arm.z(), each.delay)));
  }
}

std::vector<JsonValue> aids_json(const std::vector<SimulatedAid>& aids) {
  std::vector<JsonValue> list;
  for (const SimulatedAid& each : aids)
    list.emplace_back(
        JsonFields{{{"file", each.aid.file}, {"kind", to_string(each.aid.kind)}, {"rows", std::uint64_t{each.aid.record.time.size()}}}});
  return list;
}

std::string aids_table(const std::vector<SimulatedAid>& aids) {
  std::string table;
  for (const SimulatedAid& each : aids) table += fmt::format("  {:<14} {} rows\n", each.aid.file, each.aid.record.time.size());
  return table;
}

}  // namespace imulab
