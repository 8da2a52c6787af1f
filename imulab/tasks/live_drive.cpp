#include "imulab/tasks/live_drive.hpp"

#include "imulab/core/memory.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/recording/readings.hpp"
#include "imulab/results/live.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace imulab {
namespace {

/// Takes the last row away: a file that is being written may end inside it.
void drop_last_row(AidRecord& record) {
  record.time.pop_back();
  const auto shorten = [](auto& column) {
    if (!column.empty()) column.pop_back();
  };
  shorten(record.position), shorten(record.position_sigma), shorten(record.velocity), shorten(record.velocity_sigma);
  shorten(record.value), shorten(record.value_sigma);
}

}  // namespace

LiveDrive::LiveDrive(const Method& method, Session session, RecordingOptions options, std::vector<Requirement> requirements)
    : method_(&method), session_(std::move(session)), requirements_(std::move(requirements)), options_(std::move(options)) {
  if (session_.aids.empty())
    throw Error(
        fmt::format("{}: has no aids; expected [[aid]], as kind = \"gnss\" with the file that the receiver's rows are written to", session_.file));
  session_.steps.clear();
  view_.imu = session_.imu.name;
}

std::optional<Range> LiveDrive::add(const Recording& piece, Range samples) {
  const std::optional<Range> left = all_.add(piece, samples);
  view_.time_s = all_.time_s(), view_.samples = all_.samples().size();
  if (left) estimate(false);
  return left;
}

/// Aids that have no row yet are left out, as long as another has.
std::vector<Aid> LiveDrive::aids_now(bool last) const {
  std::vector<Aid> out;
  std::string problems;
  bool any = false;
  for (const Aid& aid : session_.aids) {
    Session one = session_;
    one.aids = {aid};
    try {
      for (Aid& read : read_aids(one, one.recordings.front(), recording_).aids) {
        if (has_record(read.kind) && !last) drop_last_row(read.record);
        if (has_record(read.kind) && read.record.time.empty()) continue;
        any = any || has_record(read.kind);
        read.recording.clear();
        out.push_back(std::move(read));
      }
    } catch (const Error& e) {
      problems += (problems.empty() ? "" : "; ") + std::string(e.what());
    }
  }
  if (!any) throw Error(problems.empty() ? "the files of the aids have no rows" : problems);
  return out;
}

void LiveDrive::estimate(bool last) {
  constexpr double most_memory = 4;  // over what came: copies with findings, room to grow, and the epochs of the smoother
  expect_memory(most_memory * static_cast<double>(all_.samples().bytes()), fmt::format("a calibration while {:.0f} s arrive", view_.time_s));
  recording_ = completed(all_.samples(), options_);
  view_ = {.imu = view_.imu, .time_s = view_.time_s, .samples = view_.samples};
  try {
    Session session = session_;
    session.aids = aids_now(last);
    session.recordings.front().file = recording_.name;  // a stream has the name of where it comes from
    result_ = calibrate(*method_, {session, {&recording_, 1}});
  } catch (const Error& e) {
    result_.reset(), view_.problem = e.what();
    return;
  } catch (const Unsupported& e) {
    result_.reset(), view_.problem = e.what();
    return;
  }
  Quality& quality = result_->calibration.quality;
  for (const Requirement& r : requirements_) quality.requirements.push_back(assess(result_->calibration, r));
  view_.requirements = quality.requirements, view_.because = quality.findings.reasons();
  view_.missing = missing_coefficients(result_->calibration, requirements_);
  view_.done = !requirements_.empty() && std::ranges::all_of(quality.requirements, &RequirementResult::met);
}

std::string shortcomings(const LiveDrive& drive) {
  const LiveDriveView& view = drive.view();
  if (!view.problem.empty()) return "no estimate: " + view.problem;
  std::string unmet;
  for (const RequirementResult& r : view.requirements)
    if (!r.met) unmet += (unmet.empty() ? "" : ", ") + progress_text(r);
  for (const std::string& reason : view.because) unmet += (unmet.empty() ? "" : "; ") + reason;
  if (unmet.empty()) return "";
  const bool helps = !view.missing.empty() && !view.missing.front().shown_by.empty();
  return "not reached: " + unmet + (helps ? "\n  what helps most: " + view.missing.front().shown_by : "");
}

}  // namespace imulab
