#include "imulab/results/navigation.hpp"

#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/navigation_error.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab {
namespace {

/// From 0 to 360 as on a compass, rounded to `decimals`: what would print as 360 is 0.
double compass_deg(const EulerAngles& angles, int decimals) {
  const double steps = std::pow(10, decimals), deg = std::round(angles.heading / unit::deg * steps) / steps;
  return deg < 0 ? deg + 360 : std::abs(deg);
}

/// Times count from here: 0, or where the stamps are dates, the begin of the rest or of the solution.
double origin_of_times(const NavigatedSession& s) {
  const double begin = s.navigated.aligned ? s.navigated.aligned->begin : s.navigated.solution.time.front();
  return date_text(begin).empty() ? 0 : begin;
}

std::string alignment_text(const AlignedOn& aligned, double zero) {
  const FineAlignment& a = aligned.alignment;
  const EulerAngles angles = euler_angles(a.attitude.C_nb);
  const Eigen::Vector3d sigma = angle_sigmas(a.attitude) / unit::deg;
  return fmt::format("aligned on the rest from {:.3f} s to {:.3f} s\n", aligned.begin - zero, aligned.end - zero) +
         fmt::format("  roll     {:>12.5f} deg  u = {:.2g}\n", angles.roll / unit::deg, sigma.x()) +
         fmt::format("  pitch    {:>12.5f} deg  u = {:.2g}\n", angles.pitch / unit::deg, sigma.y()) +
         fmt::format("  heading  {:>12.5f} deg  u = {:.2g}\n", compass_deg(angles, 5), sigma.z()) +
         fmt::format("  gyro noise {:.2g} deg/sqrt(h), accelerometer noise {:.2g} ug/sqrt(Hz)\n  normalized innovations {:.2f} (1: as stated)\n",
                     a.gyro_noise / unit::deg_per_sqrt_h, a.accel_noise / unit::ug_per_sqrt_hz, std::sqrt(a.innovation_square));
}

std::string end_text(const Solution& solution) {
  const NavigationState& s = solution.states.back();
  const EulerAngles angles = euler_angles(s.q_nb.toRotationMatrix());
  return fmt::format("end      latitude {:.7f} deg, longitude {:.7f} deg, height {:.3f} m\n", s.latitude / unit::deg, s.longitude / unit::deg,
                     s.height) +
         fmt::format("         velocity east {:.4f}, north {:.4f}, up {:.4f} m/s\n", s.velocity.x(), s.velocity.y(), s.velocity.z()) +
         fmt::format("         roll {:.4f}, pitch {:.4f}, heading {:.4f} deg\n", angles.roll / unit::deg, angles.pitch / unit::deg,
                     compass_deg(angles, 4));
}

std::string error_text(const NavigationErrors& errors, double zero) {
  const NavigationError& e = errors.history.back();
  const Eigen::Vector3d attitude = e.attitude / unit::arcsec;
  return fmt::format("\nerrors at {:.3f} s   {:>11} {:>11} {:>11} {:>11}\n", e.time - zero, "east", "north", "up", "horizontal") +
         fmt::format("  position, m       {:>11.4g} {:>11.4g} {:>11.4g} {:>11.4g}\n", e.position.x(), e.position.y(), e.position.z(),
                     e.horizontal()) +
         fmt::format("  velocity, m/s     {:>11.4g} {:>11.4g} {:>11.4g} {:>11.4g}\n", e.velocity.x(), e.velocity.y(), e.velocity.z(),
                     e.velocity.head<2>().norm()) +
         fmt::format("  attitude, arcsec  {:>11.4g} {:>11.4g} {:>11.4g}\n", attitude.x(), attitude.y(), attitude.z()) +
         fmt::format("  rate              {:.4g} nmi/h\n", errors.rate / unit::nmi_per_h);
}

std::string headline(const NavigationErrors& errors) {
  const NavigationError& e = errors.history.back();
  return fmt::format("position error {:.4g} m horizontal, {:.4g} nmi/h; heading error {:.3g} arcsec", e.horizontal(), errors.rate / unit::nmi_per_h,
                     e.attitude.z() / unit::arcsec);
}

std::string one_session(const NavigatedSession& s) {
  const Solution& solution = s.navigated.solution;
  const double zero = origin_of_times(s), begin = solution.time.front() - zero, end = solution.time.back() - zero;
  std::string text = s.errors ? text::wrapped("", headline(*s.errors)) + "\n" : "";
  text += fmt::format("{}: navigated from {:.3f} s to {:.3f} s ({:.1f} s), vertical channel {}\n", one_line(s.session), begin, end, end - begin,
                      to_string(s.navigated.vertical));
  if (zero != 0) text += fmt::format("times from {}\n", date_text(zero));
  text += s.navigated.aligned ? alignment_text(*s.navigated.aligned, zero) : "started as the session says ([initial])\n";
  text += end_text(solution);
  return s.errors ? text + error_text(*s.errors, zero) : text;
}

std::string several_sessions(const std::vector<NavigatedSession>& sessions) {
  std::string text = text::wrapped("", navigation_headline(sessions)) + "\n";
  text += fmt::format("{:<26} {:>9} {:>12} {:>9} {:>10} {:>9}\n", "session", "time, s", "horizontal m", "up, m", "heading as", "nmi/h");
  for (const auto& s : sessions) {
    text += fmt::format("{:<26} {:>9.1f}", one_line(s.session), s.navigated.solution.time.back() - s.navigated.solution.time.front());
    if (!s.errors) {
      text += " no truth\n";
      continue;
    }
    const NavigationError& e = s.errors->history.back();
    text += fmt::format(" {:>12.4g} {:>9.3g} {:>10.4g} {:>9.3g}\n", e.horizontal(), e.position.z(), e.attitude.z() / unit::arcsec,
                        s.errors->rate / unit::nmi_per_h);
  }
  text += fmt::format("vertical channel {}; heading error in arcsec\n", to_string(sessions[0].navigated.vertical));
  return text;
}

}  // namespace

