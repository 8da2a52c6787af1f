#include "imulab/session.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/procedure.hpp"
#include "imulab/tasks/inspect.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include "python/module.hpp"
#include <cmath>
#include <map>
#include <optional>
#include <pybind11/stl.h>
#include <tuple>
#include <type_traits>
#include <utility>

namespace imulab::python {
namespace {

std::shared_ptr<Session> shared(Session session) { return std::make_shared<Session>(std::move(session)); }

/// The procedure that `imulab procedure NAME` writes; options as its help names them.
Session procedure(const std::string& name, const std::map<std::string, double>& given, std::uint64_t seed) {
  const auto take = [&](const char* key, auto& value) {
    const auto it = given.find(key);
    if (it == given.end()) return;
    using Value = std::decay_t<decltype(value)>;
    if (std::is_integral_v<Value> && !(std::abs(it->second) < 1e9 && it->second == std::floor(it->second)))
      throw Error(fmt::format("procedure: {} is {}; expected a whole number", key, it->second));
    value = static_cast<Value>(it->second);
  };
  for (const auto& [key, value] : given)
    if (key != "poses" && key != "rest" && key != "table_arcsec" && key != "record" && key != "rate_hz" && key != "turns")
      throw Error("procedure: no option " + key + "; expected poses, rest, table_arcsec, record, rate_hz or turns");
  if (name == "handheld" || name == "hand-held") {  // as it was called before
    HandHeldOptions options;
    take("poses", options.poses), take("rest", options.rest), take("rate_hz", options.rate_hz);
    return hand_held_procedure(options, seed);
  }
  if (name == "dai-unit") {
    DaiUnitOptions options;
    take("record", options.record), take("rate_hz", options.rate_hz);
    return dai_unit_procedure(options);
  }
  std::string names = "handheld, dai-unit";
  for (const TableProcedure& one : table_procedures()) {
    names += fmt::format(", {}", one.name);
    if (one.name != name) continue;
    TableProcedureOptions options = one.options;
    double arcsec = options.table / unit::arcsec;
    take("rest", options.rest), take("rate_hz", options.rate_hz), take("turns", options.turns), take("table_arcsec", arcsec);
    options.table = arcsec * unit::arcsec;
    return one.make(options);
  }
  throw Error(fmt::format("procedure: no {}; expected one of {}", name, names));
}

/// An inspection with its page, its session where that is complete, and the recording.
using Inspected = std::tuple<Outcome, std::shared_ptr<Session>, std::shared_ptr<Recording>>;

Inspected inspected(const InspectionTask& task) {
  const auto answer = inspection_answer(task);
  const auto found = std::const_pointer_cast<InspectedRecording>(answer.data);  // Python reads alone
  return {{answer},
          found->inspection.complete() ? std::shared_ptr<Session>(found, &found->session) : nullptr,
          found->recording ? std::shared_ptr<Recording>(found, &*found->recording) : nullptr};
}

/// From its text, which has every digit, and what the text does not say.
std::shared_ptr<Session> unpickled(const py::tuple& state) {
  constexpr std::size_t members = 4;
  if (state.size() != members) throw Error("a pickled session of another version; expected one of this version");
  auto session = shared(parse_session(state[0].cast<std::string>(), state[1].cast<std::string>()));
  session->sha256 = state[2].cast<std::string>(), session->noise_taken = state[3].cast<std::optional<std::string>>();
  return session;
}

/// As the command opens a recording in place of a session.
std::shared_ptr<Session> session_of_recording(const std::string& file, const std::vector<std::string>& topics) {
  return run(py::none(), [=](const auto&) {
    const InspectionTask task{.files = {file}, .topics = topics};
    return shared(session_for(inspect_files(task), task, "declare it: inspect(file, declare={KEY: VALUE}), or write a session"));
  });
}

}  // namespace

void bind_session(py::module_& module) {
  py::class_<Session, std::shared_ptr<Session>>(module, "Session")
      .def_static("read", [](const std::string& path) { return shared(read_session(path)); })
      .def_static("parse", [](const std::string& text, const std::string& file) { return shared(parse_session(text, file)); })
      .def_readonly("file", &Session::file)
      .def_property_readonly("imu", [](const Session& s) { return s.imu.name; })
      .def_property_readonly("gravity", [](const Session& s) { return s.site.gravity(); })
      .def_property_readonly("assumed_gravity", &assumed_gravity)
      .def_property_readonly("gravity_sigma", [](const Session& s) { return s.site.gravity_sigma(); })
      .def_property_readonly("recordings",
                             [](const Session& s) {
                               std::vector<std::string> files;
                               for (const RecordingSource& source : s.recordings) files.push_back(source.file);
                               return files;
                             })
      .def_property_readonly("text", &session_text)
      .def_property_readonly("procedure_text", &procedure_text)
      .def(py::pickle([](const Session& s) { return py::make_tuple(session_text(s), s.file, s.sha256, s.noise_taken); }, &unpickled))
      .def("save", [](const Session& s, const std::string& path) { write_session(path, s); })
      .def("__eq__", [](const Session& a, const Session& b) { return a == b; });
  module.def("procedure", [](const std::string& name, const std::map<std::string, double>& options, std::uint64_t seed) {
    return shared(procedure(name, options, seed));
  });
  module.def("inspect", [](const std::vector<std::string>& files, const std::vector<std::string>& topics, const Declarations& declared) {
    return run(py::none(), [task = InspectionTask{.files = files, .topics = topics, .declared = declared}](const auto&) { return inspected(task); });
  });
  module.def("session_of_recording", &session_of_recording, py::arg("file"), py::arg("topics") = std::vector<std::string>{});
  module.def("thermal_units", [](const Session& session, const std::string& file) {
    const RecordingSource source = session.source_of(file);
    const auto unit = [](const std::optional<ThermalSource>& thermal) { return thermal ? std::optional(thermal->unit) : std::nullopt; };
    return std::pair(unit(source.gyro_temperature), unit(source.accel_temperature));
  });
}

}  // namespace imulab::python
