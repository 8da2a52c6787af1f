// Work of many independent parts, on the threads of one process, or of several processes that share a folder: on one machine, or on many under mpirun
// or srun. Finished parts are in the folder, so that the same command resumes after any end (docs/cluster.md).
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace imulab {

struct SharedWork {
  std::size_t count = 0;
  std::function<std::string(std::size_t)> work;               ///< the result of a part, as bytes; of several parts at a time, in any order
  std::function<void(std::size_t, const std::string&)> take;  ///< gets every result, in the order of the parts, one at a time
  std::function<void(std::size_t)> progress = {};             ///< called with the number of parts taken
};

/// A field of a work's identity: its name, and its value.
using IdentityField = std::pair<std::string, std::string>;

/// The identity of a work: everything that its results depend on. That is its name, imulab's version, and the fields: all options, numbers of runs
/// and seeds, and the content of all inputs, by SHA-256. Each is on a line of its own, so that no two requests have the same text.
std::string work_identity(std::string_view work, const std::vector<IdentityField>& fields);

/// Where several processes share a work, and keep what is finished.
struct Checkpoint {
  std::filesystem::path folder;                    ///< made where it is not there
  std::vector<std::filesystem::path> merged = {};  ///< folders of runs that were made apart: read only
  std::string identity = {};                       ///< of the work (work_identity): whoever sets up the work adds it
};

/// Does all parts that are not finished yet. The results that `take` gets do not depend on how many threads and processes there are. Every process
/// that shares a folder takes parts that no other has begun, then parts that others have begun and not finished: one that dies costs its own part.
/// Throws what a part throws; Error where the folder is another work's, and where it cannot be written.
void for_each(const SharedWork& work, const Checkpoint* checkpoint = nullptr);

/// True for the first of the processes that mpirun or srun started together, which reports the result, and for a process that is alone.
bool leads_processes();

/// True if this process is in a task of a Slurm array. Such tasks do not know of each other: in each of them a process leads.
bool in_job_array();

/// Numbers as bytes, and back.
std::string bytes_of(const double* numbers, std::size_t count);
/// Throws Error where there are fewer.
void read_numbers(const std::string& bytes, double* numbers, std::size_t count);

}  // namespace imulab