std::string navigation_headline(const std::vector<NavigatedSession>& sessions) {
  std::vector<double> rates;
  for (const NavigatedSession& s : sessions)
    if (s.errors) rates.push_back(s.errors->rate / unit::nmi_per_h);
  if (rates.empty()) return "there is no truth, so the errors are not known";
  if (sessions.size() > 1)
    return fmt::format("pure-inertial rate over {} sessions: RMS {:.4g} nmi/h, CEP {:.4g} nmi/h (half of the sessions are below)", rates.size(),
                       rate_summary(rates).rms, rate_summary(rates).cep);
  return headline(*sessions.front().errors);
}

std::string navigation_table(const std::vector<NavigatedSession>& sessions) {
  return sessions.size() == 1 ? one_session(sessions[0]) : several_sessions(sessions);
}

namespace {

double largest(const std::vector<double>& column) {
  double size = 0;
  for (const double value : column) size = std::max(size, std::abs(value));
  return size;
}

std::string largest_of(const Columns3& c, double unit) {
  return fmt::format("{:.4g}, {:.4g}, {:.4g}", largest(c[0]) / unit, largest(c[1]) / unit, largest(c[2]) / unit);
}

}  // namespace

std::string motion_table(const Recording& recording, const Solution& truth) {
  double distance = 0, fastest = 0, bank = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double speed = truth.states[i].velocity.norm();
    if (i > 0) distance += (truth.time[i] - truth.time[i - 1]) * (speed + truth.states[i - 1].velocity.norm()) / 2;
    fastest = std::max(fastest, speed);
    bank = std::max(bank, std::abs(euler_angles(truth.states[i].q_nb.toRotationMatrix()).roll));
  }
  std::string text = fmt::format("  distance       {:.6g} km, at most {:.5g} m/s\n", distance / 1000, fastest);
  text += fmt::format("  largest bank   {:.4g} deg\n", bank / unit::deg);
  if (recording.gyro_unit != "rad/s" || recording.accel_unit != "m/s^2") return text;  // counts
  text += fmt::format("  largest rate   {} deg/s about x, y, z\n", largest_of(recording.gyro, unit::deg));
  return text + fmt::format("  largest force  {} m/s^2 along x, y, z\n", largest_of(recording.accel, 1));
}

}  // namespace imulab
