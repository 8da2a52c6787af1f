// The fields of what `compare`, `predict` and `plan` print with --json, each stated once (core/fields.hpp; docs/reference/results.md).
#pragma once

#include "imulab/coefficient.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/text/json_fields.hpp"
#include "imulab/model/calibration_fields.hpp"
#include "imulab/results/summary.hpp"

#include <array>
#include <utility>

namespace imulab {

// ---- comparisons

/// The unit of a coefficient's differences that has this name, stored for good; absent where there is none.
std::optional<std::string_view> stored_unit(CoefficientIndex index, const std::string& name);

template <class Fields>
void describe(Fields& f, CoefficientDifference& d) {
  f("a", d.a), f("b", d.b), f("difference", d.difference), f("standard_uncertainty", d.uncertainty);
  fields::derived(f, "sigmas", d.sigmas());
  f.table("user", [&](auto& user) {
    const auto set_unit = [&](const std::string& name) {
      const auto unit = stored_unit(d.index, name);
      fields::expect(user, unit.has_value(), "unit", "a unit of " + std::string(coefficient(d.index).name));
      d.user_unit = unit.value_or("");
    };
    user("difference", d.user_difference), user("standard_uncertainty", d.user_uncertainty);
    fields::via(
        user, "unit", [&] { return std::string(d.user_unit); }, set_unit);
  });
}

template <class Fields>
void describe(Fields& f, DifferenceGivenOthers& d) {
  f("coefficient", d.index), f("sigmas", d.sigmas);
}

template <class Fields>
void describe(Fields& f, Consistency& c) {
  f("chi2", c.chi2), f("degrees_of_freedom", c.degrees_of_freedom), f("p_value", c.p_value), f("differing", c.differing, fields::if_any);
}

/// A comparison and the names of its calibrations.
struct NamedComparison {
  std::string a, b;
  Comparison comparison;
};

template <class Fields>
void describe(Fields& f, NamedComparison& c) {
  f("a", c.a), f("b", c.b);
  fields::derived(f, "frame", "accelerometers");
  describe_by_name(f, "coefficients", c.comparison.coefficients);
  f("consistency", c.comparison.consistency);
  f("lever_arm_translation", c.comparison.translation, fields::optional);
}

template <class Fields>
void describe(Fields& f, ComparedCalibration& c) {
  f("name", c.name), f("imu", c.imu, fields::or_empty), f("serial", c.serial, fields::or_empty), f("method", c.method, fields::or_empty);
  fields::choice(f, "frame", c.frame, body_frames, "accelerometers or rig", fields::optional), f("date", c.date, fields::or_empty),
      f("dated", c.dated, fields::or_empty);
  f("without_uncertainties", c.bare, fields::optional), f("doubtful", c.doubtful, fields::optional);
  f("with_turn_on", c.with_turn_on, fields::if_any);
}

template <class Fields>
void describe(Fields& f, Agreement::Coefficient& c) {
  describe(f, c.consistency);
}

template <class Fields>
void describe(Fields& f, Agreement& agreement) {
  f("calibrations", agreement.calibrations);
  describe_by_name(f, "coefficients", agreement.coefficients);
  f("consistency", agreement.consistency);
  const auto names = [&] {
    std::vector<CoefficientIndex> differing;
    for (const auto& c : agreement.coefficients)
      if (c.differs) differing.push_back(c.index);
    return differing;
  };
  const auto mark = [&](const std::vector<CoefficientIndex>& differing) {
    for (auto& c : agreement.coefficients) c.differs = contains(differing, c.index);
  };
  fields::via(f, "differing", names, mark, fields::optional);
}

// ---- comparisons of other results

template <class Fields>
void describe(Fields& f, ComparedFigure& c) {
  f("unit", c.unit), f("values", c.values, fields::or_nan), f("standard_uncertainties", c.uncertainties, fields::or_nan);
  f("bounds", c.bounds, fields::or_nan);
  if constexpr (Fields::reads) return;
  const double most = c.significance();
  fields::derived(f, c.in_sigmas() ? "sigmas" : "relative_change", most < 0 ? std::optional<double>() : std::optional(most));
}

template <class Fields>
void describe(Fields& f, ComparedCurve& c) {
  f("result", c.result), f("panel", c.panel), f("x", c.x, {.digits = 6}), f("y", c.y, {.digits = 6});
  fields::check(f, c.x.size() == c.y.size(), "y", "expected as many numbers as in x");
}

template <class Fields>
void describe(Fields& f, ResultComparison& c) {
  f("kind", c.kind), f("results", c.names), f("notes", c.notes);
  fields::check(f, c.names.size() > 1, "results", "expected two names or more");
  fields::check(f, c.notes.size() == c.names.size(), "notes", "expected as many texts as in results");
  describe_by_name(f, "figures", c.figures);
  for (const ComparedFigure& figure : c.figures)
    for (const auto* list : {&figure.values, &figure.uncertainties, &figure.bounds})
      fields::check(f, list->size() == c.names.size(), "figures", figure.name + ": expected lists of as many numbers as in results");
  f("x_label", c.x_label, fields::optional), f("logarithmic", c.logarithmic, fields::optional), f("curves", c.curves, fields::optional);
  for (const ComparedCurve& curve : c.curves)
    fields::check(f, curve.result < c.names.size(), "curves", "expected each result as a place in results, from 0");
}

// ---- predictions

template <class Fields>
void describe(Fields& f, Shortfall& s) {
  f("selector", s.requirement.selector), f("limit", s.requirement.limit), f("coefficient", s.coefficient), f("sigma", s.sigma, fields::or_infinity);
  f("source", s.source, fields::optional);
  if constexpr (Fields::reads) {
    s.requirement.coefficients = {s.coefficient};
    s.requirement.unit = user_unit(coefficient(s.coefficient), s.requirement.limit);
  }
}

template <class Fields>
void describe(Fields& f, PredictedCoefficient& c) {
  f("closed_form", c.sigma), f("first_order", c.first_order, fields::if_any), f("second_order", c.second_order, fields::if_any);
  f("bias_taken_out", c.bias, fields::if_any), f("monte_carlo", c.monte_carlo, fields::if_any), f("cramer_rao", c.cramer_rao, fields::if_known);
  f("degrees_of_freedom", c.degrees_of_freedom, fields::How{fields::Presence::optional, fields::Null::infinity});
  f("of_half_effects", c.sigma_of_half, fields::if_any), f("of_twice_effects", c.sigma_of_twice, fields::if_any);
  f("budget", c.budget, fields::if_any);
}

template <class Fields>
void describe(Fields& f, Tolerance& t) {
  f("factor", t.factor);
  if (!t.factor) {
    f("not_met", t.shortfalls);
    return;
  }
  f("unlimited", t.unlimited), f("angle", t.sizes.angle), f("orthogonality", t.sizes.orthogonality), f("zero", t.sizes.zero);
  f("timing", t.sizes.timing), f("gyro_noise_density", t.sizes.gyro_noise), f("accel_noise_density", t.sizes.accel_noise);
  f("gyro_turn_on", t.sizes.gyro_turn_on), f("accel_turn_on", t.sizes.accel_turn_on);
}

template <class Fields>
void describe(Fields& f, Tolerances::Answer& answer) {
  f("others_as_declared", answer.declared), f("others_perfect", answer.alone, fields::if_any);
}

template <class Fields>
void describe(Fields& f, Advice& advice) {
  f("coefficients", advice.coefficients), f("advice", advice.turns);
}

template <class Fields>
void describe(Fields& f, AddedManoeuvres& a) {
  f("added", a.names), f("added_s", a.added), f("duration_s", a.duration), f("worst", a.worst, fields::or_infinity);
}

template <class Fields>
void describe(Fields& f, PredictionSummary& p) {
  if constexpr (Fields::reads) {
    if (f.at().has("added")) describe(f, p.added.emplace());
  } else if (p.added) {
    describe(f, *p.added);
  }
  describe_by_name(f, "coefficients", p.coefficients);
  f("undetermined", p.undetermined, fields::optional), f("considered", p.considered, fields::if_any), f("priors", p.priors, fields::if_any);
  f("notes", p.notes, fields::if_any), f("rig_errors", p.rig_errors, fields::if_any);
  f("monte_carlo_runs", p.runs, fields::if_any), f("not_met", p.missed, fields::if_any);
  if constexpr (!Fields::reads) f("tolerance", p.tolerance, fields::if_any);
  f("worst_determined", p.advice, fields::if_any);
}

// ---- plans

template <class Fields>
void describe(Fields& f, TableTurn& turn) {
  fields::choice(f, "axis", turn.axis, std::array{RigAxis::outer, RigAxis::middle, RigAxis::inner}, "outer, middle or inner");
  f("angle_deg", turn.angle_deg), f("rest_s", turn.rest);
}

template <class Fields>
void describe(Fields& f, PriorEffect& prior) {
  f("fleet", prior.fleet), f("units", prior.units), f("duration_without_s", prior.duration_without, fields::or_nan);
}

template <class Fields>
void describe(Fields& f, PlanSummary& plan) {
  if constexpr (Fields::reads) {
    if (f.at().has("requirements"))
      f.at()["requirements"].list([&](const auto& item) {
        try {
          for (Requirement& r : parse_requirements(item.text())) plan.requirements.push_back(std::move(r));
        } catch (const Error& e) {
          item.fail(e.what());
        }
        return 0;
      });
  } else {
    std::vector<std::string> texts;
    for (const Requirement& r : plan.requirements) texts.push_back(to_string(r));
    f("requirements", texts);
  }
  f("margin", plan.margin, fields::optional), f("duration_s", plan.path.duration), f("first_rest_s", plan.path.first_rest),
      f("turns", plan.path.turns), f("prior", plan.prior, fields::if_any);
  describe(f, plan.prediction);
}

}  // namespace imulab
