#include "imulab/estimate/kernel/input.hpp"

#include "imulab/error.hpp"
#include "imulab/model/frame_axes.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <fmt/core.h>

#include <algorithm>

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

RecordingSource only_source(const Session& procedure) {
  validate(procedure);
  if (procedure.recordings.size() > 1)
    throw Error(fmt::format("{}: {} recordings; expected a procedure with one", procedure.file, procedure.recordings.size()));
  return procedure.recordings.empty() ? RecordingSource{} : procedure.recordings.front();
}

Rests rests_of(const CalibrationInput& input, const Recording& recording) {
  return input.rests ? Rests{*input.rests, {}, {}} : imulab::rests_of(recording, input.session);
}

void expect_alive(const Recording& recording, Triad triad, std::string_view consequence) {
  const Columns3& columns = triad == Triad::accel ? recording.accel : recording.gyro;
  for (std::size_t j = 0; j < 3; ++j)
    if (!columns[j].empty() && std::all_of(columns[j].begin(), columns[j].end(), [&](double v) { return v == columns[j].front(); }))
      throw Unsupported(
          fmt::format("{}: {} {} reads {:g} in every sample: {}", recording.name, to_string(triad), "xyz"[j], columns[j].front(), consequence));
}

std::vector<CoefficientIndex> chosen_coefficients(const std::vector<CoefficientIndex>& wanted, const std::vector<CoefficientIndex>& supplied,
                                                  std::string_view method) {
  if (wanted.empty()) return supplied;
  // A whole term, as accel.thermal, has more orders than some methods.
  const auto has_other_orders = [&](CoefficientIndex index) {
    return is_extended(coefficient(index)) && std::ranges::any_of(wanted, [&](CoefficientIndex other) {
             const Coefficient &a = coefficient(index), &b = coefficient(other);
             return a.triad == b.triad && a.term == b.term && a.row == b.row && contains(supplied, other);
           });
  };
  for (const CoefficientIndex index : wanted)
    if (!zero_by_frame(index) && !contains(supplied, index) && !has_other_orders(index))
      throw TermsError(fmt::format("{} is not a coefficient that the method {} estimates", coefficient(index).name, method));
  std::vector<CoefficientIndex> chosen = supplied;
  std::erase_if(chosen, [&](CoefficientIndex index) { return !contains(wanted, index); });
  if (chosen.empty())
    throw TermsError(fmt::format("the terms select no coefficient of the method {}; the accelerometer matrix is lower triangular", method));
  return chosen;
}

}  // namespace imulab::kernel
