// trajectory, navigate, budget.
#include "imulab/core/rotation.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/navigate.hpp"
#include "imulab/tasks/aided.hpp"
#include "imulab/tasks/budget.hpp"
#include "imulab/tasks/navigate.hpp"
#include "imulab/tasks/trajectory.hpp"
#include "imulab/tasks/usable.hpp"
#include "imulab/units.hpp"

#include "python/module.hpp"
#include <pybind11/stl.h>
#include <utility>

namespace imulab::python {
namespace {

/// Each row: t [s], latitude, longitude [deg], height [m], velocity east, north, up [m/s], roll, pitch, heading [deg].
Array rows_of(const Solution& solution) {
  return table_of(solution.size(), [&](std::size_t i) {
    const NavigationState& s = solution.states[i];
    const EulerAngles a = euler_angles(s.q_nb.toRotationMatrix());
    return std::array{solution.time[i],   s.latitude / unit::deg, s.longitude / unit::deg, s.height, s.velocity.x(), s.velocity.y(), s.velocity.z(),
                      a.roll / unit::deg, a.pitch / unit::deg,    a.heading / unit::deg};
  });
}

std::array<double, 10> row_of(double time, const Eigen::Vector3d& position, const Eigen::Vector3d& velocity, const Eigen::Vector3d& attitude) {
  return {time, position[0], position[1], position[2], velocity[0], velocity[1], velocity[2], attitude[0], attitude[1], attitude[2]};
}

/// Each row: t [s], position east, north, up [m], velocity [m/s], attitude [rad].
Array rows_of(const NavigationErrors& errors) {
  return table_of(errors.history.size(), [&](std::size_t i) {
    const NavigationError& e = errors.history[i];
    return row_of(e.time, e.position, e.velocity, e.attitude);
  });
}

/// Each row: t [s], then one sigma of the position east, north, up [m], of the velocity [m/s], of phi about east, north, up [rad].
Array sigma_rows_of(const AidedNavigation& n) {
  return table_of(n.solution.size(), [&](std::size_t i) {
    const Eigen::Matrix<double, 9, 1> sigma = sigmas_at(n, n.solution.time[i]);
    return row_of(n.solution.time[i], sigma.tail<3>(), sigma.segment<3>(3), sigma.head<3>());
  });
}

py::tuple flown(const std::string& mission, const py::dict& keywords, const std::shared_ptr<CalibrationObject>& unit, const std::string& folder,
                const py::object& progress) {
  const auto o = options_from<TrajectoryOptions>(keywords);
  if (o.errors && unit) throw Error("errors and unit exclude each other");
  const auto answer = run(progress, [=](const std::function<void(double)>& report) {
    const TrajectoryTask task{
        .mission = mission, .errors = o.errors, .unit = unit ? std::optional(unit->calibration()) : std::nullopt, .seed = o.seed, .progress = report};
    return flight_answer(read_mission(mission), task, folder);
  });
  const auto session = std::make_shared<Session>(answer.data->session);
  std::vector<std::string> warnings = answer.warnings;
  if (folder.empty() && session->barometer_file) {
    session->barometer_file.reset();
    warnings.emplace_back("the heights of the mission's barometer are a file: name a folder, or give navigate a barometer");
  }
  return py::make_tuple(session, std::make_shared<Recording>(answer.data->recording), std::make_shared<Solution>(answer.data->truth), warnings);
}

std::pair<Outcome, std::shared_ptr<Solution>> navigated_with_aids(const std::string& name, const std::shared_ptr<CalibrationObject>& calibration,
                                                                  const std::string& calibration_name, const std::shared_ptr<Session>& session,
                                                                  const std::shared_ptr<Recording>& recording, const NavigateVerbOptions& o,
                                                                  const std::shared_ptr<Solution>& truth) {
  const auto answer = run(py::none(), [=](const auto&) {
    check_aided(o);
    std::vector<std::string> told;
    if (calibration) told = expect_usable(calibration->calibration(), calibration_name, o.allow_undetermined, "allow_undetermined=True");
    return aided_answer(name, calibration ? calibration->calibration() : no_calibration(), *session, *recording, o, told);
  });
  Outcome out{answer};
  out.arrays["sigmas"] = sigma_rows_of(*answer.data);
  if (truth) out.arrays["errors"] = rows_of(navigation_errors(answer.data->solution, *truth));
  const auto aided = std::const_pointer_cast<AidedNavigation>(answer.data);  // Python reads alone
  return {std::move(out), std::shared_ptr<Solution>(aided, &aided->solution)};
}

std::pair<Outcome, std::shared_ptr<Solution>> navigated(const std::string& name, const std::shared_ptr<CalibrationObject>& calibration,
                                                        const std::string& calibration_name, std::shared_ptr<Session> session,
                                                        std::shared_ptr<Recording> recording, const py::dict& keywords,
                                                        std::shared_ptr<Solution> truth) {
  const auto o = options_from<NavigateVerbOptions>(keywords);
  if (o.aided) return navigated_with_aids(name, calibration, calibration_name, session, recording, o, truth);
  const auto answer = run(py::none(), [=](const auto&) {
    check_aided(o);
    std::vector<std::string> told;
    if (calibration) told = expect_usable(calibration->calibration(), calibration_name, o.allow_undetermined, "allow_undetermined=True");
    const NavigateOptions options = navigate_options(o, *session);
    std::optional<TrueMotion> reference;
    if (truth)
      reference = {"truth", *truth};
    else
      reference = o.truth.empty() ? session_truth(*session) : read_truth(o.truth);
    if (calibration) check_thermal_units(calibration->calibration(), session->source_of(name));
    return navigation_answer(
        {navigate_session(name, calibration ? calibration->calibration() : no_calibration(), *session, *recording, options, reference, true)}, o,
        told);
  });
  Outcome out{answer};
  const auto sessions = std::const_pointer_cast<std::vector<NavigatedSession>>(answer.data);  // Python reads alone
  NavigatedSession& found = sessions->front();
  if (found.errors) out.arrays["errors"] = rows_of(*found.errors);
  return {std::move(out), std::shared_ptr<Solution>(sessions, &found.navigated.solution)};
}

Answer budget_of(const BudgetVerbOptions& o, const std::function<void(double)>& report) {
  const MissionFile file = read_mission(o.mission);
  const auto tell = [](const std::string&) {};  // the answer has them
  if (!several_grades(o).empty()) return grades_answer(file, o, tell, report);
  return budget_answer(file, o, tell, report, "allow_undetermined=True");
}

py::bytes part_of_budget(const std::string& mission, const py::dict& keywords, const std::string& part) {
  auto o = options_from<BudgetVerbOptions>(keywords);
  o.mission = mission;
  o.shared.part = part;
  return part_of([=] { budget_of(o, {}); });
}

/// `parts`: those of the Monte Carlo, where it was done before.
Outcome budgeted(const std::string& mission, const py::dict& keywords, const py::object& progress, const std::vector<std::string>& parts) {
  auto o = options_from<BudgetVerbOptions>(keywords);
  o.mission = mission;
  o.shared.sources = parts_in_memory(parts);
  return {run(progress, [o](const std::function<void(double)>& report) { return budget_of(o, report); })};
}

}  // namespace

void bind_navigation(py::module_& module) {
  py::class_<Solution, std::shared_ptr<Solution>>(module, "Solution")
      .def_property_readonly("rows", [](const Solution& s) { return rows_of(s); })
      .def("save", [](const Solution& s, const std::string& path) {
        const py::gil_scoped_release unlocked;
        write_solution(path, s);
      });
  module.def("trajectory", &flown);
  module.def("navigate", &navigated);
  module.def("budget", &budgeted);
  module.def("part_of_budget", &part_of_budget);
}

}  // namespace imulab::python
