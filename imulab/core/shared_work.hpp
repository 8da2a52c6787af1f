// Work of many independent blocks, on the threads of one process; in parts, by processes that know nothing of each other, whose files are joined; or
// resumed after any end from what a folder keeps (docs/reference/fleet-store.md).
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace imulab {

class PartWriter;
class PartReader;

struct SharedWork {
  std::size_t count = 0;                                      ///< of blocks
  std::function<std::string(std::size_t)> work;               ///< the result of a block, as bytes; of several blocks at a time, in any order
  std::function<void(std::size_t, const std::string&)> take;  ///< gets every result, in the order of the blocks, one at a time
  std::function<void(std::size_t)> progress = {};             ///< called with the number of blocks taken
};

/// A field of a work's identity: its name, and its value.
using IdentityField = std::pair<std::string, std::string>;

/// The identity of a work: everything that its results depend on. That is its name, imulab's version, and the fields: all options, numbers of runs
/// and seeds, and the content of all inputs, by SHA-256. Each is on a line of its own, so that no two requests have the same text.
std::string work_identity(std::string_view work, const std::vector<IdentityField>& fields);
/// The name of the first field in which another identity differs.
std::string differing_field(const std::string& identity, const std::string& other);

/// How a work is done where not at one go in one process.
struct Sharing {
  std::string identity = {};                ///< of the work (work_identity): whoever sets up the work adds it
  std::filesystem::path checkpoint = {};    ///< a folder for what is finished, from which the same work goes on; empty: none
  std::shared_ptr<PartWriter> part = {};    ///< does the blocks of this part alone, and then throws PartIsDone
  std::shared_ptr<PartReader> joined = {};  ///< takes the results from parts that were done before
};

/// Thrown where a part was asked for and is done: nothing is to be said of the whole.
struct PartIsDone {
  std::shared_ptr<PartWriter> part;
};

/// Does all blocks, or takes their results from where they are. What `take` gets does not depend on how many threads and parts there were. Throws
/// what a block throws; Error where parts or checkpoint are another work's or damaged, and where the checkpoint cannot be written.
void for_each(const SharedWork& work, const Sharing* sharing = nullptr);

/// Numbers as bytes, and back.
std::string bytes_of(const double* numbers, std::size_t count);
/// Throws Error where there are fewer.
void read_numbers(const std::string& bytes, double* numbers, std::size_t count);

}  // namespace imulab
