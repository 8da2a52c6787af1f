// MATLAB's .mat files of version 4 and 5 (to 7.2, also compressed). Version 7.3 is HDF5. imulab-read reads them (apps/imulab_read/matio_reader.cpp).
#include "imulab/formats/recording/child/read_program.hpp"
#include "imulab/formats/recording/format.hpp"
#include "imulab/formats/recording/logs/binary.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace imulab::recording_io {
namespace {

constexpr ProgramFormat matio{"MATIO", "a MATLAB file", "libmatio", "libmatio-dev"};

/// Version 4 has no signature: the head of its first variable has to be one.
bool is_matlab_4(std::string_view head) {
  if (head.size() < 22) return false;
  for (const bool big_endian : {false, true}) {
    const auto number = [&](std::size_t i) { return load<std::uint32_t>(head.data() + 4 * i, big_endian); };
    const std::uint32_t type = number(0), name = number(4);
    if (type / 1000 != (big_endian ? 1u : 0u) || type / 100 % 10 != 0 || type / 10 % 10 > 5 || type % 10 > 2) continue;
    constexpr std::uint32_t most = std::numeric_limits<std::int32_t>::max();
    if (number(1) > most || number(2) > most || number(3) > 1 || name < 2 || name > 64 || head.size() < 20 + name) continue;
    const std::string_view letters = head.substr(20, name - 1);
    const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'; };
    if (head[20 + name - 1] == '\0' && std::all_of(letters.begin(), letters.end(), is_letter)) return true;
  }
  return false;
}

bool is_matlab(std::string_view head) {
  if (is_matlab_4(head)) return true;
  if (head.size() < 128 || !head.starts_with("MATLAB ")) return false;
  return head.substr(124, 4) == std::string_view("\0\1IM", 4) || head.substr(124, 4) == std::string_view("\1\0MI", 4);
}

std::vector<TableDescription> describe_matlab(const TableRequest& request) { return describe_by_program(matio, request); }
void read_matlab(const TableRequest& request, const Wanted& wanted, const PieceSink& sink) {
  sink(columns_by_program(matio, request, wanted.columns));
}

}  // namespace

RecordingFormat matlab_format() { return {.name = "MATLAB .mat", .recognizes = is_matlab, .describe = describe_matlab, .read = read_matlab}; }

}  // namespace imulab::recording_io
