#include "imulab/procedure.hpp"

#include "imulab/core/random.hpp"
#include "imulab/error.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/turn.hpp"
#include "imulab/session.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace imulab {

namespace {

/// Uniform over all attitudes: outer and inner uniform, middle with density cos. In whole tenths of a degree, which are easy to read in a file.
std::array<double, 3> random_tenths(std::uint64_t seed, std::uint64_t pose) {
  const RandomStream draws(seed, "hand-held attitudes");  // of the name depend the draws
  const auto symmetric = [&](std::uint64_t k) { return 2 * draws.uniform(3 * pose + k) - 1; };
  return {std::round(1800 * symmetric(0)), std::round(std::asin(symmetric(1)) / unit::deg * 10), std::round(1800 * symmetric(2))};
}

void validate(const HandHeldOptions& o) {
  if (o.poses < 1) throw Error("handheld: no poses; expected at least one");
  constexpr int most_poses = 100'000;
  if (o.poses > most_poses) throw Error(fmt::format("handheld: {} poses; expected at most {}", o.poses, most_poses));
  if (!(o.first_rest > 0 && o.rest > 0 && o.move > 0)) throw Error("handheld: expected durations above 0 of the rests and moves");
  if (!(o.rate_hz > 0)) throw Error("handheld: expected a sampling rate above 0");
}

RecordingSource si_recording(double rate_hz) {
  RecordingSource source;
  source.file = "recording.csv";
  source.rate_hz = rate_hz;
  source.time.column = std::string("t");
  source.gyro.columns = {"gx", "gy", "gz"};
  source.gyro.unit = "rad/s";
  source.accel.columns = {"ax", "ay", "az"};
  source.accel.unit = "m/s^2";
  return source;
}

}  // namespace

Session hand_held_procedure(const HandHeldOptions& options, std::uint64_t seed) {
  validate(options);
  Session session;
  session.imu.name = "handheld";
  session.imu.grade = options.grade;
  session.site.latitude = options.latitude;
  session.site.height = options.height;
  session.rigs.emplace_back();  // kind none
  session.recordings.push_back(si_recording(options.rate_hz));
  std::array<double, 3> tenths{};
  for (int pose = 0; pose < options.poses; ++pose) {
    const auto target = random_tenths(seed, static_cast<std::uint64_t>(pose));
    Step hold;
    hold.recording = session.recordings.front().file;
    hold.start = pose == 0 ? 0 : session.steps.back().end + options.move;
    hold.end = hold.start + (pose == 0 ? options.first_rest : options.rest);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      tenths[axis] += std::remainder(target[axis] - tenths[axis], 3600);  // the hand goes the short way
      hold.angles[axis] = tenths[axis] / 10 * unit::deg;
    }
    session.steps.push_back(hold);
  }
  validate(session);
  return session;
}

Session warm_up_procedure(const WarmUpOptions& options, std::uint64_t seed) {
  HandHeldOptions by_hand = options.by_hand;
  constexpr double least_K = 10;  // from which thermal terms are estimated
  if (!(std::abs(options.to - options.from) >= least_K && std::isfinite(options.to - options.from)))
    throw Error(fmt::format("warm-up: {:g} to {:g} degC; expected a change of {:g} K or more", options.from, options.to, least_K));
  if (!(options.minutes > 0)) throw Error(fmt::format("warm-up: {:g} minutes; expected more than 0", options.minutes));
  const double seconds = 60 * options.minutes, pause = by_hand.rest + by_hand.move;
  const double more = std::floor((seconds - by_hand.first_rest) / pause);
  constexpr int least_poses = 9;  // a triad's offset and matrix
  if (!(more + 1 >= least_poses))
    throw Error(
        fmt::format("warm-up: {:g} minutes have room for less than {} rests; expected more minutes, or shorter rests", options.minutes, least_poses));
  by_hand.poses = 1 + static_cast<int>(std::min(1e6, more));
  Session session = hand_held_procedure(by_hand, seed);
  session.imu.name = "warm-up";
  RecordingSource& source = session.recordings.front();
  source.gyro_temperature = source.accel_temperature = ThermalSource{.columns = {std::string("temperature")}};
  constexpr double time_constants = 3;
  for (Step& step : session.steps) {
    const double way = 1 - std::exp(-time_constants * step.end / session.steps.back().end);
    step.temperature = std::round(10 * (options.from + (options.to - options.from) * way)) / 10;
  }
  session.steps.front().temperature = options.from;
  validate(session);
  return session;
}

