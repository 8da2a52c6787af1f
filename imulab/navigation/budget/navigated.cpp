#include "imulab/navigation/budget/navigated.hpp"

#include "imulab/error.hpp"

#include <algorithm>
#include <utility>

namespace imulab {

NavigatedBudget::NavigatedBudget(const Calibration& calibration, const Session& session, NavigateOptions& options, int outputs)
    : calibration_(calibration), strapdown_{.vertical = options.vertical, .gravity = session.site.given_gravity}, outputs_(std::max(1, outputs)) {
  if (calibration.estimated.empty()) return;
  options.begin = [this, then = std::move(options.begin)](const NavigationStart& start) {
    begin(start);
    if (then) then(start);
  };
  options.step = [this, then = std::move(options.step)](double time, const NavigationState& state, const Increment& sample) {
    step(time, state, sample);
    if (then) then(time, state, sample);
  };
}

void NavigatedBudget::begin(const NavigationStart& start) try {
  refused_ = nullptr;
  ErrorSources sources = error_sources(calibration_);
  if (start.aligned) {
    sources.start.aligned_over = start.aligned->end - start.aligned->begin;
    sources.gyro_noise.N = start.aligned->alignment.gyro_noise;
    sources.accel_noise.N = start.aligned->alignment.accel_noise;
  }
  budget_.emplace(start.time, start.interval, start.state, sources,
                  BudgetOptions{.strapdown = strapdown_, .output_interval = (start.end - start.time) / outputs_, .algorithm = false});
} catch (const Error&) {  // the navigation continues without a budget
  refused_ = std::current_exception();
}

void NavigatedBudget::step(double time, const NavigationState& state, const Increment& sample) try {
  if (!refused_) budget_->add(time, state, sample);
} catch (const Error&) {
  refused_ = std::current_exception();
}

std::optional<ErrorBudget> NavigatedBudget::finish() {
  if (refused_) std::rethrow_exception(refused_);
  if (!budget_) return {};
  return budget_->finish();
}

}  // namespace imulab
