#include "imulab/estimate/method.hpp"

#include "imulab/core/error.hpp"
#include "imulab/estimate/hybrid/hybrid.hpp"
#include "imulab/estimate/hybrid/prediction.hpp"
#include "imulab/estimate/kernel/plausibility.hpp"
#include "imulab/estimate/rests/rests.hpp"
#include "imulab/estimate/turntable/prediction.hpp"
#include "imulab/estimate/turntable/turntable.hpp"
#include "imulab/estimate/whole_unit/whole_unit.hpp"

#include <array>
#include <utility>

namespace imulab {

namespace {

constexpr std::array all{
    Method{.name = "handheld", .summary = "from rests and the rotations between them", .calibrate = rests::calibrate_handheld},
    Method{.name = "hybrid",
           .summary = "from rests and turns in one place, without a table's angles",
           .takes_curves = true,
           .calibrate = hybrid::calibrate,
           .predict = hybrid::predict},
    Method{.name = "static", .summary = "from rests alone", .calibrate = rests::calibrate_static},
    Method{.name = "turntable", .summary = "from the table's angles", .calibrate = turntable::calibrate, .predict = turntable::predict},
    Method{.name = "whole-unit",
           .summary = "from chamber, rate table and centrifuge, all recordings together",
           .takes_several = true,
           .takes_full = true,
           .takes_stepwise = true,
           .calibrate = whole_unit::calibrate},
};

}  // namespace

std::span<const Method> methods() { return all; }

const Method& method(std::string_view name, std::span<const Method> table) {
  std::string names;
  for (const Method& m : table) {
    if (m.name == name) return m;
    names += (names.empty() ? "" : ", ") + std::string(m.name);
  }
  throw Error("no method " + std::string(name) + "; expected one of " + names);
}

CalibrationResult calibrate(const Method& method, const CalibrationInput& input, const CalibrationOptions& options) {
  for (const Recording& recording : input.recordings) kernel::expect_different_channels(recording);
  CalibrationResult result = method.calibrate(input, options);
  Quality& quality = result.calibration.quality;
  for (std::string& contradiction : kernel::contradictions(result.calibration.model, input.recordings.front())) {
    quality.verdict = "doubtful";
    quality.because.push_back(std::move(contradiction));
  }
  return result;
}

CalibrationResult calibrate(std::string_view name, const CalibrationInput& input, const CalibrationOptions& options) {
  return calibrate(method(name), input, options);
}

}  // namespace imulab
