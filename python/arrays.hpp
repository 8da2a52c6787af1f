// numpy arrays <-> columns. The Python side has made them arrays of double already; here their shapes and strides are read.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/recording.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <string>
#include <tuple>
#include <vector>

namespace imulab::python {

namespace py = pybind11;

/// An array of float64 with any strides.
using Array = py::array_t<double>;

/// N numbers, or one column of three.
std::vector<double> column_of(const Array& array);
/// Stamps: integers are nanoseconds, other numbers seconds. Throws Error as nanoseconds_of.
std::vector<std::int64_t> exact_stamps(const py::array& t, const std::string& name);
/// N x 3. Throws Error naming it for another shape.
Columns3 columns_of(const std::string& name, const Array& array);
/// None, N or N x 3: none, one column or three.
std::vector<std::vector<double>> thermal_columns(const std::string& name, const py::object& array);

/// Rows of numbers: `row(i)` gives an array of them.
template <class Row>
Array table_of(std::size_t count, const Row& row) {
  constexpr auto columns = static_cast<py::ssize_t>(std::tuple_size_v<decltype(row(std::size_t{}))>);
  Array rows({static_cast<py::ssize_t>(count), columns});
  double* to = rows.mutable_data();
  for (std::size_t i = 0; i < count; ++i)
    for (const double value : row(i)) *to++ = value;
  return rows;
}

Array array_of(const std::vector<double>& column);
py::array_t<std::int64_t> array_of(const std::vector<std::int64_t>& column);
py::array_t<std::int64_t> indices_of(const std::vector<std::size_t>& indices);
/// N x 3; 0 x 3 where the columns are empty.
Array array_of(const Columns3& columns);
Array array_of(const Eigen::MatrixXd& matrix);

}  // namespace imulab::python
