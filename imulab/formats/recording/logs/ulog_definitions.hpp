// The layout of the messages of a ULog file.
#pragma once

#include "imulab/formats/recording/logs/binary.hpp"
#include "imulab/formats/recording/table.hpp"

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::recording_io {

struct UlogColumn {
  ColumnDescription description;
  NumberField field;
};

/// Definitions of messages: "sensor_gyro:uint64_t timestamp;float x;...". A field may be an array or another message.
class UlogDefinitions {
 public:
  /// Takes a definition as it stands in the file.
  void add(std::string_view definition);
  /// The numbers of a message: `x` of a number, `gyro_rad.1` of an array, `esc.1.rpm` of messages inside it. Texts and padding are left out. Throws
  /// Error for a message that is not defined, or contains itself.
  std::vector<UlogColumn> columns(const std::string& message, const std::string& file) const;

 private:
  struct Field {
    std::string type, name;
    std::size_t count = 0;  // of an array; 0: no array
  };
  void append(std::vector<UlogColumn>& columns, std::size_t& offset, const std::string& message, const std::string& before, int depth,
              const std::string& file) const;

  std::map<std::string, std::vector<Field>, std::less<>> fields_;
};

}  // namespace imulab::recording_io
