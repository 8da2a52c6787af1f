#include "imulab/formats/recording/archive/zip.hpp"

#include "imulab/core/memory.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/recording/logs/binary.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>
#include <zlib.h>

namespace imulab::recording_io {
namespace {

[[noreturn]] void fail_zip(const std::string& place, const std::string& what) { throw Error(place + ": " + what + "; expected a zip archive"); }

struct ZipDirectory {
  std::uint64_t offset = 0, entries = 0;
};

/// The archive ends with the place of its directory; a comment may follow.
ZipDirectory zip_directory(std::string_view archive, const std::string& file) {
  const std::size_t end = archive.rfind("PK\5\6");
  if (end == std::string_view::npos || archive.size() - end < 22) fail_zip(file, "has no directory at its end (is it truncated?)");
  const char* p = archive.data() + end;
  ZipDirectory directory{load<std::uint32_t>(p + 16), load<std::uint16_t>(p + 10)};
  if (end >= 20 && archive.substr(end - 20, 4) == "PK\6\7") {
    const auto large = load<std::uint64_t>(p - 20 + 8);
    if (large > archive.size() || archive.size() - large < 56 || archive.substr(large, 4) != "PK\6\6") fail_zip(file, "its directory is damaged");
    directory = {load<std::uint64_t>(archive.data() + large + 48), load<std::uint64_t>(archive.data() + large + 32)};
  }
  return directory;
}

/// Sizes that do not fit 32 bits stand in a field of their own.
void read_large_sizes(std::string_view extra, std::uint64_t& bytes, std::uint64_t& stored, std::uint64_t& offset) {
  constexpr std::uint64_t elsewhere = std::numeric_limits<std::uint32_t>::max();
  while (extra.size() >= 4) {
    const auto id = load<std::uint16_t>(extra.data());
    const std::size_t size = load<std::uint16_t>(extra.data() + 2);
    if (size > extra.size() - 4) return;
    std::string_view field = extra.substr(4, size);
    for (std::uint64_t* value : {&bytes, &stored, &offset})
      if (id == 1 && *value == elsewhere && field.size() >= 8) {
        *value = load<std::uint64_t>(field.data());
        field.remove_prefix(8);
      }
    extra.remove_prefix(4 + size);
  }
}

/// Reads the entry at `at` and moves on to the next; nothing for a member that is neither stored nor deflated.
std::optional<ZipMember> zip_entry(std::string_view archive, std::size_t& at, const std::string& file) {
  if (at > archive.size() || archive.size() - at < 46 || archive.substr(at, 4) != "PK\1\2") fail_zip(file, "its directory is damaged");
  const char* p = archive.data() + at;
  const std::size_t name = load<std::uint16_t>(p + 28), extra = load<std::uint16_t>(p + 30), comment = load<std::uint16_t>(p + 32);
  if (archive.size() - at - 46 < name + extra + comment) fail_zip(file, "its directory is damaged");
  std::uint64_t stored = load<std::uint32_t>(p + 20), bytes = load<std::uint32_t>(p + 24), offset = load<std::uint32_t>(p + 42);
  read_large_sizes({p + 46 + name, extra}, bytes, stored, offset);
  at += 46 + name + extra + comment;

  ZipMember member;
  member.name.assign(p + 46, name);
  const auto method = load<std::uint16_t>(p + 10);
  if ((method != 0 && method != 8) || (load<std::uint16_t>(p + 8) & 1) != 0) return std::nullopt;  // other methods, encrypted
  if (offset > archive.size() || archive.size() - offset < 30 || archive.substr(offset, 4) != "PK\3\4")
    fail_zip(file, fmt::format("{} is not where the directory says", member.name));
  const char* local = archive.data() + offset;
  const std::size_t begin = offset + 30 + load<std::uint16_t>(local + 26) + load<std::uint16_t>(local + 28);
  if (begin > archive.size() || archive.size() - begin < stored) fail_zip(file, fmt::format("{} reaches beyond the end of the file", member.name));
  member.deflated = method == 8;
  member.stored = archive.substr(begin, stored);
  member.check = load<std::uint32_t>(p + 16);
  if (!std::in_range<std::size_t>(bytes))
    throw Error(fmt::format("{}: {} has {} bytes; expected less than 4 GiB on a 32-bit system", file, member.name, bytes));
  member.bytes = static_cast<std::size_t>(bytes);
  constexpr std::uint64_t best_ratio = 1032;  // of deflate
  if (member.deflated ? bytes / best_ratio > stored : bytes != stored) fail_zip(file, fmt::format("{} has impossible sizes", member.name));
  return member;
}

}  // namespace

std::string_view first_member(std::string_view head) {
  constexpr std::size_t before_name = 30;
  if (!head.starts_with("PK\3\4") || head.size() < before_name) return {};
  return head.substr(before_name, load<std::uint16_t>(head.data() + 26));
}

std::vector<ZipMember> zip_members(std::string_view archive, const std::string& file) {
  const ZipDirectory directory = zip_directory(archive, file);
  std::vector<ZipMember> members;
  if (directory.offset > archive.size()) fail_zip(file, "its directory is damaged");
  auto at = static_cast<std::size_t>(directory.offset);
  for (std::uint64_t i = 0; i < directory.entries; ++i)
    if (auto member = zip_entry(archive, at, file)) members.push_back(std::move(*member));
  return members;
}

struct ZipReader::Inflater {
  z_stream stream{};
  ~Inflater() { inflateEnd(&stream); }
};

ZipReader::ZipReader(const ZipMember& member, std::string place) : member_(member), place_(std::move(place)) {
  if (!member.deflated) return;
  inflater_ = std::make_unique<Inflater>();
  if (inflateInit2(&inflater_->stream, -MAX_WBITS) != Z_OK) throw Error(place_ + ": cannot be read: no memory");
}

ZipReader::~ZipReader() = default;

void ZipReader::read(char* to, std::size_t size) {
  if (!member_.deflated) {
    if (member_.stored.size() - at_ < size) fail_zip(place_, "ends too early");
    std::memcpy(to, member_.stored.data() + at_, size);
    at_ += size;
    return;
  }
  constexpr std::size_t piece = 1 << 24;  // zlib counts in 32 bits
  z_stream& stream = inflater_->stream;
  while (size > 0) {
    const std::size_t in = std::min(piece, member_.stored.size() - at_), out = std::min(piece, size);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(member_.stored.data() + at_));
    stream.avail_in = static_cast<uInt>(in);
    stream.next_out = reinterpret_cast<Bytef*>(to);
    stream.avail_out = static_cast<uInt>(out);
    const int state = inflate(&stream, Z_NO_FLUSH);
    const std::size_t got = out - stream.avail_out;
    at_ += in - stream.avail_in;
    check_ = recording_io::crc32({to, got}, check_);
    to += got;
    size -= got;
    if (size == 0) return;
    if (state != Z_OK || (got == 0 && in == stream.avail_in))
      fail_zip(place_, state == Z_STREAM_END ? "ends too early" : "its compressed data are damaged");
  }
}

