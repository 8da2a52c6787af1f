// Inputs by their content, for the identity of a shared work (core/shared_work.hpp): a file that changes under its name is another input.
#pragma once

#include "imulab/core/shared_work.hpp"
#include "imulab/session.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace imulab {

/// The SHA-256 of a file; "absent" where it is not there, since a mission may name a calibration that an option replaces.
std::string content_of(const std::filesystem::path& file);

/// A session's text and the noise that it names, without its recordings: a prediction reads nothing else. A session that was never a file counts by
/// the text that it would have.
std::vector<IdentityField> content_of(const Session& session);

}  // namespace imulab
