// The noise of logs at rest: one log, or several together.
#pragma once

#include "imulab/noise.hpp"
#include "imulab/session.hpp"
#include "imulab/tasks/noise_moving.hpp"
#include "imulab/tasks/verb.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

struct NoiseVerbOptions : ShowOptions {
  std::vector<std::string> recordings, declarations, topics;
  std::string recording, deviation = "overlapping-allan";
  std::vector<std::string> moving;         ///< files with vibration or motion
  std::vector<MovingInput> moving_inputs;  ///< what they contain
  std::optional<std::string> require;      ///< limits on terms (results/noise_requirement.hpp)
  std::optional<std::string> model;        ///< its terms; absent: as the spectrum requires
  std::optional<std::string> datasheet;    ///< values or their file (formats/noise/data_sheet.hpp)
  double in_memory_mb = 336;               ///< six million rows of seven numbers: the analysis then takes about a gigabyte
  bool remove_temperature = false, bound = false;
  std::optional<double> horizon_s, confidence;  ///< of the bound

  std::uint64_t most_bytes() const { return static_cast<std::uint64_t>(1e6 * in_memory_mb); }
};
/// The verb `noise`, which sets these.
Verb& declare(Verb& command, NoiseVerbOptions& o);

/// Throws Error for a name that is no deviation's.
DeviationKind deviation_named(const std::string& name);

/// A recording as it is in memory. Its page keeps the recording.
AnswerOf<NoiseAnalysis> noise_answer(const Recording& recording, const Session& session, const NoiseVerbOptions& o);
/// A recording of a session's files, whose columns go through temporary files where they are longer than the options allow. The page, where --report
/// asks for it, is made at once, since the columns are not kept. `tell` gets the warnings of reading before the analysis begins.
AnswerOf<NoiseAnalysis> noise_answer(const Session& session, const RecordingSource& source, const NoiseVerbOptions& o, const Tell& tell);
/// The noise at rest from a file, beside a log in motion.
AnswerOf<NoiseAnalysis> noise_answer(NoiseAnalysis saved, const NoiseVerbOptions& o);
/// The data sheet of the options, without a log.
AnswerOf<NoiseAnalysis> data_sheet_answer(const NoiseVerbOptions& o);
/// Several logs together, each with the name of its file.
AnswerOf<NoiseBatch> noise_answer(std::vector<NoiseAnalysis> logs, const NoiseVerbOptions& o);

}  // namespace imulab
