#include "imulab/core/checkpoint_folder.hpp"

#include "imulab/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <sstream>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <vector>

namespace imulab {

namespace fs = std::filesystem;

namespace {

static_assert(std::endian::native == std::endian::little, "the bytes of a checkpoint are in this order");

[[noreturn]] void fail(const fs::path& file, const char* what) {
  throw Error(fmt::format("{}: {}: {}", file.string(), what, std::generic_category().message(errno)));
}

std::string text_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

void write_all(int file, const fs::path& name, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(name, "cannot be written");
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

/// A new file with this text, whole or not at all; false: it was there. Its temporary name cannot be guessed, and a link of that name is not
/// followed.
bool create_whole(const fs::path& file, const std::string& text) {
  std::string part = file.string() + ".XXXXXX";
  const int out = ::mkstemp(part.data());
  if (out < 0) fail(file, "cannot be made");
  const mode_t mask = ::umask(0);
  ::umask(mask);
  try {
    write_all(out, part, text);
    if (::fchmod(out, 0666 & ~mask) != 0) fail(file, "cannot be made");  // mkstemp's file is private, and other users may share the work
  } catch (...) {
    ::close(out);
    ::unlink(part.c_str());
    throw;
  }
  ::close(out);
  const bool made = ::link(part.c_str(), file.c_str()) == 0;  // fails where another process was faster
  const int reason = errno;
  ::unlink(part.c_str());
  errno = reason;
  if (!made && reason != EEXIST) fail(file, "cannot be made");
  return made;
}

/// The file `identity`. Its first line is the version of the records' format.
std::string identity_file(const std::string& identity) { return "format=imulab.checkpoint/2\n" + identity + "\n"; }

/// The name of the first field of `wanted` in which another identity differs.
std::string differing_field(const std::string& wanted, const std::string& other) {
  std::istringstream one(wanted), two(other);
  for (std::string line, there; std::getline(one, line);)
    if (!std::getline(two, there) || line != there) return line.substr(0, line.find('='));
  return "identity";
}

void expect_identity(const fs::path& folder, const std::string& identity, const char* expected) {
  const fs::path file = folder / "identity";
  if (!fs::exists(file)) throw Error(fmt::format("{}: is no checkpoint; expected {}", folder.string(), expected));
  const std::string wanted = identity_file(identity), there = text_of(file);
  if (there == wanted) return;
  throw Error(fmt::format("{}: is the checkpoint of another run (its \"{}\" differs); expected {}", folder.string(), differing_field(wanted, there),
                          expected));
}

using RecordHead = std::array<std::uint64_t, 3>;  // part, size, checksum

/// The checksum of part, size and bytes: it shows damage to any of them.
std::uint64_t record_checksum(std::uint64_t part, std::string_view result) {
  const std::array<std::uint64_t, 2> head{part, result.size()};
  return checksum(result, checksum({reinterpret_cast<const char*>(head.data()), sizeof head}));
}

/// The whole records of a file from `begin` on; where they end.
std::uint64_t read_records(const fs::path& file, std::uint64_t begin, const CheckpointFolder::Sink& sink) {
  std::ifstream in(file, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(begin));
  std::error_code none;
  const std::uint64_t size = fs::file_size(file, none);
  RecordHead head{};
  while (begin + sizeof head <= size && in.read(reinterpret_cast<char*>(head.data()), sizeof head)) {
    const auto [part, bytes, sum] = head;
    if (bytes > size - begin - sizeof head) break;
    std::string result(bytes, '\0');
    if (!in.read(result.data(), static_cast<std::streamsize>(bytes)) || record_checksum(part, result) != sum) break;
    begin += sizeof head + bytes;
    sink(part, std::move(result));
  }
  return begin;
}

std::vector<fs::path> result_files(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().filename().string().starts_with("results-")) files.push_back(entry.path());
  return files;
}

}  // namespace

std::uint64_t checksum(std::string_view bytes, std::uint64_t sum) {
  for (const char c : bytes) sum = (sum ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return sum;
}

std::string checkpoint_record(std::uint64_t part, std::string_view result) {
  const RecordHead head{part, result.size(), record_checksum(part, result)};
  return std::string(reinterpret_cast<const char*>(head.data()), sizeof head).append(result);
}

CheckpointFolder::CheckpointFolder(fs::path folder, const std::string& identity) : folder_(std::move(folder)) {
  if (identity.empty()) throw Error(folder_.string() + ": the work has no identity; expected one, by which the folder knows it");
  std::error_code wrong;
  fs::create_directories(folder_, wrong);
  if (wrong) throw Error(fmt::format("{}: cannot be made: {}", folder_.string(), wrong.message()));
  if (!fs::is_directory(folder_)) throw Error(folder_.string() + ": is a file; expected a folder");
  // Until one of them has made it, processes that begin at once find nothing but what the others are about to name so.
  const fs::directory_iterator entries(folder_);
  if (std::all_of(begin(entries), end(entries), [](const auto& entry) { return entry.path().filename().string().starts_with("identity."); }))
    create_whole(folder_ / "identity", identity_file(identity));
  expect_identity(folder_, identity, "a new or an empty folder, or that of an earlier run of this command");
  fs::create_directories(folder_ / "claims", wrong);
  if (wrong) throw Error(fmt::format("{}: cannot be made: {}", (folder_ / "claims").string(), wrong.message()));
}

CheckpointFolder::~CheckpointFolder() {
  if (file_ >= 0) ::close(file_);
}

bool CheckpointFolder::claim(std::size_t chunk, int round) {
  const fs::path file = folder_ / "claims" / fmt::format("{}.{}", chunk, round);
  const int claimed = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (claimed < 0 && errno == EEXIST) return false;
  if (claimed < 0) fail(file, "cannot be made");
  ::close(claimed);
  return true;
}

void CheckpointFolder::append(std::size_t part, const std::string& result) {
  const std::lock_guard lock(one_);
  std::array<char, 256> host{};
  if (file_ < 0) ::gethostname(host.data(), host.size() - 1);
  for (int n = 0; file_ < 0; ++n) {  // a process may have had this number before
    const fs::path name = folder_ / fmt::format("results-{}-{}-{}", host.data(), ::getpid(), n);
    file_ = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0666);
    if (file_ < 0 && errno != EEXIST) fail(name, "cannot be made");
    own_ = name.filename().string();
  }
  write_all(file_, folder_, checkpoint_record(part, result));
}

void CheckpointFolder::read_new(const Sink& sink) {
  const std::lock_guard lock(one_);
  for (const fs::path& file : result_files(folder_)) {
    if (file.filename() == own_) continue;
    std::uint64_t& begin = read_[file.filename().string()];
    begin = read_records(file, begin, sink);
  }
}

void CheckpointFolder::read(const fs::path& folder, const std::string& identity, const Sink& sink) {
  expect_identity(folder, identity, "the folder of an earlier run of this command");
  for (const fs::path& file : result_files(folder)) read_records(file, 0, sink);
}

}  // namespace imulab
