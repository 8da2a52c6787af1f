#include "imulab/tasks/drive_plan.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/session/mission.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/json.hpp"
#include "imulab/report/prediction_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

namespace imulab {
namespace {

/// From standstill to standstill, as segments of a mission.
struct Manoeuvre {
  std::string_view name, segments;
};

constexpr std::string_view standstill = "[[segment]]\nkind = \"brake\"\nduration_s = 5\n";

constexpr std::array manoeuvres{
    Manoeuvre{"rest of 60 s", "[[segment]]\nkind = \"rest\"\nduration_s = 60\n"},
    Manoeuvre{"hard braking", "[[segment]]\nkind = \"accelerate\"\nto_mps = 15\nduration_s = 6\n[[segment]]\nkind = \"brake\"\nduration_s = 3\n"},
    Manoeuvre{"slope",
              "[[segment]]\nkind = \"accelerate\"\nto_mps = 8\nduration_s = 5\n[[segment]]\nkind = \"climb\"\nangle_deg = 5\nduration_s = 6\n"
              "pitch_s = 3\n[[segment]]\nkind = \"brake\"\nduration_s = 4\n"},
    Manoeuvre{"figure eight",
              "[[segment]]\nkind = \"accelerate\"\nto_mps = 8\nduration_s = 5\n[[segment]]\nkind = \"turn\"\nangle_deg = 360\nrate_dps = 22\n"
              "[[segment]]\nkind = \"turn\"\nangle_deg = -360\nrate_dps = 22\n[[segment]]\nkind = \"brake\"\nduration_s = 4\n"},
    Manoeuvre{"there and back",
              "[[segment]]\nkind = \"accelerate\"\nto_mps = 8\nduration_s = 5\n[[segment]]\nkind = \"straight\"\nduration_s = 15\n[[segment]]\n"
              "kind = \"turn\"\nangle_deg = 180\nrate_dps = 22\n[[segment]]\nkind = \"straight\"\nduration_s = 15\n[[segment]]\nkind = \"brake\"\n"
              "duration_s = 4\n"},
};

/// The method that takes missions.
const Method& planned_method() {
  return *std::ranges::find_if(methods(), [](const Method& m) { return m.takes_aids && m.predict; });
}

/// A mission with what it reaches.
struct Judged {
  std::string text;
  double duration = 0, end_speed = 0;  // s, m/s
  Prediction prediction;
  double worst = 0;
};

Judged judged_drive(std::string text, const std::string& name, const PredictionOptions& options) {
  Judged out{.text = std::move(text)};
  const ReadProcedure read = procedure_of(parse_mission(out.text, name), name);
  PredictionOptions task = options;
  task.motion = read.motion;
  out.prediction = predict(planned_method(), read.session, task);
  out.duration = read.motion->time.back(), out.end_speed = read.motion->states.back().velocity.norm();
  for (const RequirementResult& r : assess(out.prediction, options.requirements)) out.worst = std::max(out.worst, r.reached / r.limit);
  return out;
}

void expect_no_path_options(const PlanOptions& o) {
  const PlanOptions usual;
  for (const auto& [name, given] : {std::pair{"axes", o.axes != usual.axes},
                                    {"grade", o.grade != usual.grade},
                                    {"noise", o.noise.has_value()},
                                    {"within", o.within.has_value()},
                                    {"rest", o.rest.has_value()},
                                    {"prior", !o.prior.empty()},
                                    {"part", o.shared.is_divided()}})
    if (given) throw OptionError(name, "belongs to a path of turns; a mission has its own IMU, and its maneuvers their own times");
}

PlannedDrive plan_drive(const PlanOptions& o, const std::function<void(double)>& progress) {
  const MappedFile mapped(*o.mission, Content::settings);
  const std::string name = input_name(*o.mission);
  const MissionFile file = parse_mission(mapped.text(), name);
  if (file.mission.carrier.banks || file.mission.track)
    throw Error(
        fmt::format("{}: the maneuvers are those of a vehicle on segments; expected carrier = \"vehicle\" and no [track]; of others imulab "
                    "predict --method {} judges what you add",
                    name, planned_method().name));
  const PredictionOptions options{.requirements = errors_of_option("require", [&] { return parse_requirements(o.require); }),
                                  .effects = o.effects == "table"};
  Judged now = judged_drive(std::string(mapped.text()) + "\n", name, options);
  PlannedDrive out{.requirements = options.requirements, .before = now.duration};
  constexpr std::size_t most = 20;  // manoeuvres: a quarter of an hour
  constexpr double helps = 0.01;    // of the worst ratio
  while (now.worst > o.margin && out.added.size() < most) {
    if (progress) progress(static_cast<double>(out.added.size()) / most);
    const std::string begin = now.text + (now.end_speed > 0.01 ? std::string(standstill) : "");
    std::optional<Judged> best;
    std::string_view best_name;
    double best_rate = 0;
    for (const Manoeuvre& m : manoeuvres) {
      Judged with = judged_drive(begin + std::string(m.segments), name, options);
      const double gain = std::log(now.worst / with.worst), rate = gain / (with.duration - now.duration);
      if (gain > helps && rate > best_rate) best = std::move(with), best_name = m.name, best_rate = rate;
    }
    if (!best) break;
    now = *std::move(best);
    out.added.emplace_back(best_name);
  }
  out.duration = now.duration, out.mission = std::move(now.text), out.prediction = std::move(now.prediction), out.worst = now.worst;
  return out;
}

PredictionSummary summary_of(const PlannedDrive& p) {
  PredictionSummary out = imulab::summary_of(p.prediction);
  out.added = {p.added, p.duration - p.before, p.duration, p.worst};
  return out;
}

std::string plan_headline(const PlannedDrive& p) {
  if (p.added.empty() && p.worst <= 1) return fmt::format("the mission as it is, {}", text::minutes(p.duration));
  if (p.added.empty()) return fmt::format("no maneuver helps; the mission lasts {}", text::minutes(p.duration));
  return fmt::format("added {}: {} longer, {} in all", fmt::join(p.added, ", "), text::minutes(p.duration - p.before), text::minutes(p.duration));
}

}  // namespace

AnswerOf<PlannedDrive> drive_plan_answer(const PlanOptions& o, const std::function<void(double)>& progress) {
  expect_no_path_options(o);
  const auto p = std::make_shared<const PlannedDrive>(plan_drive(o, progress));
  Conclusion conclusion = conclude(Verdict::none, "", assess(p->prediction, p->requirements));
  conclusion.headline = plan_headline(*p) + "; " + conclusion.headline;
  return {{.json = [p] { return prediction_json(summary_of(*p)); },
           .table = [p](bool details) { return prediction_text(p->prediction, p->requirements, details); },
           .page = [p, conclusion,
                    name = *o.mission] { return prediction_page({.procedure = name, .summary = summary_of(*p), .conclusion = conclusion}); },
           .shortcomings =
               p->worst <= 1 ? "" : "no maneuver of the table brings the drive to the requirements: " + shortfall_text(p->prediction.missed.front()),
           .conclusion = conclusion},
          p};
}

}  // namespace imulab
