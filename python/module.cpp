// The extension under the package imulab: it converts arguments and results, and computes nothing itself. python/imulab has the interface.
#include "python/module.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/recording/origin.hpp"
#include "imulab/recording/readings.hpp"
#include "imulab/tasks/budget.hpp"
#include "imulab/tasks/compare.hpp"
#include "imulab/tasks/export.hpp"
#include "imulab/tasks/extrinsics.hpp"
#include "imulab/tasks/navigate.hpp"
#include "imulab/tasks/noise.hpp"
#include "imulab/tasks/plan.hpp"
#include "imulab/tasks/predict.hpp"
#include "imulab/tasks/simulate.hpp"
#include "imulab/tasks/trajectory.hpp"
#include "imulab/tasks/verify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <pybind11/stl.h>
#include <type_traits>

namespace imulab::python {
namespace {

std::mutex guard;
std::vector<std::thread> abandoned;

// ---- options of the verbs as keywords, from the tables by which the command parses

/// The name of a kind of values, as Python annotates it.
template <class Value>
const char* kind_of(const Value*) {
  if constexpr (std::is_same_v<Value, bool>) return "bool";
  if constexpr (std::is_same_v<Value, double>) return "float";
  if constexpr (std::is_integral_v<Value> && !std::is_same_v<Value, bool>) return "int";
  if constexpr (std::is_same_v<Value, std::string>) return "str";
  if constexpr (std::is_same_v<Value, std::optional<double>>) return "float | None";
  if constexpr (std::is_same_v<Value, std::optional<std::string>>) return "str | None";
  return "list[str]";
}

std::string kind_of(const VerbOption& row) {
  if (row.file != VerbOption::File::none && std::holds_alternative<std::string*>(row.value)) return "PathLike";
  if (row.file != VerbOption::File::none && std::holds_alternative<std::optional<std::string>*>(row.value)) return "PathLike | None";
  return std::visit([](const auto* value) -> std::string { return kind_of(value); }, row.value);
}

/// A text, or the name of a file as a path.
std::string text_of(const VerbOption& row, py::handle value) {
  const py::object text = py::hasattr(value, "__fspath__") ? py::object(value.attr("__fspath__")()) : py::reinterpret_borrow<py::object>(value);
  if (!py::isinstance<py::str>(text)) throw py::cast_error();
  std::string out = text.cast<std::string>();
  if (out.find('\0') != std::string::npos) throw Error(row.keyword + ": has a NUL character; expected a path");
  return out;
}

void expect_in_range(const VerbOption& row, py::handle value) {
  const std::string shown = py::str(value);
  if (row.range)
    if (const auto number = value.cast<double>(); !(number >= (*row.range)[0] && number <= (*row.range)[1]))
      throw Error(fmt::format("{}: {}; expected {:.10g} to {:.10g}", row.keyword, shown, (*row.range)[0], (*row.range)[1]));
  if (!row.choices.empty() && std::find(row.choices.begin(), row.choices.end(), shown) == row.choices.end())
    throw Error(fmt::format("{}: {}; expected {} or {}", row.keyword, shown, fmt::join(row.choices.begin(), row.choices.end() - 1, ", "),
                            row.choices.back()));
  if (const std::string problem = row.problem_of ? row.problem_of(shown) : ""; !problem.empty())
    throw Error(fmt::format("{}: {}", row.keyword, problem));
}

void set(const VerbOption& row, py::handle value) {
  if (value.is_none() && !row.is_required) return;  // the default
  if (std::holds_alternative<std::optional<std::string>*>(row.value) && py::isinstance<py::str>(value) && py::len(value) == 0) return;
  try {
    std::visit(
        [&](auto* to) {
          using Value = std::decay_t<decltype(*to)>;
          if constexpr (std::is_same_v<Value, std::string> || std::is_same_v<Value, std::optional<std::string>>)
            *to = text_of(row, value);
          else
            *to = value.cast<Value>();
        },
        row.value);
    expect_in_range(row, value);
  } catch (const py::cast_error&) {
    if (PyLong_Check(value.ptr()) && std::holds_alternative<std::uint64_t*>(row.value))
      throw Error(fmt::format("{}: {}; expected 0 to 2^64 - 1", row.keyword, std::string(py::str(value))));
    throw py::type_error(fmt::format("{}: expected {}, got {}", row.keyword, kind_of(row), Py_TYPE(value.ptr())->tp_name));
  }
}

template <class Options>
void add_table(py::dict& tables) {
  Options o;
  Verb command("imulab", "");
  const Verb& verb = declare(command, o);
  py::list rows;
  for (const VerbOption& row : verb.options)
    if (!row.keyword.empty())
      rows.append(
          py::make_tuple(row.keyword, kind_of(row), std::visit([](const auto* value) { return py::object(py::cast(*value)); }, row.value), row.help));
  tables[py::str(verb.own_name())] = rows;
}

void bind_outcome(py::module_& module) {
  py::class_<Outcome>(module, "Outcome")
      .def_property_readonly("json", [](const Outcome& o) { return o.document(); })
      .def_property_readonly("text", [](const Outcome& o) { return o.text(false); })
      .def_property_readonly("headline", [](const Outcome& o) { return o.headline(); })
      .def_property_readonly("shortcomings", [](const Outcome& o) { return o.shortcomings; })
      .def_property_readonly("warnings", [](const Outcome& o) { return o.all_warnings(); })
      .def_readonly("arrays", &Outcome::arrays)
      .def("page", [](const Outcome& o) {
        if (!o.page) throw Error("this answer has no page; expected one of a verb with --report");
        return o.page();
      });
}

void bind_options(py::module_& module) {
  module.def("keywords", [] {
    py::dict tables;
    add_table<CalibrateOptions>(tables), add_table<CompareOptions>(tables), add_table<VerifyOptions>(tables), add_table<SimulateOptions>(tables);
    add_table<PredictOptions>(tables), add_table<PlanOptions>(tables), add_table<NoiseVerbOptions>(tables);
    add_table<TrajectoryOptions>(tables), add_table<NavigateVerbOptions>(tables), add_table<BudgetVerbOptions>(tables);
    add_table<ExportVerbOptions>(tables), add_table<ExtrinsicsOptions>(tables);
    return tables;
  });
}

}  // namespace

void keep_until_exit(std::thread thread) {
  const std::lock_guard lock(guard);
  abandoned.push_back(std::move(thread));
}

void wait_for_abandoned() {
  const py::gil_scoped_release unlocked;
  const std::lock_guard lock(guard);
  for (std::thread& thread : abandoned) thread.join();
  abandoned.clear();
}

void take_keywords(Verb& verb, const py::dict& given) {
  for (const auto& [key, value] : given) {
    const auto name = key.cast<std::string>();
    const auto row = std::find_if(verb.options.begin(), verb.options.end(), [&](const VerbOption& o) { return o.keyword == name; });
    if (name.empty() || row == verb.options.end())
      throw py::type_error(fmt::format("{}() got an unexpected keyword argument '{}'", verb.own_name(), name));
    set(*row, value);
    row->given = py::bool_(py::reinterpret_borrow<py::object>(value));
  }
  for (const VerbOption& row : verb.options) {
    if (row.is_required && !row.keyword.empty() && !given.contains(row.keyword))
      throw py::type_error(fmt::format("{}() missing the keyword argument '{}'", verb.own_name(), row.keyword));
    for (const VerbOption* other : row.excluded)
      if (row.given && other->given) throw Error(fmt::format("{} and {} exclude each other; expected one", other->keyword, row.keyword));
  }
}

std::string in_keywords(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool begins = i == 0 || std::isalnum(static_cast<unsigned char>(text[i - 1])) == 0;
    if (!begins || text.compare(i, 2, "--") != 0 || i + 2 == text.size() || std::islower(static_cast<unsigned char>(text[i + 2])) == 0) {
      out += text[i];
      continue;
    }
    for (i += 2; i < text.size() && (std::islower(static_cast<unsigned char>(text[i])) != 0 || text[i] == '-'); ++i)
      out += text[i] == '-' ? '_' : text[i];
    --i;
  }
  return out;
}

}  // namespace imulab::python

