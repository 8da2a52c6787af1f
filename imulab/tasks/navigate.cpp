#include "imulab/tasks/navigate.hpp"

#include "imulab/core/error.hpp"
#include "imulab/formats/recording/solution.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/navigation/budget/navigated.hpp"
#include "imulab/navigation/navigation_error.hpp"

#include <utility>

namespace imulab {

Calibration no_calibration() {
  Calibration ideal;
  ideal.model.gyro.raw_unit = "rad/s";
  ideal.model.accel.raw_unit = "m/s^2";
  return ideal;
}

TrueMotion read_truth(const std::filesystem::path& file) {
  Solution solution = read_solution(file);
  return {file.string(), std::move(solution)};
}

std::optional<TrueMotion> session_truth(const Session& session) {
  if (!session.truth_file) return std::nullopt;
  return read_truth(session_path(session, *session.truth_file));
}

NavigatedSession navigate_session(const std::string& name, const Calibration& calibration, const Session& session, Recording recording,
                                  NavigateOptions options, const std::optional<TrueMotion>& truth, bool explain) {
  std::optional<ComparedStates> compared;
  if (truth && !options.keep) {
    compared.emplace(truth->solution);
    options.each = [&compared, each = std::move(options.each)](double time, const NavigationState& state) {
      if (each) each(time, state);
      compared->add(time, state);
    };
  }
  std::optional<NavigatedBudget> budget;
  if (explain) budget.emplace(calibration, session, options);
  NavigatedSession out{.session = name, .navigated = navigate(calibration, session, std::move(recording), options), .errors = {}};
  if (truth)
    out.errors = errors_at(truth->name, [&] { return navigation_errors(compared ? compared->solution() : out.navigated.solution, truth->solution); });
  if (budget) try {
      out.explained = budget->finish();
      if (!out.explained) out.unexplained = "the calibration has no uncertainties.";
    } catch (const Error& e) {
      out.unexplained = e.what();
    }
  return out;
}

}  // namespace imulab
