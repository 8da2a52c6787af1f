#include "imulab/estimate/method.hpp"

#include "imulab/core/error.hpp"
#include "imulab/estimate/hybrid/hybrid.hpp"
#include "imulab/estimate/hybrid/prediction.hpp"
#include "imulab/estimate/kernel/clocks.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/estimate/kernel/plausibility.hpp"
#include "imulab/estimate/rests/rests.hpp"
#include "imulab/estimate/turntable/prediction.hpp"
#include "imulab/estimate/turntable/turntable.hpp"
#include "imulab/estimate/whole_unit/whole_unit.hpp"
#include "imulab/model/frame.hpp"
#include "imulab/recording/even_stamps.hpp"
#include "imulab/recording/short_gaps.hpp"
#include "imulab/recording/validate.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace imulab {

namespace {

constexpr std::array all{
    Method{.name = "handheld",
           .summary = "from rests and the rotations between them",
           .calibrate = rests::calibrate_handheld,
           .predict = rests::predict_handheld},
    Method{.name = "hybrid",
           .summary = "from rests and turns in one place, without a table's angles",
           .takes_curves = true,
           .calibrate = hybrid::calibrate,
           .predict = hybrid::predict},
    Method{.name = "static", .summary = "from rests alone", .calibrate = rests::calibrate_static, .predict = rests::predict_static},
    Method{.name = "turntable", .summary = "from the table's angles", .calibrate = turntable::calibrate, .predict = turntable::predict},
    Method{.name = "whole-unit",
           .summary = "from chamber, rate table and centrifuge, all recordings together",
           .takes_several = true,
           .takes_full = true,
           .takes_stepwise = true,
           .calibrate = whole_unit::calibrate,
           .predict = whole_unit::predict},
};

/// The recordings with even stamps where theirs scatter, and with samples that were lost one or two at a time; empty where all are good as they are.
std::vector<Recording> corrected_recordings(const CalibrationInput& input, std::vector<std::string>& said) {
  std::vector<Recording> out;
  for (std::size_t k = 0; k < input.recordings.size(); ++k) {
    const Recording& r = input.recordings[k];
    const Stamps wanted = k < input.session.recordings.size() ? input.session.recordings[k].time.stamps : Stamps::automatic;
    const std::optional<EvenClock> clock = replacing_clock(r, wanted);
    const std::size_t lost = input.rests || clock ? 0 : short_gaps(r).filled;  // given rests name samples: their numbers stay
    if (!clock && lost == 0) continue;
    if (out.empty()) out.assign(input.recordings.begin(), input.recordings.end());
    if (lost > 0) {
      out[k] = with_short_gaps_filled(std::move(out[k])).recording;
      said.push_back(fmt::format("{}: {} samples are missing, one or two at a time; they were interpolated from their neighbors", r.name, lost));
      continue;
    }
    const bool declared = k >= input.session.recordings.size() || input.session.recordings[k].rate_hz;
    out[k] = with_even_stamps(std::move(out[k]), *clock, declared);
    said.push_back(fmt::format(
        "{}: its stamps scatter by {:.2g} ms (RMS) about an even clock of {:.6g} ms, which replaces them unless the recorded stamps are declared",
        r.name, 1e3 * clock->scatter_s, 1e3 * clock->interval_s));
  }
  return out;
}

void validate(const CalibrationOptions& options) {
  for (const auto& [name, level] : {std::pair{"significance", options.significance}, std::pair{"outlier_level", options.outlier_level}})
    if (!(level > 0 && level < 1)) throw Error(fmt::format("{}: {} is no probability; expected more than 0 and less than 1", name, level));
}

/// Given rests: of the only recording, inside it, one after the other.
void validate_rests(const CalibrationInput& input) {
  if (!input.rests) return;
  const std::size_t size = input.recordings.empty() ? 0 : input.recordings.front().size();
  std::size_t least = 0;
  for (const Range& rest : *input.rests) {
    if (rest.begin < least || rest.end <= rest.begin || rest.end > size)
      throw Error(
          fmt::format("rests: samples {} to {} are no rest; expected ranges in ascending order from {} to {}", rest.begin, rest.end, least, size));
    least = rest.end;
  }
}

}  // namespace

std::span<const Method> methods() { return all; }

Prediction prediction_of(const Calibration& calibration) {
  Prediction out{calibration.estimated, {}, calibration.covariance.diagonal().cwiseSqrt(), {}};
  out.cramer_rao = out.sigma;
  out.frame = calibration.frame;
  for (const std::string& name : calibration.quality.unobservable) out.undetermined.push_back(coefficient_index(name));
  for (const std::string& name : calibration.quality.considered)
    if (const CoefficientIndex index = coefficient_index(name); contains(out.coefficients, index)) out.considered.push_back(index);
  return out;
}

std::vector<Shortfall> shortfalls(const Prediction& p, const std::vector<Requirement>& requirements) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  std::vector<Shortfall> out;
  std::vector<CoefficientIndex> named;
  for (const Requirement& r : requirements)
    for (const CoefficientIndex index : r.coefficients) {
      if (contains(named, index)) continue;
      const auto found = std::find(p.coefficients.begin(), p.coefficients.end(), index);
      const bool fixed = p.frame == "accelerometers" && zero_by_frame(index);
      const double sigma = found != p.coefficients.end() ? p.sigma[found - p.coefficients.begin()] : fixed ? 0 : infinite;
      if (sigma <= r.limit) continue;
      out.push_back({r, index, sigma, std::isinf(sigma) ? "the procedure does not determine it" : ""});
      named.push_back(index);
    }
  return out;
}

const Method& method(std::string_view name, std::span<const Method> table) {
  std::string names;
  for (const Method& m : table) {
    if (m.name == name) return m;
    names += (names.empty() ? "" : ", ") + std::string(m.name);
  }
  throw Error("no method " + std::string(name) + "; expected one of " + names);
}

CalibrationResult calibrate(const Method& method, const CalibrationInput& input, const CalibrationOptions& options) {
  validate(options);
  validate(input.session);
  validate_rests(input);
  for (const Recording& recording : input.recordings) kernel::expect_different_channels(recording);
  std::vector<std::string> clocks;
  const std::vector<Recording> corrected = corrected_recordings(input, clocks);
  const std::span<const Recording> recordings = corrected.empty() ? input.recordings : std::span<const Recording>(corrected);
  Session session = input.session;
  const std::vector<kernel::ClockGain> gains = kernel::correct_clocks(session, recordings, clocks);
  CalibrationResult result = method.calibrate({session, recordings, input.rests}, options);
  Quality& quality = result.calibration.quality;
  quality.warnings.insert(quality.warnings.begin(), clocks.begin(), clocks.end());
  for (std::string& contradiction : kernel::contradictions(result.calibration.model, recordings.front()))
    kernel::add_doubt(quality, std::move(contradiction));
  for (const kernel::ClockGain& gain : gains) kernel::doubt_clock(result.calibration, gain);
  if (std::string twice = kernel::repetition(recordings); !twice.empty()) kernel::add_doubt(quality, std::move(twice));
  for (std::size_t k = 0; k < recordings.size(); ++k)
    kernel::judge_interval(recordings[k], k < session.recordings.size() && session.recordings[k].rate_hz, quality);
  return result;
}

CalibrationResult calibrate(std::string_view name, const CalibrationInput& input, const CalibrationOptions& options) {
  return calibrate(method(name), input, options);
}

}  // namespace imulab
