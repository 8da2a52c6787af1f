#include "imulab/formats/solution/aided_solution.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/solution/solution.hpp"
#include "imulab/formats/text/append_number.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string>
#include <string_view>

namespace imulab {

namespace {

using Sigmas = Eigen::Matrix<double, 9, 1>;

/// One sigma of roll, pitch, heading from phi's [rad]: levels about the body's horizontal axes.
Eigen::Vector3d level_sigmas(const Sigmas& s, double heading) {
  const double e2 = s[0] * s[0], n2 = s[1] * s[1], sine = std::pow(std::sin(heading), 2), cosine = 1 - sine;
  return {std::sqrt(e2 * sine + n2 * cosine), std::sqrt(e2 * cosine + n2 * sine), s[2]};
}

void add_csv(std::string& text, double time, const NavigationState& s, const Sigmas& sigma, bool) {
  const EulerAngles a = euler_angles(s.q_nb.toRotationMatrix());
  append_state(text, time, s, {a.roll, a.pitch, a.heading < 0 ? a.heading + 2 * std::numbers::pi : a.heading});
  const Eigen::Vector3d angles = level_sigmas(sigma, a.heading) / unit::deg;
  for (const double value : {sigma[6], sigma[7], sigma[8], sigma[3], sigma[4], sigma[5], angles[0], angles[1], angles[2]})
    text += ',', text::append_four_digits(text, value);
  text += '\n';
}

void add_geojson(std::string& text, double, const NavigationState& s, const Sigmas&, bool last) {
  fmt::format_to(std::back_inserter(text), "[{:.9f},{:.9f},{:.3f}]{}", s.longitude / unit::deg, s.latitude / unit::deg, s.height, last ? "" : ",\n");
}

void add_kml(std::string& text, double, const NavigationState& s, const Sigmas&, bool) {
  fmt::format_to(std::back_inserter(text), "{:.9f},{:.9f},{:.3f}\n", s.longitude / unit::deg, s.latitude / unit::deg, s.height);
}

/// `time`: of GPS, as that of a date since 1970; quality 1, no number of satellites, no age and ratio.
void add_pos(std::string& text, double time, const NavigationState& s, const Sigmas& sigma, bool) {
  using namespace std::chrono;
  const double day = std::floor(time / 86400), rest = time - 86400 * day;
  const year_month_day date{sys_days{days{static_cast<int>(day)}}};
  const int hour = static_cast<int>(rest / 3600), minute = static_cast<int>(rest / 60) % 60;
  fmt::format_to(std::back_inserter(text), "{:04}/{:02}/{:02} {:02}:{:02}:{:06.3f} {:14.9f} {:14.9f} {:10.4f}   1   0 {:8.4f} {:8.4f} {:8.4f}",
                 int(date.year()), unsigned(date.month()), unsigned(date.day()), hour, minute, rest - 3600. * hour - 60. * minute,
                 s.latitude / unit::deg, s.longitude / unit::deg, s.height, sigma[7], sigma[6], sigma[8]);
  fmt::format_to(std::back_inserter(text),
                 "   0.0000   0.0000   0.0000   0.00    0.0 {:10.5f} {:10.5f} {:10.5f} {:9.5f} {:8.5f} {:8.5f}   0.0   0.0   0.0\n", s.velocity.y(),
                 s.velocity.x(), s.velocity.z(), sigma[4], sigma[3], sigma[5]);
}

}  // namespace

struct SolutionText {
  std::string_view ending, head, tail;
  void (*add)(std::string& text, double time, const NavigationState& state, const Sigmas& sigma, bool last);
  std::size_t most = 0;  // states; 0: all
};

namespace {

constexpr std::string_view dated_ending = ".pos";

constexpr std::array texts{
    SolutionText{".csv",
                 "t,latitude_deg,longitude_deg,height_m,ve,vn,vu,roll_deg,pitch_deg,heading_deg,"
                 "sigma_e_m,sigma_n_m,sigma_u_m,sigma_ve,sigma_vn,sigma_vu,sigma_roll_deg,sigma_pitch_deg,sigma_heading_deg\n",
                 "", add_csv},
    SolutionText{".geojson",
                 "{\"type\":\"Feature\",\"properties\":{\"software\":\"imulab\"},\"geometry\":{\"type\":\"LineString\",\"coordinates\":[\n", "]}}\n",
                 add_geojson, 10'000},
    SolutionText{".kml",
                 "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\"><Document><Placemark><name>imulab</name>"
                 "<LineString><altitudeMode>absolute</altitudeMode><coordinates>\n",
                 "</coordinates></LineString></Placemark></Document></kml>\n", add_kml, 10'000},
    SolutionText{
        dated_ending,
        "% program   : imulab\n%  GPST                   latitude(deg) longitude(deg)  height(m)   Q  ns   sdn(m)   sde(m)   sdu(m)  sdne(m)  "
        "sdeu(m)  sdun(m) age(s)  ratio    vn(m/s)    ve(m/s)    vu(m/s)      sdvn     sdve     sdvu    sdvne    sdveu    sdvun\n",
        "", add_pos},
};

constexpr std::string_view odometry_ending = ".mcap";

std::string lower_ending(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

}  // namespace

void expect_solution_ending(const std::filesystem::path& path, bool aided) {
  const std::string ending = lower_ending(path);
  if (ending.empty() || ending == texts.front().ending || is_stream(path)) return;
  const bool known = ending == odometry_ending || std::ranges::find(texts, std::string_view(ending), &SolutionText::ending) != texts.end();
  if (!known) throw Error(fmt::format("{}: expected a .csv file, or with --aided .geojson, .kml, .pos, .mcap", path.string()));
  if (!aided) throw Error(path.string() + ": belongs to --aided; expected it, or a .csv file");
}

bool needs_dates(const std::filesystem::path& path) { return lower_ending(path) == dated_ending; }

void expect_dates(const std::filesystem::path& path, const std::optional<std::int64_t>& gps_ahead) {
  if (gps_ahead) return;
  throw Error(
      fmt::format("{}: has dates, in GPS time, and the recording's clock has none; expected time = {{ scale = \"gps\" }} or \"utc\" in "
                  "[[recording]] beside an aid with dates, or another ending: .csv, .geojson, .kml, .mcap",
                  path.string()));
}

AidedSolutionFile::AidedSolutionFile(const std::filesystem::path& path, const std::optional<std::int64_t>& gps_ahead) {
  const std::string ending = lower_ending(path);
  if (ending == odometry_ending) {
    odometry_.emplace(path);
    return;
  }
  const auto named = std::ranges::find(texts, std::string_view(ending), &SolutionText::ending);
  form_ = named != texts.end() ? &*named : texts.data();
  if (needs_dates(path)) expect_dates(path, gps_ahead), ahead_ = 1e-9 * static_cast<double>(*gps_ahead);
  file_.emplace(path);
  text_ = form_->head;
}

void AidedSolutionFile::add(const AidedNavigation& n, double time, const NavigationState& state) {
  if (odometry_) return odometry_->add(n, time, state);
  const std::size_t step = form_->most > 0 ? std::max<std::size_t>(1, n.states / form_->most) : 1;
  if (const std::size_t i = taken_++; i % step == 0) form_->add(text_, time + ahead_, state, sigmas_at(n, time), i + step >= n.states);
  if (text_.size() < 1 << 20) return;
  file_->write(text_);
  text_.clear();
}

void AidedSolutionFile::commit() {
  if (odometry_) return odometry_->commit();
  file_->write(text_ + std::string(form_->tail));
  file_->commit();
}

}  // namespace imulab
