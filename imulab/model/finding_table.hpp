// The table of findings: name, severity and text of each code. Values of Findings::add are inserted into text and advice; the compiler checks that
// they fit. The severity may be changed where a finding is added.
#pragma once

#include "imulab/finding.hpp"
#include "imulab/finding_code.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <type_traits>

namespace imulab {

struct FindingRow {
  Code code;
  std::string_view name;
  Severity severity;
  std::string_view words, advice = {};
};

inline constexpr auto finding_table = [] {
  using enum Code;
  using enum Severity;
  return std::to_array<FindingRow>({
      {other, "other", note, "{}"},
      {not_converged, "not-converged", doubt, "the fit did not converge"},
      {undetermined, "undetermined", doubt, "{} not determined by the data"},
      {few_degrees_of_freedom, "few-degrees-of-freedom", doubt, "only {:.0f} degree{} of freedom remain{} to check the result"},
      {large_residuals, "large-residuals", doubt, "the residuals are {:.0f} times what the noise explains"},
      {small_residuals, "small-residuals", doubt, "the residuals are far smaller than the declared noise: the uncertainties are too large"},
      {scatter, "scatter", warning, "the {} scatter {:.3g} times as much as the noise explains", "the uncertainties are enlarged by this factor"},
      {spread, "spread", note, "{} spread by {:.3g} {} (1 sigma) more than the sample noise explains; counted in the uncertainties"},
      {uncertain_scale, "uncertain-scale", doubt, "{} is uncertain by {:.2g} %"},
      {implausible_scale, "implausible-scale", warning, "{} is implausible for an IMU, {:.3g} times what {}: {}"},
      {larger_term, "larger-term", warning, "{} is larger than expected of this IMU",
       "the data set its size; check the declared grade and sizes of terms"},
      {dropped, "dropped", warning, "dropped as an outlier: {}"},
      {many_dropped, "many-dropped", doubt, "{} of {} {} were dropped as outliers"},
      {noise_not_as_declared, "noise-not-as-declared", warning, "the {}' noise is {:.2g} times the declared density",
       "the declared one sets the weights"},
      {coarse_steps, "coarse-steps", doubt,
       "the steps of the gyros' readings are coarser than their noise; smaller motion is lost; use a finer output"},
      {recordings_together, "recordings-together", note, "{} recordings of one IMU were calibrated together"},

      {effect_assumed, "effect-assumed", note,
       "assumed: {} of {:.3g} {} (one sigma); the data hardly show it, and if it is larger, so are the errors of {}; to see it: {}"},
      {unexpected_effect, "unexpected-effect", doubt, "{}, by more than is expected of this IMU"},
      {unexpected_site_effect, "unexpected-site-effect", doubt, "{}, by more than is expected of this IMU"},
      {effects_not_told_apart, "effects-not-told-apart", warning, "the data do not tell these apart: {}; to do so: {}"},
      {improbable_data, "improbable-data", doubt,
       "noise and an IMU of grade {} explain the data with a probability of {:.1g}: something is wrong that is no known effect"},
      {unit_size, "unit-size", note, "the IMU's effects are {:.2g} times those of its grade, {}{}"},
      {grade_contradicted, "grade-contradicted", warning,
       "the data contradict the declared grade, {}: the noise, the biases and the effects are most probably those of grade {} ({:.0f} %); sizes "
       "are averaged over the grades"},
      {likely_grade, "likely-grade", note,
       "no grade declared: the noise, the biases and the effects are most probably those of grade {} ({:.0f} %); sizes are averaged over the "
       "grades"},

      {wrong_latitude, "wrong-latitude", doubt, "the latitude seems to be wrong"},
      {latitude_of_other_sign, "latitude-of-other-sign", warning, "the gyros show a latitude of the other sign{}; check the site's latitude"},
      {latitude_in_g_sensitivity, "latitude-in-g-sensitivity", warning,
       "the g-sensitivity is the same on all axes, as a latitude of {:.1f} deg (u = {:.1f} deg) instead of {:.1f} would make it; check the site's "
       "latitude"},
      {latitude_by_turns, "latitude-by-turns", warning,
       "between the rests gravity turns against the calibrated gyros, as a latitude of the wrong sign makes it; check its sign"},
      {latitude_by_fit, "latitude-by-fit", warning, "at a latitude of {:g} deg in place of {:g} deg {}; check its sign"},
      {latitude_by_rests, "latitude-by-rests", warning,
       "the gyros show a latitude of {:.3f} deg (u = {:.2g} deg), not {:.3f}; this latitude is used, with its gravity if none is declared; "
       "check the site's latitude"},
      {latitude_assumed, "latitude-assumed", note,
       "assumed: the latitude of {:.3g} deg; with the other sign gyro.g_sensitivity.xx, .yy and .zz would differ by {:.3g} deg/h/g, and an IMU with "
       "as much of its own would not show it; check the sign"},
      {no_latitude, "no-latitude", note, "no latitude: Earth's rate {}"},
      {not_earth_rate, "not-earth-rate", doubt, "the gyros' readings at rest are not the Earth's rate at this latitude"},
      {wrong_gravity, "wrong-gravity", doubt, "the given gravity of {:g} m/s^2 is not that of {} ({:.3f})"},
      {wrong_turn, "wrong-turn", doubt, "a turn does not fit its declared angle"},
      {axes_not_as_declared, "axes-not-as-declared", doubt,
       "the {}' axes are not as declared: {}{}; check the order and the signs of both triads' columns"},
      {scale_not_as_declared, "scale-not-as-declared", doubt, "{}"},
      {wrong_rate, "wrong-rate", warning,
       "{}: the stamps give {:.6g} Hz where {:.6g} Hz is declared: turns are rates times the stamps' time, so the gyros' scales are {:.2g} % off if "
       "the "
       "stamps are wrong; correct the one that is"},
      {wrong_rate_of_increments, "wrong-rate-of-increments", doubt,
       "{}: the stamps give {:.6g} Hz where {:.6g} Hz is declared: increments, and with them the scales, are {:.2g} % off if the stamps are right; "
       "correct "
       "the declared rate"},
      {no_grade, "no-grade", note, "priors: of grade mems, since the {} declares none"},
      {beyond_grade, "beyond-grade", doubt, "{} is {:.1f} times what an IMU of grade {} has; declare its grade, unit and axes"},
      {large_mounting, "large-mounting", doubt, "{} is {:.0f} deg; declare the columns' axes (right, forward, up)"},

      {clock_corrected, "clock-corrected", warning, "{}"},
      {samples_lost, "samples-lost", doubt,
       "{}: samples are lost without a trace in the stamps: turns come {:.2g} s earlier at once than the steps say, which no clock does; the angle "
       "of a "
       "turn that lost some is wrong; record again with all samples"},
      {clock_loses, "clock-loses", doubt,
       "{}: its clock loses {:.0f} ppm on that of the steps: if it does because samples are missing, the gyros' scales are off by as much; find out "
       "whether all samples were recorded"},
      {at_a_limit, "at-a-limit", warning, "{0}: {1} of {2} samples have a reading at a limit: rests with {3}, and turns that need {3}, are not used"},
      {repeated_readings, "repeated-readings", doubt, "{}"},
      {stuck_readings, "stuck-readings", doubt, "{}"},

      {other_method_doubts, "other-method-doubts", doubt, "{}, by the method {} from the same data"},
      {other_method_differs, "other-method-differs", doubt, "the method {} finds {} {:.1f} standard deviations away, from the same data"},
      {other_method_refuses, "other-method-refuses", doubt, "the method {} refuses the same data: {}"},

      {rests_searched, "rests-searched", note, "{}"},
      {rests_rejected, "rests-rejected", warning, "{} of {} stretches that look like rests were rejected: {}",
       "nothing is taken from them; hold the IMU still, and record one unit without a pause"},
      {few_rests, "few-rests", warning, "only {} rest{}: about 20 in different directions are good"},
      {rests_near_a_plane, "rests-near-a-plane", warning,
       "all rests have gravity near one axis or plane of the IMU: turn it so that each of its axes points up and down"},
      {short_rests, "short-rests", warning,
       "{} of {} rests are no longer than {:g} s; settling transients at their ends cannot be cut off, and the Earth's rate hardly shows in them; "
       "use "
       "rests of 30 s or more"},
      {one_attitude, "one-attitude", note,
       "one attitude shows the gyros' biases, and how the biases follow the temperature; the accelerometers' biases, scales and nonorthogonality "
       "stay "
       "as declared: to have all, calibrate this recording together with one by hand"},
      {parts_used, "parts-used", note, "{} were used"},
      {turns_used, "turns-used", note, "{} of {} turns were used with their declared angle, each with u = {:.2g} deg"},
      {turns_not_used, "turns-not-used", warning,
       "{} of {} turns have no rest of their own before and after them, or a gap: their angle is not used"},
      {turns_without_sigma, "turns-without-sigma", warning,
       "turns are declared, but not how well their angles are known: they are not used; declare the sigma of the rig's angles"},
      {start_of_fit, "start-of-fit", note, "{}"},
      {gyros_not_calibrated, "gyros-not-calibrated", warning, "the gyros were not calibrated: {}"},
      {gyros_change, "gyros-change", doubt, "the gyros' output changes between the rests"},
      {gyros_against_gravity, "gyros-against-gravity", doubt, "the gyros do not turn as gravity does"},
      {gyros_do_not_carry_gravity, "gyros-do-not-carry-gravity", warning,
       "the calibrated gyros do not carry gravity from rest to rest; check the latitude, and the columns of both triads"},
      {axes_against_gravity, "axes-against-gravity", doubt, "{}, as gravity turns in the IMU; check the order and the signs of both triads' columns"},
      {held_out_rotations, "held-out-rotations", note,
       "held-out rotations are predicted to {:.3f} deg RMS (10-fold cross-validation over {} rotations of more than 10 deg)"},
      {poor_rotations, "poor-rotations", doubt, "held-out rotations are predicted no better than to {:.2g} deg"},
      {large_misalignments, "large-misalignments", warning,
       "the rests leave misalignments so uncertain that the equations are not linear within them: single uncertainties hold, combinations are less "
       "certain "
       "than stated; add rests with gravity between the axes"},
      {uncertain_combinations, "uncertain-combinations", doubt, "combinations of coefficients are less certain than stated"},
      {uncertain_spread, "uncertain-spread", doubt, "the spread beyond the sample noise rests on {:.0f} degrees of freedom"},
      {fast_sweep, "fast-sweep", doubt,
       "the temperature changed by {:.0f} K, and as fast as in {:.0f} s: a thermometer that is late by some seconds makes the thermal terms wrong; "
       "expected {:.0f} s or more: let the IMU warm up more slowly"},

      {velocities_left_out, "velocities-left-out", warning,
       "{} of {} velocities do not fit: the IMU was bumped, shaken, or displaced; they are not used: {}"},
      {disturbances_in_turns, "disturbances-in-turns", doubt,
       "{:.0f} of {:.0f} disturbances that were left out are in turns: that is no bump but something that the model lacks; check the delay between "
       "the "
       "triads, the lever arms and the stamps"},
      {colored_residuals, "colored-residuals", doubt,
       "the velocities' residuals are alike from one to the next (correlation {:.2f}): slow vibration, or something that the model lacks; the "
       "uncertainties may be too small"},
      {headings_scatter, "headings-scatter", warning, "the headings within the rests scatter {:.3g} times as much as the gyros' noise explains",
       "a stand that moves does that, or biases that drift; they count that much less"},
      {forces_scatter, "forces-scatter", warning, "the rests' mean forces scatter {:.3g} times as much as the noise explains",
       "biases or scale factors that drift do that; the uncertainties are enlarged by this factor"},
      {motion_left_out, "motion-left-out", warning, "{}"},
      {iterations, "iterations", note, "{} iterations over {} blocks"},
      {triads_delayed, "triads-delayed", note, "the accelerometers' output is {:.3g} ms (u = {:.2g} ms) behind the gyros'"},
      {delay_too_large, "delay-too-large", doubt,
       "the accelerometers' output is {:.3g} ms behind the gyros', more than what the method corrects; shift one triad's stamps"},
      {late_axis, "late-axis", doubt, "the {} {}'s readings are a sample {} than the others'",
       "it was corrected; the scatter of the velocities fell from {3:.3g} to {4:.3g} times the noise; check the filter and the column of this axis"},

      {table_note, "table-note", note, "{}"},
      {table_warning, "table-warning", warning, "{}"},
      {reversed_axis, "reversed-axis", warning, "{}"},
      {wrong_sign_of_axis, "wrong-sign-of-axis", doubt, "the sign of an axis seems to be wrong"},
      {changed_on_table, "changed-on-table", doubt, "{} after {:.0f} s"},
      {change_on_table, "change-on-table", warning,
       "{} by ({:.3g}, {:.3g}, {:.3g}) {} along (or about) its axes between {} and {}; the coefficients are those before it; {}"},
      {unit_changed, "unit-changed", doubt, "{} of {} {} were dropped as outliers: the IMU or the table may have changed during the session"},
      {residuals_enlarge, "residuals-enlarge", warning,
       "the residuals are {:.3g} times what the noise and the declared table errors explain; the uncertainties are enlarged for {:.3g} times the "
       "accelerometers' noise, {:.3g} times the gyros' and {:.3g} times the table's errors{}"},
      {residuals_exceed, "residuals-exceed", doubt, "the residuals exceed the declared noise and table errors"},
      {residuals_below_declaration, "residuals-below-declaration", warning,
       "the residuals are only {:.3g} times what the noise and the declared table errors explain; the table is better than declared, or the samples' "
       "noise "
       "is not white (quantization averages out faster); declare the noise densities"},
      {likelier_noise, "likelier-noise", note,
       "though chance explains the residuals, {:.3g} times the accelerometers' noise, {:.3g} times the gyros' and {:.3g} times the table's errors "
       "are more "
       "likely; the uncertainties are for these"},
      {point_warning, "point-warning", warning, "{}"},
      {too_few_levels, "too-few-levels", warning, "{}"},
      {points_used, "points-used", note, "{} points were used: {} in the chamber, {} on the rate table, {} on the centrifuge"},
      {points_scatter, "points-scatter", doubt, "the points scatter {:.2f} times as much as noise and declared errors explain",
       "the uncertainties are enlarged by this factor"},
      {fit_residual, "fit-residual", note, "fit residual, x y z: {:.2g}, {:.2g}, {:.2g} % RMS of the full scale of {:.4g} {} (largest {:.2g} %)"},
      {rig_error, "rig-error", note, "{}: {:+.3g} {} (u = {:.2g}) from its declaration (sigma {:.3g})"},
      {rig_angles, "rig-angles", note, "{} errors of mounting and leveling were estimated jointly, {:.3g} arcsec RMS"},
      {machine_fit, "machine-fit", warning,
       "{}: not as declared; the data fit best with {:+.3g} {} (chi2 falls by {:.3g}): what depends on it is biased beyond the stated uncertainties"},
      {machine_not_as_declared, "machine-not-as-declared", doubt, "a machine is not as declared"},
      {hysteresis, "hysteresis", warning, "{} {} differs by {:.2g} {} between warming and cooling: hysteresis, which the model does not have"},
      {not_settled, "not-settled", warning,
       "{}: the sensors lag behind their thermal readings, and the thermal coefficients are biased beyond the stated uncertainties; wait longer at "
       "each "
       "temperature"},
      {chamber_not_repeated, "chamber-not-repeated", doubt, "the chamber's points do not settle or do not repeat"},
      {stepwise, "stepwise", note, "the stepwise estimate takes the effects as absent"},

      {late_start, "late-start", warning,
       "the solution begins with the first fix, {:.6g} s after the recording; an initial state would give an earlier start"},
      {drive_passes, "drive-passes", note, "{}{} passes over {:.0f} s with {}; {} values of aids, innovations {:.2f} times their stated size (RMS)"},
      {aid_noise, "aid-noise", note, "{}noise of {}: {:.3g} times the declared sigma, from {:.0f} values"},
      {aid_constant, "aid-constant", note, "{}"},
      {position_lost, "position-lost", warning,
       "the position is lost: a sigma of {:.2g} m at {:.6g} s, {:.2g} m in the median; expected positions by an aid"},
      {heading_not_shown, "heading-not-shown", doubt, "the motion does not show the heading; expected accelerations or turns while the aids measure"},
      {large_innovations, "large-innovations", doubt,
       "innovations are {:.1f} times their stated size; the aids contradict each other or the recording"},
      {many_suspects, "many-suspects", doubt, "{:.0f} % of the aids' values are suspects"},
      {suspects_in_a_row, "suspects-in-a-row", warning,
       "the values of {} from {:.6g} s to {:.6g} s contradict all else: suspects, which hardly count"},
      {long_errors, "long-errors", warning,
       "errors of {} last: in the long run its values tell as much as with {:.2g} times the sigma, and are so taken"},
      {lasting_errors, "lasting-errors", doubt,
       "innovations of {} are alike over {} in a row: its errors last, and uncertainties may be {:.2g} times too small"},
      {outages_off, "outages-off", doubt, "errors in withheld times are {:.1f} times their stated sigma"},
      {noise_still_changes, "noise-still-changes", doubt, "the estimates of the noise still change after {} passes"},
      {samples_at_a_limit, "samples-at-a-limit", doubt, "{:.2g} % of the samples are at a limit: what moved in them is not known"},
      {null_positions, "null-positions", warning, "{}: {} of {} positions are at latitude 0 and longitude 0: no fixes, and they are left out"},
      {held_positions, "held-positions", warning,
       "{}: {} of {} positions repeat the one before exactly: the receiver holds its last one, and they are left out"},
      {no_positions, "no-positions", doubt, "{}: {} of {} positions are zeros, or held while it moves: the aid hardly measures the position"},
      {begin_left_out, "begin-left-out", warning,
       "{}: {} of {} positions, until {:.6g} s, are left out: {:.3g} m from where the others begin, which no motion explains"},
      {positions_not_joined, "positions-not-joined", doubt,
       "{}: no motion joins {} of its positions, from {:.6g} s on, and {} from {:.6g} s on: which are right is not known"},
      {far_from_site, "far-from-site", doubt,
       "{}: its positions are {:.0f} km and more from {}, latitude {:.6g} deg{}; expected one of them corrected"},
      {stamps_moved, "stamps-moved", warning, "{}: its stamps were moved by {:.2f} s: turns and changes of speed fit there alone{}"},
      {position_level, "position-level", doubt,
       "{}: its positions are {:.3g} m {} {} at {:.6g} s by the other data, {:.2g} times what its slow error lets expect: another datum or geoid, a "
       "jump, or "
       "aids that contradict each other; the sigmas of the position contain it"},
      {aid_level, "aid-level", doubt,
       "{}: its values are {} at {:.6g} s by the other data, {:.2g} times what its slow error lets expect: another zero, unit or sign, or aids that "
       "contradict each other"},
      {all_withheld, "all-withheld", doubt, "all values of the aids are withheld: nothing corrects the solution"},
      {no_position_aid, "no-position-aid", doubt, "no aid measures the position; expected an [[aid]] of kind = \"gnss\" with its file"},
      {same_receiver, "same-receiver", doubt, "{}: has the positions of {}: one receiver, whose errors count once; leave one out"},
      {aid_off, "aid-off", doubt, "{}: its error comes out {:.3g} times what a {} usually has: another unit, sign or frame"},
      {constant_off, "constant-off", doubt, "{}: comes out {:.3g} from what is declared, {:.3g} times what its sigma lets expect"},
      {imu_noise_off, "imu-noise-off", doubt,
       "the noise of the {} comes out {:.3g} times its declared size: the recording in other axes or units, or positions that jump"},
      {calibrated_on_same, "calibrated-on-same", doubt,
       "the calibration was made of this recording, which so counts twice: sigmas are too small; expected another one"},
      {shown_by_no_motion, "shown-by-no-motion", warning, "not determined, so still as uncertain as its prior: {}{}"},
      {no_coefficient_shown, "no-coefficient-shown", doubt, "the motion shows no coefficient"},
      {drive_contradicts, "drive-contradicts", doubt,
       "{} contradicts the other{}: chi2 {:.3g} for {:g} differences, most in {} ({:.1f} sigmas); another unit, or one that changed"},
      {force_at_rest, "force-at-rest", doubt,
       "{}at rest from {:.1f} to {:.1f} s the calibrated force is {:+.3g} mg from gravity, where {:.2g} mg is its uncertainty"},
      {turn_missed, "turn-missed", doubt,
       "{}from {:.1f} to {:.1f} s the calibrated gyros miss gravity's turn by {:.3g} deg, where {:.2g} deg is their uncertainty"},

      {motion_part, "motion-part", note, "the {:.0f} s with most motion were used, of {:.0f} s"},
      {imu_not_calibrated, "imu-not-calibrated", note, "{}: scales and misalignments of {}, since no calibration was given"},
      {effects_not_estimated, "effects-not-estimated", warning,
       "effects such as asymmetry and nonlinearity are not estimated, and u does not contain them", "compare with another method"},
      {rates_unlike, "rates-unlike", doubt, "{} and {} turn differently, by {:.0f} % of their rates: not on one rigid body, or not at one time"},
      {clock_ambiguous, "clock-ambiguous", doubt, "the clocks of {} and {} agree at two offsets, {:.3f} s and {:.3f} s"},
      {mounting_not_shown, "mounting-not-shown", warning, "{}: the motion does not show the {}", "turn the body quickly about another axis"},
      {accels_late, "accels-late", warning, "{}: the accelerometers are {:.2g} ms later against its gyros than those of {}, u = {:.2g} ms"},
      {mounting_predicted, "mounting-predicted", note, "predicted from the motion of {}, of another IMU like it, 0.1 m away along each axis"},
      {joint_estimate, "joint-estimate", note, "with the motion in common with {}, standard uncertainties are {:.2f} to {:.2f} of those alone"},
      {not_joint, "not-joint", note, "not estimated jointly with the others: {}"},
      {imus_contradict, "imus-contradict", doubt,
       "the calibrations of {} contradict each other in their common motion, by {:.1f} sigmas (chance: {:.2g})"},

      {evidence, "evidence", note, "{}"},
      {axes_found, "axes-found", note, "axes: {}"},
      {up_at_first_rest, "up-at-first-rest", note, "up at the first rest: about {} (if it was the other side: --set accel.axes=-x,-y,-z)"},
      {rests_found, "rests-found", note, "rests: {} found{}, {} between them{}"},
      {turns_explained, "turns-explained", note, "gyros explain {} turns of {:.3g} deg RMS to {:.2g} deg"},
      {open_question, "open-question", warning, "{}: {}"},
      {turns_unexplained, "turns-unexplained", warning, "{}: {}"},
      {file_problem, "file-problem", doubt, "{}"},

      {outlier_of_fleet, "outlier-of-fleet", warning,
       "the unit is an outlier of the fleet {} (distance {:.1f}, probability by chance {:.2g}); the prior is not used; check the unit and the store"},
      {prior_used, "prior-used", note, "prior: {:.0f} units of {}; the data alone are {:.1f} from their mean (chance: {:.2g})"},
      {from_fleet, "from-fleet", note, "from the fleet alone:{}"},
      {imported, "imported", doubt, "imported: its uncertainties are not known"},
      {import_undetermined, "import-undetermined", doubt, "{} coefficients are not determined by the data"},
      {simulated, "simulated", note, "{}"},
  });
}();

constexpr const FindingRow& finding_row(Code code) { return finding_table[static_cast<std::size_t>(code)]; }
constexpr bool every_code_has_its_row() {
  for (std::size_t k = 0; k < finding_table.size(); ++k)
    if (finding_table[k].code != static_cast<Code>(k)) return false;
  return finding_table.back().code == Code::simulated;
}
static_assert(every_code_has_its_row());

namespace finding_io {

template <class Value>
const Value& shown(const Value& value) {
  return value;
}
inline std::string_view shown(const Subject& subject) { return subject.name; }

template <class Value>
void take(Finding& finding, const Value& value) {
  if constexpr (std::is_same_v<Value, Subject>)
    finding.subject = value.name;
  else if constexpr (std::is_arithmetic_v<Value> && !std::is_same_v<Value, char>)
    finding.numbers.push_back(static_cast<double>(value));
}

}  // namespace finding_io

template <Code code, class... Values>
Finding& Findings::add(const Values&... values) {
  using finding_io::shown;
  constexpr const FindingRow& row = finding_row(code);
  push_back(Finding{.code = code, .severity = row.severity});
  Finding& out = back();
  (finding_io::take(out, values), ...);
  out.text = fmt::format(fmt::format_string<decltype(shown(values))...>(row.words), shown(values)...);
  out.advice = fmt::format(fmt::format_string<decltype(shown(values))...>(row.advice), shown(values)...);
  return out;
}

}  // namespace imulab
