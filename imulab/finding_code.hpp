// The codes of findings. Files and the Python module use their names ("wrong-latitude"). A code never changes its meaning.
//
// Example:
//   if (calibration.quality.findings.has(Code::wrong_latitude)) std::puts("check the latitude");
#pragma once

#include "imulab/finding.hpp"

namespace imulab {

// clang-format off
enum class Code : std::uint16_t {
  // A sentence without a code, from an older file, a reader or another program
  other,
  // Fits
  not_converged, undetermined, few_degrees_of_freedom, large_residuals, small_residuals, scatter, spread, uncertain_scale, implausible_scale,
  larger_term, dropped, many_dropped, noise_not_as_declared, coarse_steps, recordings_together,
  // Effects, and their sizes in the IMU
  effect_assumed, unexpected_effect, unexpected_site_effect, effects_not_told_apart, improbable_data, unit_size, grade_contradicted, likely_grade,
  // Site and declarations
  wrong_latitude, latitude_of_other_sign, latitude_in_g_sensitivity, latitude_by_turns, latitude_by_fit, latitude_by_rests, latitude_assumed,
  no_latitude, not_earth_rate, wrong_gravity, wrong_turn, axes_not_as_declared, scale_not_as_declared, wrong_rate, wrong_rate_of_increments, no_grade,
  beyond_grade, large_mounting,
  // Recordings and clocks
  clock_corrected, samples_lost, clock_loses, at_a_limit, repeated_readings, stuck_readings,
  // Another method
  other_method_doubts, other_method_differs, other_method_refuses,
  // Rests, and turns by hand
  rests_searched, rests_rejected, few_rests, rests_near_a_plane, short_rests, one_attitude, parts_used, turns_used, turns_not_used, turns_without_sigma,
  start_of_fit, gyros_not_calibrated, gyros_change, gyros_against_gravity, gyros_do_not_carry_gravity, axes_against_gravity, held_out_rotations,
  poor_rotations, large_misalignments, uncertain_combinations, uncertain_spread, fast_sweep,
  // Turns in one place
  velocities_left_out, disturbances_in_turns, colored_residuals, headings_scatter, forces_scatter, motion_left_out, iterations, triads_delayed,
  delay_too_large, late_axis,
  // Tables and machines
  table_note, table_warning, reversed_axis, wrong_sign_of_axis, changed_on_table, change_on_table, unit_changed, residuals_enlarge, residuals_exceed,
  residuals_below_declaration, likelier_noise, point_warning, too_few_levels, points_used, points_scatter, fit_residual, rig_error, rig_angles,
  machine_fit, machine_not_as_declared, hysteresis, not_settled, chamber_not_repeated, stepwise,
  // Aided navigation, and drives
  late_start, drive_passes, aid_noise, aid_constant, position_lost, heading_not_shown, large_innovations, many_suspects, suspects_in_a_row,
  long_errors, lasting_errors, outages_off, noise_still_changes, samples_at_a_limit, null_positions, held_positions, no_positions, begin_left_out,
  positions_not_joined, far_from_site, stamps_moved, position_level, aid_level, all_withheld, no_position_aid, same_receiver, aid_off, constant_off,
  imu_noise_off, calibrated_on_same, shown_by_no_motion, no_coefficient_shown, drive_contradicts, force_at_rest, turn_missed,
  // IMUs on one body
  motion_part, imu_not_calibrated, effects_not_estimated, rates_unlike, clock_ambiguous, mounting_not_shown, accels_late, mounting_predicted, joint_estimate, not_joint, imus_contradict,
  // What a recording holds
  evidence, axes_found, up_at_first_rest, rests_found, turns_explained, open_question, turns_unexplained, file_problem,
  // Priors of a fleet, imports, simulations
  outlier_of_fleet, prior_used, from_fleet, imported, import_undetermined, simulated,
};
// clang-format on

}  // namespace imulab
