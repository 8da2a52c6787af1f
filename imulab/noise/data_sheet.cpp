#include "imulab/noise/data_sheet.hpp"

#include "imulab/core/text.hpp"
#include "imulab/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <numbers>

namespace imulab {
namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();
const double flicker_floor = std::sqrt(2 * std::numbers::ln2 / std::numbers::pi);  // 0.664: the Allan deviation of B = 1
const double root_3 = std::sqrt(3.0);

std::string sheet_axis_name(bool gyro, std::size_t axis) { return fmt::format("{}.{}", gyro ? "gyro" : "accel", "xyz"[axis]); }

NoiseCoefficient printed_coefficient(double value, SheetKind kind) {
  return {value, unlimited, 0, kind == SheetKind::maximum ? value : unlimited, true};
}
NoiseCoefficient bounded_coefficient(double upper) {
  NoiseCoefficient out = undetermined_below(upper);
  out.bounded = true;
  return out;
}

/// One axis of a sheet.
class SheetAxis {
 public:
  SheetAxis(const DataSheet& sheet, bool gyro, std::size_t axis) : sheet_(sheet), gyro_(gyro), axis_(axis) {}

  NoiseFit coefficients() const {
    NoiseFit out;
    out.N = white();
    const double N = out.N.value, floor = squared_floor(N);
    out.B = flicker(floor);
    const SheetEntry* const K = find(SheetQuantity::K);
    out.K = K != nullptr ? printed_coefficient(K->value, kind_of(*K)) : bounded_coefficient(root_3 * floor / (2 * N));  // (1) with B = 0
    out.Q = out.R = undetermined_below(unlimited);
    return out;
  }

 private:
  const SheetEntry* find(SheetQuantity quantity) const { return sheet_.find(gyro_, axis_, quantity); }
  SheetKind kind_of(const SheetEntry& entry) const { return entry.kind == SheetKind::undeclared ? sheet_.kind : entry.kind; }

  /// Returns true if the sheet has values of the whole triad alone.
  bool of_triad() const {
    return std::ranges::none_of(sheet_.entries, [&](const SheetEntry& entry) { return entry.gyro == gyro_ && entry.axis; });
  }

  NoiseCoefficient white() const {
    std::vector<const SheetEntry*> given;
    for (const SheetQuantity quantity : {SheetQuantity::N, SheetQuantity::psd, SheetQuantity::rms})
      if (const SheetEntry* const entry = find(quantity)) given.push_back(entry);
    if (std::any_of(given.begin(), given.end(), [](const SheetEntry* entry) { return entry->axis.has_value(); }))
      std::erase_if(given, [](const SheetEntry* entry) { return !entry->axis; });  // an axis's own value replaces that of its triad
    const std::string triad = gyro_ ? "gyro" : "accel", owner = of_triad() ? triad : sheet_axis_name(gyro_, axis_);
    if (given.empty()) throw Error(fmt::format("{0}: has no white noise; expected {1}.N, {1}.psd, or {1}.rms with {1}.bandwidth", owner, triad));
    if (given.size() > 1)
      throw Error(fmt::format("{}: gives the white noise twice: \"{}\" and \"{}\"; expected one of them, the density if there is one", owner,
                              given[0]->text, given[1]->text));
    const SheetEntry& entry = *given.front();
    const double N = entry.quantity == SheetQuantity::N     ? entry.value
                     : entry.quantity == SheetQuantity::psd ? std::sqrt(entry.value)
                                                            : entry.value / std::sqrt(noise_bandwidth(entry));
    return printed_coefficient(N, kind_of(entry));
  }

