// The appendix of a certificate: all coefficients, the model, the fit, and the files.
#include "imulab/calibration.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/model/relative_uncertainty.hpp"
#include "imulab/recording/origin.hpp"
#include "imulab/report/calibration_facts.hpp"
#include "imulab/report/calibration_parts.hpp"
#include "imulab/report/certificate_parts.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/start.hpp"
#include "imulab/results/calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace imulab::report {

namespace {

std::string all_coefficients(const Calibration& c) {
  std::string rows;
  for (const CoefficientIndex index : c.estimated) {
    if (!is_result(c, index)) continue;
    const UserValue user = user_value(c, index);
    const ExpandedUncertainty u = expanded_uncertainty(c, index);
    const double expanded = u.coverage_factor * user.uncertainty;
    rows += fmt::format(
        "<tr><th><code>{}</code></th><td>{}</td><td>{}</td><td class=\"left\">{}</td><td>{:.2f}</td><td>{}</td><td>{}</td><td>{}</td><td "
        "class=\"left\">{}</td></tr>\n",
        escaped(coefficient(index).name), rounded_to(user.value, expanded), uncertainty_text(expanded), escaped(readable_unit(user.unit)),
        u.coverage_factor, u.degrees_of_freedom > 1e4 ? "&gt; 10⁴" : fmt::format("{:.0f}", u.degrees_of_freedom),
        number_text(coefficient_value(c.model, index), 8), number_text(u.standard, 2), escaped(readable_unit(coefficient(index).unit)));
  }
  return "<h2>Appendix: all measured coefficients</h2>\n<div class=\"scroll\"><table "
         "class=\"numbers\"><thead><tr><th></th><th>value</th><th>U</th><th></th>"
         "<th>k</th><th>ν<sub>eff</sub></th><th>value (SI)</th><th>u (SI)</th><th></th></tr></thead><tbody>\n" +
         rows + "</tbody></table></div>\n";
}

std::string fit_part(const Calibration& c) {
  const Quality& q = c.quality;
  Statements s;
  s.add("verdict", q.verdict == Verdict::none ? "none on record" : verdict_text(q));
  if (q.degrees_of_freedom > 0)
    s.add("residuals", fmt::format("chi-square {} per degree of freedom, {} degrees of freedom; 1 is expected", number_text(q.chi2_per_dof),
                                   q.degrees_of_freedom));
  if (q.condition > 0) s.add("condition of the scaled normal equations", number_text(q.condition));
  std::string open, held;
  for (const std::string& name : q.unobservable) open += (open.empty() ? "" : ", ") + name;
  for (const std::string& name : q.considered) held += (held.empty() ? "" : ", ") + name;
  s.add_known("not determined by the data", open);
  s.add_known("held at a prior, whose uncertainty is contained in U", held);
  if (c.estimated.size() > 1)
    s.add("correlations",
          "errors of coefficients are correlated, strongest " + strongest_correlations(c) + "; the covariance of all is in the calibration file");
  s.add_known("clock", clock_text(c.clock));
  s.add_known("evaluated with", c.software);
  std::vector<std::string> assumed;
  for (const Finding& finding : q.findings)
    if (is_assumption(finding)) assumed.push_back(finding.text);
  return "<h2>Fit</h2>\n" + s.html() + list(q.findings.warnings()) +
         (assumed.empty() ? "" : "<h3>Assumed, and not confirmed by the data</h3>\n" + list(assumed));
}

std::string files_part(const Certificate& certificate) {
  const Calibration& c = certificate.report.result.calibration;
  std::string rows;
  const auto add = [&rows](const std::string& what, const std::string& file, const std::string& hash) {
    rows += fmt::format("<tr><td>{}</td><td>{}</td><td class=\"hash\">{}</td></tr>\n", what, escaped(shortened(file, 120)), escaped(hash));
  };
  add("calibration", certificate.file, certificate.sha256);
  if (!c.session_file.empty() && (c.sources.empty() || c.session_file != c.sources.front().file)) add("session", c.session_file, c.session_sha256);
  for (const SourceFile& source : c.sources) add("recording", source.file, source.sha256);
  std::string options;
  for (const auto& [name, value] : c.options) options += fmt::format("{}{} = {}", options.empty() ? "" : ", ", name, value);
  return "<h2>Files</h2>\n<table><thead><tr><th></th><th>file</th><th>SHA-256</th></tr></thead><tbody>\n" + rows + "</tbody></table>\n" +
         (options.empty() ? "" : "<p>Options of the calibration: " + escaped(shortened(options, 400)) + ".</p>\n") + list(certificate.report.missing);
}

}  // namespace

std::string appendix_part(const Certificate& certificate) {
  const Calibration& c = certificate.report.result.calibration;
  return all_coefficients(c) + "<h2>Model</h2>\n" + model_equation(c) + fit_part(c) +
         not_covered_section(certificate.report, certificate.laboratory.conditions.temperature) + files_part(certificate) +
         "<p class=\"small\">Written by " + escaped(software()) +
         " from the files above and from what the session and the laboratory's file declare, which was not checked. It is no statement that the "
         "laboratory or this certificate conforms to ISO/IEC 17025.</p>\n<p><strong>End of the certificate" +
         (certificate.number.empty() ? std::string() : " " + escaped(shortened(certificate.number, 60))) + "</strong></p>\n";
}

}  // namespace imulab::report
