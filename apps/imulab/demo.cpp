// imulab demo: a good calibration from a poor table (Cheng 2014), and twenty drives that prove it. Nothing is needed but the command.
#include "apps/imulab/command.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/io/calibration/file.hpp"
#include "imulab/io/result/fields.hpp"
#include "imulab/io/result/reached.hpp"
#include "imulab/io/text/file.hpp"
#include "imulab/io/text/terminal.hpp"
#include "imulab/model/compare.hpp"
#include "imulab/model/requirement.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/navigation/navigate.hpp"
#include "imulab/navigation/navigation_error.hpp"
#include "imulab/rig/procedure.hpp"
#include "imulab/simulate/simulate_motion.hpp"

#include <fmt/core.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <memory>

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
  calibration.software = software();
  return calibration;
}

/// A rest to align on, then an hour around a city at 60 km/h: straight roads and bends of 45 deg.
struct Drive {
  std::vector<Increment> increments;
  Session session;
  Solution truth;
};

Drive hour_of_driving() {
  using namespace motion;
  const FlightStart parked{.latitude = 40 * unit::deg, .longitude = 116.3 * unit::deg, .height = 50};
  std::vector<Segment> segments{rest(301), accelerate(60 / 3.6, 20)};
  for (int leg = 0; leg < 9; ++leg) segments.insert(segments.end(), {straight(375), turn(45 * unit::deg, 3 * unit::deg, 3)});
  segments.push_back(accelerate(-60 / 3.6, 20));
  Carrier vehicle;
  vehicle.banks = false;
  const Trajectory path = flight(parked, segments, vehicle);
  Drive drive{ideal_increments(path, interval), {}, truth(path, interval, 50)};
  InitialState& start = drive.session.initial.emplace();
  start.latitude = parked.latitude, start.longitude = parked.longitude, start.height = parked.height;
  drive.session.site.latitude = parked.latitude, drive.session.site.height = parked.height;
  drive.session.recordings.emplace_back();
  Step hold;
  hold.end = 300;
  drive.session.steps = {hold};
  return drive;
}

/// Pure-inertial error over time of navigation with a calibration [nmi/h].
double rate(const Drive& drive, const Recording& recording, const Calibration& calibration) {
  NavigateOptions options;
  options.vertical = VerticalChannel::fixed;
  options.align = true;
  return navigation_errors(navigate(calibration, drive.session, recording, options).solution, drive.truth).rate / unit::nmi_per_h;
}

struct Rates {
  std::vector<double> classical, hybrid, exact;  ///< of each drive [nmi/h]
};

/// The same IMU with new noise on every drive.
Rates drive_all(const Truth& truth, const Calibration& classical, const Calibration& hybrid, std::uint64_t seed) {
  const Drive drive = hour_of_driving();
  Calibration exact;
  exact.model = truth.model;
  Truth on_the_road;
  on_the_road.model = truth.model;
  on_the_road.gyro_noise.N = 0.001 * unit::deg_per_sqrt_h;
  on_the_road.accel_noise.N = 5 * unit::ug_per_sqrt_hz;
  Rates rates{std::vector<double>(drives), std::vector<double>(drives), std::vector<double>(drives)};
  Progress progress("driving", drives);
  std::atomic<std::uint64_t> done = 0;
  tbb::parallel_for(std::size_t{0}, drives, [&](std::size_t k) {
    const Recording recording = simulate_motion(drive.increments, interval, on_the_road, seed + k);
    rates.classical[k] = rate(drive, recording, classical);
    rates.hybrid[k] = rate(drive, recording, hybrid);
    rates.exact[k] = rate(drive, recording, exact);
    progress.report(++done);
  });
  for (std::vector<double>* of : {&rates.classical, &rates.hybrid, &rates.exact}) std::sort(of->begin(), of->end());
  return rates;
}

std::string row(const char* name, const std::vector<double>& sorted) {
  return fmt::format("     {:<24} {:.2f}   {:.2f} to {:.2f}\n", name, median(sorted), sorted.front(), sorted.back());
}

std::string misalignment(const Calibration& c) {
  double worst = 0;
  for (const CoefficientIndex index : select_coefficients("gyro.matrix.off_diagonal")) worst = std::max(worst, relative_uncertainty(c, index));
  return fmt::format("{:.2g} arcsec", worst / unit::arcsec);
}

void demo(const Arguments& a) {
  const fs::path folder = a.folder;
  fs::create_directories(folder);
  const auto say = [&](const std::string& text) {
    if (a.json) return;
    fmt::print("{}", text);
    std::fflush(stdout);
  };
  TableProcedureOptions options{.rest = 17, .table = table};
  Truth truth, unused;
  say("A navigation-grade IMU, and a turntable that is accurate to 1 arcmin only.\n\n");
  const Calibration hybrid = calibrated(cheng_path_procedure({.table = table}), "hybrid", a.seed, nullptr, truth);
  const Calibration classical = calibrated(zhang_24_procedure(options), "turntable", a.seed + 1, &truth.model, unused);
  write_whole(folder / "classical.json", calibration_text(classical));
  write_whole(folder / "hybrid.json", calibration_text(hybrid));
  say(fmt::format("1  Classical, 31 min: the table's angles are the reference.\n     gyro misalignments known to {}\n", misalignment(classical)));
  say(fmt::format("2  Hybrid, 25 min: the table only turns the IMU, its angles are not used.\n     gyro misalignments known to {}\n",
                  misalignment(hybrid)));
  say(fmt::format("3  An hour's drive, {} times, navigated with nothing but the IMU:\n     error in nmi/h           median  least to most\n", drives));
  const Rates rates = drive_all(truth, classical, hybrid, a.seed);
  say(row("classical", rates.classical) + row("hybrid", rates.hybrid) + row("with the true values", rates.exact));
  say(fmt::format("\nBoth calibrations are in {}\nYour own sensor, by hand: imulab calibrate FOLDER --method handheld -o calibration.json\n",
                  fs::absolute(folder).lexically_normal().string()));
  if (a.json)
    fmt::print("{}", json_text({{{"drives", std::uint64_t{drives}},
                                 {"classical_median_nmi_per_h", median(rates.classical)},
                                 {"hybrid_median_nmi_per_h", median(rates.hybrid)},
                                 {"exact_median_nmi_per_h", median(rates.exact)}}}));
}

}  // namespace

void add_demo(Verb app) {
  const auto a = std::make_shared<Arguments>();
  Verb verb = app.verb("demo", "A good calibration from a poor table, and twenty drives that prove it; no input needed");
  verb.option("-o,--output FOLDER", a->folder, "the folder to write to").show_default();
  verb.option("--seed", a->seed, "random seed of the IMU and the noise").show_default();
  verb.flag("--json", a->json, "print the figures as JSON");
  verb.does([a] { demo(*a); });
}

}  // namespace imulab::command
