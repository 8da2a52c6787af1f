#include "imulab/estimate/kernel/input.hpp"

#include "imulab/core/error.hpp"
#include "imulab/recording/validate.hpp"

#include <fmt/core.h>

namespace imulab::kernel {

const Recording& only_recording(const CalibrationInput& input, std::string_view method) {
  if (input.recordings.size() == 1) {
    validate(input.recordings.front());
    return input.recordings.front();
  }
  std::string names;
  for (const Recording& recording : input.recordings) names += (names.empty() ? "" : ", ") + recording.name;
  throw Error(fmt::format("the method {} takes one recording; got {}{}", method, input.recordings.size(), names.empty() ? "" : " (" + names + ")"));
}

Rests rests_of(const CalibrationInput& input, const Recording& recording) {
  if (input.rests) return {*input.rests, {}};
  return imulab::rests_of(recording, input.session);
}

}  // namespace imulab::kernel
