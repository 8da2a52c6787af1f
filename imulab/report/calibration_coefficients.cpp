// Values with their uncertainties, as a certificate states them; correlations; tests of terms.
#include "imulab/calibration.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/model/relative_uncertainty.hpp"
#include "imulab/report/calibration_parts.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/pictures.hpp"
#include "imulab/results/calibration.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <vector>

namespace imulab::report {

namespace {

/// Coefficients of one kind and unit, in table order.
struct Group {
  std::string name, unit;
  std::vector<CoefficientIndex> members;
};

std::string kind_of(const Coefficient& c, BodyFrame frame) {
  std::string triad = c.triad == Triad::accel ? "accelerometer" : "gyro";
  switch (c.term) {
    case Term::offset:
      return triad + " offset";
    case Term::matrix:
      return triad + (c.row == c.column                                               ? " scale"
                      : c.triad == Triad::accel && frame == BodyFrame::accelerometers ? " nonorthogonality"
                                                                                      : " misalignment");
    case Term::quadratic:
      return triad + " quadratic term";
    case Term::cubic:
      return triad + " cubic term";
    case Term::thermal:
      return triad + (c.column == 1 ? " thermal term" : c.column == 2 ? " quadratic thermal term" : " cubic thermal term");
    case Term::matrix_thermal1:
    case Term::matrix_thermal2:
      return triad + (c.row == c.column ? " scale" : " misalignment") +
             (c.term == Term::matrix_thermal1 ? " over temperature" : " over temperature squared");
    case Term::g_sensitivity:
      return "gyro g-sensitivity";
    case Term::lever_arm:
      return "accelerometer lever arm";
  }
  return triad;
}

std::string element_of(CoefficientIndex index) {
  const std::string_view name = coefficient(index).name;
  return std::string(name.substr(name.rfind('.') + 1));
}

std::vector<Group> groups_of(const Calibration& calibration) {
  std::vector<Group> groups;
  for (const CoefficientIndex index : calibration.estimated) {
    if (!is_result(calibration, index)) continue;
    const std::string kind = kind_of(coefficient(index), calibration.frame), unit = user_value(calibration, index).unit;
    auto at = std::find_if(groups.begin(), groups.end(), [&](const Group& g) { return g.name == kind && g.unit == unit; });
    if (at == groups.end()) at = groups.insert(groups.end(), {kind, unit, {}});
    at->members.push_back(index);
  }
  return groups;
}

std::string intervals_of(const Calibration& calibration, const Group& group) {
  std::vector<Interval> rows;
  for (const CoefficientIndex index : group.members) {
    const UserValue v = user_value(calibration, index);
    const double expanded = expanded_uncertainty(calibration, index).coverage_factor * v.uncertainty;
    rows.push_back({element_of(index), v.value, expanded, rounded_to(v.value, expanded) + " ± " + uncertainty_text(expanded)});
  }
  const std::string seconds = group.name == "gyro scale" && calibration.clock ? "; seconds: " + clock_text(calibration.clock) : "";
  return figure(interval_rows(rows, readable_unit(group.unit), group.name), group.name + seconds);
}

std::vector<std::string> coefficient_cells(const Calibration& calibration, CoefficientIndex index) {
  const UserValue user = user_value(calibration, index);
  const ExpandedUncertainty u = expanded_uncertainty(calibration, index);
  const double value = coefficient_value(calibration.model, index), expanded = u.coverage_factor * user.uncertainty;
  const bool measured = is_result(calibration, index);
  return {"<code>" + escaped(coefficient(index).name) + "</code>",
          rounded_to(user.value, expanded),
          measured ? uncertainty_text(expanded) : "",
          escaped(readable_unit(user.unit)),
          uncertainty_text(user.uncertainty),
          !measured                    ? "prior"
          : u.degrees_of_freedom > 1e4 ? "&gt; 10⁴"
                                       : fmt::format("{:.0f}", u.degrees_of_freedom),
          measured ? fmt::format("{:.2f}", u.coverage_factor) : "",
          number_text(value, 8),
          number_text(u.standard, 2),
          escaped(readable_unit(coefficient(index).unit))};
}

/// Coefficients that were not estimated and are not those of an ideal IMU.
std::string other_values(const Calibration& calibration) {
  const SensorModel ideal;
  Table t{.head = {"coefficient", "value", "", "value (SI)", ""}, .rows = {}, .left = {2, 4}};
  for (const CoefficientIndex index : coefficient_indices()) {
    const double value = coefficient_value(calibration.model, index);
    if (contains(calibration.estimated, index) || value == coefficient_value(ideal, index)) continue;
    const UserValue user = user_value(calibration, index);
    t.rows.push_back({"<code>" + escaped(coefficient(index).name) + "</code>", number_text(user.value, 6), escaped(readable_unit(user.unit)),
                      number_text(value, 8), escaped(readable_unit(coefficient(index).unit))});
  }
  return t.rows.empty() ? "" : "<h3>Values without uncertainties</h3>\n" + table(t);
}

std::vector<std::string> names_of_estimated(const Calibration& calibration) {
  std::vector<std::string> names;
  for (const CoefficientIndex index : calibration.estimated) names.emplace_back(coefficient(index).name);
  return names;
}

Eigen::MatrixXd correlation_of(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  Eigen::MatrixXd out = covariance;
  for (Eigen::Index i = 0; i < out.rows(); ++i)
    for (Eigen::Index j = 0; j < out.cols(); ++j) out(i, j) = sigma[i] > 0 && sigma[j] > 0 ? covariance(i, j) / (sigma[i] * sigma[j]) : 0;
  return out;
}

std::string strongest_pairs(const std::vector<std::string>& names, const Eigen::MatrixXd& correlation) {
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < names.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) pairs.emplace_back(-std::abs(correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j))), j, i);
  std::sort(pairs.begin(), pairs.end());
  std::string text;
  for (std::size_t k = 0; k < std::min<std::size_t>(3, pairs.size()); ++k) {
    const auto& [size, i, j] = pairs[k];
    const double r = correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    text += fmt::format("{}{} and {} ({})", text.empty() ? "" : ", ", names[i], names[j], number_text(r, 2));
  }
  return text;
}

}  // namespace

