#include "apps/imulab/fleet.hpp"
namespace imulab::command {
void add_fleet_stats(Verb&) {}
}  // namespace imulab::command
