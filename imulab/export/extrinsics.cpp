#include "imulab/export/extrinsics.hpp"

#include "imulab/error.hpp"
#include "imulab/export/write.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <vector>

namespace imulab {
namespace {

using export_io::exact_number, export_io::plain;

/// A name for frames: letters, digits and underscores, a letter first. "left_imu" of the topic "/left/imu".
std::string frame_name(std::string_view name) {
  std::string out;
  for (const char c : name)
    if (std::isalnum(static_cast<unsigned char>(c)))
      out += c;
    else if (!out.empty())
      out += '_';
  return out.empty() || !std::isalpha(static_cast<unsigned char>(out.front())) ? "imu" + out : out;
}

/// Roll, pitch and yaw of the axes of `to` in those of `from`: R = R_z(yaw) R_y(pitch) R_x(roll).
Vector3d roll_pitch_yaw(const Mounting& m) {
  const Matrix3d r = m.rotation.transpose();
  return {std::atan2(r(2, 1), r(2, 2)), std::asin(std::clamp(-r(2, 0), -1., 1.)), std::atan2(r(1, 0), r(0, 0))};
}

/// Lines about each mounting for a comment.
std::string head(const Extrinsics& e, std::string_view mark) {
  std::string out = fmt::format("{} Extrinsics of imulab{}\n", mark, e.verdict == Verdict::doubtful ? ", DOUBTFUL" : "");
  for (const Mounting& m : e.from_first) {
    const Vector3d turn = m.uncertainties(Mounting::rotation_row) / unit::deg, arm = 1e3 * m.uncertainties(Mounting::lever_arm_row);
    out += fmt::format("{} {} relative to {}: u of rotation {:.2g}, {:.2g}, {:.2g} deg, of lever arm {:.2g}, {:.2g}, {:.2g} mm, of clock {:.2g} ms\n",
                       mark, plain(m.to), plain(m.from), turn[0], turn[1], turn[2], arm[0], arm[1], arm[2],
                       1e3 * m.uncertainty(Mounting::clock_offset_row));
    for (const std::string& what : m.not_shown) out += fmt::format("{}   NOT SHOWN by the motion: {}\n", mark, plain(what));
  }
  return out;
}

/// T_i_b takes points from the axes of imu0 to those of the IMU; its stamps plus time_offset are those of imu0 (kalibr_imu_camera_calibration,
/// IccSensors.py).
std::string kalibr_text(const Extrinsics& e) {
  std::string out = head(e, "#");
  for (std::size_t k = 0; k < e.imus.size(); ++k) {
    const Mounting m = e.between(0, k);
    const Eigen::Matrix4d t = m.matrix();
    out += fmt::format("imu{}:  # {}\n  T_i_b:\n", k, plain(e.imus[k]));
    for (int i = 0; i < 4; ++i)
      out += fmt::format("    - [{}, {}, {}, {}]\n", exact_number(t(i, 0)), exact_number(t(i, 1)), exact_number(t(i, 2)), exact_number(t(i, 3)));
    out += fmt::format("  time_offset: {}\n", exact_number(k == 0 ? 0. : -m.clock_offset));
  }
  return out;
}

std::string ros_text(const Extrinsics& e) {
  std::string out = head(e, "#");
  for (const Mounting& m : e.from_first) {
    const Vector3d angles = roll_pitch_yaw(m);
    out += fmt::format(
        "ros2 run tf2_ros static_transform_publisher --x {} --y {} --z {} --roll {} --pitch {} --yaw {} --frame-id {} --child-frame-id {}\n",
        exact_number(m.lever_arm.x()), exact_number(m.lever_arm.y()), exact_number(m.lever_arm.z()), exact_number(angles[0]), exact_number(angles[1]),
        exact_number(angles[2]), frame_name(m.from), frame_name(m.to));
  }
  return out;
}

std::string urdf_text(const Extrinsics& e) {
  std::string comment = head(e, " ");
  for (std::size_t at = 0; (at = comment.find("--", at)) != std::string::npos;) comment[at] = ' ';  // would end it
  std::string out = "<!--\n" + comment + "-->\n";
  for (const Mounting& m : e.from_first) {
    const Vector3d angles = roll_pitch_yaw(m);
    out += fmt::format(
        "<joint name=\"{0}_to_{1}\" type=\"fixed\">\n  <parent link=\"{0}\"/>\n  <child link=\"{1}\"/>\n"
        "  <origin xyz=\"{2} {3} {4}\" rpy=\"{5} {6} {7}\"/>\n</joint>\n",
        frame_name(m.from), frame_name(m.to), exact_number(m.lever_arm.x()), exact_number(m.lever_arm.y()), exact_number(m.lever_arm.z()),
        exact_number(angles[0]), exact_number(angles[1]), exact_number(angles[2]));
  }
  return out;
}

std::string csv_text(const Extrinsics& e) {
  std::string out = "from,to,quantity,value,standard_uncertainty,unit\n";
  for (const Mounting& m : e.from_first) {
    const std::string pair = frame_name(m.from) + "," + frame_name(m.to);
    const auto row = [&](const std::string& quantity, double value, const std::string& sigma, const char* unit_name) {
      out += fmt::format("{},{},{},{},{}\n", pair, quantity, exact_number(value), sigma, unit_name);
    };
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) row(fmt::format("rotation.{}{}", "xyz"[i], "xyz"[j]), m.rotation(i, j), "", "1");
    for (int i = 0; i < 3; ++i)
      row(fmt::format("lever_arm.{}", "xyz"[i]), m.lever_arm[i], exact_number(m.uncertainties(Mounting::lever_arm_row)[i]), "m");
    row("clock_offset", m.clock_offset, exact_number(m.uncertainty(Mounting::clock_offset_row)), "s"),
        row("clock_drift", m.clock_drift, exact_number(m.uncertainty(Mounting::clock_drift_row)), "1");
    row("accel_delay", m.accel_delay, exact_number(m.uncertainty(Mounting::accel_delay_row)), "s");
  }
  return out;
}

constexpr std::array known_targets{ExtrinsicsTarget{"kalibr", kalibr_text}, ExtrinsicsTarget{"openvins", kalibr_text},  // which reads that chain
                                   ExtrinsicsTarget{"ros", ros_text}, ExtrinsicsTarget{"urdf", urdf_text}, ExtrinsicsTarget{"csv", csv_text}};

}  // namespace

std::span<const ExtrinsicsTarget> extrinsics_targets() { return known_targets; }

std::string exported_extrinsics(const Extrinsics& extrinsics, std::string_view target) {
  const auto* const found = std::ranges::find(known_targets, target, &ExtrinsicsTarget::name);
  if (found != known_targets.end()) return found->text(extrinsics);
  std::vector<std::string_view> names;
  for (const ExtrinsicsTarget& t : known_targets) names.push_back(t.name);
  throw Error(fmt::format("--to {}: holds no extrinsics; expected one of {}", target, text::listed(names)));
}

}  // namespace imulab
