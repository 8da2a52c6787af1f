// Work of many independent parts, on the threads of one process, or of several processes that share a folder: on one machine, or on many under mpirun
// or srun. Finished parts are in the folder, so that the same command resumes after any end (docs/cluster.md).
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace imulab {

struct SharedWork {
  std::size_t count = 0;
  std::function<std::string(std::size_t)> work;               ///< the result of a part, as bytes; of several parts at a time, in any order
  std::function<void(std::size_t, const std::string&)> take;  ///< gets every result, in the order of the parts, one at a time
  std::function<void(std::size_t)> progress = {};             ///< called with the number of parts taken
  std::string identity = {};  ///< what all results depend on; empty: the number of parts and the result of the first, which then has to repeat
};

/// Where several processes share a work, and keep what is finished.
struct Checkpoint {
  std::filesystem::path folder;                    ///< made where it is not there
  std::vector<std::filesystem::path> merged = {};  ///< folders of runs that were made apart: read only
};

/// Does all parts that are not finished yet. The results that `take` gets do not depend on how many threads and processes there are. Every process
/// that shares a folder takes parts that no other has begun, then parts that others have begun and not finished: one that dies costs its own part.
/// Throws what a part throws; Error where the folder is another work's, and where it cannot be written.
void for_each(const SharedWork& work, const Checkpoint* checkpoint = nullptr);

/// Of processes that mpirun or srun started together the first one: it says what came out. True where this process is alone.
bool leads_processes();

/// Numbers as bytes, and back.
std::string bytes_of(const double* numbers, std::size_t count);
/// Throws Error where there are fewer.
void read_numbers(const std::string& bytes, double* numbers, std::size_t count);

}  // namespace imulab
