#include "imulab/calibration.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/compensate.hpp"
#include "imulab/error.hpp"
#include "imulab/exchange.hpp"
#include "imulab/files.hpp"
#include "imulab/recording/readings.hpp"
#include "imulab/report/calibration_page.hpp"
#include "imulab/results/calibration.hpp"
#include "imulab/tasks/export.hpp"
#include "imulab/tasks/usable.hpp"
#include "imulab/tasks/verify.hpp"

#include "python/module.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <pybind11/stl.h>
#include <utility>

namespace imulab::python {
namespace {

std::shared_ptr<CalibrationObject> object_of(Calibration calibration) {
  return std::make_shared<CalibrationObject>(CalibrationObject{std::make_shared<CalibrationResult>(CalibrationResult{std::move(calibration)}), {}});
}

/// Each row: name, value, standard uncertainty (NaN: not determined), unit; SI.
py::list coefficients(const Calibration& c) {
  py::list rows;
  for (const CoefficientIndex index : coefficient_indices()) {
    const Coefficient& row = coefficient(index);
    rows.append(py::make_tuple(row.name, coefficient_value(c.model, index),
                               standard_uncertainty(c, index).value_or(std::numeric_limits<double>::quiet_NaN()), row.unit));
  }
  return rows;
}

/// Likewise in the units that people use: offsets in ug and deg/h, scales in ppm from one.
py::list user_rows(const Calibration& c) {
  py::list rows;
  for (const CoefficientIndex index : coefficient_indices()) {
    const UserValue v = user_value(c, index);
    rows.append(py::make_tuple(coefficient(index).name, v.value, v.uncertainty, v.unit));
  }
  return rows;
}

constexpr std::size_t block = 1024;  // samples: twelve columns of them stay in the second-level cache

/// Rows of three numbers with any strides.
struct Rows {
  const double* data = nullptr;  // null: none
  py::ssize_t row = 0, column = 0;

