// The extension under the package imulab: it converts arguments and results, and computes nothing itself. python/imulab has the interface.
#include "imulab/core/error.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/text/file.hpp"

#include "python/bindings.hpp"
#include "python/work.hpp"
#include <exception>
#include <filesystem>
#include <pybind11/stl.h>

namespace imulab::python {
namespace {

void bind_outcome(py::module_& module) {
  py::class_<Outcome>(module, "Outcome")
      .def_readonly("json", &Outcome::json)
      .def_readonly("text", &Outcome::text)
      .def_readonly("shortcomings", &Outcome::shortcomings)
      .def_readonly("warnings", &Outcome::warnings)
      .def_readonly("arrays", &Outcome::arrays)
      .def("page", [](const Outcome& o) {
        if (!o.page) throw Error("this answer has no page; expected one of a verb with --report");
        return o.page();
      });
}

}  // namespace
}  // namespace imulab::python

PYBIND11_MODULE(_imulab, module) {
  namespace python = imulab::python;
  namespace py = pybind11;
  py::register_exception<imulab::Error>(module, "Error", PyExc_ValueError);
  py::register_exception<imulab::Unsupported>(module, "Unsupported", PyExc_RuntimeError);
  py::register_exception_translator([](std::exception_ptr failure) {
    try {
      std::rethrow_exception(failure);
    } catch (const std::filesystem::filesystem_error& e) {  // a name that the system refuses
      PyErr_SetString(py::module_::import("imulab._imulab").attr("Error").ptr(), e.what());
    }
  });
  module.attr("software") = imulab::software();
  module.def("wait_for_abandoned", &python::wait_for_abandoned);
  module.def("write_whole", [](const std::string& path, const std::string& text) { imulab::write_whole(path, text); });
  python::bind_outcome(module);
  python::bind_recording(module);
  python::bind_session(module);
  python::bind_calibration(module);
  python::bind_estimates(module);
  python::bind_navigation(module);
  python::bind_fleets(module);
  python::bind_live(module);
}
