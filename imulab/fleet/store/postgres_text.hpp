// The store's statements and values as PostgreSQL takes them. Its binary format is that of the wire: integers and doubles most significant byte
// first.
#pragma once

#include "imulab/fleet/store/engine.hpp"

#include <string>
#include <string_view>

namespace imulab::fleet {

/// A statement of the store in PostgreSQL's words: "?" and "?1" as "$1", the types of columns, texts that compare byte by byte as in SQLite, tables
/// of the store ("main."), of this connection ("temp.") and of a store that is merged ("other.").
std::string postgres_sql(std::string_view text);

/// PostgreSQL keeps only UTF-8 without NUL: other bytes as "\xe9", as messages show them.
std::string postgres_utf8(std::string_view text);

/// The type's number in the server's catalog; 0: NULL, of whatever type its column has.
unsigned postgres_type(const Value& value);
/// As a parameter or a field of COPY; empty for NULL.
std::string postgres_binary(const Value& value);
/// A field of a row. Throws Error for a type that the store does not use.
Value postgres_value(unsigned type, std::string_view bytes);

// The binary format of COPY, as its manual page has it: a head, then for each row the number of fields, and each with its length.
std::string postgres_copy_head();
std::string postgres_copy_row(const Query& row);
std::string postgres_copy_tail();

}  // namespace imulab::fleet
