// Options of verbs whose work several processes share (docs/cluster.md).
#pragma once

#include "apps/imulab/command.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/shared_work.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab::command {

struct CheckpointOptions {
  std::string folder;
  std::vector<std::string> merged;

  /// None where no folder is named. Throws Error for folders to merge alone.
  std::optional<Checkpoint> checkpoint() const {
    if (folder.empty() && !merged.empty()) throw Error("--merge: belongs to --checkpoint, whose folder has the result");
    if (folder.empty()) return std::nullopt;
    return Checkpoint{folder, {merged.begin(), merged.end()}};
  }
  /// Whether another process of the same work says what came out.
  bool silent() const { return !folder.empty() && !leads_processes(); }
};

inline void add_checkpoint_options(Verb& verb, CheckpointOptions& o) {
  verb.option("--checkpoint DIR", o.folder, "a folder for what is finished: the same command goes on from there, and several at once share the work");
  verb.option("--merge DIR", o.merged, "with --checkpoint: folders of runs that were made apart").takes_several(1);
}

}  // namespace imulab::command
