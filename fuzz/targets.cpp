#include "fuzz/targets.hpp"

#include <stdexcept>

namespace imulab::fuzz {

const std::vector<Target>& targets() {
  static const std::vector<Target> all{
      {"text", text_table, "", "text"},
      {"dialect", dialect, "", "text"},
      {"numpy", numpy, ".npy .npz"},
      {"matlab", matlab, ".mat", "", true},
      {"hdf5", hdf5, ".h5", "", true},
      {"rows", binary_rows, "psins.bin mixed.bin"},
      {"ulog", ulog, ".ulg"},
      {"dataflash", dataflash, "ardupilot.bin"},
      {"novatel", novatel},
      {"archive", archive, ".gz .bz2 .xz .zst .lz4 .zip"},
      {"workbook", workbook},
      {"ros1", ros1, ".bag"},
      {"mcap", mcap, ".mcap"},
      {"ros2", ros2, ".db3"},
      {"solution", solution, "", "text"},
      {"aids", aids, ".ulg ardupilot.bin none.mcap", "text"},
      {"stream", stream, "", "text"},
      {"inspection", inspection, ".npy .npz .ulg ardupilot.bin zstd.mcap lz4.bag .db3", "text"},
      {"search", search, "", "text", true},
      {"rewritten_bag", rewritten_bag, ".bag .mcap .db3"},
      {"session", session, "", "toml"},
      {"mission", mission, "", "toml"},
      {"calibration", calibration, "", "json"},
      {"import", imported, ".param .calib .json .yaml .txt .params table.csv", "import"},
      {"result", result, "", "json"},
      {"noise", noise, "", "json"},
      {"requirement", requirement, "", "requirement"},
      {"decimal", decimal},
      {"fleet_store", fleet_store, "", "", true},
      {"checkpoint", checkpoint},
      {"part", part},
      {"command_line", command_line, "", "command_line", true},
  };
  return all;
}

void finding(const char* what) { throw std::logic_error(what); }

}  // namespace imulab::fuzz
