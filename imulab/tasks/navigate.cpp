#include "imulab/tasks/navigate.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/budget/navigated.hpp"
#include "imulab/navigation/navigation_error.hpp"
#include "imulab/report/navigation_page.hpp"
#include "imulab/tasks/inspect.hpp"
#include "imulab/tasks/navigation_figures.hpp"
#include "imulab/units.hpp"

#include <map>
#include <utility>

namespace imulab {

Verb& declare(Verb& command, NavigateVerbOptions& o) {
  Verb& verb = command.verb("navigate", "Align, compute the pure-inertial solution, and compare it with a truth");
  verb.option("CALIBRATION", o.calibration, "calibration.json, or none if the recordings are in rad/s and m/s^2 already").required().reads();
  verb.option("SESSION", o.sessions, "sessions with one recording each, or recordings, which are inspected first; several give one row each")
      .required()
      .takes_several(1)
      .reads();
  verb.option("--vertical CHANNEL", o.vertical,
              "vertical channel; aided and held need a barometer, and held takes the height from it. Absent: as the session declares in "
              "[navigation], else free")
      .one_of({"free", "fixed", "aided", "held"});
  verb.option("--barometer FILE", o.barometer, "CSV file with t,height_m, for aided and held; absent: the session's").reads();
  verb.option("--align", o.align, "align on the first rest even if the session has [initial]");
  verb.option("--heading DEG", o.heading_deg, "heading at the end of the rest; only roll and pitch are then aligned")
      .in_range(-360., 360.)
      .called("heading_deg");
  verb.option("--heading-sigma DEG", o.heading_sigma_deg, "standard uncertainty of --heading; absent: exact")
      .in_range(0., 180.)
      .called("heading_sigma_deg");
  verb.option("--gaps HOW", o.gaps, "at missing samples: interpolate, or stop with exit code 2").one_of({"integrate", "refuse"}).show_default();
  verb.option("--aided", o.aided, "correct the solution with the session's aids ([[aid]]), and smooth it");
  verb.option("--filter", o.filter, "with --aided: at each time use only earlier data, but sizes of noise from the whole recording");
  verb.option("--outages EVERY,LENGTH", o.outages,
              "with --aided: withhold the aids for LENGTH seconds every EVERY seconds, and compare; a third number is the time of the first outage");
  verb.option("--truth FILE", o.truth, "reference solution; absent: the session's [truth]; not with --aided, which --outages checks").reads();
  verb.option(
      "--require LIMITS", o.require,
      "limits for the errors against the truth, as in \"horizontal <= 100 m at 300 s\" or, at the end, \"horizontal <= 1 nmi/h\"; also vertical, "
      "velocity, heading; of several sessions also CEP and RMS; exit code 1 otherwise; not with --aided");
  verb.option("-o,--output FILE", o.output,
              "the whole solution as CSV; - for standard output in place of the table; with --aided also .geojson, .kml, .pos, .mcap")
      .writes()
      .of_command();
  topics_option(verb, o.topics).of_command();
  declarations_option(verb, o.declarations);
  report_option(verb, o.report);
  allow_undetermined_option(verb, o.allow_undetermined);
  json_option(verb, o.json);
  verb.example("imulab navigate calibration.json drive --vertical fixed -o solution.csv");
  verb.example("imulab navigate none drive --aided --outages 60,10 -o solution.csv");
  return verb;
}

NavigateOptions navigate_options(const NavigateVerbOptions& o, const Session& session) {
  if (o.heading_sigma_deg && !o.heading_deg) throw OptionError("heading-sigma", "belongs to --heading; expected both");
  NavigateOptions options;
  options.vertical = o.vertical ? vertical_channel(*o.vertical) : session.vertical.value_or(VerticalChannel::free);
  const bool needs_heights = options.vertical == VerticalChannel::aided || options.vertical == VerticalChannel::held;
  if (!o.barometer.empty() && !needs_heights) throw OptionError("barometer", "belongs to --vertical aided or held; expected one of them");
  options.align = o.align;
  options.gaps = o.gaps == "refuse" ? GapTreatment::refuse : GapTreatment::integrate;
  if (o.heading_deg) options.heading = {*o.heading_deg * unit::deg, o.heading_sigma_deg.value_or(0) * unit::deg};
  if (!o.barometer.empty())
    options.barometer = read_heights(o.barometer);
  else if (needs_heights && session.barometer_file)
    options.barometer = read_heights(session_path(session, *session.barometer_file).string());
  return options;
}

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

namespace {

/// The warnings of a session's navigation and of its comparison.
std::vector<std::string> warnings_of(const NavigatedSession& session) {
  std::vector<std::string> all = session.navigated.warnings;
  if (session.errors) all.insert(all.end(), session.errors->warnings.begin(), session.errors->warnings.end());
  return all;
}

}  // namespace

AnswerOf<std::vector<NavigatedSession>> navigation_answer(std::vector<NavigatedSession> sessions, const NavigateVerbOptions& o,
                                                          const std::vector<std::string>& told) {
  const auto all = std::make_shared<const std::vector<NavigatedSession>>(std::move(sessions));
  const auto required = o.require ? errors_of_option("require", [&] { return assess(*all, *o.require); }) : std::vector<RequirementResult>();
  const bool doubtful = std::any_of(all->begin(), all->end(), [](const NavigatedSession& s) { return s.navigated.doubtful; });
  const Conclusion conclusion = conclude(doubtful ? Verdict::doubtful : Verdict::none, navigation_headline(*all), required);
  std::vector<std::string> warnings;
  for (const NavigatedSession& one : *all)
    for (const std::string& text : warnings_of(one)) warnings.push_back((all->size() > 1 ? one.session + ": " : "") + text);
  return {{.json = [all] { return navigation_json(*all); },
           .table = [all](bool) { return navigation_table(*all); },
           .page = [all, conclusion, told] { return navigation_page({.sessions = *all, .warnings = told, .conclusion = conclusion}); },
           .warnings = std::move(warnings),
           .told = told,
           .shortcomings = missed_requirements(conclusion),
           .conclusion = conclusion},
          all};
}

}  // namespace imulab
