// calibrate, compare, predict, plan, noise, simulate.
#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/fleet/store/sample.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/noise/noise_analysis.hpp"
#include "imulab/report/comparison_page.hpp"
#include "imulab/report/noise_page.hpp"
#include "imulab/results/noise.hpp"
#include "imulab/tasks/compare.hpp"
#include "imulab/tasks/predict.hpp"
#include "imulab/tasks/recordings.hpp"
#include "imulab/tasks/simulate.hpp"

#include "python/bindings.hpp"
#include "python/work.hpp"
#include <algorithm>
#include <pybind11/stl.h>
#include <utility>

namespace imulab::python {
namespace {

using Recordings = std::vector<std::shared_ptr<Recording>>;

/// Of files where `given` is none.
SessionRecordings recordings_of(const Session& session, const std::optional<Recordings>& given, const Method& method, const std::string& chosen) {
  if (!given) return read_recordings(session, method, chosen);
  std::vector<Recording> copies;
  for (const auto& recording : *given) copies.push_back(*recording);
  return given_recordings(session, std::move(copies));
}

FleetPrior prior_at(const std::string& file) {
  FleetStore store(file);
  return fleet_prior(store);
}

std::pair<std::shared_ptr<CalibrationObject>, std::vector<std::string>> calibrated(std::shared_ptr<Session> session, std::optional<Recordings> given,
                                                                                   const std::string& method_name, const std::string& terms,
                                                                                   const std::string& require, const std::string& chosen,
                                                                                   bool stepwise, const std::string& prior,
                                                                                   const py::object& progress) {
  const Method& chosen_method = method(method_name);
  CalibrationTask task{.method = method_name, .terms = terms, .stepwise = stepwise, .curves = true};
  if (!require.empty()) task.requirements = parse_requirements(require);
  auto work = [=](const std::function<void(double)>& report) mutable {
    task.progress = report;
    if (!prior.empty()) task.prior = prior_at(prior);
    const auto data = std::make_shared<SessionRecordings>(recordings_of(*session, given, chosen_method, chosen));
    auto result = std::make_shared<CalibrationResult>(calibrate(*data, task));
    if (!given) add_provenance(result->calibration, data->session, data->recordings);
    result->calibration.options = {{"terms", terms}};
    if (!chosen.empty()) result->calibration.options["recording"] = chosen;
    if (stepwise) result->calibration.options["stepwise"] = "true";
    if (!prior.empty()) result->calibration.options["prior"] = prior;
    std::vector<std::string> warnings = data->warnings;
    const std::vector<std::string>& own = result->calibration.quality.warnings;
    warnings.insert(warnings.end(), own.begin(), own.end());
    result->calibration.quality.warnings = warnings;
    return std::pair(std::make_shared<CalibrationObject>(CalibrationObject{std::move(result), data}), std::move(warnings));
  };
  return run(progress, std::move(work));
}

Outcome compared(const std::vector<std::pair<std::string, std::shared_ptr<CalibrationObject>>>& given, bool different_imus) {
  std::vector<NamedCalibration> inputs;
  for (const auto& [name, object] : given) inputs.push_back({name, object->calibration()});
  const auto found = std::make_shared<ComparedCalibrations>(compare_calibrations(inputs, different_imus));
  const ComparisonSummary& s = found->summary;
  return {.json = comparison_json(inputs, s.comparisons, s.agreement),
          .text = comparison_table(inputs, s.comparisons, s.agreement),
          .warnings = found->warnings,
          .page = [found] { return comparison_page(found->summary); }};
}

Outcome predicted(std::shared_ptr<Session> procedure, const std::string& method, const std::string& terms, const std::string& require,
                  std::uint64_t runs, std::uint64_t seed, bool classical, const py::object& progress) {
  PredictionOptions asked{.terms = parse_terms(terms), .runs = runs, .seed = seed, .classical = classical};
  if (!require.empty()) asked.requirements = parse_requirements(require);
  return run(progress, [=](const std::function<void(double)>& report) mutable {
    asked.progress = report;
    const auto p = std::make_shared<Prediction>(imulab::predicted(method, *procedure, asked));
    return Outcome{.json = prediction_json(summary_of(*p)),
                   .text = prediction_text(*p, asked.requirements),
                   .shortcomings = shortcomings(*p),
                   .warnings = p->warnings,
                   .page = [p, name = procedure->file, required = !asked.requirements.empty()] { return prediction_page(*p, name, required); }};
  });
}

std::pair<Outcome, std::shared_ptr<Session>> planned(const std::string& require, const std::string& grade, double latitude_deg,
                                                     std::optional<double> gravity, const std::vector<std::string>& axes, bool by_hand,
                                                     std::optional<double> time, std::optional<double> rest, const std::string& prior,
                                                     const py::object& progress) {
  PlanTask task{.requirements = parse_requirements(require),
                .grade = grade,
                .latitude = latitude_deg * unit::deg,
                .gravity = gravity,
                .by_hand = by_hand,
                .time = time,
                .rest = rest};
  if (!axes.empty()) task.axes.clear();
  for (const RigAxis axis : {RigAxis::outer, RigAxis::middle, RigAxis::inner})
    if (std::find(axes.begin(), axes.end(), to_string(axis)) != axes.end()) task.axes.push_back(axis);
  if (task.axes.empty()) throw Error("axes: expected some of outer, middle, inner");
  return run(progress, [=](const std::function<void(double)>& report) mutable {
    if (!prior.empty()) task.prior = prior_at(prior);
    task.progress = report;
    const auto p = std::make_shared<PlannedProcedure>(plan(task));
    return std::pair(Outcome{.json = plan_json(*p), .text = plan_text(*p), .shortcomings = shortcomings(*p), .page = [p] { return plan_page(*p); }},
                     std::make_shared<Session>(p->procedure));
  });
}

DeviationKind kind_of(const std::string& name) {
  if (const auto kind = deviation_kind(name)) return *kind;
  throw Error("deviation: " + name + "; expected overlapping-allan, allan, modified-allan, hadamard, overlapping-hadamard or total");
}

Outcome noise(std::shared_ptr<Session> session, std::shared_ptr<Recording> recording, const std::string& deviation, bool remove_temperature) {
  const NoiseOptions options{kind_of(deviation), remove_temperature};
  return run(py::none(), [=](const auto&) {
    const auto still = std::make_shared<StillPart>(still_part(*recording, *session));
    const auto analysis = std::make_shared<NoiseAnalysis>(analyze_noise(still->recording, *still, options));
    Outcome out{.json = noise_json(*analysis), .text = noise_text(*analysis), .warnings = analysis->warnings, .page = [still, analysis] {
                  return noise_page(*analysis, still->recording, still->range);
                }};
    for (const NoiseAxis& axis : analysis->axes)
      if (!axis.fit) out.shortcomings += (out.shortcomings.empty() ? "no noise to be seen on " : ", ") + axis.name;
    return out;
  });
}

Array deviation_of(const Array& rate, double interval_s, const std::string& kind, const std::optional<std::vector<std::size_t>>& factors) {
  const std::vector<double> column = column_of(rate);
  std::vector<DeviationPoint> points;
  {
    const py::gil_scoped_release unlocked;
    points = deviation(column, interval_s, factors ? *factors : averaging_factors(column.size()), kind_of(kind));
  }
  Array rows({static_cast<py::ssize_t>(points.size()), py::ssize_t{7}});
  auto values = rows.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    const DeviationPoint& p = points[static_cast<std::size_t>(i)];
    const double row[] = {p.tau, p.deviation, p.edf, p.lower_68, p.upper_68, p.lower_95, p.upper_95};
    for (py::ssize_t k = 0; k < 7; ++k) values(i, k) = row[k];
  }
  return rows;
}

py::tuple simulated(std::shared_ptr<Session> procedure, std::uint64_t seed, const std::shared_ptr<CalibrationObject>& unit,
                    const std::optional<std::string>& grade, const std::string& folder) {
  SimulationTask task{.seed = seed, .unit = unit ? std::optional(unit->calibration()) : std::nullopt, .grade = grade};
  Simulation out = run(py::none(), [=](const auto&) {
    Simulation s = simulate_session(*procedure, task);
    if (!folder.empty()) write_simulated(folder, s);
    return s;
  });
  Recordings recordings;
  for (Recording& recording : out.recordings) recordings.push_back(std::make_shared<Recording>(std::move(recording)));
  const auto truth =
      std::make_shared<CalibrationObject>(CalibrationObject{std::make_shared<CalibrationResult>(CalibrationResult{std::move(out.truth)}), {}});
  return py::make_tuple(std::make_shared<Session>(std::move(out.session)), std::move(recordings), truth);
}

}  // namespace

void bind_estimates(py::module_& module) {
  module.def("methods", [] {
    std::vector<std::pair<std::string_view, std::string_view>> names;
    for (const Method& m : methods()) names.emplace_back(m.name, m.summary);
    return names;
  });
  module.def("choose_recording", [](const Session& session, const std::string& name) { return choose_recording(session, name).file; });
  module.def("calibrate", &calibrated);
  module.def("compare", &compared);
  module.def("predict", &predicted);
  module.def("plan", &planned);
  module.def("noise", &noise);
  module.def("deviation", &deviation_of);
  module.def("simulate", &simulated);
}

}  // namespace imulab::python
