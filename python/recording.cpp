#include "imulab/recording.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/session.hpp"

#include "python/module.hpp"
#include <pybind11/stl.h>
#include <utility>

namespace imulab::python {

ReadingOptions reading_options(const py::dict& given, const std::string& triad) {
  ReadingOptions options;
  options.unit = given["unit"].cast<std::string>();
  options.counts_per_unit = given["counts_per_unit"].cast<double>();
  options.increment = given["increment"].cast<bool>();
  options.limits = given["limits"].cast<std::optional<std::array<double, 2>>>();
  options.temperature = thermal_columns(triad + "_temperature", given["temperature"]);
  return options;
}

namespace {

Recording make(const py::array& t, const Array& gyro, const Array& accel, const std::string& name, std::optional<double> interval_s,
               const py::dict& gyro_options, const py::dict& accel_options) {
  const RecordingOptions options{
      .name = name, .interval_s = interval_s, .gyro = reading_options(gyro_options, "gyro"), .accel = reading_options(accel_options, "accel")};
  Columns3 rates = columns_of("gyro", gyro), forces = columns_of("accel", accel);
  std::vector<std::int64_t> time_ns = exact_stamps(t, name);
  const py::gil_scoped_release unlocked;
  Recording recording = make_recording(Nanoseconds{std::move(time_ns)}, std::move(rates), std::move(forces), options);
  validate(recording);
  return recording;
}

Array seconds(const Recording& r) {
  Array t(static_cast<py::ssize_t>(r.size()));
  for (std::size_t i = 0; i < r.size(); ++i) t.mutable_at(static_cast<py::ssize_t>(i)) = r.time_s(i);
  return t;
}

py::object temperature(const Columns3& columns) { return columns[0].empty() ? py::object(py::none()) : py::object(array_of(columns)); }

// Every member as it is, so that another process has the same bits.

py::tuple state_of(const Recording& r) {
  return py::make_tuple(r.name, r.interval_s, array_of(r.time_ns), array_of(r.gyro), array_of(r.accel), r.gyro_increment, r.accel_increment,
                        temperature(r.gyro_temperature), temperature(r.accel_temperature), r.gyro_unit, r.accel_unit, indices_of(r.saturated),
                        indices_of(r.gaps), indices_of(r.starts));
}

Columns3 columns_in(const py::object& object) { return object.is_none() ? Columns3{} : columns_of("state", object.cast<Array>()); }

std::shared_ptr<Recording> recording_of(const py::tuple& state) {
  constexpr std::size_t members = 14;
  if (state.size() != members) throw Error("a pickled recording of another version; expected one of this version");
  auto r = std::make_shared<Recording>();
  r->name = state[0].cast<std::string>(), r->interval_s = state[1].cast<double>();
  const auto stamps = state[2].cast<py::array_t<std::int64_t, py::array::c_style>>();
  r->time_ns.assign(stamps.data(), stamps.data() + stamps.size());
  r->gyro = columns_in(state[3]), r->accel = columns_in(state[4]);
  r->gyro_increment = state[5].cast<bool>(), r->accel_increment = state[6].cast<bool>();
  r->gyro_temperature = columns_in(state[7]), r->accel_temperature = columns_in(state[8]);
  r->gyro_unit = state[9].cast<std::string>(), r->accel_unit = state[10].cast<std::string>();
  r->saturated = state[11].cast<std::vector<std::size_t>>(), r->gaps = state[12].cast<std::vector<std::size_t>>();
  r->starts = state[13].cast<std::vector<std::size_t>>();
  return r;
}

}  // namespace

void bind_recording(py::module_& module) {
  py::class_<Recording, std::shared_ptr<Recording>>(module, "Recording")
      .def(py::init(&make), py::arg("t"), py::arg("gyro"), py::arg("accel"), py::arg("name"), py::arg("interval_s"), py::arg("gyro_options"),
           py::arg("accel_options"))
      .def("__len__", &Recording::size)
      .def_readonly("name", &Recording::name)
      .def_readonly("interval_s", &Recording::interval_s)
      .def_readonly("gyro_unit", &Recording::gyro_unit)
      .def_readonly("accel_unit", &Recording::accel_unit)
      .def_property_readonly("t", &seconds)
      .def_property_readonly("time_ns", [](const Recording& r) { return array_of(r.time_ns); })
      .def_property_readonly("gyro", [](const Recording& r) { return array_of(r.gyro); })
      .def_property_readonly("accel", [](const Recording& r) { return array_of(r.accel); })
      .def_property_readonly("gyro_temperature", [](const Recording& r) { return temperature(r.gyro_temperature); })
      .def_property_readonly("accel_temperature", [](const Recording& r) { return temperature(r.accel_temperature); })
      .def_property_readonly("gaps", [](const Recording& r) { return indices_of(r.gaps); })
      .def_property_readonly("saturated", [](const Recording& r) { return indices_of(r.saturated); })
      .def(py::pickle(&state_of, &recording_of))
      .def("save", [](const Recording& r, const std::string& path) {
        const py::gil_scoped_release unlocked;
        write_recording(path, r);
      });
  module.def(
      "read_recording",
      [](std::shared_ptr<Session> session, const std::string& file) {
        RecordingReading reading =
            run(py::none(), [session = std::move(session), file](const auto&) { return read_recording(*session, session->source_of(file)); });
        return std::pair(std::make_shared<Recording>(std::move(reading.recording)), std::move(reading.warnings));
      },
      py::arg("session"), py::arg("file"));
}

}  // namespace imulab::python
