// Chunks that cannot be read: left out and reported.
#pragma once

#include "imulab/formats/recording/bag/compression.hpp"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace imulab::bag {

class Damage {
 public:
  explicit Damage(std::string file) : file_(std::move(file)) {}

  /// The chunk at this byte is left out.
  void chunk(std::uint64_t at, const std::string& what) { chunks_.emplace(at, what); }
  /// The file is of no use from this byte on.
  void end(std::uint64_t at, const std::string& what) { ends_.emplace(at, what); }
  /// The index cannot be used.
  void index(const std::string& what) { index_ = what; }
  bool any_index() const { return !index_.empty(); }

  bool any() const { return !chunks_.empty() || !ends_.empty(); }
  std::vector<std::string> warnings() const;
  /// "run.mcap: chunk at byte 12: what"
  std::string place(std::uint64_t at) const;
  /// The compression of a chunk. Throws Error with the place where there is none.
  Compression compression(std::string_view name, std::uint64_t at) const;

 private:
  std::string file_, index_;
  std::map<std::uint64_t, std::string> chunks_, ends_;
};

}  // namespace imulab::bag
