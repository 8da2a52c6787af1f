#include "imulab/results/live.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/formats/text/json_fields.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/results/requirement_progress.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace imulab {

using Eigen::Vector3d;

namespace {

/// The nearest face, edge or corner, as "+x-y".
std::string signs_of(const Vector3d& direction) {
  Vector3d nearest = Vector3d::UnitX();
  for (int code = 0; code < 27; ++code) {
    const int x = code % 3 - 1, y = code / 3 % 3 - 1, z = code / 9 - 1;
    const Vector3d corner(x, y, z);
    if (!corner.isZero() && corner.normalized().dot(direction) > nearest.normalized().dot(direction)) nearest = corner;
  }
  std::string text;
  for (Eigen::Index i = 0; i < 3; ++i)
    if (nearest[i] != 0) text += fmt::format("{}{}", nearest[i] > 0 ? '+' : '-', "xyz"[i]);
  return text;
}

/// The directions up as a map: the half of the unit's directions around +z, and that around -z, each a disc with x to the right and y to the top.
class Discs {
 public:
  static constexpr int rows = 11, columns = 23, apart = 2;

  Discs() {
    lines_.fill(std::string(2 * columns + apart, ' '));
    for (const int disc : {0, 1}) {
      for (int i = 0; i < 72; ++i) put(disc, std::cos(i * std::numbers::pi / 36), std::sin(i * std::numbers::pi / 36), ".");
      put(disc, 1, 0, "+x"), put(disc, -1, 0, "-x"), put(disc, 0, 1, "+y"), put(disc, 0, -1, "-y"), put(disc, 0, 0, disc == 0 ? "+z" : "-z");
    }
  }
  /// On the rim in both.
  void mark(const Vector3d& up, const char* mark) {
    const double across = std::hypot(up.x(), up.y()), r = std::acos(std::min(1.0, std::abs(up.z()))) / (std::numbers::pi / 2);
    const double x = across > 0 ? r * up.x() / across : 0, y = across > 0 ? r * up.y() / across : 0;
    if (up.z() > -0.2) put(0, x, y, mark);
    if (up.z() < 0.2) put(1, x, y, mark);
  }
  const std::array<std::string, rows>& lines() const { return lines_; }

 private:
  void put(int disc, double x, double y, const std::string& text) {
    const auto row = static_cast<std::size_t>(std::lround((1 - y) * (rows - 1) / 2));
    const long middle = long{disc} * (columns + apart) + std::lround((1 + x) * (columns - 1) / 2);
    const auto at = static_cast<std::size_t>(std::clamp<long>(middle, 0, 2 * columns + apart - static_cast<long>(text.size())));
    lines_[row].replace(at, text.size(), text);
  }
  std::array<std::string, rows> lines_;
};

std::string colored(const std::string& text, Color code, bool color) { return color ? in_color(code, text) : text; }

std::string map_text(const LiveView& view, bool color) {
  Discs discs;
  for (const Vector3d& up : view.up) discs.mark(up, "o");
  if (view.next && !view.done) discs.mark(view.next->up, "X");
  if (view.now) discs.mark(*view.now, "@");
  const std::array<std::string, Discs::rows> beside{"",
                                                    "what points up at rest:",
                                                    "  o so far   @ now   X next",
                                                    "",
                                                    "turned so far about",
                                                    fmt::format("  x {:>8.0f} deg", view.turned_deg.x()),
                                                    fmt::format("  y {:>8.0f} deg", view.turned_deg.y()),
                                                    fmt::format("  z {:>8.0f} deg", view.turned_deg.z()),
                                                    "",
                                                    "",
                                                    ""};
  std::string text;
  for (std::size_t row = 0; row < beside.size(); ++row) {
    std::string line;
    for (const char c : discs.lines()[row])
      line += c == 'X'               ? colored("X", Color::yellow, color)
              : c == '@' || c == 'o' ? colored(std::string(1, c), Color::green, color)
                                     : std::string(1, c);
    text += fmt::format(" {}  {}\n", line, beside[row]);
  }
  return text;
}

/// The worst first; as many as there is room for.
std::string requirements_text(const LiveView& view, bool color) {
  constexpr std::size_t room = 5;
  constexpr int width = 20;
  std::vector<RequirementResult> all = view.requirements;
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.reached / a.limit > b.reached / b.limit; });
  std::string text;
  for (std::size_t k = 0; k < room; ++k) {
    if (k < all.size()) {
      const int filled = static_cast<int>(std::floor(width * std::min(1.0, all[k].limit / all[k].reached)));
      const std::string bar = std::string(static_cast<std::size_t>(filled), '#') + std::string(static_cast<std::size_t>(width - filled), '.');
      text += fmt::format(" {} {:.55}", colored(bar, all[k].met ? Color::green : Color::yellow, color), progress_text(all[k]));
      if (k + 1 == room && all.size() > room) text += fmt::format(" (and {})", all.size() - room);
    }
    text += "\n";
  }
  return text;
}

}  // namespace

