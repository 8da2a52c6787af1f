// A file that nobody else sees: it has no name, and is gone when it is closed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace imulab {

/// Where temporary files go: TMPDIR, else /var/tmp (/tmp is often memory).
const char* temporary_place();

/// Throws Error "PLACE: a temporary file cannot be WHAT: ..." with the system's reason.
[[noreturn]] void temporary_failed(const char* what, int error);

/// Bytes that are appended, read anywhere and taken back from the end. All throw Error with the place and the reason of the system.
class TemporaryFile {
 public:
  TemporaryFile();
  ~TemporaryFile();
  TemporaryFile(TemporaryFile&& from) noexcept;
  TemporaryFile& operator=(TemporaryFile&& from) noexcept;

  void append(std::span<const std::byte> bytes);
  void read(std::uint64_t place, std::span<std::byte> to) const;
  /// Reads the last bytes, and cuts them off.
  void take_back(std::span<std::byte> to);
  std::uint64_t size() const { return size_; }
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace imulab
