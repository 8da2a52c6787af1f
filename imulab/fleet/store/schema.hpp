// The tables of a fleet store.
#pragma once

#include "imulab/fleet/store/database.hpp"

namespace imulab::fleet {

/// Makes the tables in a new file. Throws Error where the file is something else, newer, or without its tables.
void expect_schema(Database& database, Access access);

}  // namespace imulab::fleet
