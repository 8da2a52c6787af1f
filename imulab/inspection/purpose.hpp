// What a log is good for that no method of calibration takes, and what an answer to a question about it would mean.
#pragma once

#include "imulab/inspection/inspection.hpp"
#include "imulab/inspection/signals.hpp"
#include "imulab/inspection/triads.hpp"

#include <string>

namespace imulab::inspection {

/// Of a log at rest in one attitude: its noise, or, where the temperature changes, how the zeros follow it, with the readings' change.
void add_purpose(const SignalTable& table, const TriadEvidence& triads, Inspection& result);

/// True of a log in one attitude from which the method static determines how the biases follow the temperature.
bool sweeps_in_one_attitude(const SignalTable& table, const TriadEvidence& triads, const Inspection& result);

/// The consequence of each unit that the gyros' readings may have: their white noise at rest, and the grade that has about as much. Empty without a
/// rest or a rate. "deg/s gives N 0.3 deg/sqrt(h), as mems; rad/s gives N 17 deg/sqrt(h)".
std::string noise_by_unit(const SignalTable& table, const TriadEvidence& triads, double interval_s);

}  // namespace imulab::inspection
