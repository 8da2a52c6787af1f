// imulab plan --require ...
#include "apps/imulab/checkpoint.hpp"
#include "apps/imulab/command.hpp"
#include "apps/imulab/prior.hpp"
#include "apps/imulab/report.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/hybrid/path_design.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/tasks/predict.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <memory>
#include <optional>

namespace imulab::command {

namespace {

struct Options {
  std::string require, grade = "navigation", axes = "3", report, prior;
  double latitude_deg = 45;
  std::optional<double> gravity, time, rest;
  std::optional<std::string> output;
  CheckpointOptions shared;
  bool json = false;
};

/// 1, 2, 3 and hand, or names.
std::vector<RigAxis> axes_of(const std::string& text) {
  using enum RigAxis;
  if (text == "1") return {outer};
  if (text == "2") return {middle, inner};
  if (text == "3" || text == "hand") return {outer, middle, inner};
  std::vector<RigAxis> axes;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string name = text.substr(begin, end - begin);
    const std::size_t before = axes.size();
    for (const RigAxis axis : {outer, middle, inner})
      if (name == to_string(axis) && std::find(axes.begin(), axes.end(), axis) == axes.end()) axes.push_back(axis);
    if (axes.size() == before) throw Error(fmt::format("--axes: {}; expected 1, 2, 3, hand, or names such as outer,inner", text));
    begin = end + 1;
  }
  std::sort(axes.begin(), axes.end());
  return axes;
}

void run(const Options& options) {
  PlanTask task{.requirements = errors_at("--require", [&] { return parse_requirements(options.require); }),
                .grade = options.grade,
                .latitude = options.latitude_deg * unit::deg,
                .gravity = options.gravity,
                .axes = axes_of(options.axes),
                .by_hand = options.axes == "hand",
                .time = options.time,
                .rest = options.rest};
  if (options.json && options.output == "-") throw Error("--json: standard output has the procedure; expected -o FILE");
  task.checkpoint = options.shared.checkpoint();
  if (!options.prior.empty()) task.prior = prior_at(options.prior);
  const PlannedProcedure planned = [&] {
    Progress progress("planning");
    task.progress = [&progress](double part) { progress.report(part); };
    return plan(task);
  }();
  if (options.shared.silent()) return;
  if (options.output) write_whole(*options.output, procedure_text(planned.procedure));
  if (options.json)
    print_json(plan_json(planned));
  else if (options.output != "-")
    print(plan_text(planned));
  if (!options.report.empty()) write_whole(options.report, plan_page(planned));
  if (const std::string missing = shortcomings(planned); !missing.empty()) throw Unsupported(missing);
}

}  // namespace

void add_plan(Verb app) {
  const auto o = std::make_shared<Options>();
  Verb verb = app.verb("plan", "Find the shortest sequence of turns and rests with which the hybrid method meets requirements");
  verb.option("--require LIMITS", o->require, "requirements, as in \"gyro.matrix.off_diagonal <= 1 arcsec, accel.offset <= 1 ug\"").required();
  verb.option("--grade GRADE", o->grade, "grade of the IMU's noise: strategic, navigation, tactical, mems, mems-30g").show_default();
  verb.option("--latitude", o->latitude_deg, "latitude of the site, degrees").in_range(-90, 90).show_default();
  verb.option("--gravity", o->gravity, "gravity measured to 1e-5 m/s^2; if absent, normal gravity, known to 3e-4").in_range(9.7, 9.9);
  verb.option("--axes AXES", o->axes, "axes of the table: 1 (outer, vertical), 2 (middle and inner), 3, hand, or names such as outer,inner")
      .show_default();
  verb.option("--time N", o->time, "find the best path within this many seconds instead of the shortest").in_range(60, hybrid::longest_path);
  verb.option("--rest", o->rest, "duration of every rest in whole seconds; if absent, each is chosen").in_range(6, 600, true);
  add_prior_option(verb, o->prior);
  verb.option("-o,--output FILE", o->output, "the procedure to write; - for standard output in place of the table").writes();
  add_report_option(verb, o->report);
  add_checkpoint_options(verb, o->shared);
  verb.flag("--json", o->json, "print the result as JSON");
  verb.example("imulab plan --require \"gyro.matrix.diagonal <= 10 ppm\" -o plan.toml");
  verb.does([o] { run(*o); });
}

}  // namespace imulab::command
