#include "imulab/core/checkpoint_file.hpp"

#include "imulab/core/sealed.hpp"
#include "imulab/core/shared_work.hpp"
#include "imulab/error.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <fcntl.h>
#include <fstream>
#include <sys/file.h>
#include <system_error>
#include <unistd.h>

namespace imulab {

namespace {

/// A process died over its header; what else is there is somebody's.
bool begins_as(const std::filesystem::path& file, std::uint64_t size, std::string_view header) {
  if (size >= header.size()) return false;
  std::string bytes(size, 0);
  return std::ifstream(file, std::ios::binary).read(bytes.data(), static_cast<std::streamsize>(size)) && header.starts_with(bytes);
}

}  // namespace

CheckpointFile::CheckpointFile(const std::filesystem::path& folder, const std::string& identity, const Sink& sink) : file_(folder / "results") {
  if (identity.empty()) throw Error(folder.string() + ": the work has no identity; expected one, by which the folder knows it");
  std::error_code wrong;
  create_directories(folder, wrong);
  if (wrong || (!exists(file_) && !is_empty(folder, wrong)))
    throw Error(fmt::format("{}: {}; expected a new or an empty folder, or that of an earlier run of this command", folder.string(),
                            wrong ? "cannot be made: " + wrong.message() : "is no checkpoint"));
  open_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (open_ < 0) fail("cannot be opened: " + std::generic_category().message(errno));
  try {
    if (::flock(open_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
      fail("another process works on it; expected a folder for each (--part K/N divides a work)");
    read(identity, sink);
  } catch (...) {
    ::close(open_);
    throw;
  }
}

CheckpointFile::~CheckpointFile() { ::close(open_); }

void CheckpointFile::fail(const std::string& what) const { throw Error(fmt::format("{}: {}", file_.parent_path().string(), what)); }

/// What is whole; the rest is cut off, also of a header.
void CheckpointFile::read(const std::string& identity, const Sink& sink) {
  SealedWriter header;
  header.text("imulab.checkpoint/3"), header.text(identity), header.seal();
  std::ifstream in(file_, std::ios::binary);
  const std::uint64_t size = file_size(file_);
  SealedReader reader(in, size);
  std::string format, there;
  const bool named = reader.text(format) && reader.text(there) && reader.seal();
  if (!named && !begins_as(file_, size, header.bytes())) fail("is no checkpoint of this version; expected a new or an empty folder");
  if (named && there != identity)
    fail(fmt::format(
        "is the checkpoint of another run (its \"{}\" differs); expected a new or an empty folder, or that of an earlier run of this command",
        differing_field(identity, there)));
  std::uint64_t behind = named ? reader.left() : size, block = 0;
  for (bool whole = named; whole;) {
    std::string result;
    SealedReader one(in, behind);
    whole = one.number(block) && one.text(result) && one.seal();
    if (whole) behind = one.left(), sink(block, std::move(result));
  }
  if (behind > 0 && ::ftruncate(open_, static_cast<off_t>(size - behind)) != 0) fail("cannot be cut");
  if (!named) write(header.bytes());
}

void CheckpointFile::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(open_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("cannot be written: " + std::generic_category().message(errno));
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void CheckpointFile::append(std::size_t block, const std::string& result) {
  SealedWriter record;
  record.number(block), record.text(result), record.seal();
  const std::lock_guard lock(one_);
  write(record.bytes());
}

}  // namespace imulab
