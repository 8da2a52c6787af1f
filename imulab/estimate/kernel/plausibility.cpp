#include "imulab/estimate/kernel/plausibility.hpp"

#include "imulab/error.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/recording/repeated_part.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace imulab::kernel {

namespace {

constexpr double scale_tolerance = 0.2;  // uncalibrated MEMS sensors are within a few percent

bool near(double value, double expected) { return std::abs(value / expected - 1) < scale_tolerance; }

/// A scale that results if readings are in another unit than declared.
struct MistakenUnit {
  Triad triad;
  double scale;
  std::string_view read;
};
constexpr std::array mistaken_units{MistakenUnit{Triad::gyro, unit::deg, "deg/s"},
                                    MistakenUnit{Triad::gyro, 1 / unit::deg, "rad/s"},
                                    MistakenUnit{Triad::gyro, unit::deg_per_h, "deg/h"},
                                    MistakenUnit{Triad::gyro, 1 / unit::deg_per_h, "rad/s"},
                                    MistakenUnit{Triad::gyro, 1.0 / 3600, "deg/h"},
                                    MistakenUnit{Triad::gyro, 3600, "deg/s"},
                                    MistakenUnit{Triad::accel, unit::g, "g"},
                                    MistakenUnit{Triad::accel, 1 / unit::g, "m/s^2"},
                                    MistakenUnit{Triad::accel, 1e-3 * unit::g, "mg"},
                                    MistakenUnit{Triad::accel, 1e3 / unit::g, "m/s^2"}};

/// Returns the declaration in the session that explains such a scale.
std::string cause_of(Triad triad, double scale, const Recording& recording) {
  const std::string_view read = mistaken_unit(triad, scale);
  const std::string unit = read.empty() ? "" : fmt::format("the readings are in {}, not in the declared unit", read),
                    also = read.empty() ? "" : "; or " + unit;
  const bool increment = triad == Triad::accel ? recording.accel_increment : recording.gyro_increment;
  if (increment && near(scale, recording.interval_s)) return "the readings are rates; declare them as rates" + also;
  if (!increment && near(scale, 1 / recording.interval_s)) return "the readings are increments; declare them as increments" + also;
  if (!unit.empty()) return unit;
  if (triad == Triad::accel && near(scale, 1e-3)) return "the readings are in thousandths of the declared unit";
  if (triad == Triad::gyro && (near(scale, 1e-3) || near(scale, 1e-6)))
    return "the unit of the stamps is smaller than declared (ms or us, not s), or the readings are in thousandths of the declared unit";
  if (triad == Triad::gyro && (near(scale, 1e3) || near(scale, 1e6))) return "the unit of the stamps is larger than declared (s, not ms or us)";
  return "check the declared unit, whether the readings are rates or increments, and the unit of the stamps";
}

/// Returns the input axis with the largest element in each output axis.
std::array<int, 3> strongest(const Matrix3d& matrix) {
  std::array<int, 3> at{};
  for (int row = 0; row < 3; ++row) {
    Eigen::Index column = 0;
    matrix.row(row).cwiseAbs().maxCoeff(&column);
    at[static_cast<std::size_t>(row)] = static_cast<int>(column);
  }
  return at;
}

void judge_axes(Findings& found, const char* name, const Matrix3d& matrix, bool counts) {
  const std::array<int, 3> at = strongest(matrix);
  std::string wrong;
  for (int row = 0; row < 3; ++row) {
    const int column = at[static_cast<std::size_t>(row)];
    const bool reversed = matrix(row, column) < 0 && !counts;  // counts may decrease when the quantity increases
    if (column != row || reversed)
      wrong += fmt::format("{}{} is along the {}{} reading", wrong.empty() ? "" : ", ", "xyz"[row], reversed ? "-" : "", "xyz"[column]);
  }
  if (wrong.empty()) return;
  found.add<Code::axes_not_as_declared>(Subject{name}, wrong, matrix.determinant() < 0 && !counts ? " (left-handed)" : "");
}

}  // namespace

std::string_view mistaken_unit(Triad triad, double scale) {
  for (const MistakenUnit& mistake : mistaken_units)
    if (mistake.triad == triad && near(scale, mistake.scale)) return mistake.read;
  return {};
}

namespace {

/// A scale beyond the tolerance, of all axes or of the worst axis.
struct WrongScale {
  std::string words;  ///< "the gyros' scale is 2.01 in the declared unit, where 1 is expected"
  bool common = false;
  double mean = 1;
};
std::optional<WrongScale> wrong_scale(Triad triad, const Matrix3d& matrix) {
  const char* const name = triad == Triad::accel ? "accelerometers" : "gyros";
  const Vector3d scale = matrix.rowwise().norm();
  int wrong = 0, worst = 0;
  for (int row = 0; row < 3; ++row) {
    wrong += !near(scale[row], 1);
    if (std::abs(std::log(scale[row])) > std::abs(std::log(scale[worst]))) worst = row;
  }
  if (wrong == 0) return {};
  const bool common = wrong == 3 && near(scale.minCoeff(), scale.maxCoeff());
  return WrongScale{fmt::format("the {}{} scale is {:.4g} in the declared unit, where 1 is expected", name,
                                common ? "'" : fmt::format("' {}", "xyz"[worst]), common ? scale.mean() : scale[worst]),
                    common, scale.mean()};
}

}  // namespace

