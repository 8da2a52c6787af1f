// The folder in which one process keeps the finished blocks of a work, so that the same work goes on after any end.
//
//   results   the format's name, the identity of the work and a seal; then blocks: number, result, seal (core/sealed.hpp)
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>

namespace imulab {

class CheckpointFile {
 public:
  using Sink = std::function<void(std::size_t block, std::string result)>;

  /// Makes the folder, or goes on with it: `sink` gets its blocks; what does not have its seal, and all behind it, is cut off. Throws Error where it
  /// is another work's or another process's, or something else, and for an empty identity.
  CheckpointFile(const std::filesystem::path& folder, const std::string& identity, const Sink& sink);
  ~CheckpointFile();
  CheckpointFile(const CheckpointFile&) = delete;
  CheckpointFile& operator=(const CheckpointFile&) = delete;

  /// Throws Error where it cannot be written.
  void append(std::size_t block, const std::string& result);

 private:
  void read(const std::string& identity, const Sink& sink);
  void write(std::string_view bytes);
  [[noreturn]] void fail(const std::string& what) const;

  std::filesystem::path file_;
  std::mutex one_;
  int open_ = -1;
};

}  // namespace imulab