namespace {

constexpr double acceleration = default_acceleration_dps2 * unit::deg;

/// Writes steps one after the other, in whole degrees.
class TableSteps {
 public:
  TableSteps(std::string name, const TableProcedureOptions& o) : options_(o) {
    if (!(o.rest > 0 && o.move > 0 && o.turn_rate > 0 && o.rate_hz > 0))
      throw Error(name + ": expected a duration of the rests, a rate of the turns and a sampling rate above 0");
    if (!(o.table >= 0)) throw Error(name + ": expected a table sigma of at least 0");
    if (o.turns < 1) throw Error(name + ": no turns; expected at least one");
    session_.imu.name = std::move(name);
    session_.imu.grade = o.grade;
    session_.site.latitude = o.latitude;
    session_.site.height = o.height;
    RigDeclaration& rig = session_.rigs.emplace_back();
    rig.kind = RigKind::turntable;
    rig.angle.value = rig.orthogonality.value = rig.zero.value = o.table;
    rig.timing.value = 10e-3;
    session_.recordings.push_back(si_recording(o.rate_hz));
  }

  void rest() { rest_for(options_.rest); }
  void rest_for(double seconds) { session_.steps.push_back(next(StepKind::hold, seconds)); }
  /// A rest at other angles.
  void rest_at(double outer, double middle, double inner) {
    const std::array<double, 3> angles{outer, middle, inner};
    if (angles != degrees_ && !session_.steps.empty()) time_ += options_.move;
    if (angles != degrees_ && session_.steps.empty()) time_ = options_.move;
    degrees_ = angles;
    rest();
  }
  void turn(RigAxis axis, double angle_deg) {
    const double angle = angle_deg * unit::deg;
    Step step = next(StepKind::rotate, turn_duration(angle, options_.turn_rate, acceleration));
    step.axis = axis, step.angle = angle, step.rate = options_.turn_rate, step.acceleration = acceleration;
    degrees_[static_cast<std::size_t>(axis)] += angle_deg;
    session_.steps.push_back(step);
  }
  Session session() const {
    validate(session_);
    return session_;
  }

 private:
  Step next(StepKind kind, double duration) {
    Step step;
    step.kind = kind;
    step.recording = session_.recordings.front().file;
    step.start = time_;
    step.end = time_ += duration;
    for (std::size_t a = 0; a < 3; ++a) step.angles[a] = degrees_[a] * unit::deg;
    return step;
  }

  TableProcedureOptions options_;
  Session session_;
  double time_ = 0;
  std::array<double, 3> degrees_{};
};

}  // namespace

Session six_position_procedure(const TableProcedureOptions& options) {
  TableSteps table("six-position", options);
  for (const auto& [middle, inner] : {std::pair{0.0, 0.0}, {0.0, 90.0}, {90.0, 0.0}, {0.0, 180.0}, {0.0, -90.0}, {-90.0, 0.0}})
    table.rest_at(0, middle, inner);
  return table.session();
}

TableProcedureOptions ferraris_options() {
  TableProcedureOptions options;
  options.rest = 5, options.move = 2, options.turn_rate = 90 * unit::deg, options.table = 1 * unit::deg, options.grade = "mems";
  return options;
}

