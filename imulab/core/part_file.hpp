// A part of a work, in a file: its task, which blocks of each work it did, and their results. Files of all parts are joined by adding up in the order
// of the blocks: the same bits as one process.
//
//   the format's name; the command; K, N and the number of works; seal; then each work: identity, number of its blocks, the results of the part's
//   blocks in order, seal (core/sealed.hpp)
#pragma once

#include "imulab/core/sealed.hpp"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <istream>
#include <memory>
#include <string>
#include <vector>

namespace imulab {

inline constexpr std::size_t most_parts = 1'000'000;

/// The K-th part of N, from 1 on.
struct PartNumber {
  std::size_t number = 1, of = 1;
};

/// "3/8"; "auto" and "auto/8" by the environment (Slurm arrays and tasks, MPI ranks, Kubernetes' indexed jobs). Throws Error for what is none of
/// these, and where the environment says nothing.
PartNumber part_named(const std::string& text);

/// "of 8 parts these are missing: 3, 5"; empty: none is.
std::string missing_parts(std::size_t of, const std::function<bool(std::size_t part)>& is_there);

/// Blocks begin ... end - 1.
struct BlockRange {
  std::size_t begin = 0, end = 0;
  std::size_t size() const { return end - begin; }
};
/// Of a part: whole blocks, nearly as many in each part.
BlockRange blocks_of(PartNumber part, std::size_t count);

class PartWriter {
 public:
  /// `command`: what makes the same works again, for whoever joins the parts.
  PartWriter(PartNumber part, std::string command);

  std::string name() const;  ///< "part-3-of-8"
  BlockRange begin_work(const std::string& identity, std::size_t count);
  void add(const std::string& result) { works_.text(result); }
  void end_work();
  /// The file.
  std::string bytes() const;
  /// "part 3 of 8: blocks 26 to 39 of 104"
  std::string summary() const;

 private:
  PartNumber part_;
  std::string command_;
  SealedWriter works_;
  std::uint64_t count_ = 0;
  BlockRange range_;
  std::size_t blocks_ = 0;
};

/// All parts of one work, or of several.
class PartReader {
 public:
  /// Something to read, by name: a file, or bytes in memory.
  struct Source {
    std::string name;
    std::function<std::unique_ptr<std::istream>(std::uint64_t& size)> open;
  };
  static Source file(const std::filesystem::path& path);
  static Source memory(std::string name, std::string bytes);

  /// Throws Error for parts that are missing, there twice, of different tasks, or damaged at their begin.
  explicit PartReader(std::vector<Source> parts);

  const std::string& command() const { return command_; }
  /// True until all works were read.
  bool has_more() const { return read_ < works_; }
  /// The results of the next work. Throws Error where it is another one, and where a part is damaged: what `take` got then means nothing.
  void read(const std::string& identity, std::size_t count, const std::function<void(std::size_t, const std::string&)>& take);

 private:
  struct Part {
    Source source;
    std::uint64_t number = 0, left = 0, sum = 0;  ///< bytes that were not read yet, and the sum of those before
  };
  std::vector<Part> parts_;  ///< in their order
  std::string command_;
  std::uint64_t works_ = 0, read_ = 0;
};

}  // namespace imulab
