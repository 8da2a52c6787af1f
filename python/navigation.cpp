// trajectory, navigate, budget.
#include "imulab/core/error.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/core/units.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/recording/solution.hpp"
#include "imulab/model/calibration.hpp"
#include "imulab/navigation/navigation_error.hpp"
#include "imulab/report/navigation_page.hpp"
#include "imulab/tasks/budget.hpp"
#include "imulab/tasks/navigate.hpp"
#include "imulab/tasks/recordings.hpp"
#include "imulab/tasks/trajectory.hpp"
#include "imulab/tasks/usable.hpp"

#include "python/bindings.hpp"
#include "python/work.hpp"
#include <pybind11/stl.h>
#include <utility>

namespace imulab::python {
namespace {

/// Rows of: t [s], latitude, longitude [deg], height [m], velocity east, north, up [m/s], roll, pitch, heading [deg].
Array rows_of(const Solution& solution) {
  Array rows({static_cast<py::ssize_t>(solution.size()), py::ssize_t{10}});
  auto values = rows.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    const NavigationState& s = solution.states[static_cast<std::size_t>(i)];
    const EulerAngles angles = euler_angles(s.q_nb.toRotationMatrix());
    const double row[] = {solution.time[static_cast<std::size_t>(i)],
                          s.latitude / unit::deg,
                          s.longitude / unit::deg,
                          s.height,
                          s.velocity.x(),
                          s.velocity.y(),
                          s.velocity.z(),
                          angles.roll / unit::deg,
                          angles.pitch / unit::deg,
                          angles.heading / unit::deg};
    for (py::ssize_t k = 0; k < 10; ++k) values(i, k) = row[k];
  }
  return rows;
}

/// Rows of: t [s], position east, north, up [m], velocity [m/s], attitude [rad].
Array rows_of(const NavigationErrors& errors) {
  Array rows({static_cast<py::ssize_t>(errors.history.size()), py::ssize_t{10}});
  auto values = rows.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    const NavigationError& e = errors.history[static_cast<std::size_t>(i)];
    values(i, 0) = e.time;
    for (py::ssize_t k = 0; k < 3; ++k) values(i, 1 + k) = e.position[k], values(i, 4 + k) = e.velocity[k], values(i, 7 + k) = e.attitude[k];
  }
  return rows;
}

py::tuple flown(const std::string& mission, bool errors, const std::shared_ptr<CalibrationObject>& unit, std::uint64_t seed,
                const std::string& folder, const py::object& progress) {
  FlownMission out = run(progress, [=](const std::function<void(double)>& report) {
    TrajectoryTask task{
        .mission = mission, .errors = errors, .unit = unit ? std::optional(unit->calibration()) : std::nullopt, .seed = seed, .progress = report};
    FlownMission f = fly(read_mission(mission), task);
    if (!folder.empty()) write_flown(folder, f);
    return f;
  });
  return py::make_tuple(std::make_shared<Session>(std::move(out.session)), std::make_shared<Recording>(std::move(out.recording)),
                        std::make_shared<Solution>(std::move(out.truth)), std::move(out.warnings));
}

std::pair<Outcome, std::shared_ptr<Solution>> navigated(const std::string& name, const std::shared_ptr<CalibrationObject>& calibration,
                                                        std::shared_ptr<Session> session, std::shared_ptr<Recording> recording,
                                                        const std::string& vertical, bool align, std::optional<double> heading_deg,
                                                        double heading_sigma_deg, const std::string& barometer, const std::string& truth_file,
                                                        std::shared_ptr<Solution> truth, bool refuse_gaps) {
  NavigateOptions options;
  const std::map<std::string, VerticalChannel> channels{
      {"free", VerticalChannel::free}, {"fixed", VerticalChannel::fixed}, {"aided", VerticalChannel::aided}, {"held", VerticalChannel::held}};
  const auto channel = channels.find(vertical);
  if (channel == channels.end()) throw Error("vertical: " + vertical + "; expected free, fixed, aided or held");
  options.vertical = channel->second;
  options.align = align;
  if (heading_deg) options.heading = {*heading_deg * unit::deg, heading_sigma_deg * unit::deg};
  if (refuse_gaps) options.gaps = GapTreatment::refuse;
  const auto found = std::make_shared<NavigatedSession>(run(py::none(), [=](const auto&) mutable {
    if (!barometer.empty()) options.barometer = read_heights(barometer);
    std::optional<TrueMotion> reference;
    if (truth)
      reference = {"truth", *truth};
    else
      reference = truth_file.empty() ? session_truth(*session) : read_truth(truth_file);
    if (calibration) check_thermal_units(calibration->calibration(), session->source_of(name));
    return navigate_session(name, calibration ? calibration->calibration() : no_calibration(), *session, *recording, options, reference, true);
  }));
  Outcome out{.json = navigation_json({*found}), .text = navigation_table({*found}), .warnings = found->navigated.warnings, .page = [found] {
                return navigation_page({.sessions = {*found}});
              }};
  if (found->errors) {
    out.arrays["errors"] = rows_of(*found->errors);
    out.warnings.insert(out.warnings.end(), found->errors->warnings.begin(), found->errors->warnings.end());
  }
  return {std::move(out), std::shared_ptr<Solution>(found, &found->navigated.solution)};
}

/// Of the calibration that a mission names. Throws Unsupported where it is not determined, unless that is allowed.
std::vector<std::string> doubts_about(const ErrorSpecification& specification, const std::filesystem::path& mission, bool allowed) {
  if (!specification.calibration) return {};
  const std::filesystem::path file = mission.parent_path() / *specification.calibration;
  Usability found = usability(read_calibration(file), file.string());
  if (found.undetermined.empty()) return found.warnings;
  if (!allowed) throw Unsupported(found.undetermined + "; expected a calibration from more data, or allow_undetermined=True");
  found.warnings.push_back(found.undetermined);
  return found.warnings;
}

Outcome budgeted(const std::string& mission, const std::optional<std::string>& grade, const std::optional<std::string>& system,
                 const std::optional<std::string>& calibration, const std::optional<std::string>& noise, std::uint64_t runs, std::uint64_t seed,
                 double every, bool allow_undetermined, const py::object& progress) {
  return run(progress, [=](const std::function<void(double)>& report) {
    const BudgetTask task{mission, grade, system, calibration, noise, runs, seed, every, report};
    const MissionFile file = read_mission(mission);
    const ErrorSpecification specification = specification_of(task, file);
    std::vector<std::string> doubts = doubts_about(specification, mission, allow_undetermined);
    const auto b = std::make_shared<MissionBudget>(mission_budget(file, specification, task));
    b->warnings.insert(b->warnings.begin(), doubts.begin(), doubts.end());
    return Outcome{.json = budget_json(*b), .text = budget_table(b->budget, b->monte_carlo), .warnings = b->warnings, .page = [b, mission] {
                     return budget_page(*b, mission);
                   }};
  });
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
}

}  // namespace imulab::python
