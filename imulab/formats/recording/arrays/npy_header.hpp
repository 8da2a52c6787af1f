// The head of an array as NumPy stores it (numpy.lib.format, versions 1 to 3): type, order and shape.
#pragma once

#include "imulab/formats/recording/arrays/arrays.hpp"
#include "imulab/formats/recording/logs/binary.hpp"

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::recording_io {

struct NpyArray {
  NumberArray array;                ///< no columns where it does not hold numbers, or has more than two dimensions
  std::vector<NumberField> fields;  ///< of the columns; by column the offset of the column's first number
  std::size_t stride = 0;           ///< from one row's field to the next
  bool by_column = false;
  std::size_t bytes = 0;   ///< of all numbers
  std::size_t offset = 0;  ///< of the first, from the array's head
  std::string type;        ///< as NumPy writes it
};

/// The longest head that is read.
inline constexpr std::size_t npy_longest_head = 1 << 20;

/// The number of bytes of the head; 0 where `head`, its first 12 bytes at least, is none.
std::size_t npy_head_size(std::string_view head);
/// `head`: all of it. `available`: how many bytes of numbers there are, one row at least; `name`: of the array; `place`: for messages. Throws Error
/// where it is damaged.
NpyArray npy_array(std::string_view head, std::size_t available, const std::string& name, const std::string& place);

}  // namespace imulab::recording_io