std::string direction_text(const Vector3d& direction) {
  const std::string signs = signs_of(direction);
  return (signs.size() == 2 ? "" : signs.size() == 4 ? "the edge " : "the corner ") + signs;
}

std::string turn_text(const HandTurn& turn) {
  return fmt::format("turn by {:.0f} deg about {} until {} points up", turn.angle / unit::deg, signs_of(turn.axis), direction_text(turn.up));
}

std::string turns_text(const std::vector<HandTurn>& turns) {
  std::string text;
  for (const HandTurn& turn : turns) text += (text.empty() ? "" : "; ") + turn_text(turn) + ", hold still";
  return text;
}

std::string progress_text(const RequirementResult& r) {
  const std::string selector = r.text.substr(0, r.text.find(" <="));
  const UserUnit unit = user_unit(coefficient(coefficient_index(r.coefficient)), r.limit);
  if (!std::isfinite(r.reached)) return selector + " not determined";
  const std::string why = !r.met && r.reached <= r.limit && !r.note.empty() ? " (" + r.note + ")" : "";
  return fmt::format("{} {:.3g} {} of {:.3g} {}{}", selector, r.reached / unit.size, unit.name, r.limit / unit.size, unit.name, why);
}

std::string live_picture(const LiveView& view, bool color) {
  std::string text = fmt::format(" {}: calibration by hand, {:.1f} s, {} rest{}\n", view.imu.empty() ? "IMU" : excerpt(view.imu, 30), view.time_s,
                                 view.up.size(), view.up.size() == 1 ? "" : "s");
  if (view.done)
    text += " done\n\n";
  else if (!view.resting_s)
    text += " moving\n\n";
  else if (*view.resting_s < view.rest_s)
    text += fmt::format(" at rest for {:.1f} s: hold still until {:g} s\n\n", *view.resting_s, view.rest_s);
  else
    text += fmt::format(" at rest for {:.1f} s: long enough\n\n", *view.resting_s);
  text += map_text(view, color) + requirements_text(view, color) + "\n";
  if (view.done) return text;
  if (!view.problem.empty()) text += fmt::format(" {}\n", excerpt(view.problem, 75));
  if (view.next)
    text += colored(fmt::format(" next: {},\n       then hold still for {:g} s", turn_text(*view.next), view.rest_s), Color::yellow, color) + "\n";
  return text;
}

template <class Fields>
void describe(Fields& f, const LiveView& view) {
  const auto direction = view.up.empty() ? "" : direction_text(view.up.back());
  f("time_s", view.time_s), f("rests", view.up.size()),
      f("requirements", std::vector<RequirementProgress>(view.requirements.begin(), view.requirements.end())), f("done", view.done);
  f("up", direction, fields::if_any), f("problem", view.problem, fields::if_any);
  f("next", view.next && !view.done ? turn_text(*view.next) : std::string(), fields::if_any);
}

std::string live_json(const LiveView& view) { return json_text(written(view), JsonLayout::one_line); }

}  // namespace imulab
