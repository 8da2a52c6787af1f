// Members of a zip archive, stored or deflated (PKWARE APPNOTE 6.3, with Zip64).
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::recording_io {

struct ZipMember {
  std::string name;
  std::string_view stored;  ///< as it stands in the archive
  std::size_t bytes = 0;    ///< of its content
  std::uint32_t check = 0;  ///< CRC-32 of its content
  bool deflated = false;    ///< else stored is the content
};

/// The name of an archive's first member, from its first bytes; empty where it is none.
std::string_view first_member(std::string_view head);

/// Throws Error with `file` where the archive is damaged. Members of another method are left out.
std::vector<ZipMember> zip_members(std::string_view archive, const std::string& file);

/// Reads a member from its begin on. `place`: for messages.
class ZipReader {
 public:
  ZipReader(const ZipMember& member, std::string place);
  ~ZipReader();
  ZipReader(const ZipReader&) = delete;
  ZipReader& operator=(const ZipReader&) = delete;

  /// Exactly `size` bytes. Throws Error where the member is damaged or ends before.
  void read(char* to, std::size_t size);
  /// At the end of the content: throws Error where its check sum is not the archive's.
  void expect_intact() const;

 private:
  struct Inflater;
  const ZipMember& member_;
  std::string place_;
  std::size_t at_ = 0;
  std::uint32_t check_ = 0;
  std::unique_ptr<Inflater> inflater_;
};

/// A member, or its first `most` bytes, unpacked into memory, which grows with what is found.
std::string unpacked(const ZipMember& member, const std::string& place, std::uint64_t most = std::numeric_limits<std::uint64_t>::max());

}  // namespace imulab::recording_io
