// A recording inspected: what it holds, the session for it, and the recording as that session declares it.
#pragma once

#include "imulab/formats/recording/signals.hpp"
#include "imulab/inspection/inspection.hpp"
#include "imulab/recording.hpp"
#include "imulab/tasks/verb.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

struct InspectOptions : ShowOptions {
  std::vector<std::string> files, topics, declarations;
  double longest_s = stream_s;
};
/// The verb `inspect`, which sets these.
Verb& declare(Verb& command, InspectOptions& o);
/// The option --topic TOPIC.
VerbOption& topics_option(Verb& verb, std::vector<std::string>& topics);
/// The option --set KEY=VALUE.
void declarations_option(Verb& verb, std::vector<std::string>& declarations);
/// Throws OptionError for what is not KEY=VALUE.
Declarations parse_declarations(const std::vector<std::string>& texts);

struct InspectionTask {
  std::vector<std::string> files, topics = {};  ///< files of one recording; topics: several of one file, or none
  Declarations declared = {};
  double longest_s = stream_s;                   ///< for how long a stream is read
  std::size_t most_numbers = numbers_inspected;  ///< as read_tables takes it
};

/// The recordings that files are: neighbors that are parts of one split bag are one recording.
std::vector<std::string> recordings_named(const std::vector<std::string>& files);

/// Throws Error as read_tables and inspect do, and for declarations that there are not.
Inspection inspect_files(const InspectionTask& task);

struct InspectedRecording {
  Inspection inspection;
  Session session;                     ///< complete where the inspection is
  std::optional<Recording> recording;  ///< as the session declares it; absent where something is open, wrong, or a stream
};

/// A problem of the recording as its session declares it is a problem of the inspection.
InspectedRecording inspect_and_read(const InspectionTask& task);
AnswerOf<InspectedRecording> inspection_answer(const InspectionTask& task);

/// The session of one file, of which nothing is open. Throws Error for a problem, Unsupported with the open questions. `hint` says how they are
/// answered.
Session session_for(const Inspection& inspection, const InspectionTask& task, const std::string& hint);

/// The gravity that a session assumes as anywhere on Earth, also where it is written in its file; empty where it is known better.
std::string assumed_gravity(const Session& session);

}  // namespace imulab