std::string scale_contradiction(Triad triad, const Matrix3d& matrix, const Recording& recording) {
  const std::optional<WrongScale> wrong = wrong_scale(triad, matrix);
  if (!wrong) return {};
  return wrong->words + ": " + (wrong->common ? cause_of(triad, wrong->mean, recording) : "this axis is not like the others; check its column");
}

std::string scale_far_from_unit(const SensorModel& model) {
  for (const Triad triad : {Triad::accel, Triad::gyro})
    if (const TriadModel& t = triad_model(model, triad); t.raw_unit != "count")
      if (const std::optional<WrongScale> wrong = wrong_scale(triad, t.matrix)) return wrong->words;
  return {};
}

bool is_oblique(const Matrix3d& coarse) {
  const Matrix3d axes = coarse.rowwise().normalized();
  return (axes * axes.transpose() - Matrix3d::Identity()).cwiseAbs().maxCoeff() > 0.2;
}

void expect_gyro_scale(const Matrix3d& coarse, const Recording& recording) {
  if (is_oblique(coarse)) return;
  if (const std::string wrong = scale_contradiction(Triad::gyro, coarse, recording); !wrong.empty())
    throw Error(fmt::format("{}: {}", recording.name, wrong));
}

Findings contradictions(const SensorModel& model, const Recording& recording) {
  Findings found;
  for (const Triad triad : {Triad::accel, Triad::gyro}) {
    const bool accel = triad == Triad::accel;
    const Matrix3d& matrix = triad_model(model, triad).matrix;
    const bool counts = (accel ? recording.accel_unit : recording.gyro_unit) == "count";
    judge_axes(found, accel ? "accelerometers" : "gyros", matrix, counts);
    if (const std::string wrong = counts ? "" : scale_contradiction(triad, matrix, recording); !wrong.empty())
      found.add<Code::scale_not_as_declared>(wrong).subject = accel ? "accelerometers" : "gyros";
  }
  return found;
}

void judge_interval(const Recording& r, bool declared, Quality& quality) {
  double time = 0, samples = 0;
  for (std::size_t i = 1; i < r.size(); ++i)
    if (!r.follows_gap(i)) time += r.time_s(i) - r.time_s(i - 1), samples += 1;
  const double ratio = r.interval_s * samples / time;  // factor by which all scales are too small
  constexpr std::size_t enough = 200;
  const bool increments = r.gyro_increment || r.accel_increment;
  // Crystals are accurate to 1e-4, and the ends of a recording to a fraction of a sample; declared rates are often rounded.
  const double allowed = increments ? 5e-4 : 2e-3;
  if (samples < enough || !(std::abs(ratio - 1) > allowed)) return;
  const double off = 100 * std::abs(ratio - 1);
  if (increments)
    quality.findings.add<Code::wrong_rate_of_increments>(Subject{r.name}, samples / time, 1 / r.interval_s, off);
  else if (declared)
    quality.findings.add<Code::wrong_rate>(Subject{r.name}, samples / time, 1 / r.interval_s, off);
}

std::string repetition(std::span<const Recording> recordings) {
  const std::optional<RepeatedPart> found = repeated_part(recordings);
  if (!found) return {};
  const auto times = [&](std::size_t of, const Range& range) {
    const Recording& r = recordings[of];
    return fmt::format("{:.2f} s to {:.2f} s", r.time_s(range.begin), r.time_s(range.end - 1));
  };
  const bool own = found->of == found->recording;
  return fmt::format(
      "{}: the readings from {} are those from {}{} again, to the last digit, {} samples in all: data that count twice make the "
      "uncertainties too small; take them out",
      recordings[found->recording].name, times(found->recording, found->samples), times(found->of, found->earlier),
      own ? "" : " of " + recordings[found->of].name, found->in_all);
}

void expect_different_channels(const Recording& recording) {
  for (const auto& [name, triad] : {std::pair{"gyro", &recording.gyro}, std::pair{"accel", &recording.accel}})
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t other = (axis + 1) % 3;
      const std::vector<double>& column = (*triad)[axis];
      const bool constant = std::all_of(column.begin(), column.end(), [&](double value) { return value == column.front(); });
      if (!constant && column == (*triad)[other])
        throw Error(fmt::format("{}: {} {} and {} are equal in every sample; expected three different columns", recording.name, name, "xyz"[axis],
                                "xyz"[other]));
    }
}

}  // namespace imulab::kernel