  /// Of white noise: pi / 2 times the -3 dB bandwidth of a first-order low-pass.
  double noise_bandwidth(const SheetEntry& rms) const {
    const SheetEntry *const first_order = find(SheetQuantity::bandwidth), *const noise = find(SheetQuantity::noise_bandwidth);
    if ((first_order == nullptr) == (noise == nullptr))
      throw Error(fmt::format("\"{}\": needs one bandwidth; expected {}.bandwidth (-3 dB, first order) or noise_bandwidth", rms.text,
                              gyro_ ? "gyro" : "accel"));
    return first_order != nullptr ? first_order->value * std::numbers::pi / 2 : noise->value;
  }

  /// m^2 of (1), or what stands for it.
  double squared_floor(double N) const {
    if (const SheetEntry* const m = find(SheetQuantity::stability)) return m->value * m->value;
    if (const SheetEntry* const B = find(SheetQuantity::B)) return std::pow(flicker_floor * B->value, 2);
    if (const SheetEntry* const K = find(SheetQuantity::K)) return 2 * N * K->value / root_3;
    return N * N / assumed_white_s;
  }

  NoiseCoefficient flicker(double squared_floor) const {
    if (const SheetEntry* const B = find(SheetQuantity::B)) return printed_coefficient(B->value, kind_of(*B));
    NoiseCoefficient out = bounded_coefficient(std::sqrt(squared_floor) / flicker_floor);  // (1) with K = 0
    // A printed stability is evidence of B: predictions count the bound as its value.
    if (find(SheetQuantity::stability) != nullptr) out.value = out.upper, out.standard_uncertainty = unlimited, out.determined = true;
    return out;
  }

  const DataSheet& sheet_;
  bool gyro_;
  std::size_t axis_;
};

bool has_triad(const DataSheet& sheet, bool gyro) {
  return std::any_of(sheet.entries.begin(), sheet.entries.end(), [&](const SheetEntry& entry) { return entry.gyro == gyro; });
}

/// The minimum of the Allan deviation: that of B, if the log determines it, since the least of a few scattered points is too low. Else the least
/// point, and only its upper bound if the log ends before the deviation rises.
SheetComparison measured_stability(const NoiseAxis& axis, double sheet) {
  if (const NoiseCoefficient& B = axis.fit->B; B.determined)
    return {axis.name + ".stability", sheet, flicker_floor * B.value, flicker_floor * B.lower, flicker_floor * B.upper};
  const auto smaller = [](const DeviationPoint& a, const DeviationPoint& b) { return a.deviation < b.deviation; };
  const auto least = std::min_element(axis.deviation.begin(), axis.deviation.end(), smaller);
  if (least + 1 == axis.deviation.end()) return {axis.name + ".stability", sheet, NAN, 0, least->upper_95};
  return {axis.name + ".stability", sheet, least->deviation, least->lower_95, least->upper_95};
}

}  // namespace

const SheetEntry* DataSheet::find(bool gyro, std::size_t axis, SheetQuantity quantity) const {
  const SheetEntry* common = nullptr;
  for (const SheetEntry& entry : entries) {
    if (entry.gyro != gyro || entry.quantity != quantity) continue;
    if (entry.axis == axis) return &entry;
    if (!entry.axis) common = &entry;
  }
  return common;
}

NoiseAnalysis data_sheet_noise(const DataSheet& sheet) {
  NoiseAnalysis out;
  out.source = "data sheet";
  out.recording = sheet.name;
  out.interval_s = sheet.rate_hz > 0 ? 1 / sheet.rate_hz : 0;
  for (const bool gyro : {true, false})
    for (std::size_t i = 0; i < 3 && has_triad(sheet, gyro); ++i)
      out.axes.push_back({.name = sheet_axis_name(gyro, i), .unit = gyro ? "rad/s" : "m/s^2", .fit = SheetAxis(sheet, gyro, i).coefficients()});
  for (const SheetEntry& entry : sheet.entries) out.notes.push_back(entry.text);
  return out;
}

