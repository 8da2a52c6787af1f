// Files and streams for reading.
#include "imulab/error.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/formats/text/unfinished.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <fcntl.h>
#include <list>
#include <mutex>
#include <optional>
#include <poll.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace imulab {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail_to_read(const fs::path& path, const char* what) {
  throw Error(fmt::format("{}: {}{}{}", input_name(path), what, errno != 0 ? ": " : "", errno != 0 ? std::strerror(errno) : ""));
}

std::string size_text(std::uint64_t bytes) {
  return bytes >= std::uint64_t{1} << 30 ? fmt::format("{} GiB", bytes >> 30) : fmt::format("{} MiB", bytes >> 20);
}

struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

using SteadyClock = std::chrono::steady_clock;

/// True if bytes, or the end, can be read before this time.
bool wait_for_more(int descriptor, SteadyClock::time_point until) {
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - SteadyClock::now()).count();
    pollfd waiting{descriptor, POLLIN, 0};
    const int ready = left <= 0 ? 0 : ::poll(&waiting, 1, static_cast<int>(std::min<std::int64_t>(left, 1'000'000)));
    if (ready < 0 && errno == EINTR) continue;
    if (ready != 0 || left <= 0) return ready != 0;
  }
}

/// True for the first bytes of a text, also of one in two bytes a character.
bool begins_like_text(std::string_view head) {
  const bool two_bytes = head.starts_with("\xFF\xFE") || head.starts_with("\xFE\xFF");
  return two_bytes || head.find('\0') == std::string_view::npos;
}

/// A stream to its end, or to a time; of one that is no text, which may have no end, the first bytes.
StreamText read_open_stream(int descriptor, const fs::path& path, std::size_t longest, std::optional<SteadyClock::time_point> until) {
  constexpr std::size_t piece = 1 << 16;
  StreamText stream;
  std::string& text = stream.text;
  for (std::size_t size = 0;;) {
    if (until && !wait_for_more(descriptor, *until)) {
      stream.ended = false;
      return stream;
    }
    text.resize(size + piece);
    const ssize_t n = ::read(descriptor, text.data() + size, piece);
    if (n < 0 && errno != EINTR && !(until && errno == EAGAIN)) fail_to_read(path, "cannot be read");
    size += static_cast<std::size_t>(std::max<ssize_t>(n, 0));
    if (size > longest) throw Error(fmt::format("{}: is longer than {}; expected less", input_name(path), size_text(longest)));
    text.resize(size);
    if (n == 0 || (until && size <= piece && !begins_like_text(text))) return stream;
  }
}

/// A pipe was opened without waiting for its writer; from here on it waits for data. Returns what came first. Throws Error where nobody opens its
/// other end, and where nothing comes from a device.
std::string expect_writer(int descriptor, const fs::path& path) {
  constexpr int longest_s = 5;
  struct stat status {};
  const bool device = ::fstat(descriptor, &status) == 0 && S_ISCHR(status.st_mode);
  const auto until = SteadyClock::now() + std::chrono::seconds(longest_s);
  std::string first;
  while (!wait_for_more(descriptor, std::min(until, SteadyClock::now() + std::chrono::milliseconds(100)))) {
    char byte = 0;  // a pipe without a writer is at its end, one with a silent writer is not
    const ssize_t n = ::read(descriptor, &byte, 1);
    if (n > 0) first = byte;
    if (n > 0 || (n < 0 && errno == EAGAIN && !device)) break;
    if (SteadyClock::now() < until) continue;
    throw Error(device ? fmt::format("{}: nothing comes from this device; expected data within {} s", path.string(), longest_s)
                       : fmt::format("{}: nobody writes to this pipe; expected a writer within {} s", path.string(), longest_s));
  }
  ::fcntl(descriptor, F_SETFL, ::fcntl(descriptor, F_GETFL) & ~O_NONBLOCK);
  return first;
}

/// A regular file's whole text.
std::string read_open_file(int descriptor, const fs::path& path, std::size_t size) {
  std::string text(size, '\0');
  for (std::size_t done = 0; done < size;) {
    const ssize_t n = ::read(descriptor, text.data() + done, size - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail_to_read(path, "cannot be read");
    if (n == 0) throw Error(lost_text(path));
    done += static_cast<std::size_t>(n);
  }
  return text;
}

}  // namespace

