// Results, conformity, traceability and signature of a certificate.
#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"
#include "imulab/model/frame_axes.hpp"
#include "imulab/model/relative_uncertainty.hpp"
#include "imulab/report/calibration_facts.hpp"
#include "imulab/report/certificate_parts.hpp"
#include "imulab/report/html.hpp"
#include "imulab/results/calibration.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab::report {

namespace {

std::string name_on_certificate(CoefficientIndex index, const std::string& unit) {
  const Coefficient& c = coefficient(index);
  const std::string element(c.name.substr(c.name.rfind('.') + 1));
  if (c.term == Term::offset) return unit == "count at zero" ? "zero " + element : "offset " + element;
  if (!is_scale(c)) return "misalignment " + element;
  return (unit == "ppm" ? "scale correction " : "scale ") + element.substr(0, 1);
}

std::string result_row(const Calibration& calibration, CoefficientIndex index) {
  const UserValue user = user_value(calibration, index);
  std::string row = "<tr><th>" + escaped(name_on_certificate(index, user.unit)) + "</th>";
  if (!is_result(calibration, index)) return row + "<td colspan=\"4\">not determined</td></tr>\n";
  const double k = expanded_uncertainty(calibration, index).coverage_factor, expanded = k * user.uncertainty;
  return row + fmt::format("<td>{}</td><td>{}</td><td class=\"left\">{}</td><td>{:.2f}</td></tr>\n", rounded_to(user.value, expanded),
                           uncertainty_text(expanded), escaped(readable_unit(user.unit)), k);
}

bool any_of_triad(const Calibration& c, Triad triad) {
  return std::ranges::any_of(c.estimated, [&](CoefficientIndex index) { return coefficient(index).triad == triad; });
}

/// The seconds of the gyros' scales, beside these: what their U does not contain.
std::string time_base_row(const Calibration& c) {
  if (!c.clock || c.clock->seconds == "true") return "";
  const double k = coverage_factor(std::numeric_limits<double>::infinity()), expanded = k * c.clock->sigma / unit::ppm;
  return fmt::format("<tr><th>time base</th><td>{}</td><td>{}</td><td class=\"left\">ppm</td><td>{:.2f}</td></tr>\n",
                     rounded_to(c.clock->gain / unit::ppm, expanded), uncertainty_text(expanded), k);
}

std::string time_base_text(const Calibration& c) {
  if (!c.clock || !any_of_triad(c, Triad::gyro)) return "";
  return c.clock->seconds == "true"
             ? fmt::format(" The gyros' scales are per true second; their U contains that of the recording's clock, {} ppm.",
                           uncertainty_text(coverage_factor(std::numeric_limits<double>::infinity()) * c.clock->sigma / unit::ppm))
             : " The gyros' scales are per second of the recording's own clock. Time base: by how much that clock gains; the U of the scales does "
               "not "
               "contain its U.";
}

std::string next_power_on_text(const Calibration& c) {
  const std::string next = next_switch_on_text(c);
  return next.empty() ? next : " At the next power-on the standard uncertainties are " + escaped(readable_unit(next)) + ", as the recordings differ.";
}

/// Offsets and matrix of a triad; elements that the choice of axes makes zero are no results.
std::string triad_results(const Calibration& c, Triad triad) {
  std::string rows;
  for (const CoefficientIndex index : coefficient_indices()) {
    const Coefficient& of = coefficient(index);
    if (of.triad != triad || (of.term != Term::offset && of.term != Term::matrix)) continue;
    if (c.frame == BodyFrame::accelerometers && zero_by_frame(index)) continue;
    rows += result_row(c, index);
  }
  if (triad == Triad::gyro) rows += time_base_row(c);
  return fmt::format(
      "<div><h3>{}</h3><div class=\"scroll\"><table class=\"numbers\"><thead><tr><th></th><th>value</th><th>U</th><th></th><th>k</th>"
      "</tr></thead><tbody>\n{}</tbody></table></div></div>\n",
      triad == Triad::accel ? "Accelerometers" : "Gyros", rows);
}

std::string reached_on_certificate(const RequirementResult& r) {
  if (!std::isfinite(r.reached)) return "not determined";
  const UserUnit unit = user_unit(coefficient(coefficient_index(r.coefficient)), r.limit);
  return escaped(uncertainty_text(r.reached / unit.size) + " " + readable_unit(unit.name) + (r.note.empty() ? "" : " (" + r.note + ")"));
}

}  // namespace