std::string coefficients_section(const Calibration& calibration) {
  const std::string others = other_values(calibration);
  if (calibration.estimated.empty()) return others.empty() ? "" : section("coefficients", "Coefficients", "", others);
  Table t{.head = {"coefficient", "value", "U", "", "u", "ν<sub>eff</sub>", "k", "value (SI)", "u (SI)", ""}, .rows = {}, .left = {3, 9}};
  Table priors = t;
  for (const CoefficientIndex index : calibration.estimated)
    if (!is_result(calibration, index)) priors.rows.push_back(coefficient_cells(calibration, index));
  std::vector<std::string> figures;
  for (const Group& group : groups_of(calibration)) {
    figures.push_back(intervals_of(calibration, group));
    for (const CoefficientIndex index : group.members) t.rows.push_back(coefficient_cells(calibration, index));
  }
  return section(
      "coefficients", "Coefficients",
      "Bars show ± U, the expanded uncertainty: 95 % of such intervals contain the true value. Misalignments are relative to their row's scale; "
      "scales are differences from one, or the scale itself where the readings are counts.",
      beside(figures) +
          paragraph(
              "u: standard uncertainty; ν: effective degrees of freedom; k: coverage factor of a t distribution for 95.45 %; U = k u. JCGM 100.") +
          table(t) + (priors.rows.empty() ? "" : folded("Not determined by the data: priors", table(priors))) + others);
}

