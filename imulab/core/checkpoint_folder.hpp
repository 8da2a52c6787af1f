// The folder of a shared work: results of its parts, and who has begun what. Several processes read and write it at once, also over a network.
//
//   identity            the format's version, then what the results depend on (work_identity)
//   claims/C.R          chunk C was begun in round R
//   results-HOST-PID-N  records of one process: part, size, checksum of all else (64 bits each, least significant byte first), bytes
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

namespace imulab {

/// FNV-1a, 64 bits: tells damage, not malice. `sum`: of the bytes before.
std::uint64_t checksum(std::string_view bytes, std::uint64_t sum = 0xcbf29ce484222325);

/// A part's result as a file of results has it.
std::string checkpoint_record(std::uint64_t part, std::string_view result);

class CheckpointFolder {
 public:
  using Sink = std::function<void(std::size_t part, std::string result)>;

  /// Makes the folder, or joins it. Throws Error where it is another work's, or something else, and for an empty identity.
  CheckpointFolder(std::filesystem::path folder, const std::string& identity);
  ~CheckpointFolder();
  CheckpointFolder(const CheckpointFolder&) = delete;
  CheckpointFolder& operator=(const CheckpointFolder&) = delete;

  /// True if no process has begun this chunk in this round before.
  bool claim(std::size_t chunk, int round);
  /// Throws Error where it cannot be written.
  void append(std::size_t part, const std::string& result);
  /// Records since the last call, those of other processes too. A record that is not whole yet is left for the next call.
  void read_new(const Sink& sink);
  /// All of another folder. Throws Error where there is none, and where it is another work's.
  static void read(const std::filesystem::path& folder, const std::string& identity, const Sink& sink);

 private:
  std::filesystem::path folder_;
  std::mutex one_;
  int file_ = -1;  // of this process, and its name
  std::string own_;
  std::map<std::string, std::uint64_t> read_;  // how far each file was read
};

}  // namespace imulab
