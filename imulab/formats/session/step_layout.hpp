// Steps as the file states them -> steps in time: absent angles and times are filled in.
#pragma once

#include "imulab/formats/session/fields.hpp"
#include "imulab/session.hpp"

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace imulab::session_io {

/// Seconds in which a procedure reaches a hold or spin where it has no move_s.
inline constexpr double default_move_s = 10;

/// The state of the rig after a step; s, and deg so that sums of whole degrees stay exact.
struct RigState {
  bool begun = false;  ///< by a first step
  double time = 0;
  std::array<double, 3> angles_deg{0, 0, 0};
  double spin_dps = 0;
  std::optional<Mount> mount;
  std::optional<double> temperature;
};

class StepLayout {
 public:
  /// A problem of a step, and the key that has it.
  struct StepProblem {
    std::string_view key;
    std::string message;
  };

  /// Places the next step of its recording: checks the times it gives, or puts it after the previous step. Where there is a problem, `step` is not
  /// usable.
  std::optional<StepProblem> place(const StepText& text, const std::string& recording, Step& step);

 private:
  std::map<std::string, RigState> rigs_;
};

}  // namespace imulab::session_io
