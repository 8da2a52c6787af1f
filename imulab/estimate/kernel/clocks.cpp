#include "imulab/estimate/kernel/clocks.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace imulab::kernel {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

template <class Late>
void move_steps(Session& session, const RecordingSource& source, const Late& late) {
  for (Step& step : session.steps)
    if (session.recordings.size() < 2 || step.recording == source.file) step.start += late(step.start), step.end += late(step.end);
}

void correct_offset(Session& session, const RecordingSource& source, const Recording& recording, std::vector<std::string>& said) {
  const std::optional<ClockOffset> offset = clock_offset(recording, session.steps_of(source));
  // If commanded turns are absent from the data, nothing correlates: the plan belongs to another recording, not to another clock.
  if (!offset || offset->correlation < 0.7 || offset->correlation < offset->uncorrected + 0.001) return;
  move_steps(session, source, [&](double) { return offset->offset_s; });
  said.push_back(fmt::format(
      "{}: the clock of the steps is {:.2f} s (u = {:.2f} s) off the recording's; their times were moved (correlation of the rate with the "
      "commanded turns {:.2f}, before {:.2f})",
      recording.name, offset->offset_s, std::max(offset->sigma_s, 0.01), offset->correlation, offset->uncorrected));
}

const char* gains_or_loses(const ClockRate& clock) { return clock.rate > 0 ? "gains" : "loses"; }

std::optional<ClockGain> correct_rate(Session& session, const RecordingSource& source, const Recording& recording, std::vector<std::string>& said) {
  constexpr double allowed_s = 0.1;  // steps are declared to 0.1 s, and the methods tolerate such an error
  const std::optional<ClockRate> found = clock_rate(recording, session.steps_of(source));
  if (!found) return std::nullopt;
  ClockGain gain{recording.name, *found, recording.gyro_increment};
  if (gain.significant() && std::abs(found->rate) * (recording.time_s(recording.size() - 1) - recording.time_s(0)) > allowed_s) {
    move_steps(session, source, [&](double step_s) { return found->late(step_s); });
    said.push_back(fmt::format("{}: its clock {} {:.0f} ppm (u = {:.0f} ppm) on that of the steps, by {} turns; the steps' times were moved",
                               recording.name, gains_or_loses(*found), 1e6 * std::abs(found->rate), 1e6 * found->sigma, found->turns));
  }
  return gain;
}

/// Returns the smallest relative uncertainty of the gyro scales; infinite if none is estimated.
double gyro_scale_sigma(const Calibration& calibration) {
  double sigma = std::numeric_limits<double>::infinity();
  for (const char* name : {"gyro.matrix.xx", "gyro.matrix.yy", "gyro.matrix.zz"}) {
    const CoefficientIndex index = coefficient_index(name);
    const auto at = std::find(calibration.estimated.begin(), calibration.estimated.end(), index) - calibration.estimated.begin();
    if (at == std::ssize(calibration.estimated)) continue;
    sigma = std::min(sigma, std::sqrt(calibration.covariance(at, at)) / std::abs(coefficient_value(calibration.model, index)));
  }
  return sigma;
}

}  // namespace

std::vector<ClockGain> correct_clocks(Session& session, std::span<const Recording> recordings, std::vector<std::string>& said) {
  std::vector<ClockGain> gains;
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    const RecordingSource source = session.recordings.size() > k ? session.recordings[k] : RecordingSource{};
    correct_offset(session, source, recordings[k], said);
    if (std::optional<ClockGain> gain = correct_rate(session, source, recordings[k], said)) gains.push_back(std::move(*gain));
  }
  return gains;
}

void state_clock(Calibration& calibration, const Session& session, const std::vector<ClockGain>& gains) {
  constexpr double stamped = 50 * unit::ppm, nominal = 0.02;
  std::vector<Eigen::Index> of_gyros;
  for (std::size_t i = 0; i < calibration.estimated.size(); ++i) {
    const Coefficient& c = coefficient(calibration.estimated[i]);
    if (c.triad == Triad::gyro && c.term != Term::thermal) of_gyros.push_back(static_cast<Eigen::Index>(i));
  }
  if (of_gyros.empty()) return;
  const bool unstamped = std::ranges::any_of(session.recordings, [](const RecordingSource& r) { return !r.time.column; });
  double information = 1 / std::pow(unstamped ? nominal : stamped, 2), sum = 0;
  for (const ClockGain& gain : gains) information += std::pow(gain.clock.sigma, -2), sum += gain.clock.rate * std::pow(gain.clock.sigma, -2);
  ClockScale clock{session.imu.clock, sum / information, 1 / std::sqrt(information)};
  // A clock that gains has short seconds: the unit turns by a larger angle per true second.
  if (clock.seconds == "true") {
    TriadModel& gyro = calibration.model.gyro;
    VectorXd value(std::ssize(of_gyros));
    for (Index k = 0; k < value.size(); ++k)
      value[k] = coefficient_value(calibration.model, calibration.estimated[static_cast<std::size_t>(of_gyros[static_cast<std::size_t>(k)])]);
    calibration.covariance(of_gyros, of_gyros) += clock.sigma * clock.sigma * value * value.transpose();
    const double factor = 1 + clock.gain;
    gyro.offset *= factor, gyro.matrix *= factor, gyro.quadratic *= factor, gyro.cubic *= factor;
    calibration.model.g_sensitivity *= factor;
  }
  calibration.clock = std::move(clock);
}

void doubt_clock(Calibration& calibration, const ClockGain& gain) {
  constexpr double declared_s = 0.1;  // accuracy of declared step times
  if (gain.clock.lost_s > declared_s) {
    calibration.quality.findings.add<Code::samples_lost>(Subject{gain.recording}, gain.clock.lost_s);
    if (!calibration.quality.cause) calibration.quality.cause = "lost samples";
    return;
  }
  constexpr double of_clocks = 250 * unit::ppm;  // five sigmas of a clock that stamps samples
  const double rate = gain.clock.rate;
  if (!gain.increments || !gain.significant() || rate > 0 || std::abs(rate) < std::max(of_clocks, gyro_scale_sigma(calibration))) return;
  calibration.quality.findings.add<Code::clock_loses>(Subject{gain.recording}, 1e6 * std::abs(rate));
}

}  // namespace imulab::kernel
