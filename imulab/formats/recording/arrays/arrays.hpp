// Files that hold arrays by name (NumPy, MATLAB, HDF5): which of them are a table.
#pragma once

#include "imulab/formats/recording/table.hpp"

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace imulab::recording_io {

/// An array with one row for each sample.
struct NumberArray {
  std::string name;  ///< may be empty
  std::size_t rows = 0;
  std::vector<ColumnDescription> columns;
};

/// A shape as a table of numbers: one dimension is a column; two are rows and columns, where the longer one is the rows.
struct ArrayShape {
  std::size_t rows = 0, columns = 0;
  bool by_column = false;  ///< the file has column after column; else row after row
};
ArrayShape table_shape(const std::vector<std::size_t>& dimensions, bool last_runs_fastest);

/// `name` of a single column; `name.1`, `name.2` ... of several; without a name the numbers alone.
std::vector<ColumnDescription> column_names(const std::string& name, std::size_t columns, const std::string& unit = "");

/// Where a column of a table is: which array, and which of its columns.
struct ArrayColumn {
  std::size_t array = 0, column = 0;
};

struct ArrayTable {
  TableDescription
      description;  ///< with the name of its first array; without one where it is the only table; all arrays' names are other names of it
  std::vector<ArrayColumn> places;  ///< of the columns
};

/// The arrays of one length are one table, in the order in which the arrays come. Arrays of a single row are settings and left out, unless there are
/// no others; the name of a sampling rate is then another name of each table, by which its value is read.
std::vector<ArrayTable> tables_of(const std::vector<NumberArray>& arrays);
std::vector<TableDescription> descriptions_of(const std::vector<NumberArray>& arrays);

/// True for the name of a setting that is the sampling rate: "fs", "imu/sampling_rate".
bool names_rate(const std::string& name);

/// The table that a session names, by any of its arrays, and the columns requested of it. Throws Error as find_table and find_column do.
std::vector<ArrayColumn> find_array_columns(const std::vector<NumberArray>& arrays, const std::string& topic, const std::vector<Column>& columns,
                                            const std::string& file);

/// The columns at `places`, array by array: `read(array, columns, to)`, where `to` are the indices of these columns in `places`.
template <class Read>
void for_each_array(const std::vector<ArrayColumn>& places, std::size_t arrays, const Read& read) {
  for (std::size_t a = 0; a < arrays; ++a) {
    std::vector<std::size_t> wanted, to;
    for (std::size_t i = 0; i < places.size(); ++i)
      if (places[i].array == a) wanted.push_back(places[i].column), to.push_back(i);
    if (!wanted.empty()) read(a, wanted, to);
  }
}

}  // namespace imulab::recording_io
