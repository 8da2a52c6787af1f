#include "python/arrays.hpp"

#include "imulab/error.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/readings.hpp"

#include <algorithm>

namespace imulab::python {
namespace {

std::string shape_text(const Array& array) {
  std::string text = "(";
  for (py::ssize_t d = 0; d < array.ndim(); ++d) text += (d > 0 ? ", " : "") + std::to_string(array.shape(d));
  return text + (array.ndim() == 1 ? ",)" : ")");
}

}  // namespace

std::vector<double> column_of(const Array& array) {
  if (array.ndim() != 1) throw Error("shape " + shape_text(array) + "; expected (N,)");
  const auto values = array.unchecked<1>();
  std::vector<double> column(static_cast<std::size_t>(values.shape(0)));
  for (std::size_t i = 0; i < column.size(); ++i) column[i] = values(static_cast<py::ssize_t>(i));
  return column;
}

std::vector<std::int64_t> exact_stamps(const py::array& t, const std::string& name) {
  if (!py::isinstance<py::array_t<std::int64_t>>(t)) return nanoseconds_of(column_of(t), name);
  const auto exact = py::array_t<std::int64_t>(t).unchecked<1>();
  std::vector<std::int64_t> time_ns(static_cast<std::size_t>(exact.shape(0)));
  for (std::size_t i = 0; i < time_ns.size(); ++i) time_ns[i] = exact(static_cast<py::ssize_t>(i));
  return time_ns;
}

Columns3 columns_of(const std::string& name, const Array& array) {
  if (array.ndim() != 2 || array.shape(1) != 3) throw Error(name + ": shape " + shape_text(array) + "; expected (N, 3), a row a sample");
  const auto values = array.unchecked<2>();
  Columns3 columns;
  for (py::ssize_t axis = 0; axis < 3; ++axis) {
    std::vector<double>& column = columns[static_cast<std::size_t>(axis)];
    column.resize(static_cast<std::size_t>(values.shape(0)));
    for (std::size_t i = 0; i < column.size(); ++i) column[i] = values(static_cast<py::ssize_t>(i), axis);
  }
  return columns;
}

std::vector<std::vector<double>> thermal_columns(const std::string& name, const py::object& object) {
  if (object.is_none()) return {};
  const auto array = object.cast<Array>();
  if (array.ndim() == 1) return {column_of(array)};
  Columns3 columns = columns_of(name, array);
  return {std::move(columns[0]), std::move(columns[1]), std::move(columns[2])};
}

Array array_of(const std::vector<double>& column) { return Array(static_cast<py::ssize_t>(column.size()), column.data()); }

py::array_t<std::int64_t> array_of(const std::vector<std::int64_t>& column) {
  return py::array_t<std::int64_t>(static_cast<py::ssize_t>(column.size()), column.data());
}

py::array_t<std::int64_t> indices_of(const std::vector<std::size_t>& indices) {
  py::array_t<std::int64_t> array(static_cast<py::ssize_t>(indices.size()));
  std::copy(indices.begin(), indices.end(), array.mutable_data());
  return array;
}

Array array_of(const Columns3& columns) {
  return table_of(columns[0].size(), [&](std::size_t i) { return std::array{columns[0][i], columns[1][i], columns[2][i]}; });
}

Array array_of(const Eigen::MatrixXd& matrix) {
  Array array({static_cast<py::ssize_t>(matrix.rows()), static_cast<py::ssize_t>(matrix.cols())});
  auto values = array.mutable_unchecked<2>();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index k = 0; k < matrix.cols(); ++k) values(i, k) = matrix(i, k);
  return array;
}

}  // namespace imulab::python