std::string results_part(const Certificate& certificate) {
  const Calibration& c = certificate.report.result.calibration;
  std::string tables;
  for (const Triad triad : {Triad::accel, Triad::gyro})
    if (any_of_triad(c, triad)) tables += triad_results(c, triad);
  const bool rig = c.frame == BodyFrame::rig;
  return "<h2>Results</h2>\n<p>To the item's readings V belong specific force a = A0 + A1 V and angular rate w = W0 + W1 V, with the further terms "
         "of the "
         "appendix, which has the full model. Offsets A0, W0 are added to the output (a sensor's bias is the offset with the other sign); scale "
         "corrections are A1 - 1 and W1 - 1, to first order minus the sensor's scale factor error (IEEE 528). Of readings in counts the table has "
         "what the sensor itself does: its counts at zero, and its counts per "
         "unit. Misalignments, outside the diagonal of A1 and W1, are relative to their row's scale. Axes: " +
         escaped(frame_text(c)) + (rig ? "" : ", so that its misalignments xy, xz and yz are zero by definition") + ".</p>\n<div class=\"pair\">" +
         tables +
         "</div>\n<p>U is the expanded uncertainty: the standard uncertainty multiplied by the coverage factor k, which for a t distribution with "
         "the "
         "effective degrees of freedom corresponds to a coverage probability of 95.45 % (JCGM 100). It holds at the time and under the conditions of "
         "the calibration and contains no drift, no change from one power-on to the next, and nothing outside these conditions." +
         time_base_text(c) + next_power_on_text(c) + " 1 g = 9.80665 m/s².</p>\n";
}

std::string conformity_part(const Calibration& c) {
  const std::vector<RequirementResult>& requirements = c.quality.requirements;
  const std::string heading = "<h2>Decision rule and conformity</h2>\n";
  if (requirements.empty()) return heading + "<p>No requirement was given: no statement of conformity is made.</p>\n";
  const bool doubtful = c.quality.verdict == Verdict::doubtful;
  std::string rows;
  for (const RequirementResult& r : requirements)
    rows += fmt::format("<tr><td>{}</td><td><code>{}</code></td><td>{}</td><td>{}</td></tr>\n", escaped(readable_unit(r.text)),
                        escaped(r.coefficient), reached_on_certificate(r),
                        doubtful ? "no statement"
                        : r.met  ? "<strong>met</strong>"
                                 : "<strong>not met</strong>");
  return heading +
         "<p>Requirements are on uncertainties, not tolerances of values: the larger of u and U/2 of each named coefficient, of matrices relative to "
         "the row's scale, is compared with the limit. Decision rule: simple acceptance, met if the largest is at most the limit; no guard band is "
         "taken off, since what is compared is itself an uncertainty. With fewer than 3 effective degrees of freedom no requirement is met." +
         (doubtful ? std::string(" The calibration is doubtful: no statement of conformity is made.") : "") +
         "</p>\n<table class=\"wide\"><thead><tr><th>requirement</th><th>largest, "
         "of</th><th>reached</th><th>conformity</th></tr></thead><tbody>\n" +
         rows + "</tbody></table>\n";
}

std::string traceability_part(const Certificate& certificate) {
  const Calibration& calibration = certificate.report.result.calibration;
  const std::vector<Reference>& references = calibration.references;
  std::string rows;
  for (const Origin& origin : origins_of(certificate.report)) {
    const auto r = std::ranges::find_if(references, [&](const Reference& own) { return own.quantity == origin.quantity; });
    const bool declared = r != references.end();
    const std::string unused = declared ? why_unused(origin, *r, calibration) : "";
    rows += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td></tr>\n", escaped(origin.name),
                        escaped(origin.from.substr(0, origin.from.find(": "))),  // the conditions have the value
                        declared ? fmt::format("{}{}, certificate {}", unused.empty() ? "" : "<strong>not traceable</strong>: ",
                                               escaped(shortened(r->instrument, 120)), certificate_text(*r, unused))
                                 : "<strong>not traceable</strong>: no reference is declared");
  }
  const std::string& own = certificate.laboratory.traceability;
  return "<h2>Traceability</h2>\n<p>References are as the session declares them; their certificates were not checked by the program that wrote this "
         "page.</p>\n<table class=\"wide\"><thead><tr><th>quantity</th><th>origin</th><th>reference</th></tr></thead><tbody>\n" +
         rows + "</tbody></table>\n" + (own.empty() ? "" : "<p>Statement of the laboratory: " + escaped(own) + "</p>\n");
}

std::string signature_part(const Laboratory& lab) {
  return fmt::format(
      "<p>The results relate only to the item named on this certificate, in the state in which it was measured. The certificate may be reproduced "
      "only in full, unless "
      "the laboratory has approved otherwise in writing.</p>\n"
      "<div class=\"sign\"><div>signature, date</div><div>{}<br>{}</div></div>\n",
      lab.signatory.name.empty() ? "name: <span class=\"fill short\"></span>" : escaped(shortened(lab.signatory.name, 120)),
      lab.signatory.function.empty() ? "function: <span class=\"fill short\"></span>" : escaped(shortened(lab.signatory.function, 120)));
}

}  // namespace imulab::report