std::string uncertainty_section(const Calibration& calibration) {
  if (calibration.estimated.empty()) return {};
  Table t{.head = {"coefficient", "u", "from the fit", "from declared g", ""}, .rows = {}, .left = {4}};
  for (const CoefficientIndex index : calibration.estimated) {
    const ExpandedUncertainty u = expanded_uncertainty(calibration, index);
    if (u.declared == 0 || u.standard == 0) continue;
    const UserValue user = user_value(calibration, index);
    const double unit = user.uncertainty / u.standard;
    t.rows.push_back({"<code>" + escaped(coefficient(index).name) + "</code>", uncertainty_text(user.uncertainty),
                      uncertainty_text(u.from_fit * unit), uncertainty_text(u.declared * unit), escaped(readable_unit(user.unit))});
  }
  Table rigs{.head = {"rig or aid", "declared sigma", "found", "u"}, .rows = {}};
  for (const RigErrorEstimate& e : calibration.quality.rig_errors)
    rigs.rows.push_back({escaped(e.name), number_text(e.declared_sigma), rounded_to(e.value, e.uncertainty), uncertainty_text(e.uncertainty)});
  std::vector<std::string> said;
  for (const UncertaintySource& source : calibration.quality.sources) said.push_back(source.consequence);
  const bool rig = calibration.frame == BodyFrame::rig;
  std::string lead = "Type A comes from the residuals and the noise of the data, type B from declarations. ";
  lead += t.rows.empty() ? "No declared part is known apart from the rest. "
                         : "The uncertainty of g is the same part of all three accelerometer scales. ";
  lead += rig ? "The rig's declared errors and the priors of terms act through the fit, so they are inside its part; imulab predict shows them one "
                "by one."
              : "Priors of terms that the data do not show act through the fit, so they are inside its part.";
  return section(
      "uncertainty", "Type A and type B", lead,
      (t.rows.empty() ? "" : table(t)) + list(said) + (rigs.rows.empty() ? "" : "<h3>Rig and aids, estimated jointly [SI]</h3>\n" + table(rigs)));
}

std::string strongest_correlations(const Calibration& calibration) {
  return strongest_pairs(names_of_estimated(calibration), correlation_of(calibration.covariance));
}

std::string correlation_section(const Calibration& calibration) {
  if (calibration.estimated.size() < 2) return {};
  const std::vector<std::string> names = names_of_estimated(calibration);
  const Eigen::MatrixXd correlation = correlation_of(calibration.covariance);
  return section("correlation", "Correlations", "",
                 figure(correlation_map(names, correlation, "correlations of the coefficients"),
                        "Correlation of the coefficients' errors. Strongest: " + strongest_pairs(names, correlation) +
                            ". The covariance is in the calibration file.",
                        true));
}

std::string effects_section(const Calibration& calibration) {
  const Quality& quality = calibration.quality;
  if (quality.effects.empty()) return {};
  Table t{.head = {"effect", "result", "clearest axis", "u", "unit"}, .rows = {}, .text_columns = true};
  for (const EffectEstimate& effect : quality.effects) {
    const std::size_t k = clearest_axis(effect);
    t.rows.push_back({"<code>" + escaped(effect.name) + "</code>", effect.significant ? "significant" : "not significant, its prior is included",
                      rounded_to(effect.values[k], effect.sigma[k]), uncertainty_text(effect.sigma[k]), escaped(effect.unit)});
  }
  std::string opinion;
  if (quality.second_opinion)
    opinion = paragraph(
        fmt::format("Second opinion, by the method {} on the same data: at most {:.1f} standard deviations of the difference apart ({}).",
                    escaped(quality.second_opinion->method), std::abs(quality.second_opinion->sigmas), escaped(quality.second_opinion->coefficient)));
  return section("effects", "Effects besides the model",
                 "What the IMU and its mount do besides the sensor model, estimated with the coefficients and included in their uncertainties.",
                 table(t) + opinion);
}

std::string tests_section(const Calibration& calibration) {
  Table t{.head = {"term", "result", "chi-square", "p"}, .rows = {}, .text_columns = true};
  for (const TermTest& test : calibration.quality.term_tests) {
    const bool tested = test.degrees_of_freedom > 0;
    t.rows.push_back({"<code>" + escaped(test.term) + "</code>",
                      !tested     ? "not observable"
                      : test.kept ? "significant, estimated"
                                  : "not significant, its prior is included",
                      tested ? fmt::format("{} / {}", number_text(test.statistic), test.degrees_of_freedom) : "",
                      tested ? number_text(test.p_value, 2) : ""});
  }
  const auto& considered = calibration.quality.considered;
  std::string names;
  for (const std::string& name : considered) names += (names.empty() ? "" : ", ") + name;
  const std::string open =
      considered.empty() ? "" : paragraph("Hardly shown by the data; the uncertainty of their priors enters the others: " + names + ".");
  if (t.rows.empty() && open.empty()) return {};
  return section("tests", "Terms beyond biases and matrices", "", (t.rows.empty() ? "" : table(t)) + open);
}

}  // namespace imulab::report