namespace {

struct KeptText {
  fs::path name;
  std::shared_ptr<const std::string> text;
};
std::mutex kept_mutex;
std::list<KeptText> kept_texts;

std::shared_ptr<const std::string> kept_text(const fs::path& path) {
  const std::lock_guard lock(kept_mutex);
  const auto kept = std::find_if(kept_texts.begin(), kept_texts.end(), [&](const KeptText& k) { return k.name == path; });
  return kept != kept_texts.end() ? kept->text : nullptr;
}

}  // namespace

void keep_as_file(const fs::path& name, std::string text) {
  const std::lock_guard lock(kept_mutex);
  kept_texts.push_back({name, std::make_shared<const std::string>(std::move(text))});
}

KeptFile::KeptFile(fs::path name, std::string text) : text_(std::make_shared<const std::string>(std::move(text))) {
  const std::lock_guard lock(kept_mutex);
  kept_texts.push_back({std::move(name), text_});
}

KeptFile::~KeptFile() {
  const std::lock_guard lock(kept_mutex);
  kept_texts.remove_if([this](const KeptText& kept) { return kept.text == text_; });
}

bool is_kept(const fs::path& path) { return kept_text(path) != nullptr; }

void forget_kept() {
  const std::lock_guard lock(kept_mutex);
  kept_texts.clear();
}

bool is_stream(const fs::path& path) {
  std::error_code none;
  const fs::file_status status = fs::status(path, none);
  return path == "-" || (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status));
}

StreamText read_stream(const fs::path& path, double longest_s) {
  errno = 0;
  const auto until = SteadyClock::now() + std::chrono::duration_cast<SteadyClock::duration>(std::chrono::duration<double>(longest_s));
  if (path == "-") return read_open_stream(STDIN_FILENO, path, longest_stream, until);
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)};  // a pipe without a writer must not wait here
  if (file.fd < 0) fail_to_read(path, "cannot be opened");
  std::string first = expect_writer(file.fd, path);
  StreamText stream = read_open_stream(file.fd, path, longest_stream, until);
  stream.text.insert(0, first);
  return stream;
}

MappedFile::MappedFile(const fs::path& path, Content content) {
  const bool settings = content == Content::settings;
  const std::size_t longest = settings ? longest_settings : longest_stream;
  errno = 0;
  kept_ = kept_text(path);
  if (kept_) {
    data_ = kept_->data(), size_ = kept_->size();
    return;
  }
  if (path == "-") {
    text_ = read_open_stream(STDIN_FILENO, path, longest, std::nullopt).text;
    return;
  }
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)};
  if (file.fd < 0) fail_to_read(path, "cannot be opened");
  struct stat status {};
  if (::fstat(file.fd, &status) != 0) fail_to_read(path, "cannot be read");
  if (S_ISDIR(status.st_mode)) throw Error(path.string() + ": is a folder; expected a file");
  if (!S_ISREG(status.st_mode)) {
    text_ = expect_writer(file.fd, path);
    text_ += read_open_stream(file.fd, path, longest, std::nullopt).text;
    return;
  }
  if (!std::in_range<std::size_t>(status.st_size))
    throw Error(fmt::format("{}: has {}; expected {} on a 32-bit system", path.string(), size_text(static_cast<std::uint64_t>(status.st_size)),
                            "less than 4 GiB"));
  const auto size = static_cast<std::size_t>(status.st_size);
  if (settings && size > longest) throw Error(fmt::format("{}: is longer than {}; expected less", path.string(), size_text(longest)));
  if (size <= most_copied) {
    text_ = read_open_file(file.fd, path, size);
    return;
  }
  void* mapped = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.fd, 0);
  if (mapped == MAP_FAILED) fail_to_read(path, "cannot be read");
  ::madvise(mapped, size, MADV_SEQUENTIAL);
  data_ = static_cast<const char*>(mapped), size_ = size;
  message_ = "imulab: " + printable(lost_text(path)) + "\n";
  begin_mapped(data_, size_, message_);
}

MappedFile::~MappedFile() {
  if (message_.empty()) return;  // it is not mapped
  end_mapped(data_);
  ::munmap(const_cast<char*>(data_), size_);
}

void MappedFile::release(std::size_t offset) const {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  if (!message_.empty()) ::madvise(const_cast<char*>(data_), std::min(offset, size_) / page * page, MADV_DONTNEED);
}

}  // namespace imulab
