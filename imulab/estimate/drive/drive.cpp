#include "imulab/estimate/drive/drive.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/drive/coefficients.hpp"
#include "imulab/estimate/drive/quality.hpp"
#include "imulab/estimate/drive/rest_check.hpp"
#include "imulab/estimate/drive/together.hpp"
#include "imulab/estimate/drive/unmodeled.hpp"
#include "imulab/estimate/kernel/effect_findings.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/prediction.hpp"
#include "imulab/grade.hpp"
#include "imulab/navigation/aided/foreseen.hpp"
#include "imulab/navigation/aided/setup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab::drive {

using Eigen::Index;

namespace {

void expect_aids(const Session& session, const std::string& name) {
  if (session.aids.empty())
    throw Error(
        fmt::format("{}: has no aids, which the method drive needs; expected [[aid]], as kind = \"gnss\" with a file "
                    "(docs/reference/aids.md)",
                    session.file.empty() ? name : session.file));
}

void expect_si(const Recording& recording) {
  for (const auto& [unit, triad] : {std::pair(recording.gyro_unit, "gyro"), std::pair(recording.accel_unit, "accel")})
    if (unit == "count")
      throw Error(fmt::format("{}: {} in counts, whose size a drive does not tell; expected its unit and counts_per_unit", recording.name, triad));
}

/// Returns the session of one recording with its aids; an initial state applies only if there is one recording.
Session session_of_drive(const Session& session, const Recording& recording, std::size_t drives) {
  Session out = session;
  for (std::size_t k = 0; k < session.aids.size() && drives > 1; ++k)
    if (const Aid& aid = session.aids[k]; has_record(aid.kind) && aid.recording.empty())
      throw Error(fmt::format("aid {} ({}) goes with which of {} recordings? expected recording = \"{}\" or another", k + 1, to_string(aid.kind),
                              drives, recording.name));
  std::erase_if(out.aids, [&](const Aid& aid) { return !aid.recording.empty() && aid.recording != recording.name; });
  if (out.aids.empty()) throw Error(fmt::format("{}: no aid goes with it; expected [[aid]] with recording = \"{}\"", recording.name, recording.name));
  if (drives > 1) out.initial.reset();
  return out;
}

/// Returns the session with the place of the drive if it has none, because gravity depends on it.
Session with_place(Session session, const AidedNavigation& n) {
  if (session.site.given_gravity || session.site.latitude) return session;
  const NavigationState& state = n.solution.states.front();
  session.site.latitude = state.latitude, session.site.longitude = state.longitude, session.site.height = state.height;
  return session;
}

/// Adds the uncertainty of gravity, which has the same relative effect on all three accelerometer scales.
void add_gravity(Calibration& c, const Site& site) {
  Eigen::VectorXd common = Eigen::VectorXd::Zero(std::ssize(c.estimated));
  for (std::size_t k = 0; k < c.estimated.size(); ++k)
    if (const Coefficient& row = coefficient(c.estimated[k]); row.triad == Triad::accel && is_scale(row))
      common[static_cast<Index>(k)] = coefficient_value(c.model, c.estimated[k]) * site.gravity_sigma() / site.gravity();
  c.covariance += common * common.transpose();
}

/// Navigates the drives, with all optional terms of a unit; chosen terms exclude others.
std::vector<Drive> navigated(const CalibrationInput& input, const std::vector<CoefficientIndex>& chosen, bool all_terms) {
  std::vector<Drive> out;
  const Shared shared = shared_by(input.recordings, input.session);
  for (const Recording& recording : input.recordings) {
    expect_si(recording);
    const Session session = session_of_drive(input.session, recording, input.recordings.size());
    const aided::OutputTerms terms = all_terms ? output_terms(recording, input.session, shared) : aided::OutputTerms{};
    out.push_back(drive_of(aided::navigate_under(unit_priors(input.session.imu, chosen), session, recording, session.aids, {.keep = false},
                                                 all_terms ? &terms : nullptr),
                           recording, input.session.imu));
  }
  return out;
}

/// Returns the calibration for these constants, including errors for which the navigation has no states.
StatedUnit stated(const AidedNavigation& constants, const Session& session) {
  StatedUnit out = calibration_of(constants);
  out.calibration.imu = session.imu.name;
  add_gravity(out.calibration, session.site);
  return out;
}

bool with_terms(const auto& options) { return options.effects && options.terms.empty(); }

}  // namespace

