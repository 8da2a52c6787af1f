#include "imulab/estimate/kernel/plausibility.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace imulab::kernel {

namespace {

constexpr double scale_tolerance = 0.2;  // uncalibrated MEMS sensors are within a few percent

bool near(double value, double expected) { return std::abs(value / expected - 1) < scale_tolerance; }

/// A mistake in the session that multiplies a scale by `factor`.
struct Mistake {
  double factor;
  std::string cause;
};

std::vector<Mistake> mistakes(Triad triad, const Recording& recording) {
  const bool increment = triad == Triad::accel ? recording.accel_increment : recording.gyro_increment;
  std::vector<Mistake> out;
  const auto units = [&](double factor, const char* coarse, const char* fine) {  // declared -> read
    out.push_back({factor, fmt::format("the readings are in {}, not in the declared unit", fine)});
    out.push_back({1 / factor, fmt::format("the readings are in {}, not in the declared unit", coarse)});
  };
  if (triad == Triad::gyro) {
    units(unit::deg, "rad/s", "deg/s");
    units(unit::deg_per_h, "rad/s", "deg/h");
    units(1.0 / 3600, "deg/s", "deg/h");
    out.push_back({1e-3, "the unit of the stamps is smaller than declared (ms, not s), or the readings are in thousandths of the declared unit"});
    out.push_back({1e3, "the unit of the stamps is larger than declared (s, not ms)"});
    out.push_back({1e-6, "the unit of the stamps is smaller than declared (us, not s)"});
    out.push_back({1e6, "the unit of the stamps is larger than declared (s, not us)"});
  } else {
    units(unit::g, "m/s^2", "g");
    units(1e-3 * unit::g, "m/s^2", "mg");
    out.push_back({1e-3, "the readings are in thousandths of the declared unit (mg, mm/s^2)"});
  }
  if (increment)
    out.push_back({recording.interval_s, "the readings are rates; declare output = \"rate\""});
  else
    out.push_back({1 / recording.interval_s, "the readings are increments; declare output = \"increment\""});
  return out;
}

std::string cause_of(Triad triad, double factor, const Recording& recording) {
  for (const Mistake& mistake : mistakes(triad, recording))
    if (near(factor, mistake.factor)) return mistake.cause;
  return "check the declared unit, whether the readings are rates or increments, and the unit of the stamps";
}

/// The input axis with the largest part in each output axis.
std::array<int, 3> strongest(const Matrix3d& matrix) {
  std::array<int, 3> at{};
  for (int row = 0; row < 3; ++row) {
    Eigen::Index column = 0;
    matrix.row(row).cwiseAbs().maxCoeff(&column);
    at[static_cast<std::size_t>(row)] = static_cast<int>(column);
  }
  return at;
}

void judge_axes(std::vector<std::string>& found, const char* name, const Matrix3d& matrix, bool counts) {
  const std::array<int, 3> at = strongest(matrix);
  std::string wrong;
  for (int row = 0; row < 3; ++row) {
    const int column = at[static_cast<std::size_t>(row)];
    const bool reversed = matrix(row, column) < 0 && !counts;  // counts may fall where the quantity rises
    if (column != row || reversed)
      wrong += fmt::format("{}{} is along the {}{} reading", wrong.empty() ? "" : ", ", "xyz"[row], reversed ? "-" : "", "xyz"[column]);
  }
  if (wrong.empty()) return;
  found.push_back(fmt::format("the {}' axes are not as declared: {}{}; check the order and the signs of both triads' columns", name, wrong,
                              matrix.determinant() < 0 && !counts ? " (left-handed)" : ""));
}

}  // namespace

std::string scale_contradiction(Triad triad, const Matrix3d& matrix, const Recording& recording) {
  const char* const name = triad == Triad::accel ? "accelerometers" : "gyros";
  const Vector3d scale = matrix.rowwise().norm();
  int wrong = 0, worst = 0;
  for (int row = 0; row < 3; ++row) {
    wrong += !near(scale[row], 1);
    if (std::abs(std::log(scale[row])) > std::abs(std::log(scale[worst]))) worst = row;
  }
  if (wrong == 0) return {};
  const bool common = near(scale.minCoeff(), scale.maxCoeff());
  return fmt::format("the {}{} scale is {:.4g} in the declared unit, where 1 is expected: {}", name, common ? "'" : fmt::format("' {}", "xyz"[worst]),
                     common ? scale.mean() : scale[worst],
                     common ? cause_of(triad, scale.mean(), recording) : "this axis is not like the others; check its column");
}

void expect_gyro_scale(const Matrix3d& coarse, const Recording& recording) {
  const Matrix3d axes = coarse.rowwise().normalized();
  constexpr double oblique = 0.2;  // misalignments are below a few percent
  if ((axes * axes.transpose() - Matrix3d::Identity()).cwiseAbs().maxCoeff() > oblique) return;
  if (const std::string wrong = scale_contradiction(Triad::gyro, coarse, recording); !wrong.empty())
    throw Error(fmt::format("{}: {}", recording.name, wrong));
}

std::vector<std::string> contradictions(const SensorModel& model, const Recording& recording) {
  std::vector<std::string> found;
  for (const Triad triad : {Triad::accel, Triad::gyro}) {
    const bool accel = triad == Triad::accel;
    const Matrix3d& matrix = (accel ? model.accel : model.gyro).matrix;
    const bool counts = (accel ? recording.accel_unit : recording.gyro_unit) == "count";
    judge_axes(found, accel ? "accelerometers" : "gyros", matrix, counts);
    if (std::string wrong = counts ? "" : scale_contradiction(triad, matrix, recording); !wrong.empty()) found.push_back(std::move(wrong));
  }
  return found;
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
