// calibrate, compare, extrinsics, predict, plan, noise, simulate.
#include "imulab/tasks/compare.hpp"
#include "imulab/tasks/extrinsics.hpp"
#include "imulab/tasks/noise.hpp"
#include "imulab/tasks/plan.hpp"
#include "imulab/tasks/predict.hpp"
#include "imulab/tasks/simulate.hpp"
#include "imulab/tasks/usable.hpp"

#include "python/module.hpp"
#include <pybind11/stl.h>
#include <utility>
#include <variant>

namespace imulab::python {
namespace {

using Recordings = std::vector<std::shared_ptr<Recording>>;

/// The recordings given, or those of files where `given` is none.
SessionRecordings recordings_of(const Session& session, const std::optional<Recordings>& given, const std::string& chosen, bool several_imus) {
  if (!given) return read_recordings(session, chosen, several_imus);
  std::vector<Recording> copies;
  for (const auto& recording : *given) copies.push_back(*recording);
  return given_recordings(session, std::move(copies));
}

std::pair<std::shared_ptr<CalibrationObject>, std::vector<std::string>> calibrated(std::shared_ptr<Session> session, std::optional<Recordings> given,
                                                                                   const py::dict& keywords, const py::object& progress) {
  return run(progress, [=, o = options_from<CalibrateOptions>(keywords)](const std::function<void(double)>& report) {
    CalibrationTask task = task_of(o);
    task.curves = true;
    task.progress = report;
    const auto data = std::make_shared<const SessionRecordings>(recordings_of(*session, given, o.recording, task.reference.has_value()));
    const auto answer = calibration_answer(calibrated_imu(data, o, task, !given));
    return std::pair(std::make_shared<CalibrationObject>(CalibrationObject{answer.data, data}), answer.data->calibration.quality.findings.warnings());
  });
}

using Calibrated = std::shared_ptr<CalibrationObject>;

/// Calibrations with their names, which keep their recordings, after the motion that they have in common.
std::vector<Calibrated> calibrated_jointly(const std::vector<std::pair<std::string, Calibrated>>& given, const py::object& progress) {
  std::vector<CalibratedImu> imus;
  for (const auto& [name, each] : given) {
    if (!each->data) throw Error(name + ": has no recordings; expected a calibration from calibrate(), not from a file");
    imus.push_back({each->data, *each->result});
  }
  run(progress, [&](const std::function<void(double)>& report) {
    std::vector<std::pair<std::string, CalibratedImu*>> named;
    for (std::size_t k = 0; k < imus.size(); ++k) named.emplace_back(given[k].first, &imus[k]);
    return estimate_jointly(named, report);
  });
  std::vector<Calibrated> out;
  for (CalibratedImu& imu : imus)
    out.push_back(std::make_shared<CalibrationObject>(CalibrationObject{std::make_shared<const CalibrationResult>(std::move(imu.result)), imu.data}));
  return out;
}

/// `imus`: names, recordings, and calibrations or none.
Outcome extrinsics(const std::vector<std::tuple<std::string, std::shared_ptr<Recording>, Calibrated>>& imus, const py::dict& keywords,
                   const py::object& progress) {
  const auto o = options_from<ExtrinsicsOptions>(keywords);
  std::vector<BodyImu> body;
  for (const auto& [name, recording, calibration] : imus) {
    body.push_back({.name = name, .recording = *recording, .grade = o.grade.value_or("mems")});
    if (calibration) body.back().calibration = calibration->calibration();
  }
  return {run(progress, [=](const std::function<void(double)>& report) { return extrinsics_answer(body, report); })};
}

Outcome compared(const std::vector<std::pair<std::string, std::shared_ptr<CalibrationObject>>>& given, const py::dict& keywords) {
  std::vector<NamedCalibration> inputs;
  for (const auto& [name, object] : given) inputs.push_back({name, object->calibration()});
  const auto o = options_from<CompareOptions>(keywords);
  return {comparison_answer(std::move(inputs), o.different_imus, o.tolerance)};
}

/// `procedure`: a session, or its file, or that of a mission. `parts`: those of the Monte Carlo, where it was done before.
Outcome predicted(std::variant<std::shared_ptr<Session>, std::string> procedure, const py::dict& keywords, const py::object& progress,
                  const std::vector<std::string>& parts) {
  auto o = options_from<PredictOptions>(keywords);
  o.shared.sources = parts_in_memory(parts);
  return {run(progress, [=](const std::function<void(double)>& report) {
    PredictionOptions task = task_of(o);
    const auto* file = std::get_if<std::string>(&procedure);
    const ReadProcedure read = file ? read_procedure(*file, o.method) : ReadProcedure{*std::get<std::shared_ptr<Session>>(procedure)};
    task.progress = report, task.motion = read.motion;
    auto answer = prediction_answer(o.method, read.session, read.session.file, std::move(task), read_prior(o.prior));
    answer.warnings.insert(answer.warnings.begin(), read.warnings.begin(), read.warnings.end());
    return answer;
  })};
}

py::bytes part_of_prediction(std::shared_ptr<Session> procedure, const py::dict& keywords, const std::string& part) {
  auto o = options_from<PredictOptions>(keywords);
  o.shared.part = part;
  return part_of([=] { prediction_answer(o.method, *procedure, procedure->file, task_of(o), read_prior(o.prior)); });
}

std::pair<Outcome, std::shared_ptr<Session>> planned(const py::dict& keywords, bool by_hand, const py::object& progress) {
  auto answer = run(progress, [o = options_from<PlanOptions>(keywords), by_hand](const std::function<void(double)>& report) {
    PlanTask task = task_of(o);
    task.by_hand |= by_hand;
    task.progress = report;
    return plan_answer(task);
  });
  return {{answer}, std::make_shared<Session>(answer.data->procedure)};
}

/// The file of a result, or a recording, or a calibration with its name.
using Moving = std::variant<std::string, std::shared_ptr<Recording>, std::pair<std::shared_ptr<CalibrationObject>, std::string>>;

MovingInput moving_of(const Moving& given) {
  if (const auto* const file = std::get_if<std::string>(&given)) return moving_input(*file);
  if (const auto* const c = std::get_if<2>(&given)) return MovingCalibration{c->second, std::make_shared<const Calibration>(c->first->calibration())};
  return std::shared_ptr<const Recording>(std::get<1>(given));
}

Outcome noise(std::shared_ptr<Session> session, std::shared_ptr<Recording> recording, const py::dict& keywords, const std::vector<Moving>& moving) {
  auto options = options_from<NoiseVerbOptions>(keywords);
  for (const Moving& given : moving) options.moving_inputs.push_back(moving_of(given));
  return {run(py::none(), [=, o = std::move(options)](const auto&) {
    return recording == nullptr ? data_sheet_answer(o) : noise_answer(*recording, *session, o);
  })};
}

Array deviation_of(const Array& rate, double interval_s, const std::string& kind, const std::optional<std::vector<std::size_t>>& factors) {
  const std::vector<double> column = column_of(rate);
  std::vector<DeviationPoint> points;
  {
    const py::gil_scoped_release unlocked;
    points = deviation(column, interval_s, factors ? *factors : averaging_factors(column.size()), deviation_named(kind));
  }
  return table_of(points.size(), [&](std::size_t i) {
    const DeviationPoint& p = points[i];
    return std::array{p.tau, p.deviation, p.edf, p.lower_68, p.upper_68, p.lower_95, p.upper_95};
  });
}

py::tuple simulated(std::shared_ptr<Session> procedure, const py::dict& keywords, const std::shared_ptr<CalibrationObject>& unit,
                    const std::string& folder) {
  const auto o = options_from<SimulateOptions>(keywords);
  const SimulationTask task{.seed = o.seed, .unit = unit ? std::optional(unit->calibration()) : std::nullopt, .grade = o.grade};
  const auto answer = run(py::none(), [=](const auto&) { return simulation_answer(*procedure, task, folder); });
  Recordings recordings;
  for (const Recording& recording : answer.data->recordings) recordings.push_back(std::make_shared<Recording>(recording));
  const auto truth =
      std::make_shared<CalibrationObject>(CalibrationObject{std::make_shared<CalibrationResult>(CalibrationResult{answer.data->truth}), {}});
  return py::make_tuple(std::make_shared<Session>(answer.data->session), std::move(recordings), truth);
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
  module.def("calibrate_jointly", &calibrated_jointly);
  module.def("compare", &compared);
  module.def("extrinsics", &extrinsics);
  module.def("predict", &predicted);
  module.def("part_of_prediction", &part_of_prediction);
  module.def("plan", &planned);
  module.def("noise", &noise);
  module.def("deviation", &deviation_of);
  module.def("simulate", &simulated);
}

}  // namespace imulab::python
