// What the files of the verb `fleet` share.
#pragma once

#include "apps/imulab/command.hpp"
#include "imulab/fleet/store/store.hpp"

#include <string>

namespace imulab::command {

void add_store_option(Verb& verb, std::string& store);
/// What the times in the store say of clocks that were wrong.
void warn_of_clocks(FleetStore& store);

void add_fleet_stats(Verb& fleet);   ///< stats
void add_fleet_upkeep(Verb& fleet);  ///< check, merge, export, remove

}  // namespace imulab::command
