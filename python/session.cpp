#include "imulab/recording/session.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/inspection/declared.hpp"
#include "imulab/inspection/inspection.hpp"
#include "imulab/inspection/join.hpp"
#include "imulab/io/recording/file.hpp"
#include "imulab/io/recording/signals.hpp"
#include "imulab/io/result/inspection.hpp"
#include "imulab/io/session/file.hpp"
#include "imulab/io/text/file.hpp"
#include "imulab/recording/overview.hpp"
#include "imulab/report/inspection_page.hpp"
#include "imulab/rig/procedure.hpp"

#include "python/bindings.hpp"
#include "python/work.hpp"
#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <pybind11/stl.h>
#include <utility>

namespace imulab::python {
namespace {

std::shared_ptr<Session> shared(Session session) { return std::make_shared<Session>(std::move(session)); }

/// What `imulab procedure NAME` writes; options as its help names them.
Session procedure(const std::string& name, const std::map<std::string, double>& given, std::uint64_t seed) {
  const auto take = [&](const char* key, auto& value) {
    if (const auto it = given.find(key); it != given.end()) value = static_cast<std::decay_t<decltype(value)>>(it->second);
  };
  for (const auto& [key, value] : given)
    if (key != "poses" && key != "rest" && key != "table_arcsec" && key != "record" && key != "rate_hz" && key != "turns")
      throw Error("procedure: no option " + key + "; expected poses, rest, table_arcsec, record, rate_hz or turns");
  if (name == "hand-held") {
    HandHeldOptions options;
    take("poses", options.poses), take("rest", options.rest), take("rate_hz", options.rate_hz);
    return hand_held_procedure(options, seed);
  }
  if (name == "dai-unit") {
    DaiUnitOptions options;
    take("record", options.record), take("rate_hz", options.rate_hz);
    return dai_unit_procedure(options);
  }
  const std::map<std::string, Session (*)(const TableProcedureOptions&)> on_table{{"six-position", six_position_procedure},
                                                                                  {"zhang-24", zhang_24_procedure},
                                                                                  {"cheng-path", cheng_path_procedure},
                                                                                  {"ferraris", ferraris_procedure}};
  const auto it = on_table.find(name);
  if (it == on_table.end()) throw Error("procedure: no " + name + "; expected hand-held, six-position, ferraris, zhang-24, cheng-path or dai-unit");
  TableProcedureOptions options = name == "ferraris" ? ferraris_options() : TableProcedureOptions{};
  double arcsec = options.table / unit::arcsec;
  take("rest", options.rest), take("rate_hz", options.rate_hz), take("turns", options.turns), take("table_arcsec", arcsec);
  options.table = arcsec * unit::arcsec;
  return it->second(options);
}

/// An inspection, its session where it is complete, and its page.
struct Inspected {
  Outcome outcome;
  std::shared_ptr<Session> session;  // null: questions are open
  std::shared_ptr<Recording> recording;
};

Inspected inspect_files(const std::vector<std::string>& files, const std::vector<std::string>& topics, const Declarations& declared) {
  inspection::check_declarations(declared);
  const Site site = declared_site(declared);
  std::vector<SignalTable> tables;
  for (const std::string& file : files)
    for (const std::string& topic : topics.empty() ? std::vector<std::string>{""} : topics) tables.push_back(read_signals(file, topic));
  const auto found = std::make_shared<Inspection>(inspect(inspection::joined(std::move(tables), declared), declared));
  Inspected out;
  if (found->complete()) try {
      out.session = shared(inspected_session(*found, site));
      out.session->file = files.front();
      out.session->sha256 = file_sum(files.front()).sha256;
      RecordingReading reading = read_recording(*out.session, out.session->recordings.front());
      for (std::string& text : reading.warnings) found->evidence.push_back(std::move(text));
      out.recording = std::make_shared<Recording>(std::move(reading.recording));
    } catch (const Error& e) {
      found->problems.emplace_back(e.what());
      out.session = nullptr;
    }
  out.outcome.json = inspection_json(*found);
  out.outcome.text = inspection_text(*found);
  const std::vector<std::string>& open = found->problems.empty() ? found->ambiguous : found->problems;
  for (const std::string& text : open) out.outcome.shortcomings += (out.outcome.shortcomings.empty() ? "" : "\n") + text;
  out.outcome.page = [found, recording = out.recording] {
    std::optional<Overview> picture;
    if (recording) picture = overview(SensorModel{}, *recording, 1500);
    return inspection_page(*found, picture);
  };
  return out;
}

}  // namespace

void bind_session(py::module_& module) {
  py::class_<Session, std::shared_ptr<Session>>(module, "Session")
      .def_static("read", [](const std::string& path) { return shared(read_session(path)); })
      .def_static("parse", [](const std::string& text, const std::string& file) { return shared(parse_session(text, file)); })
      .def_readonly("file", &Session::file)
      .def_property_readonly("imu", [](const Session& s) { return s.imu.name; })
      .def_property_readonly("gravity", [](const Session& s) { return s.site.gravity(); })
      .def_property_readonly("gravity_sigma", [](const Session& s) { return s.site.gravity_sigma(); })
      .def_property_readonly("recordings",
                             [](const Session& s) {
                               std::vector<std::string> files;
                               for (const RecordingSource& source : s.recordings) files.push_back(source.file);
                               return files;
                             })
      .def_property_readonly("text", &session_text)
      .def_property_readonly("procedure_text", &procedure_text)
      .def("save", [](const Session& s, const std::string& path) { write_session(path, s); })
      .def("__eq__", [](const Session& a, const Session& b) { return a == b; });
  module.def("procedure", [](const std::string& name, const std::map<std::string, double>& options, std::uint64_t seed) {
    return shared(procedure(name, options, seed));
  });
  module.def("inspect", [](const std::vector<std::string>& files, const std::vector<std::string>& topics, const Declarations& declared) {
    Inspected out = run(py::none(), [=](const auto&) { return inspect_files(files, topics, declared); });
    return std::tuple(std::move(out.outcome), out.session, out.recording);
  });
}

}  // namespace imulab::python
