// The contents of a recording, with the evidence: finds from the data the declaration that a session needs.
#pragma once

#include "imulab/finding.hpp"
#include "imulab/inspection/signals.hpp"
#include "imulab/inspection/triads.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// The user's declarations about a recording, by key: "rate_hz", "time.column", "time.unit", "gyro.columns", "gyro.unit", "gyro.output", "gyro.axes",
/// and the same of accel. They take precedence over the data.
using Declarations = std::map<std::string, std::string>;
/// All keys: those above, latitude_deg, height_m and gravity_mps2 of the place, and the grade of the IMU.
std::vector<std::string> declaration_keys();
/// The place. Throws Error for a value that is not a number in range.
Site declared_site(const Declarations& declared);
/// Throws Error for a name that is no grade.
std::optional<std::string> declared_grade(const Declarations& declared);

/// One column.
struct ColumnFinding {
  std::string name;
  std::string role;  ///< "time", "gyro.x", "accel.z", "temperature", "unused"
  std::string unit;  ///< as a session names it; empty for an unused column
  std::string evidence;
};

/// A method that the data can support, or not, and why.
struct MethodFinding {
  std::string name;
  bool supported = false;
  std::string why;
};

struct Inspection {
  std::string file, topic, format;
  std::size_t rows = 0;
  double duration_s = 0;
  std::vector<ColumnFinding> columns;
  std::optional<double> rate_hz;
  double jitter_s = 0;  ///< RMS of the stamps about an even clock; 0 where none was found
  std::size_t gaps = 0;
  /// Notes are evidence: time, accelerometers, gyros, axes, temperature, clock, readings, rests. Warnings are open questions about a key, their
  /// subject, which the user has to declare. Doubts are faults that have to be fixed in the file before it can be used.
  Findings findings;
  std::vector<MethodFinding> methods;
  std::optional<inspection::TriadEvidence> triads;  ///< where two triads were found
  std::vector<std::array<double, 2>> rests_s;       ///< when their rests begin and end, from the first row on; empty without a rate
  RecordingSource source;                           ///< the declaration, complete where nothing is ambiguous

  std::vector<std::string> evidence() const { return findings.notes(); }
  std::vector<std::string> ambiguous() const { return findings.of(Severity::warning); }
  std::vector<std::string> problems() const { return findings.reasons(); }
  bool complete() const { return ambiguous().empty() && problems().empty(); }
  void note(const std::string& evidence);
  void ask(const Question& question);
};

/// Looks at the columns. Throws Error for a table without rows or with fewer than six columns of numbers that vary, and for declarations that the
/// table contradicts.
Inspection inspect(const SignalTable& table, const Declarations& declared = {});

/// Gravity where the place is not known: 9.780 m/s^2 at the equator to 9.832 at the poles.
inline constexpr double gravity_anywhere = 9.806, gravity_anywhere_sigma = 0.015;

/// A session of one recording with the findings; if the place is not known, gravity is taken with its range anywhere on Earth.
Session inspected_session(const Inspection& inspection, const Declarations& declared);

}  // namespace imulab
