#include "imulab/formats/recording/child/read_program.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/recording/bag/bytes.hpp"
#include "imulab/formats/recording/child/child_tables.hpp"
#include "imulab/formats/recording/logs/binary.hpp"
#include "imulab/version.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <dlfcn.h>
#include <link.h>
#include <new>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <variant>

namespace imulab::recording_io {
namespace {

/// The descriptor of a request, closed at the end.
class RequestFile {
 public:
  explicit RequestFile(int number) : number_(number) {}
  ~RequestFile() {
    if (number_ >= 0) ::close(number_);
  }
  RequestFile(const RequestFile&) = delete;
  RequestFile& operator=(const RequestFile&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

void append_text(std::string& out, std::string_view text) {
  recording_io::append<std::uint64_t>(out, text.size());
  out += text;
}

/// The program, or the shared module, that this code is in.
std::filesystem::path own_file() {
  static const char here = 0;
  Dl_info info{};
  void* map = nullptr;
  if (::dladdr1(&here, &info, &map, RTLD_DL_LINKMAP) != 0 && map != nullptr)
    if (const char* const name = static_cast<link_map*>(map)->l_name; name != nullptr && *name != '\0') return std::filesystem::absolute(name);
  std::error_code unknown;
  return std::filesystem::read_symlink("/proc/self/exe", unknown);
}

/// A place where imulab-read may be, and why the file that is there is not taken; empty where it is, or none is there.
struct ReadPlace {
  std::filesystem::path program;
  std::string why;
};

ReadPlace read_place(const std::filesystem::path& program) {
  struct stat status {};
  if (::stat(program.c_str(), &status) != 0) return {program, errno == ENOENT || errno == ENOTDIR ? "" : std::generic_category().message(errno)};
  if (!S_ISREG(status.st_mode)) return {program, "is no file"};
  return {program, ::access(program.c_str(), X_OK) == 0 ? "" : "may not be run"};
}

/// The places in the folders from that of `own` up. Others than root and the owner of `own` may have put a program there, unless it and its folders
/// are theirs.
std::vector<ReadPlace> own_places(const std::filesystem::path& own) {
  struct stat self {};
  std::vector<ReadPlace> places;
  if (::stat(own.c_str(), &self) != 0) return places;
  for (std::filesystem::path folder = own.parent_path();; folder = folder.parent_path()) {
    ReadPlace place = read_place(folder / "libexec/imulab-read");
    struct stat status {};
    if (::stat(place.program.c_str(), &status) == 0)
      for (const std::filesystem::path& part : {folder, folder / "libexec", place.program}) {
        if (!place.why.empty() || ::stat(part.c_str(), &status) != 0) break;
        if ((status.st_mode & S_IWOTH) != 0) place.why = fmt::format("everybody may write to {}", part.string());
        if (status.st_uid != 0 && status.st_uid != self.st_uid)
          place.why = fmt::format("{} belongs to neither root nor the owner of {}", part.string(), own.filename().string());
      }
    places.push_back(std::move(place));
    if (folder == folder.parent_path()) return places;
  }
}

/// Starts imulab-read with a request, which it reads from memory: there is nobody to wait for.
pid_t start_read_program(const std::filesystem::path& program, const std::string& request, int pipe, int memory) {
  const RequestFile text(beyond_standard(::memfd_create("imulab", MFD_CLOEXEC)));
  if (text.number() < 0 || ::pwrite(text.number(), request.data(), request.size(), 0) != static_cast<ssize_t>(request.size())) return -1;
  posix_spawn_file_actions_t actions;
  if (::posix_spawn_file_actions_init(&actions) != 0) throw std::bad_alloc();
  std::vector<std::string> words{program.string()};
  int why = 0;
  for (const int number : {pipe, memory, text.number()}) {
    if (why == 0) why = ::posix_spawn_file_actions_adddup2(&actions, number, number);  // it stays open there
    words.push_back(std::to_string(number));
  }
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t id = -1;
  if (why == 0) why = ::posix_spawn(&id, program.c_str(), &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  errno = why;
  return why == 0 ? id : -1;
}

/// What starts imulab-read with a request.
StartChild starter(const ProgramFormat& format, const ReadRequest& request) {
  const std::string file = request.task.file.string();
  const auto options = build().options;
  if (std::none_of(options.begin(), options.end(), [&](const BuildOption& o) { return o.name == format.name && o.built_with; }))
    throw Error(fmt::format("{}: is {}, and this imulab was built without it; expected another format, or a build with {} installed", file,
                            format.noun, format.package));
  std::filesystem::path program;
  try {
    program = find_read_program(own_file());
  } catch (const Error& e) {
    throw Error(fmt::format("{}: is {}: {}", file, format.noun, e.what()));
  }
  return [program, text = to_text(request)](int pipe, int memory) { return start_read_program(program, text, pipe, memory); };
}

}  // namespace

std::string to_text(const ReadRequest& request) {
  std::string out;
  append_text(out, build().version);
  append_text(out, request.format);
  append_text(out, request.task.file.string());
  append_text(out, request.task.library);
  for (const std::uint64_t n :
       {request.task.limits.memory_bytes, std::uint64_t{request.task.limits.computing_s}, std::uint64_t{request.task.limits.wall_s},
        static_cast<std::uint64_t>(request.task.parent), std::uint64_t{request.describes}})
    recording_io::append<std::uint64_t>(out, n);
  append_text(out, request.topic);
  recording_io::append<std::uint64_t>(out, request.columns.size());
  for (const Column& column : request.columns) {
    recording_io::append<std::uint64_t>(out, column.index());
    if (const auto* const name = std::get_if<std::string>(&column))
      append_text(out, *name);
    else
      recording_io::append<std::uint64_t>(out, static_cast<std::uint64_t>(std::get<int>(column)));
  }
  return out;
}

ReadRequest read_request(std::string_view text) try {
  bag::Bytes from(text);
  const auto number = [&] { return from.number<std::uint64_t>(); };
  const auto counted = [&] { return std::string(from.take(number())); };
  ReadRequest request;
  if (const std::string version = counted(); version != build().version)
    throw Error(fmt::format("imulab-read {} serves no imulab {}; expected both of one version", build().version, version));
  request.format = counted();
  request.task.file = counted();
  request.task.library = counted();
  request.task.limits.memory_bytes = number();
  request.task.limits.computing_s = static_cast<unsigned>(number());
  request.task.limits.wall_s = static_cast<unsigned>(number());
  request.task.parent = static_cast<pid_t>(number());
  request.describes = number() != 0;
  request.topic = counted();
  for (std::uint64_t left = number(); left > 0; --left)
    if (number() == 0)
      request.columns.emplace_back(counted());
    else
      request.columns.emplace_back(static_cast<int>(number()));
  return request;
} catch (const bag::Damaged&) {
  throw Error("imulab-read: a request of another form; expected imulab to run it, which reads HDF5 and MATLAB files by it");
}

std::vector<TableDescription> describe_by_program(const ProgramFormat& format, const TableRequest& request) {
  const ChildTask task = child_task(request.file, std::string(format.library));
  return describe_in_child(task, starter(format, {.format = std::string(format.name), .task = task, .describes = true}));
}

TableRows columns_by_program(const ProgramFormat& format, const TableRequest& request, const std::vector<Column>& columns) {
  const ChildTask task = child_task(request.file, std::string(format.library));
  return columns_in_child(
      task, columns.size(),
      starter(format, {.format = std::string(format.name), .task = task, .describes = false, .topic = request.topic, .columns = columns}));
}

std::filesystem::path find_read_program(const std::filesystem::path& own) {
  std::vector<ReadPlace> places = own_places(own);
  places.push_back(read_place(std::filesystem::path(build().programs) / "imulab-read"));
  places.push_back(read_place("/usr/libexec/imulab-read"));
  if (const char* const named = std::getenv("IMULAB_READ"); named != nullptr && *named != '\0') places.push_back(read_place(named));
  std::string where;
  for (const ReadPlace& place : places) {
    if (place.why.empty() && ::access(place.program.c_str(), X_OK) == 0) return place.program;
    where += (where.empty() ? "" : ", ") + place.program.string() + (place.why.empty() ? "" : ": " + place.why);
  }
  throw Error(
      fmt::format("the program imulab-read, which reads it, was not found ({}); expected it in libexec beside imulab, as packages install it, or "
                  "its place in the environment variable IMULAB_READ",
                  where));
}

}  // namespace imulab::recording_io