  explicit Rows(const py::object& object) {
    if (object.is_none()) return;
    const auto array = object.cast<Array>();
    data = array.data();
    constexpr auto size = static_cast<py::ssize_t>(sizeof(double));
    row = array.strides(0) / size;
    column = array.ndim() == 2 ? array.strides(1) / size : 0;  // one column stands for three
  }
};

using Block = std::array<std::array<double, block>, 3>;

std::array<std::span<const double>, 3> load(const Rows& rows, std::size_t begin, std::size_t n, Block& to) {
  if (rows.data == nullptr) return {};
  const double* from = rows.data + static_cast<py::ssize_t>(begin) * rows.row;
  for (std::size_t i = 0; i < n; ++i, from += rows.row)
    for (std::size_t axis = 0; axis < 3; ++axis) to[axis][i] = from[static_cast<py::ssize_t>(axis) * rows.column];
  return {std::span(to[0].data(), n), std::span(to[1].data(), n), std::span(to[2].data(), n)};
}

void store(const Block& from, std::size_t n, double* to) {
  for (std::size_t i = 0; i < n; ++i, to += 3) to[0] = from[0][i], to[1] = from[1][i], to[2] = from[2][i];
}

/// Raw readings, N x 3, to rates and forces in `rate` and `force`, both contiguous. The Python side has checked that the shapes agree.
void apply(const CalibrationObject& calibration, const Array& gyro, const Array& accel, const py::object& gyro_temperature,
           const py::object& accel_temperature, Array rate, Array force) {
  const SensorModel& model = calibration.calibration().model;
  const Rows g(gyro), a(accel), gt(gyro_temperature), at(accel_temperature);
  const auto size = static_cast<std::size_t>(gyro.shape(0));
  double *const rates = rate.mutable_data(), *const forces = force.mutable_data();
  const py::gil_scoped_release unlocked;
  Block blocks[6];
  for (std::size_t begin = 0; begin < size; begin += block) {
    const std::size_t n = std::min(block, size - begin);
    const RawColumns raw{load(g, begin, n, blocks[0]), load(a, begin, n, blocks[1]), load(gt, begin, n, blocks[2]), load(at, begin, n, blocks[3])};
    const auto span = [&](std::size_t k) {
      return std::array{std::span(blocks[k][0].data(), n), std::span(blocks[k][1].data(), n), std::span(blocks[k][2].data(), n)};
    };
    compensate(model, raw, {span(4), span(5)});
    store(blocks[4], n, rates + 3 * begin);
    store(blocks[5], n, forces + 3 * begin);
  }
}

/// The file that `imulab export` writes, with what it leaves out, warns of and assumes.
std::tuple<std::string, std::vector<std::string>> exported(const CalibrationObject& c, const std::string& noise, const py::dict& keywords) {
  ExportVerbOptions o;
  Verb command("imulab", "");
  take_keywords(declare(command, o), keywords);
  expect_options_of_target(o);
  std::optional<ImuNoise> sizes;
  if (!noise.empty()) sizes = parse_noise(noise, "noise");
  ExportedText out = exported_text(export_target(o.target), {c.calibration(), sizes ? &*sizes : nullptr, o.options()}, o);
  for (std::vector<std::string>* more : {&out.warnings, &out.assumed}) out.left_out.insert(out.left_out.end(), more->begin(), more->end());
  return {std::move(out.text), std::move(out.left_out)};
}

std::string page(const CalibrationObject& c) {
  if (c.data) return calibration_page(*c.result, *c.data);
  return calibration_page(CalibrationReport{
      .result = *c.result, .missing = {"The recording, gravity and rotations before and after, the directions of gravity: of a saved calibration."}});
}

}  // namespace

void bind_calibration(py::module_& module) {
  py::class_<CalibrationObject, std::shared_ptr<CalibrationObject>>(module, "Calibration")
      .def_static("read", [](const std::string& path) { return object_of(read_calibration(path)); })
      .def_static("parse", [](const std::string& text, const std::string& file) { return object_of(parse_calibration(text, file)); })
      .def_static("imported",
                  [](const std::string& path, const std::optional<std::string>& gyro_file, int instance, const std::string& raw) {
                    Imported imported = import_calibration(path, {.gyro_file = gyro_file, .instance = instance, .raw = raw});
                    return std::pair(object_of(std::move(imported.calibration)), std::move(imported.warnings));
                  })
      .def_property_readonly("json", [](const CalibrationObject& c) { return calibration_document(c.calibration()); })
      .def_property_readonly("text", [](const CalibrationObject& c) { return calibration_summary(c.calibration()); })
      .def_property_readonly(
          "details", [](const CalibrationObject& c) { return calibration_details(c.calibration(), c.result->coarse ? &*c.result->coarse : nullptr); })
      .def_property_readonly("imu", [](const CalibrationObject& c) { return c.calibration().imu; })
      .def_property_readonly("method", [](const CalibrationObject& c) { return c.calibration().method; })
      .def_property_readonly("verdict", [](const CalibrationObject& c) { return std::string(to_string(conclusion_of(c.calibration()).verdict)); })
      .def_property_readonly("because", [](const CalibrationObject& c) { return c.calibration().quality.findings.reasons(); })
      .def_property_readonly("warnings", [](const CalibrationObject& c) { return c.calibration().quality.findings.warnings(); })
      .def_property_readonly("unobservable", [](const CalibrationObject& c) { return c.calibration().quality.unobservable; })
      .def("expect_usable", [](const CalibrationObject& c, const std::string& name,
                               bool allowed) { return expect_usable(c.calibration(), name, allowed, "allow_undetermined=True"); })
      .def_property_readonly("thermal_units",
                             [](const CalibrationObject& c) {
                               const SensorModel& m = c.calibration().model;
                               const auto unit = [](const TriadModel& t) {
                                 return t.temperature ? std::optional(t.temperature->unit) : std::nullopt;
                               };
                               return std::pair(unit(m.gyro), unit(m.accel));
                             })
      .def_property_readonly("shortcomings", [](const CalibrationObject& c) { return shortcomings(*c.result); })
      .def_property_readonly("coefficients", [](const CalibrationObject& c) { return coefficients(c.calibration()); })
      .def_property_readonly("in_user_units", [](const CalibrationObject& c) { return user_rows(c.calibration()); })
      .def_property_readonly("estimated",
                             [](const CalibrationObject& c) {
                               std::vector<std::string_view> names;
                               for (const CoefficientIndex index : c.calibration().estimated) names.push_back(coefficient(index).name);
                               return names;
                             })
      .def_property_readonly("covariance", [](const CalibrationObject& c) { return array_of(c.calibration().covariance); })
      .def_property_readonly("constant_covariance", [](const CalibrationObject& c) { return array_of(c.calibration().constant_covariance); })
      .def_property_readonly("curves",
                             [](const CalibrationObject& c) {
                               std::map<std::string, py::array> curves;
                               if (!c.result->curve_time.empty()) curves["t"] = array_of(c.result->curve_time);
                               for (const ConvergenceCurve& curve : c.result->curves) {
                                 curves[curve.name] = array_of(curve.residual);
                                 curves[curve.name + ".sigma"] = array_of(curve.sigma);
                               }
                               return curves;
                             })
      .def_property_readonly("gyro_unit", [](const CalibrationObject& c) { return c.calibration().model.gyro.raw_unit; })
      .def_property_readonly("accel_unit", [](const CalibrationObject& c) { return c.calibration().model.accel.raw_unit; })
      .def("save",
           [](const CalibrationObject& c, const std::string& path) {
             const py::gil_scoped_release unlocked;
             write_calibration(path, c.calibration());
           })
      .def("page", [](const std::shared_ptr<CalibrationObject>& c) { return run(py::none(), [c = *c](const auto&) { return page(c); }); })
      .def("apply", &apply, py::arg("gyro"), py::arg("accel"), py::arg("gyro_temperature"), py::arg("accel_temperature"), py::arg("rate"),
           py::arg("force"))
      .def("exported", &exported);
  module.def("verify", [](const std::string& path, const py::dict& keywords) {
    auto o = options_from<VerifyOptions>(keywords);
    o.calibration = path;
    return Outcome{run(py::none(), [o](const auto&) { return verify(o); })};
  });
  module.def("export_targets", [] {
    std::vector<std::pair<std::string_view, std::string_view>> targets;
    for (const ExportTarget& target : export_targets()) targets.emplace_back(target.name, target.summary);
    return targets;
  });
  module.def("group_of", [](const std::string& name) {
    const Coefficient& c = coefficient(coefficient_index(name));
    const bool misalignment = c.term == Term::matrix && c.row != c.column;
    return name.substr(0, name.rfind('.')) + (misalignment ? ".off_diagonal" : "");
  });
  module.def("user_unit", [](const std::string& name, double size) {
    const UserUnit unit = user_unit(coefficient(coefficient_index(name)), size, TriadModel{});
    return std::pair(unit.name, unit.size);
  });
  module.def("compensate", [](const CalibrationObject& c, std::shared_ptr<Recording> recording, bool reject_outliers) {
    CompensatedRecording out = run(py::none(), [result = c.result, recording = std::move(recording), reject_outliers](const auto&) {
      return compensate(result->calibration.model, *recording, reject_outliers ? Outliers::reject : Outliers::keep);
    });
    return std::tuple(std::make_shared<Recording>(std::move(out.recording)), indices_of(out.out_of_range), indices_of(out.replaced));
  });
}

}  // namespace imulab::python
