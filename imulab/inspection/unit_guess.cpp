// The units that readings may have, by gravity and by turns.
#include "imulab/inspection/names.hpp"
#include "imulab/recording/unit_names.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace imulab::inspection {

namespace {

struct Possible {
  std::string unit;
  Output output;
  double size;  ///< what one SI unit (of rate) reads: m/s^2 or rad/s
};

std::vector<Possible> possible_units(Quantity quantity, double interval_s) {
  std::vector<Possible> all;
  for (const Output output : {Output::rate, Output::increment})
    for (const std::string_view unit : unit_names(quantity, output == Output::increment))
      if (unit != "count") all.push_back({std::string(unit), output, (output == Output::increment ? interval_s : 1.0) / si_factor(unit)});
  return all;
}

std::string with_output(const Possible& p) { return p.output == Output::rate ? p.unit : p.unit + " a sample"; }

/// One of the units that fit: the named one, or the only one.
UnitGuess choose(const std::vector<Possible>& fit, const std::vector<Possible>& all, const std::string& named, const std::string& what,
                 const std::string& key, bool whole) {
  UnitGuess guess;
  guess.evidence = what;
  const auto is_named = [&](const Possible& p) { return p.unit == named; };
  const auto take = [&](const Possible& p) {
    guess.unit = p.unit;
    guess.output = p.output;
    guess.evidence = what + ": " + with_output(p);
  };
  if (const auto found = std::find_if(fit.begin(), fit.end(), is_named); !named.empty() && found != fit.end()) {
    take(*found);
    return guess;
  }
  if (!named.empty() && std::any_of(all.begin(), all.end(), is_named)) {
    std::string instead;
    for (const Possible& p : fit) instead += (instead.empty() ? "" : " or ") + with_output(p);
    guess.unit = named;
    guess.open = {key + ".unit", fmt::format("the file says {}, but {}", named, what + (instead.empty() ? "" : ", as in " + instead))};
    return guess;
  }
  if (!named.empty() && named != "count") {
    guess.open = {key + ".unit", fmt::format("the file says {}, which is no unit known here; {}", named, what)};
    return guess;
  }
  if (named == "count") {
    guess.evidence = what + ": counts, as the file says";
    return guess;
  }
  if (fit.size() == 1) {
    take(fit.front());
    return guess;
  }
  if (fit.empty() && whole) {
    guess.evidence = what + ", whole numbers: counts";
    return guess;
  }
  std::string list;
  for (const Possible& p : fit) list += (list.empty() ? "" : " or ") + with_output(p);
  guess.open = {key + ".unit", fmt::format("{}, {}", what, fit.empty() ? "which is no unit known here" : "which could be " + list)};
  return guess;
}

}  // namespace

UnitGuess accel_unit(double norm, double least, double most, double interval_s, const std::string& named, bool whole) {
  const std::vector<Possible> all = possible_units(Quantity::accel, interval_s);
  std::vector<Possible> fit;
  constexpr double tolerance = 0.1;  // offsets and scales of a sensor before its calibration
  for (const Possible& p : all)
    if (std::abs(norm / (unit::g * p.size) - 1) < tolerance) fit.push_back(p);
  // Whole numbers near a thousand, or a million, to g are a unit; near a power of two they may be counts.
  const double octave = std::exp2(std::round(std::log2(norm)));
  std::string what = least < most ? fmt::format("|a| at rest {:.5g} to {:.5g}", least, most) : fmt::format("|a| at rest {:.5g}", norm);
  if (whole && !fit.empty() && named.empty() && std::abs(norm / octave - 1) < 0.05) {
    fit.push_back({"count", Output::rate, octave / unit::g});
  } else if (whole && fit.empty()) {
    what += fmt::format(" ({:.5g} to g)", norm);
  }
  return choose(fit, all, named, what, "accel", whole);
}

UnitGuess gyro_unit(double scale, double interval_s, const std::string& named, bool whole) {
  const std::vector<Possible> all = possible_units(Quantity::gyro, interval_s);
  std::vector<Possible> fit;
  constexpr double tolerance = 0.15;  // of a coarse solution, on an uncalibrated sensor
  for (const Possible& p : all)
    if (std::abs(scale * p.size - 1) < tolerance) fit.push_back(p);
  const double per_degree = unit::deg / scale;
  const std::string what = fmt::format("1 deg/s reads {:.4g}, by the turns between rests", per_degree);
  if (whole && fit.size() == 1 && named.empty() && fit.front().unit != "mdeg/s") fit.push_back({"count", Output::rate, 1 / scale});
  return choose(fit, all, named, what, "gyro", whole);
}

std::vector<double> gyro_scales(double interval_s) {
  std::vector<double> scales;
  for (const Possible& p : possible_units(Quantity::gyro, interval_s)) scales.push_back(1 / p.size);
  return scales;
}

}  // namespace imulab::inspection