void ZipReader::expect_intact() const {
  if (member_.deflated && check_ != member_.check) fail_zip(place_, "its check sum is wrong: the data are damaged");
}

std::string unpacked(const ZipMember& member, const std::string& place) {
  constexpr std::size_t piece = 1 << 20;
  const std::size_t size = member.bytes;
  expect_memory(2 * static_cast<double>(size), place + ": unpacking it");
  ZipReader reader(member, place);
  std::string text;
  for (std::size_t done = 0; done < size; done = text.size()) {
    text.resize(std::min(size, done + piece));
    reader.read(text.data() + done, text.size() - done);
  }
  reader.expect_intact();
  return text;
}

namespace {

constexpr std::uint16_t zip64 = 1, version_of_zip64 = 45, version_2 = 20;
constexpr std::uint32_t in_zip64 = std::numeric_limits<std::uint32_t>::max();

/// A number in 32 bits, or a mark that says that it is among those in 64.
void append_number(std::string& out, std::uint64_t number, std::uint64_t large, std::string& numbers) {
  const bool fits = number < large && number < in_zip64;
  recording_io::append<std::uint32_t>(out, fits ? static_cast<std::uint32_t>(number) : in_zip64);
  if (!fits) recording_io::append<std::uint64_t>(numbers, number);
}

void append_field(std::string& out, const std::string& numbers) {
  if (numbers.empty()) return;
  recording_io::append<std::uint16_t>(out, zip64);
  recording_io::append<std::uint16_t>(out, static_cast<std::uint16_t>(numbers.size()));
  out += numbers;
}

}  // namespace

