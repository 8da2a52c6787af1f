#include "imulab/estimate/method.hpp"

#include "imulab/calibrate.hpp"
#include "imulab/core/nearest_name.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/check_input.hpp"
#include "imulab/estimate/drive/drive.hpp"
#include "imulab/estimate/extrinsics/reference.hpp"
#include "imulab/estimate/hybrid/hybrid.hpp"
#include "imulab/estimate/hybrid/path_design.hpp"
#include "imulab/estimate/hybrid/prediction.hpp"
#include "imulab/estimate/kernel/clocks.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/estimate/kernel/plausibility.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/estimate/kernel/rest_noise.hpp"
#include "imulab/estimate/kernel/second_opinion.hpp"
#include "imulab/estimate/rests/rests.hpp"
#include "imulab/estimate/turntable/prediction.hpp"
#include "imulab/estimate/turntable/turntable.hpp"
#include "imulab/estimate/whole_unit/whole_unit.hpp"
#include "imulab/plan.hpp"
#include "imulab/predict.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/joined.hpp"
#include "imulab/recording/origin.hpp"
#include "imulab/recording/resampling.hpp"
#include "imulab/recording/stuck_readings.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/stop.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <utility>

namespace imulab {

/// Calls a method's function after the common checks.
struct CheckedMethod {
  template <class Result, class... Arguments>
  static Result call(const MethodFunction<Result(Arguments...)>& function, std::type_identity_t<Arguments>... arguments) {
    return function.function_(arguments...);
  }
};

namespace {

Session hand_held_example(const ExampleSize& size) { return hand_held_procedure(size.by_hand, size.seed); }

constexpr std::array all{
    Method{.name = "drive",
           .summary = "from a drive or flight with a receiver, wheels or other aids",
           .reference = "Rauch 1965",
           .needs = "a receiver or other aids as [[aid]], and motion that shows the coefficients",
           .equipment = 5,
           .takes_several = true,
           .takes_aids = true,
           .test = "aided navigation: the motion against a satellite receiver and other aids",
           .angle_source = "the turns of the vehicle against the aids' velocities",
           .calibrate = drive::calibrate,
           .predict = drive::predict},
    Method{.name = "handheld",
           .summary = "from rests and the rotations between them",
           .reference = "Tedaldi 2014",
           .needs = "rests in nine or more directions, and turns about all axes between them",
           .equipment = 1,
           .test = "multi-position (tumble) by hand, with the rotations between the positions",
           .instrument = Method::Instrument::where_declared,
           .calibrate = rests::calibrate_handheld,
           .predict = rests::predict_handheld,
           .support = rests::support_handheld,
           .example = hand_held_example},
    Method{.name = "hybrid",
           .summary = "from rests and turns in one place, without a table's angles",
           .reference = "Cheng 2014",
           .needs = "gyros that resolve the Earth's rate: try it if yours do",
           .equipment = 2,
           .takes_curves = true,
           .second = "handheld",
           .test = "multi-position (tumble) with rotations in one place: zero velocity",
           .calibrate = hybrid::calibrate,
           .predict = hybrid::predict,
           .plan = hybrid::planner,
           .example = [](const ExampleSize& size) { return cheng_path_procedure(size.on_table); }},
    Method{.name = "reference",
           .summary = "from any motion beside a better IMU on the same body",
           .reference = "Kabsch 1976",
           .needs = "a better IMU on the same body: imu = \"NAME\" in each [[recording]]",
           .equipment = 6,
           .takes_several = true,
           .takes_reference = true,
           .takes_curves = true,
           .test = "comparison in motion with a reference IMU on the same body",
           .angle_source = "the turns that the reference IMU measured",
           .instrument = Method::Instrument::always,
           .calibrate = extrinsics::calibrate_by_reference},
    Method{.name = "static",
           .summary = "from rests alone",
           .reference = "Cheng 2014",
           .needs = "rests in nine or more directions",
           .equipment = 0,
           .takes_accel_alone = true,
           .second = "handheld",
           .test = "multi-position (tumble), static",
           .angle_source = "the Earth's rate at the site's latitude",
           .calibrate = rests::calibrate_static,
           .predict = rests::predict_static,
           .support = rests::support_static,
           .example = hand_held_example},
    Method{.name = "turntable",
           .summary = "from the table's angles",
           .reference = "Zhang 2010",
           .needs = "the table's angles as [[step]]",
           .equipment = 3,
           .takes_runs = true,
           .second = "handheld",
           .test = "multi-position (tumble) and rotations on a table: scale factors, misalignments",
           .angle_source = "the table's angles, with their declared errors",
           .instrument = Method::Instrument::always,
           .calibrate = turntable::calibrate,
           .predict = turntable::predict,
           .example = [](const ExampleSize& size) { return zhang_24_procedure(size.on_table); }},
    Method{.name = "whole-unit",
           .summary = "from chamber, rate table and centrifuge, all recordings together",
           .reference = "Dai 2011",
           .needs = "the machines' points as [[step]]",
           .equipment = 4,
           .takes_several = true,
           .takes_full = true,
           .takes_stepwise = true,
           .angle_source = "the rate table's rate and the centrifuge's radius, with their declared errors",
           .instrument = Method::Instrument::always,
           .calibrate = whole_unit::calibrate,
           .predict = whole_unit::predict,
           .example = [](const ExampleSize& size) { return dai_unit_procedure(size.on_machines); }},
};

/// Returns recordings with even stamps if theirs scatter, and with one or two successive lost samples filled in; empty if no recording needs it.
std::vector<Recording> corrected_recordings(const CalibrationInput& input, std::vector<std::string>& said) {
  std::vector<Recording> out;
  for (std::size_t k = 0; k < input.recordings.size(); ++k) {
    const Recording& r = input.recordings[k];
    const Stamps wanted = input.session.recordings[k].time.stamps;
    const std::optional<EvenClock> clock = replacing_clock(r, wanted);
    const std::size_t lost = input.rests || clock ? 0 : short_gaps(r).filled;  // given rests refer to sample numbers, which must not change
    if (!clock && lost == 0) continue;
    if (out.empty()) out.assign(input.recordings.begin(), input.recordings.end());
    if (lost > 0) {
      out[k] = with_short_gaps_filled(std::move(out[k])).recording;
      said.push_back(fmt::format("{}: {} samples are missing, one or two at a time; they were interpolated from their neighbors", r.name, lost));
      continue;
    }
    const bool declared = input.session.recordings[k].rate_hz.has_value();
    out[k] = with_even_stamps(std::move(out[k]), *clock, declared);
    said.push_back(fmt::format(
        "{}: its stamps scatter by {:.2g} ms (RMS) about an even clock of {:.6g} ms, which replaces them unless the recorded stamps are declared",
        r.name, 1e3 * clock->scatter_s, 1e3 * clock->interval_s));
  }
  return out;
}

/// Returns recordings with zero gyro readings for missing gyros; empty if all have gyros. Throws Error if the method needs a missing triad.
std::vector<Recording> with_both_triads(const Method& method, std::span<const Recording> recordings) {
  std::vector<Recording> out;
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    const RecordingView columns(recordings[k]);
    if (columns.has(gyro_columns) && columns.has(accel_columns)) continue;
    if (!columns.has(accel_columns))
      throw Error(fmt::format("{}: has no accelerometers; the method {} needs them. Of gyros alone the noise can be analyzed", recordings[k].name,
                              method.name));
    if (!method.takes_accel_alone)
      throw Error(fmt::format("{}: has no gyros, which the method {} needs; the method static calibrates accelerometers alone", recordings[k].name,
                              method.name));
    if (out.empty()) out.assign(recordings.begin(), recordings.end());
    for (std::vector<double>& column : out[k].gyro) column.assign(out[k].size(), 0);
    out[k].gyro_unit = "rad/s";
  }
  return out;
}

/// Calibrates; a method for one recording joins several into one.
CalibrationResult calibrate_together(const Method& method, const CalibrationInput& input, const CalibrationOptions& options) {
  if (method.takes_several || input.recordings.size() <= 1) return CheckedMethod::call(method.calibrate, input, options);
  const Joined joined = join(input.session, input.recordings);
  CalibrationResult result = CheckedMethod::call(method.calibrate, CalibrationInput{joined.session, std::span(&joined.recording, 1)}, options);
  Quality& quality = result.calibration.quality;
  for (std::vector<PartResidual>* parts : {&quality.rests, &quality.rotations})
    for (PartResidual& part : *parts) {
      const JoinedPart& of = part_at(joined.parts, part.begin_s);
      part.begin_s -= of.shift_s, part.end_s -= of.shift_s;
      part.recording = of.name;
    }
  quality.findings.add<Code::recordings_together>(joined.parts.size());
  return result;
}

/// Returns the excess of chi-square over its expectation.
double excess_of(const Quality& quality) { return (quality.chi2_per_dof - 1) * quality.degrees_of_freedom; }

/// Repeats a doubtful calibration in the other hemisphere, because no fit reaches a latitude of the wrong sign. Gyros that are all reversed fit
/// equally well there; the other result is then only used if nothing contradicts it.
CalibrationResult calibrate_in_either_hemisphere(const Method& method, const CalibrationInput& input, const CalibrationOptions& options) {
  CalibrationResult result = calibrate_together(method, input, options);
  const std::optional<double>& latitude = input.session.site.latitude;
  if (!options.effects || !latitude || method.takes_aids || method.takes_reference || result.calibration.quality.verdict != Verdict::doubtful)
    return result;
  constexpr double obvious = 30;  // difference of chi-square: five sigma of one parameter
  const Findings& found = result.calibration.quality.findings;
  const bool by_latitude = found.has(Code::wrong_latitude) || found.has(Code::not_earth_rate);
  Session elsewhere = input.session;
  elsewhere.site.latitude = -*latitude;
  try {
    CalibrationResult other = calibrate_together(method, {elsewhere, input.recordings, input.rests}, options);
    const double before = excess_of(result.calibration.quality);
    Quality& quality = other.calibration.quality;
    // A partial explanation indicates another fault, which resembles the latitude's rotation of the Earth's rate.
    const bool by_chi2 = excess_of(quality) + obvious < before && excess_of(quality) < before / 2;
    if (!by_chi2 && !(by_latitude && quality.verdict == Verdict::good)) return result;
    quality.findings.add<Code::latitude_by_fit>(
        -*latitude / unit::deg, *latitude / unit::deg,
        by_chi2 ? fmt::format("chi2 falls by {:.3g}", before - excess_of(quality)) : "nothing contradicts the data");
    quality.findings.add<Code::wrong_latitude>();
    kernel::judge(quality);
    return other;
  } catch (const Error&) {
    return result;
  } catch (const Unsupported&) {
    return result;
  }
}

/// Adds a second opinion. A method that cannot judge the data has none; its refusal of the session's declarations is one.
void add_second_opinion(Calibration& calibration, const Method& of, const CalibrationInput& input, const CalibrationOptions& options) {
  try {
    CalibrationOptions same;
    same.effects = options.effects;
    const CalibrationResult other = calibrate_together(method(of.second), input, same);
    kernel::add_second_opinion(calibration, other.calibration);
  } catch (const Error& e) {
    calibration.quality.findings.add<Code::other_method_refuses>(Subject{of.second}, e.what());
  } catch (const Unsupported&) {
  }
}

}  // namespace