Session ferraris_procedure(const TableProcedureOptions& options) {
  struct Face {
    double middle, inner;
  };
  TableSteps table("ferraris", options);
  for (const Face face : {Face{-90, 0}, {90, 0}, {0, 90}, {0, -90}, {0, 0}, {0, 180}}) table.rest_at(0, face.middle, face.inner);
  double heading = 0;
  for (const Face face : {Face{-90, 0}, {0, 90}, {0, 0}}) {
    table.rest_at(heading += 90, face.middle, face.inner);  // put down anew
    table.turn(RigAxis::outer, 360);
    table.rest();
  }
  return table.session();
}

Session zhang_24_procedure(const TableProcedureOptions& options) {
  TableSteps table("zhang-24", options);
  const double turns = 360.0 * options.turns;
  table.rest();
  for (const RigAxis axis : {RigAxis::middle, RigAxis::outer, RigAxis::inner})
    for (const double angle : {turns, -turns}) {
      table.turn(axis, angle);
      table.rest();
    }
  struct Face {
    double inner, middle;
  };
  for (const Face face : {Face{90, 0}, {0, 0}, {0, -90}, {-90, 0}, {0, 180}, {0, 90}})
    for (const double outer : {0.0, 90.0, 180.0, 270.0}) table.rest_at(outer, face.middle, face.inner);
  return table.session();
}

Session two_axis_procedure(const TableProcedureOptions& options) {
  TableSteps table("two-axis", options);
  const double turns = 360.0 * options.turns;
  const auto both_ways = [&](RigAxis axis) {
    for (const double angle : {turns, -turns}) {
      table.turn(axis, angle);
      table.rest();
    }
  };
  table.rest();
  both_ways(RigAxis::inner);
  both_ways(RigAxis::middle);
  table.rest_at(0, 0, 90);  // the other body axis is along the middle one
  both_ways(RigAxis::middle);
  for (const double middle : {0.0, 90.0, 180.0, 270.0})
    for (const double inner : {0.0, 90.0, 180.0, 270.0}) table.rest_at(0, middle, inner);
  return table.session();
}

Session turns_procedure(const std::string& name, double first_rest, std::span<const TableTurn> turns, const TableProcedureOptions& options) {
  TableSteps table(name, options);
  table.rest_for(first_rest);
  for (const TableTurn& turn : turns) {
    table.turn(turn.axis, turn.angle_deg);
    table.rest_for(turn.rest);
  }
  return table.session();
}

Session cheng_path_procedure(const TableProcedureOptions& options) {
  using enum RigAxis;
  std::vector<TableTurn> turns;
  for (const auto& [axis, angle] :
       {std::pair{middle, 90.0}, {middle, 180.0}, {middle, 180.0}, {middle, -90.0}, {inner, 90.0},   {inner, 180.0}, {inner, 180.0},
        {middle, 90.0},          {middle, 180.0}, {middle, 180.0}, {outer, 90.0},   {middle, -90.0}, {inner, -90.0}, {outer, 90.0},
        {inner, -90.0},          {middle, 90.0},  {inner, 90.0},   {outer, -90.0},  {middle, 90.0},  {inner, -90.0}})
    turns.push_back({axis, angle, options.rest});
  return turns_procedure("cheng-path", options.rest, turns, options);
}

const std::vector<TableProcedure>& table_procedures() {
  static const std::vector<TableProcedure> table{
      {"six-position", "Turntable: each body axis up and down", six_position_procedure, {}},
      {"two-axis", "Table with two axes: five turns each way about each body axis, then 16 positions", two_axis_procedure, {}},
      {"zhang-24", "Turntable: five turns each way about each axis, then 24 positions", zhang_24_procedure, {}},
      {"cheng-path", "Turntable: 20 turns of 90 and 180 deg between rests", cheng_path_procedure, {}},
      {"ferraris", "By hand against a box: each axis up and down, a turn of 360 deg about each", ferraris_procedure, ferraris_options()}};
  return table;
}

}  // namespace imulab
