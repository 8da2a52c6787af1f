// A store's name: of a file, or the address of a PostgreSQL server, "postgresql://user:password@host/database".
#pragma once

#include <filesystem>
#include <string>

namespace imulab::fleet {

/// True for "postgresql://" and "postgres://", in capitals or not: all else is a file.
bool is_server(const std::filesystem::path& store);

/// A store's name as people may see it: of an address the parts that are understood, and "***" in place of passwords and of all else; of a file as
/// it is, up to "password=".
std::string shown_store(const std::filesystem::path& store);

/// The same for each address within a text, where it ends at a space or a quote: of a message that quotes the command line.
std::string without_passwords(const std::string& text);

}  // namespace imulab::fleet