Drive drive_of(AidedNavigation navigation, const Recording& recording, const ImuDeclaration& imu) {
  const Grade& g = grade(imu.grade.value_or("mems"));
  Drive out{recording.name, std::move(navigation)};
  out.gyro_turn_on = std::pow(imu.gyro_noise.value_or(g.gyro_noise).turn_on.value, 2);
  out.accel_turn_on = std::pow(imu.accel_noise.value_or(g.accel_noise).turn_on.value, 2);
  out.gyro_change = out.gyro_turn_on + wander(Triad::gyro, recording, imu);
  out.accel_change = out.accel_turn_on + wander(Triad::accel, recording, imu);
  return out;
}

CalibrationResult calibrate(const CalibrationInput& input, const CalibrationOptions& options) {
  if (input.recordings.empty()) throw Error("the method drive takes recordings; got none");
  expect_aids(input.session, input.recordings.front().name);
  const std::vector<CoefficientIndex> chosen = kernel::chosen_coefficients(options.terms, drive_coefficients(), "drive");
  return calibration_result(navigated(input, chosen, with_terms(options)), input, options);
}

CalibrationResult calibration_result(const std::vector<Drive>& drives, const CalibrationInput& input, const CalibrationOptions& options) {
  const Session session = with_place(input.session, drives.front().navigation);
  const Together all = together(drives);
  const StatedUnit unit = stated(all.navigation, session);
  CalibrationResult result{.calibration = unit.calibration};
  Calibration& calibration = result.calibration;
  for (const Drive& drive : drives) result.iterations = std::max(result.iterations, drive.navigation.passes);
  if (drives.size() == 1) {  // with several drives, the change is part of each
    for (const Triad triad : {Triad::gyro, Triad::accel}) add_to_offsets(calibration, triad, wander(triad, input.recordings.front(), session.imu));
    if (const Drive& d = drives.front(); d.accel_turn_on > 0 || d.gyro_turn_on > 0)
      calibration.turn_on = {.accel = std::sqrt(d.accel_turn_on), .gyro = std::sqrt(d.gyro_turn_on)};
  }
  kernel::Findings findings = judged(drives, all, session, calibration);
  if (with_terms(options))
    kernel::add_effects(calibration, findings, found_effects(all.navigation, session), unit.joint, 1e-3, calibration.estimated);
  for (std::size_t k = 0; k < drives.size(); ++k)
    doubt_at_rest(calibration, drives[k].navigation, input.recordings[k], session, in_front(drives, drives[k]), findings);
  sort_by_table(calibration);
  kernel::conclude(calibration, findings);
  return result;
}

Prediction predict(const Session& mission, const PredictionOptions& options) {
  if (!options.motion)
    throw Error(
        fmt::format("{}: has no motion, from which the method drive predicts; expected a mission (docs/reference/navigate.md)", mission.file));
  expect_aids(mission, "the mission");
  const std::vector<CoefficientIndex> chosen = kernel::chosen_coefficients(options.terms, drive_coefficients(), "drive");
  const Recording readings = aided::ideal_readings(*options.motion);
  const aided::OutputTerms terms = output_terms(readings, mission, shared_by({&readings, 1}, mission));
  const AidedNavigation n = aided::foresee(unit_priors(mission.imu, chosen), mission, *options.motion, mission.aids, AidedOptions{}.passes,
                                           with_terms(options) ? &terms : nullptr);
  StatedUnit unit = stated(n, mission);
  Calibration& calibration = unit.calibration;
  for (const Triad triad : {Triad::gyro, Triad::accel}) add_to_offsets(calibration, triad, wander(triad, readings, mission.imu));
  kernel::Findings findings;
  name_undetermined(n, calibration.quality, findings);
  sort_by_table(calibration);
  add_aids(n, calibration.quality);
  std::size_t values = 0;
  for (const Aid& aid : mission.aids) values += 3 * (aid.record.position.size() + aid.record.velocity.size()) + aid.record.value.size();
  calibration.quality.degrees_of_freedom = static_cast<int>(values - std::min(values, n.constants.size()));
  calibration.quality.sources = {kernel::gravity_source(mission.site)};
  Prediction out = prediction_of(calibration);
  out.rig_errors = calibration.quality.rig_errors;
  out.notes = findings.warnings();
  std::string aids;
  for (const AidedConstant& c : n.constants)
    if (of_aid(c)) aids += (aids.empty() ? "aids, declared and u to come: " : ", ") + constant_text(c);
  if (!aids.empty()) out.notes.push_back(std::move(aids));
  if (!mission.imu.grade) out.notes.emplace_back("priors: of grade mems, since the mission declares none");
  for (const std::string& doubt : n.findings.reasons()) out.warnings.push_back(fmt::format("{}: {}", mission.file, doubt));
  out.missed = shortfalls(out, options.requirements);
  return out;
}

}  // namespace imulab::drive
