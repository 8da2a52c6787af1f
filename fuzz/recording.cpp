// Any bytes as a recording of one format: an Error is good, anything else is a finding.
#include "imulab/core/error.hpp"
#include "imulab/inspection/inspection.hpp"
#include "imulab/io/recording/format.hpp"
#include "imulab/io/recording/signals.hpp"

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <sys/mman.h>
#include <unistd.h>

namespace {

using namespace imulab;

/// The bytes as a file that only memory has.
class MemoryFile {
 public:
  MemoryFile(const std::uint8_t* data, std::size_t size) : descriptor_(::memfd_create("recording", 0)) {
    if (descriptor_ < 0 || ::write(descriptor_, data, size) != static_cast<ssize_t>(size)) std::abort();
  }
  ~MemoryFile() { ::close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  std::filesystem::path path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

const RecordingFormat& fuzzed_format() {
  for (const RecordingFormat& format : recording_formats())
    if (format.name.find(FUZZED_FORMAT) != std::string_view::npos) return format;
  std::abort();
}

/// Every table and column, as far as the file gives them.
void read_all(const RecordingFormat& format, TableRequest request) {
  const auto tables = format.describe(request);
  for (const auto& table : tables) {
    std::vector<Column> columns;
    for (std::size_t i = 0; i < table.columns.size() && i < 16; ++i) columns.emplace_back(static_cast<int>(i) + 1);
    request.topic = table.name;
    try {
      format.columns(request, columns);
    } catch (const Error&) {
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const RecordingFormat& format = fuzzed_format();
  const MemoryFile file(data, size);
  TableRequest request{file.path(), "", format.of_layout ? "+16 <f8 u2 x1 >i4x3" : ""};
  try {
    read_all(format, request);
  } catch (const Error&) {
  }
  if (std::string_view(FUZZED_FORMAT) == "CSV") {
    try {
      inspect(signals_of_text("fuzzed", {reinterpret_cast<const char*>(data), size}));
    } catch (const Error&) {
    }
  }
  return 0;
}
