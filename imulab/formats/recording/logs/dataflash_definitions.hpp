// The layout of the messages of an ArduPilot DataFlash log.
#pragma once

#include "imulab/formats/recording/logs/binary.hpp"
#include "imulab/formats/recording/table.hpp"

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::recording_io {

/// A label of a message.
struct DataflashField {
  std::string name;
  char format = 0;         ///< of the log: 'f', 'Q' ...
  std::size_t offset = 0;  ///< in the message, with its head of three bytes
};

inline constexpr std::size_t no_instance = 65535;  ///< beyond every message

struct DataflashMessage {
  std::string name;
  std::size_t length = 0;  ///< with its head; 0: not defined
  std::vector<DataflashField> fields;
  std::string units, multipliers;      ///< a character for each field, of FMTU; may be empty
  std::size_t instance = no_instance;  ///< offset of the sensor's number
};

struct DataflashColumn {
  ColumnDescription description;
  NumberField field;
  double divisor = 1;
};

/// The message that defines messages: its number, and its length with the head.
inline constexpr unsigned char dataflash_fmt = 128;
inline constexpr std::size_t dataflash_fmt_length = 89;

class DataflashDefinitions {
 public:
  DataflashDefinitions() { brief_[dataflash_fmt] = {dataflash_fmt_length, no_instance, true}; }
  /// Takes a message that defines others (FMT, FMTU, UNIT, MULT): all of its bytes, of a message defined before. The message whose instances it
  /// defines, where it does.
  std::optional<unsigned char> add(std::string_view message);
  const DataflashMessage& operator[](unsigned char id) const { return messages_[id]; }
  // The properties that are needed of every message of a log.
  std::size_t length(unsigned char id) const { return brief_[id].length; }
  std::size_t instance_offset(unsigned char id) const { return brief_[id].instance; }
  bool defines_others(unsigned char id) const { return brief_[id].defines_others; }
  /// The numbers of a message, with the divisors that bring them to their units. Times in microseconds stay so: they are exact.
  std::vector<DataflashColumn> columns(unsigned char id) const;

 private:
  struct Brief {
    std::uint16_t length = 0, instance = no_instance;
    bool defines_others = false;
  };
  void define(std::string_view message);

  std::array<DataflashMessage, 256> messages_;
  std::array<Brief, 256> brief_;
  std::map<char, std::string> units_;
  std::map<char, double> multipliers_;
};

}  // namespace imulab::recording_io
