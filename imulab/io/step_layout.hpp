// Steps as written -> steps in time: angles and times left out are filled in.
#pragma once

#include "imulab/io/session_fields.hpp"
#include "imulab/recording/session.hpp"

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace imulab {

/// What a procedure's hold or spin is reached in where it does not say.
inline constexpr double default_move_s = 10;

class StepLayout {
 public:
  /// The problem of a step, if any: the key it is about and what is wrong. Then the step is not usable.
  struct Problem {
    std::string_view key;
    std::string message;
  };

  /// Places the next step of its recording: checks the times it gives, or puts it after the step before it.
  std::optional<Problem> place(const StepText& text, const std::string& recording, Step& step);

 private:
  struct Rig {  // how the step before left the rig; times in s, angles in deg so that sums of whole degrees stay exact
    bool begun = false;
    double time = 0;
    std::array<double, 3> angles_deg{0, 0, 0};
    double spin_dps = 0;
    std::optional<Mount> mount;
    std::optional<double> temperature;
  };
  std::map<std::string, Rig> rigs_;
};

}  // namespace imulab
