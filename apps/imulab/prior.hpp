// A fleet's store as the prior of a unit: the option --prior of calibrate and plan.
#pragma once

#include "apps/imulab/command.hpp"
#include "imulab/core/error.hpp"
#include "imulab/fleet/store/sample.hpp"

#include <string>

namespace imulab::command {

inline void add_prior_option(Verb& verb, std::string& prior) {
  verb.option("--prior STORE", prior, "a fleet's store: how its units spread counts as what is known of this one before it is measured").reads();
}

inline FleetPrior prior_at(const std::string& file) {
  FleetStore store(file);
  return errors_at("--prior", [&] { return fleet_prior(store); });
}

}  // namespace imulab::command