std::span<const Method> methods() { return all; }

const Method* find_method(std::string_view name, std::span<const Method> table) {
  const auto found = std::ranges::find(table, name, &Method::name);
  return found == table.end() ? nullptr : &*found;
}

const Method& method(std::string_view name, std::span<const Method> table) {
  if (const Method* found = find_method(name, table)) return *found;
  std::vector<std::string_view> names;
  for (const Method& m : table) names.push_back(m.name);
  throw Error(fmt::format("no method {}{}", name, expected_name(name, names)));
}

std::vector<Method> methods_by_equipment() {
  std::vector<Method> out(all.begin(), all.end());
  std::ranges::sort(out, {}, &Method::equipment);
  return out;
}

std::vector<std::string_view> method_names() {
  std::vector<std::string_view> names;
  for (const Method& m : methods_by_equipment()) names.push_back(m.name);
  return names;
}

const Method& planning_method() {
  return *std::ranges::find_if(all, [](const Method& m) { return m.plan.design != nullptr; });
}

std::string names_of_methods(bool Method::*capability) {
  std::string names;
  for (const Method& m : all)
    if (m.*capability) names += (names.empty() ? "" : ", ") + std::string(m.name);
  return names;
}

CalibrationResult calibrate(const Method& method, const CalibrationInput& declared, const CalibrationOptions& options) {
  const CalibrationInput input = checked_input(method, declared, options);
  const WorkScope scope(options.stop, options.progress);
  stop_point();
  for (const Recording& recording : input.recordings) kernel::expect_different_channels(recording);
  const std::vector<Recording> completed = with_both_triads(method, input.recordings);
  const std::span<const Recording> given = completed.empty() ? input.recordings : std::span<const Recording>(completed);
  std::vector<std::string> clocks;
  const std::vector<Recording> corrected = corrected_recordings({input.session, given, input.rests}, clocks);
  const std::span<const Recording> recordings = corrected.empty() ? given : std::span<const Recording>(corrected);
  CalibrationInput used{input.session, recordings, input.rests};
  const std::vector<kernel::ClockGain> gains = kernel::correct_clocks(used.session, recordings, clocks);
  CalibrationResult result = calibrate_in_either_hemisphere(method, used, options);
  Quality& quality = result.calibration.quality;
  Findings corrections;
  for (const std::string& text : clocks) corrections.add<Code::clock_corrected>(text);
  quality.findings.prepend(corrections);
  kernel::doubt_small_residuals(quality, used.session.imu);
  const auto own = std::ranges::find_if(
      recordings, [&](const Recording& r) { return !method.takes_reference || used.session.source_of(r.name).imu != options.reference->imu; });
  quality.findings.append(kernel::contradictions(result.calibration.model, *own));
  if (options.second_opinion && options.effects && !method.second.empty()) add_second_opinion(result.calibration, method, used, options);
  for (const kernel::ClockGain& gain : gains) kernel::doubt_clock(result.calibration, gain);
  kernel::state_clock(result.calibration, used.session, gains);
  if (!method.takes_aids && !result.calibration.turn_on) result.calibration.turn_on = kernel::declared_turn_on(input.session.imu, recordings.size());
  if (!method.takes_several) result.calibration.rest_noise = kernel::rest_noise(result.calibration, used);
  if (const std::string twice = kernel::repetition(recordings); !twice.empty()) quality.findings.add<Code::repeated_readings>(twice);
  for (const Recording& recording : recordings)
    if (const std::string stuck = said_of_stuck(recording); !stuck.empty())
      quality.findings.add<Code::stuck_readings>(stuck).subject = recording.name;
  for (std::size_t k = 0; k < recordings.size(); ++k) kernel::judge_interval(recordings[k], input.session.recordings[k].rate_hz.has_value(), quality);
  for (const Recording& recording : recordings)
    if (const std::size_t n = recording.saturated.size(); n > 0)
      quality.findings.add<Code::at_a_limit>(Subject{recording.name}, n, recording.size(), n == 1 ? "it" : "them");
  kernel::judge(quality);
  add_declared_origin(result.calibration, input.session, input.recordings);
  result.calibration.session_file = declared.session.file;
  if (options.progress) options.progress(1);
  return result;
}

