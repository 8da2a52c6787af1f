#include "imulab/tasks/live.hpp"

#include "imulab/compensate.hpp"
#include "imulab/core/memory.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/rests/rests.hpp"
#include "imulab/recording/readings.hpp"
#include "imulab/recording/rest_means.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/rests.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab {
namespace {

std::string unmet(const Quality& quality) {
  std::string list;
  for (const RequirementResult& r : quality.requirements)
    if (!r.met) list += (list.empty() ? "" : ", ") + progress_text(r);
  if (!quality.unobservable.empty()) list += fmt::format("{}{} coefficients not determined", list.empty() ? "" : ", ", quality.unobservable.size());
  return list.empty() ? "the fit did not converge" : list;
}

}  // namespace

std::string usual_live_requirement(const std::string& accel_unit) {
  const std::string usual =
      "gyro.matrix.diagonal <= 500 ppm, gyro.matrix.off_diagonal <= 120 arcsec, accel.matrix.diagonal <= 500 ppm, accel.matrix.off_diagonal <= 120 "
      "arcsec";
  return accel_unit == "count" ? usual : usual + ", accel.offset <= 500 ug";  // that of counts is at zero counts, which may be anywhere
}

std::vector<Requirement> live_requirements(const std::optional<std::string>& text, const std::string& accel_unit, const Site& site) {
  std::vector<Requirement> all = parse_requirements(text.value_or(usual_live_requirement(accel_unit)));
  const double gravity = site.gravity_sigma() / site.gravity();
  for (const Requirement& r : all)
    for (const CoefficientIndex index : r.coefficients)
      if (const Coefficient& c = coefficient(index); c.triad == Triad::accel && is_scale(c) && r.limit <= gravity)
        throw Unsupported(fmt::format(
            "{}: {} cannot be better than gravity, {:.3g} ppm; expected a better known gravity or height of the site, or a looser requirement",
            to_string(r), c.name, 1e6 * gravity));
  return all;
}

std::string shortcomings(const LiveProgress& progress) {
  const LiveView& view = progress.view();
  if (!view.problem.empty()) return view.problem + (view.next ? "\n  what helps most: " + turns_text({*view.next}) : "");
  if (progress.reached()) return "";
  if (!progress.result()) return "no rest so far; expected the IMU to be held still, then turned";
  return fmt::format("not reached: {}{}", unmet(progress.result()->calibration.quality),
                     view.next ? "\n  what helps most: " + turns_text(progress.result()->missing_turns) : "");
}

LiveProgress::LiveProgress(Session session, RecordingOptions options, std::vector<Requirement> requirements, double rest_s)
    : session_(std::move(session)), requirements_(std::move(requirements)), options_(std::move(options)) {
  session_.steps.clear();
  view_.imu = session_.imu.name;
  view_.rest_s = rest_s;
}

std::optional<Range> LiveProgress::add(const Recording& piece, Range samples) {
  constexpr double often_s = 0.25, parts = 1200;  // rests are looked for, in all that came: less often the longer it is
  while (samples.begin < samples.end) {
    const double every_s = std::max(often_s, looked_s_ / parts);
    std::size_t end = samples.begin + 1;
    const double start_s = all_.size() > 0 ? all_.time_s(0) : piece.time_s(samples.begin);
    while (end < samples.end && piece.time_s(end - 1) - start_s - looked_s_ < every_s) ++end;
    append(all_, piece, {samples.begin, end});
    samples.begin = end;
    view_.time_s = all_.time_s(all_.size() - 1) - start_s, view_.samples = all_.size();
    if (all_.size() < 2 || view_.time_s - looked_s_ < every_s) continue;
    looked_s_ = view_.time_s;
    if (!find_rest()) continue;
    estimate();
    return samples;
  }
  return std::nullopt;
}

/// Looks for rests; true where the last one has just become long enough, or has ended and is nearly that long.
bool LiveProgress::find_rest() {
  constexpr double now_s = 0.3;      // a rest that ends later is still going on: the last window of the detection may be cut
  constexpr double of_ended = 0.75;  // who moves on a little early need not come back
  constexpr double most_memory = 4;  // over what came: the copy with its findings, one that is being made, room to grow, and what a calibration takes
  expect_memory(most_memory * static_cast<double>(all_.bytes()), fmt::format("a calibration while {:.0f} s arrive", view_.time_s));
  recording_ = completed(all_, options_);
  rests_ = detect_rests(recording_).rests;
  view_.resting_s.reset(), view_.now.reset();
  if (rests_.empty()) return false;
  const Range& last = rests_.back();
  const double duration = recording_.time_s(last.end - 1) - recording_.time_s(last.begin);
  const bool now = recording_.time_s(recording_.size() - 1) - recording_.time_s(last.end - 1) < now_s;
  if (now) view_.resting_s = duration, view_.now = up_at(last);
  if (duration < view_.rest_s * (now ? 1 : of_ended) || last.begin < estimated_) return false;
  estimated_ = recording_.size();
  return true;
}

void LiveProgress::estimate() {
  if (recording_.size() != all_.size()) recording_ = completed(all_, options_), rests_ = detect_rests(recording_).rests;
  CalibrationOptions options;
  options.handheld = {requirements_, 1, view_.rest_s};
  view_.problem.clear(), view_.requirements.clear(), view_.next.reset();
  try {
    Session session = session_;
    if (!session.recordings.empty()) session.recordings.front().file = recording_.name;  // a stream has the name of where it comes from
    result_ = calibrate("handheld", {session, {&recording_, 1}, {}}, options);
    for (const Requirement& r : requirements_) result_->calibration.quality.requirements.push_back(assess(result_->calibration, r));
    view_.requirements = result_->calibration.quality.requirements;
    view_.done = reached();
    if (!result_->missing_turns.empty()) view_.next = result_->missing_turns.front();
  } catch (const Unsupported& e) {  // of counts, as long as their scale is not known
    result_.reset();
    view_.problem = e.what();
    if (!rests_.empty()) view_.next = rests::opening_turn(rests_.size());
  }
  describe(rests_);
}

bool LiveProgress::reached() const {
  if (!result_) return false;
  const Quality& q = result_->calibration.quality;
  return q.converged && q.unobservable.empty() && std::all_of(q.requirements.begin(), q.requirements.end(), [](const auto& r) { return r.met; });
}

/// The upward direction at a rest; none as long as the scale is not known.
std::optional<Eigen::Vector3d> LiveProgress::up_at(const Range& rest) const {
  if (!result_) return std::nullopt;
  const RestMeans means = summarize_rests(recording_, {rest}).front();
  return compensate(result_->calibration.model, RawSample{.gyro = means.gyro, .accel = means.accel}).force.normalized();
}

/// Fills in the upward direction at each rest, and the angle by which the unit turned about each axis.
void LiveProgress::describe(const std::vector<Range>& rests) {
  view_.up.clear(), view_.turned_deg.setZero();
  if (!result_) return;
  const SensorModel& model = result_->calibration.model;
  for (const Range& rest : rests) view_.up.push_back(*up_at(rest));
  if (view_.resting_s) view_.now = view_.up.back();
  for (std::size_t k = 1; k < rests.size(); ++k) {
    const Range turn{rests[k - 1].end, rests[k].begin};
    Vector3d sum = Vector3d::Zero();
    for (std::size_t i = turn.begin; i < turn.end; ++i) sum += reading_at(recording_.gyro, i);
    const auto n = static_cast<double>(turn.size());
    view_.turned_deg += (n * model.gyro.offset + model.gyro.matrix * sum).cwiseAbs() * recording_.interval_s / unit::deg;
  }
}

}  // namespace imulab
