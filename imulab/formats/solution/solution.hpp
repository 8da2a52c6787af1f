// Navigation solutions and heights over time as CSV (docs/reference/results.md).
#pragma once

#include "imulab/core/temporary_file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/navigate.hpp"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

struct HeightRecord;

/// A row of a solution, without its end: time, place, velocity, and these angles.
void append_state(std::string& to, double time, const NavigationState& state, const EulerAngles& angles);

/// A solution's file as its states are reached. It appears whole at commit(), or not at all: states for a stream wait until then, in a temporary file
/// where they are many. The heading is written from 0 to 360 deg. Throws Error where it cannot be written.
class SolutionFile {
 public:
  explicit SolutionFile(const std::filesystem::path& path);
  void add(double time, const NavigationState& state);
  void commit();
  std::size_t states() const { return states_; }

 private:
  WholeFile file_;
  std::string text_;
  std::optional<TemporaryFile> waiting_;  // text for a stream
  std::size_t states_ = 0;
};

}  // namespace imulab
