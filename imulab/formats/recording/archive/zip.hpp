// Members of a zip archive, stored or deflated (PKWARE APPNOTE 6.3, with Zip64).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
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

/// A member unpacked into memory, which grows with what is found.
std::string unpacked(const ZipMember& member, const std::string& place);

/// Writes an archive of members that are stored. Sizes and places that do not fit 32 bits are in the fields of Zip64, so it may be of any size.
class ZipWriter {
 public:
  /// `write` gets the bytes, piece after piece. `before`: the file has as many before them. `large`: numbers from here on are in fields of 64 bits.
  explicit ZipWriter(std::function<void(std::string_view)> write, std::uint64_t before = 0,
                     std::uint64_t large = std::numeric_limits<std::uint32_t>::max())
      : write_(std::move(write)), offset_(before), large_(large) {}
  void add(const std::string& name, std::string_view content);
  void finish();

 private:
  void write(std::string_view bytes);

  std::function<void(std::string_view)> write_;
  std::uint64_t offset_, large_, members_ = 0;
  std::string directory_;
};

}  // namespace imulab::recording_io
