// The contents of a recording, for people and for programs.
#pragma once

#include "imulab/inspection/inspection.hpp"

#include <string>

namespace imulab {

/// "understood: calibrate with --method handheld"
std::string inspection_headline(const Inspection& inspection);
/// Verdict first, then the evidence, a line each, and the columns.
std::string inspection_text(const Inspection& inspection);
/// JSON (docs/reference/results.md).
std::string inspection_json(const Inspection& inspection);
/// The session with the evidence as comments. Throws Error where something is ambiguous.
std::string inspected_session_text(const Inspection& inspection, const Session& session);

}  // namespace imulab
