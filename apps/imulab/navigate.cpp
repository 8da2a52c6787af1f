// imulab navigate CALIBRATION SESSION...
#include "imulab/analysis/navigate.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/session_recording.hpp"
#include "imulab/analysis/navigation_error.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/io/calibration_file.hpp"
#include "imulab/io/navigation_text.hpp"
#include "imulab/io/session_file.hpp"
#include "imulab/io/solution_file.hpp"
#include "imulab/io/timed_table.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>

namespace imulab::command {

namespace {

namespace fs = std::filesystem;
constexpr double nmi_per_h = unit::nmi / unit::hour;

struct Options {
  std::string calibration, output, truth, barometer, vertical = "free", gaps = "integrate";
  std::vector<std::string> sessions;
  std::optional<double> heading_deg, heading_sigma_deg;
  NavigateOptions navigate;
  bool json = false;
};

// ---- what goes in

const std::map<std::string, VerticalChannel> vertical_channels{
    {"free", VerticalChannel::free}, {"fixed", VerticalChannel::fixed}, {"aided", VerticalChannel::aided}, {"held", VerticalChannel::held}};

/// The word none: a unit whose recordings are in SI already.
Calibration calibration_of(const std::string& name) {
  if (name != "none") return read_calibration(name);
  Calibration ideal;
  ideal.model.gyro.raw_unit = "rad/s";
  ideal.model.accel.raw_unit = "m/s^2";
  return ideal;
}

HeightRecord read_barometer(const std::string& file) {
  const TimedTable table = read_timed_table(file, {.column = "t", .unit = "s", .zero_ns = 0}, {Column("height_m")});
  HeightRecord out;
  for (const std::int64_t ns : table.time_ns) out.time.push_back(1e-9 * static_cast<double>(ns));
  out.height = table.values[0];
  return out;
}

void check(const Options& o) {
  const bool needs_heights = o.navigate.vertical == VerticalChannel::aided || o.navigate.vertical == VerticalChannel::held;
  if (!o.barometer.empty() && !needs_heights) throw Error("--barometer: is used by --vertical aided or held, expected one of them");
  for (const auto& [name, value] : {std::pair("--heading", o.heading_deg), std::pair("--heading-sigma", o.heading_sigma_deg)})
    if (value && !std::isfinite(*value)) throw Error(fmt::format("{}: {} is no angle, expected a finite number of degrees", name, *value));
  if (o.heading_sigma_deg && !o.heading_deg) throw Error("--heading-sigma: expected --heading too");
  if (o.sessions.size() == 1) return;
  for (const auto& [name, value] : {std::pair("--output", o.output), std::pair("--truth", o.truth), std::pair("--barometer", o.barometer)})
    if (!value.empty()) throw Error(fmt::format("{}: belongs to one session, expected it with a single SESSION", name));
}

/// The raw data are never overwritten.
void check_inputs_stay(const Options& options, const Session& session) {
  if (options.output.empty()) return;
  if (options.output == "-" || fs::is_directory(options.output)) throw Error(fmt::format("-o {}: expected a file to write", options.output));
  std::vector<fs::path> inputs{options.calibration, options.truth, options.barometer};
  if (session.truth_file) inputs.push_back(session_path(session, *session.truth_file));
  expect_inputs_stay(options.output, session, inputs);
}

NavigatedSession navigated(const Options& options, const Calibration& calibration, const std::string& name) {
  const Session session = read_session(name);
  if (session.recordings.size() != 1)
    throw Error(fmt::format("{}: has {} recordings, expected one to navigate", session.file, session.recordings.size()));
  check_inputs_stay(options, session);
  const Recording recording = read_for(calibration, session, session.recordings[0]);
  NavigatedSession out{name, navigate(calibration, session, recording, options.navigate), {}};
  if (!options.truth.empty() || session.truth_file) {
    const fs::path truth = options.truth.empty() ? session_path(session, *session.truth_file) : fs::path(options.truth);
    const Solution reference = read_solution(truth);
    try {
      out.errors = navigation_errors(out.navigated.solution, reference);
    } catch (const Error& e) {
      throw Error(fmt::format("{}: {}", truth.string(), e.what()));
    }
  }
  const std::string who = options.sessions.size() > 1 ? name + ": " : "";
  for (const auto& text : out.navigated.warnings) warn(who + text);
  if (out.errors)
    for (const auto& text : out.errors->warnings) warn(who + text);
  return out;
}

// ---- what comes out

/// As a compass counts, 0 to 360, rounded to `decimals`: what would print as 360 is 0.
double compass_deg(const EulerAngles& angles, int decimals) {
  const double steps = std::pow(10, decimals), deg = std::round(angles.heading / unit::deg * steps) / steps;
  return deg < 0 ? deg + 360 : std::abs(deg);
}

void print_alignment(const AlignedOn& aligned) {
  const FineAlignment& a = aligned.alignment;
  const EulerAngles angles = euler_angles(a.attitude.C_nb);
  const Eigen::Vector3d sigma = angle_sigmas(a.attitude) / unit::deg;
  fmt::print("aligned on the rest from {:.3f} s to {:.3f} s\n", aligned.begin, aligned.end);
  fmt::print("  roll     {:>12.5f} deg  +/- {:.2g}\n", angles.roll / unit::deg, sigma.x());
  fmt::print("  pitch    {:>12.5f} deg  +/- {:.2g}\n", angles.pitch / unit::deg, sigma.y());
  fmt::print("  heading  {:>12.5f} deg  +/- {:.2g}\n", compass_deg(angles, 5), sigma.z());
  fmt::print("  gyro noise {:.2g} deg/sqrt(h), accelerometer noise {:.2g} ug/sqrt(Hz); normalised innovations {:.2f} (1: as stated)\n",
             a.gyro_noise / unit::deg_per_sqrt_h, a.accel_noise / unit::ug_per_sqrt_hz, std::sqrt(a.innovation_square));
}

void print_end(const Solution& solution) {
  const NavigationState& s = solution.states.back();
  const EulerAngles angles = euler_angles(s.q_nb.toRotationMatrix());
  fmt::print("end      latitude {:.7f} deg, longitude {:.7f} deg, height {:.3f} m\n", s.latitude / unit::deg, s.longitude / unit::deg, s.height);
  fmt::print("         velocity east {:.4f}, north {:.4f}, up {:.4f} m/s\n", s.velocity.x(), s.velocity.y(), s.velocity.z());
  fmt::print("         roll {:.4f}, pitch {:.4f}, heading {:.4f} deg\n", angles.roll / unit::deg, angles.pitch / unit::deg,
             compass_deg(angles, 4));
}

void print_errors(const NavigationErrors& errors) {
  const NavigationError& e = errors.history.back();
  fmt::print("\nerrors at {:.3f} s   {:>11} {:>11} {:>11} {:>11}\n", e.time, "east", "north", "up", "horizontal");
  fmt::print("  position, m       {:>11.4g} {:>11.4g} {:>11.4g} {:>11.4g}\n", e.position.x(), e.position.y(), e.position.z(), e.horizontal());
  fmt::print("  velocity, m/s     {:>11.4g} {:>11.4g} {:>11.4g} {:>11.4g}\n", e.velocity.x(), e.velocity.y(), e.velocity.z(),
             e.velocity.head<2>().norm());
  fmt::print("  attitude, arcsec  {:>11.4g} {:>11.4g} {:>11.4g}\n", e.attitude.x() / unit::arcsec, e.attitude.y() / unit::arcsec,
             e.attitude.z() / unit::arcsec);
  fmt::print("  rate              {:.4g} nmi/h\n", errors.rate / nmi_per_h);
}

void print_one(const NavigatedSession& s, const std::string& output) {
  const Solution& solution = s.navigated.solution;
  fmt::print("{}: navigated from {:.3f} s to {:.3f} s ({:.1f} s), vertical channel {}\n", s.session, solution.time.front(), solution.time.back(),
             solution.time.back() - solution.time.front(), to_string(s.navigated.vertical));
  if (s.navigated.aligned) {
    print_alignment(*s.navigated.aligned);
  } else {
    fmt::print("started as the session says ([initial])\n");
  }
  print_end(solution);
  if (s.errors) print_errors(*s.errors);
  if (!output.empty()) fmt::print("{}: {} states\n", output, solution.size());
}

void print_several(const std::vector<NavigatedSession>& sessions) {
  fmt::print("{:<32} {:>9} {:>12} {:>12} {:>12} {:>10}\n", "session", "time, s", "horizontal m", "up, m", "heading as", "nmi/h");
  std::vector<double> rates;
  for (const auto& s : sessions) {
    fmt::print("{:<32} {:>9.1f}", s.session, s.navigated.solution.time.back() - s.navigated.solution.time.front());
    if (!s.errors) {
      fmt::print(" no truth\n");
      continue;
    }
    const NavigationError& e = s.errors->history.back();
    rates.push_back(s.errors->rate / nmi_per_h);
    fmt::print(" {:>12.4g} {:>12.4g} {:>12.4g} {:>10.4g}\n", e.horizontal(), e.position.z(), e.attitude.z() / unit::arcsec, rates.back());
  }
  fmt::print("vertical channel {}; heading error in arcsec\n", to_string(sessions[0].navigated.vertical));
  if (!rates.empty())
    fmt::print("pure-inertial rate over {} sessions: RMS {:.4g} nmi/h, CEP {:.4g} nmi/h (half of the runs are below)\n", rates.size(),
               summary(rates).rms, summary(rates).cep);
}

void run(Options options) {
  options.navigate.vertical = vertical_channels.at(options.vertical);
  options.navigate.gaps = options.gaps == "refuse" ? GapTreatment::refuse : GapTreatment::integrate;
  check(options);
  const Calibration calibration = calibration_of(options.calibration);
  if (!options.barometer.empty()) options.navigate.barometer = read_barometer(options.barometer);
  if (options.heading_deg) options.navigate.heading = {*options.heading_deg * unit::deg, options.heading_sigma_deg.value_or(0) * unit::deg};
  std::vector<NavigatedSession> sessions;
  for (const auto& name : options.sessions) sessions.push_back(navigated(options, calibration, name));
  if (!options.output.empty()) write_solution(options.output, sessions[0].navigated.solution);
  if (options.json) {
    fmt::print("{}", navigation_json(sessions));
  } else if (sessions.size() == 1) {
    print_one(sessions[0], options.output);
  } else {
    print_several(sessions);
  }
}

}  // namespace

void add_navigate(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  CLI::App* const verb = app.add_subcommand("navigate", "Alignment, then the pure-inertial solution, and its errors against a truth");
  verb->add_option("CALIBRATION", o->calibration, "calibration.json; none: the recordings are in rad/s and m/s^2 already")->required();
  verb->add_option("SESSION", o->sessions, "session folders or session.toml files, each with one recording; several: one row each")
      ->required()
      ->expected(1, -1);
  verb->add_option("--vertical", o->vertical, "the vertical channel; aided and held need a barometer")
      ->check(CLI::IsMember({"free", "fixed", "aided", "held"}))
      ->capture_default_str();
  verb->add_option("--barometer", o->barometer, "heights over time for aided and held: CSV with t,height_m");
  verb->add_flag("--align", o->navigate.align, "align on the first rest although the session gives an attitude");
  verb->add_option("--heading", o->heading_deg, "heading at the end of the rest, deg: aligns the levels")->check(CLI::Range(-360., 360.));
  verb->add_option("--heading-sigma", o->heading_sigma_deg, "its standard uncertainty, deg; absent: exact")->check(CLI::Range(0., 180.));
  verb->add_option("--gaps", o->gaps, "over missing samples")->check(CLI::IsMember({"integrate", "refuse"}))->capture_default_str();
  verb->add_option("--truth", o->truth, "reference solution; absent: the session's [truth]");
  verb->add_option("-o,--output", o->output, "the whole solution as CSV");
  verb->add_flag("--json", o->json, "print the result for machines");
  verb->callback([o] { run(*o); });
}

}  // namespace imulab::command
