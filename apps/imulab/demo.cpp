// imulab demo: a good calibration from a poor table (Cheng 2014), and twenty drives that prove it. Nothing is needed but the command.
#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "imulab/core/parallel.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/json.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/model/relative_uncertainty.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/motion/mission.hpp"
#include "imulab/procedure.hpp"
#include "imulab/report/drives_page.hpp"
#include "imulab/report/plot.hpp"
#include "imulab/simulate/simulate_motion.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <utility>

namespace imulab::command {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t drives = 20;
constexpr double interval = 0.02;  // s, of a sample on the drive
constexpr double table = 60 * unit::arcsec;

struct Arguments {
  std::string folder = "imulab-demo";
  std::uint64_t seed = 1;
  bool json = false;
};

/// The IMU on the table, from the simulation to the calibration.
Calibration calibrated(Session session, const char* method, std::uint64_t seed, const SensorModel* unit, Truth& truth) {
  RecordingSource source;
  source.file = "recording.csv";
  source.rate_hz = 100;
  source.gyro.unit = "rad/s";
  source.accel.unit = "m/s^2";
  session.recordings = {source};
  truth = draw_truth(session, seed, unit != nullptr ? std::optional(*unit) : std::nullopt);
  const std::vector<Recording> recordings{simulate_recording(session, source, truth, seed, draw_rig_errors(session, source, seed))};
  Calibration calibration = calibrate(method, {session, recordings}).calibration;
  calibration.created.clear();  // a demo gives the same files every time
  return calibration;
}

/// Pure-inertial errors with a calibration.
NavigationErrors errors_of(const CityDrive& drive, const Recording& recording, const Calibration& calibration) {
  NavigateOptions options;
  options.vertical = VerticalChannel::fixed;
  options.align = true;
  return navigation_errors(navigate(calibration, drive.session, recording, options).solution, drive.truth);
}

constexpr std::size_t minute = 60;  // of the truth's rows

/// Drives one IMU with new noise each time, and navigates with each of the calibrations.
DrivesReport drive_all(const Truth& truth, const std::vector<std::pair<std::string, Calibration>>& calibrations, std::uint64_t seed) {
  const CityDrive drive = city_drive(interval);
  Truth on_the_road;
  on_the_road.model = truth.model;
  on_the_road.gyro_noise.N = 0.001 * unit::deg_per_sqrt_h;
  on_the_road.accel_noise.N = 5 * unit::ug_per_sqrt_hz;
  std::vector<std::vector<NavigationErrors>> errors(calibrations.size(), std::vector<NavigationErrors>(drives));
  Progress progress("driving", drives);
  std::atomic<std::uint64_t> done = 0;
  parallel_for(drives, [&](std::size_t k) {
    const Recording recording = simulate_motion(drive.increments, interval, on_the_road, seed + k);
    for (std::size_t c = 0; c < calibrations.size(); ++c) errors[c][k] = errors_of(drive, recording, calibrations[c].second);
    progress.report(static_cast<double>(++done));
  });
  DrivesReport report;
  for (std::size_t i = 0; i < errors[0][0].history.size(); i += minute)
    report.time.push_back(errors[0][0].history[i].time - errors[0][0].history[0].time);
  for (std::size_t c = 0; c < calibrations.size(); ++c) {
    DrivenCalibration& driven = report.calibrations.emplace_back();
    driven.name = calibrations[c].first;
    for (const NavigationErrors& of : errors[c]) {
      std::vector<double>& history = driven.errors.emplace_back();
      for (std::size_t i = 0; i < of.history.size(); i += minute) history.push_back(of.history[i].horizontal());
      driven.largest.push_back(*std::max_element(history.begin(), history.end()));
    }
    std::sort(driven.largest.begin(), driven.largest.end());
  }
  return report;
}

std::string row(const DrivenCalibration& c) {
  return fmt::format("     {:<20} {:>6.0f}   {:.0f} to {:.0f}\n", c.name, median(c.largest), c.largest.front(), c.largest.back());
}

std::string misalignment(const Calibration& c) {
  double worst = 0;
  for (const CoefficientIndex index : select_coefficients("gyro.matrix.off_diagonal")) worst = std::max(worst, relative_uncertainty(c, index));
  return fmt::format("gyro misalignments known to {:.2g} arcsec", worst / unit::arcsec);
}

constexpr const char* story =
    "A navigation-grade IMU is calibrated twice on a turntable that is accurate to 1 arcmin only: classically, with the table's angles as the "
    "reference, "
    "and by the hybrid method, for which the table only turns the IMU. Then it is driven for an hour, twenty times with new noise, and navigated "
    "with "
    "nothing but its own readings.";

constexpr const char* title = "A good calibration from a poor table";

/// The demo replaces its own files, and nobody else's.
void expect_own_folder(const fs::path& folder) {
  const fs::path page = folder / "report.html";
  const bool own = fs::is_regular_file(page) && MappedFile(page).text().find(title) != std::string_view::npos;
  for (const char* name : {"classical.json", "hybrid.json", "drives.svg", "report.html"}) {
    will_write("-o", folder / name);
    if (!own && fs::exists(folder / name))
      throw Error(fmt::format("-o {}: has a {} that is not of the demo; expected another folder", folder.string(), name));
  }
}

void demo(const Arguments& a) {
  const fs::path folder = a.folder;
  expect_own_folder(folder);
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure) throw Error(fmt::format("-o {}: cannot be made: {}; expected a folder", a.folder, failure.message()));
  const auto say = [&](const std::string& text) {
    if (a.json) return;
    print(text);
    std::fflush(stdout);
  };
  Truth truth, unused;
  say("A navigation-grade IMU, and a turntable that is accurate to 1 arcmin only.\n");
  const Calibration hybrid = calibrated(cheng_path_procedure({.table = table}), "hybrid", a.seed, nullptr, truth);
  const Calibration classical = calibrated(zhang_24_procedure({.rest = 17, .table = table}), "turntable", a.seed + 1, &truth.model, unused);
  Calibration exact;
  exact.model = truth.model;
  say(fmt::format("1  Classical, 31 min: the table's angles are the reference.\n     {}\n", misalignment(classical)));
  say(fmt::format("2  Hybrid, 25 min: the table only turns the IMU, its angles are not used.\n     {}\n", misalignment(hybrid)));
  say(fmt::format("3  An hour's drive, {} times, navigated with nothing but the IMU:\n     largest error, m     median   least to most\n", drives));
  DrivesReport report = drive_all(truth, {{"classical", classical}, {"hybrid", hybrid}, {"with the true values", exact}}, a.seed);
  for (const DrivenCalibration& c : report.calibrations) say(row(c));
  report.title = title;
  report.story = story;
  report.calibrations[0].claim = misalignment(classical), report.calibrations[1].claim = misalignment(hybrid);
  const std::string own = program_name() + " calibrate FOLDER --method handheld -o calibration.json";
  report.next = {"Calibrate your own sensor by hand: " + own, fmt::format("See what is there: {} --help", program_name())};
  write_whole(folder / "report.html", drives_page(report));  // by it a next run tells that the others are the demo's, too, wherever this one ends
  write_whole(folder / "classical.json", calibration_text(classical));
  write_whole(folder / "hybrid.json", calibration_text(hybrid));
  write_whole(folder / "drives.svg", report::standalone(drives_picture(report)));
  say(fmt::format("\nReport: {}\nYour own sensor: {}\n", fs::absolute(folder / "report.html").lexically_normal().string(), own));
  JsonFields figures{{{"drives", std::uint64_t{drives}}}};
  for (const DrivenCalibration& c : report.calibrations) figures.fields.emplace_back(c.name + " [m]", median(c.largest));
  if (a.json) print_json(figures, {Verdict::none, title});
}

}  // namespace

void add_demo(Verb& app) {
  const auto a = std::make_shared<Arguments>();
  Verb& verb = app.verb("demo", "A good calibration from a poor table, and twenty drives that prove it; no input needed");
  verb.option("-o,--output FOLDER", a->folder, "the folder to write to").show_default();
  verb.option("--seed", a->seed, "random seed of the IMU and the noise").show_default();
  verb.option("--json", a->json, "print the figures as JSON");
  verb.example("imulab demo -o story");
  verb.does = [a] { demo(*a); };
}

}  // namespace imulab::command