PYBIND11_MODULE(_imulab, module) {
  namespace python = imulab::python;
  namespace py = pybind11;
  py::register_exception<imulab::Error>(module, "Error", PyExc_ValueError);
  py::register_exception<imulab::Unsupported>(module, "Unsupported", PyExc_RuntimeError);
  module.def("in_keywords", &python::in_keywords);
  py::register_exception_translator([](std::exception_ptr failure) {
    const auto raise = [](const std::string& text) {
      PyErr_SetString(py::module_::import("imulab._imulab").attr("Error").ptr(), python::in_keywords(text).c_str());
    };
    try {
      std::rethrow_exception(failure);
    } catch (const imulab::OptionError& e) {
      std::string keyword = e.option();
      std::replace(keyword.begin(), keyword.end(), '-', '_');
      raise(keyword + ": " + e.what());
    } catch (const imulab::Error& e) {
      raise(e.what());
    } catch (const std::filesystem::filesystem_error& e) {  // a name that the system refuses
      raise(e.what());
    }
  });
  module.attr("software") = imulab::software();
  module.def("wait_for_abandoned", &python::wait_for_abandoned);
  module.def("write_whole", [](const std::string& path, const std::string& text) { imulab::write_whole(path, text); });
  python::bind_outcome(module);
  python::bind_options(module);
  python::bind_recording(module);
  python::bind_session(module);
  python::bind_calibration(module);
  python::bind_estimates(module);
  python::bind_navigation(module);
  python::bind_fleets(module);
  python::bind_live(module);
}