void ZipWriter::write(std::string_view bytes) {
  write_(bytes);
  offset_ += bytes.size();
}

void ZipWriter::add(const std::string& name, std::string_view content) {
  const std::uint32_t check = recording_io::crc32(content);
  const std::uint64_t offset = offset_;
  // A head before the member and one in the directory, which begin alike.
  for (const bool listed : {false, true}) {
    std::string head, sizes, numbers, end;
    append_number(sizes, content.size(), large_, numbers);
    append_number(sizes, content.size(), large_, numbers);
    if (listed) {
      end.append(10, '\0');  // comment, disk, attributes
      append_number(end, offset, large_, numbers);
    }
    const std::uint16_t version = numbers.empty() ? version_2 : version_of_zip64;
    if (listed) recording_io::append<std::uint16_t>(head, version);
    for (const std::uint16_t word :
         {version, std::uint16_t{0}, std::uint16_t{0}, std::uint16_t{0}, std::uint16_t{0x21}})  // no flags, stored, 1980-01-01
      recording_io::append<std::uint16_t>(head, word);
    recording_io::append<std::uint32_t>(head, check);
    head += sizes;
    recording_io::append<std::uint16_t>(head, static_cast<std::uint16_t>(name.size()));
    recording_io::append<std::uint16_t>(head, static_cast<std::uint16_t>(numbers.empty() ? 0 : 4 + numbers.size()));
    head += end + name;
    append_field(head, numbers);
    if (listed)
      directory_ += "PK\x01\x02" + head;
    else
      write("PK\x03\x04" + head), write(content);
  }
  ++members_;
}

void ZipWriter::finish() {
  const std::uint64_t offset = offset_;
  constexpr std::uint16_t most_members = std::numeric_limits<std::uint16_t>::max();
  write(directory_);
  std::string sizes, numbers, end;
  append_number(sizes, directory_.size(), large_, numbers);
  append_number(sizes, offset, large_, numbers);
  const auto members = static_cast<std::uint16_t>(std::min<std::uint64_t>(members_, most_members));
  if (!numbers.empty() || members_ >= most_members) {
    end += "PK\x06\x06";
    recording_io::append<std::uint64_t>(end, 44);  // bytes that follow
    for (const std::uint16_t version : {version_of_zip64, version_of_zip64}) recording_io::append<std::uint16_t>(end, version);
    recording_io::append<std::uint64_t>(end, 0);  // disks
    for (const std::uint64_t number : {members_, members_, std::uint64_t{directory_.size()}, offset})
      recording_io::append<std::uint64_t>(end, number);
    end += "PK\x06\x07";
    recording_io::append<std::uint32_t>(end, 0);
    recording_io::append<std::uint64_t>(end, offset + directory_.size());
    recording_io::append<std::uint32_t>(end, 1);
  }
  end += "PK\x05\x06";
  recording_io::append<std::uint32_t>(end, 0);  // disks
  for (int k = 0; k < 2; ++k) recording_io::append<std::uint16_t>(end, members);
  end += sizes;
  recording_io::append<std::uint16_t>(end, 0);
  write(end);
}

}  // namespace imulab::recording_io