std::vector<SheetComparison> compare_with_sheet(const NoiseAnalysis& log, const DataSheet& sheet) {
  std::vector<SheetComparison> out;
  const bool allan = log.kind == DeviationKind::overlapping_allan || log.kind == DeviationKind::allan;
  for (const NoiseAxis& axis : log.axes) {
    const bool gyro = axis.name.starts_with("gyro.");
    if (!axis.fit || !has_triad(sheet, gyro)) continue;
    if (axis.unit == "count") throw Error("the log is in counts, which a data sheet has not; expected a log in rad/s and m/s^2");
    const auto place = static_cast<std::size_t>(axis.name.back() - 'x');
    const NoiseFit by_sheet = SheetAxis(sheet, gyro, place).coefficients();
    for (const auto& [name, term] : {std::pair{"N", &NoiseCoefficients::N}, {"B", &NoiseCoefficients::B}, {"K", &NoiseCoefficients::K}}) {
      const NoiseCoefficient &printed = by_sheet.*term, &measured = (*axis.fit).*term;
      if (printed.determined && !printed.bounded)
        out.push_back({axis.name + "." + name, printed.value, measured.determined ? measured.value : NAN, measured.lower, measured.upper});
    }
    const SheetEntry* const stability = sheet.find(gyro, place, SheetQuantity::stability);
    if (stability != nullptr && allan && !axis.deviation.empty()) out.push_back(measured_stability(axis, stability->value));
  }
  return out;
}

std::string meant_noise_key(std::string_view name) {
  const std::string words = lowered(name), first = words.substr(0, words.find_first_of(" ._-"));
  std::string_view triad;
  if (first == "gyro" || first == "gyros" || first == "gyroscope" || first == "gyroscopes" || first == "gyr") triad = "gyro";
  if (first == "accel" || first == "acc" || first == "accelerometer" || first == "accelerometers") triad = "accel";
  std::string letters;
  for (const char c : triad.empty() ? words : words.substr(first.size()))
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) letters += c;
  struct Usual {
    std::string_view name, key, triad = {};  // triad: of a name that belongs to one
  };
  static constexpr Usual usual[]{{"arw", "N", "gyro"},
                                 {"anglerandomwalk", "N", "gyro"},
                                 {"angularrandomwalk", "N", "gyro"},
                                 {"vrw", "N", "accel"},
                                 {"velocityrandomwalk", "N", "accel"},
                                 {"noise", "N"},
                                 {"density", "N"},
                                 {"noisedensity", "N"},
                                 {"ratenoisedensity", "N", "gyro"},
                                 {"ratenoisespectraldensity", "N", "gyro"},
                                 {"whitenoise", "N"},
                                 {"rmsnoise", "rms"},
                                 {"totalrmsnoise", "rms"},
                                 {"outputnoise", "rms"},
                                 {"biasinstability", "B"},
                                 {"instability", "B"},
                                 {"bi", "B"},
                                 {"stability", "stability"},
                                 {"bias", "stability"},
                                 {"biasstability", "stability"},
                                 {"inrunbias", "stability"},
                                 {"inrunstability", "stability"},
                                 {"inrunbiasstability", "stability"},
                                 {"rrw", "K", "gyro"},
                                 {"raterandomwalk", "K", "gyro"},
                                 {"randomwalk", "K"},
                                 {"biasrandomwalk", "K"}};
  for (const Usual& one : usual)
    if (letters == one.name && !(triad.empty() && one.triad.empty())) return fmt::format("{}.{}", triad.empty() ? one.triad : triad, one.key);
  return "";
}

bool has_assumed_bounds(const NoiseCoefficients& axis) {
  return axis.B.bounded && axis.K.bounded && !axis.B.determined;  // B of a printed stability is determined
}

std::string sheet_standing(const NoiseCoefficients& axis, const NoiseCoefficient& c) {
  if (c.bounded) return has_assumed_bounds(axis) ? "assumed" : "bounded";
  return std::isfinite(c.upper) ? "maximum" : "typical";
}

}  // namespace imulab