CalibrationResult calibrate(std::string_view name, const CalibrationInput& input, const CalibrationOptions& options) {
  return calibrate(method(name), input, options);
}

Prediction predict(const Method& method, const Session& declared, const PredictionOptions& options) {
  expect_valid(declared, options);
  Session procedure = declared;
  if (procedure.file.empty()) procedure.file = "procedure";  // name in messages for a procedure in memory
  errors_at(procedure.file, [&] { procedure.site.gravity(); });
  if (!method.predict) throw Error(fmt::format("the method {} has no prediction", method.name));
  const WorkScope scope(options.stop);
  stop_point();
  Prediction out = CheckedMethod::call(method.predict, procedure, options);
  if (!options.terms.empty()) {
    const Prediction whole =
        CheckedMethod::call(method.predict, procedure, PredictionOptions{.effects = false, .advice = false, .motion = options.motion});
    if (std::string note = note_of_absent(out, whole); !note.empty()) out.notes.push_back(std::move(note));
  }
  if (options.sizes && options.effects && !options.classical)
    add_sizes(out, procedure, [&](const Session& other) {
      return CheckedMethod::call(method.predict, other, PredictionOptions{.terms = options.terms, .advice = false, .motion = options.motion});
    });
  return out;
}

Prediction predict(std::string_view name, const Session& procedure, const PredictionOptions& options) {
  return predict(method(name), procedure, options);
}

TurnPath plan_path(const Session& unit, const PathLimits& limits, const std::function<void(int)>& progress) {
  const PathPlanner& planner = planning_method().plan;
  planner.expect_estimated(limits.requirements, unit);
  return planner.design(limits, unit, progress, nullptr);
}

}  // namespace imulab
