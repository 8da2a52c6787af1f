#include "imulab/io/navigation_text.hpp"

#include "imulab/core/units.hpp"

#include <nlohmann/json.hpp>

namespace imulab {

namespace {

using Json = nlohmann::ordered_json;
constexpr double nmi_per_h = unit::nmi / unit::hour;

Json to_json(const Eigen::Vector3d& v, double unit = 1) { return {v.x() / unit, v.y() / unit, v.z() / unit}; }

Json to_json(const AlignedOn& aligned) {
  const FineAlignment& a = aligned.alignment;
  const EulerAngles angles = euler_angles(a.attitude.C_nb);
  Json covariance = Json::array();
  for (int i = 0; i < 3; ++i) covariance.push_back(to_json(Eigen::Vector3d(a.attitude.covariance.row(i).transpose())));
  return {{"begin_s", aligned.begin},
          {"end_s", aligned.end},
          {"roll_pitch_heading_deg", to_json({angles.roll, angles.pitch, angles.heading}, unit::deg)},
          {"standard_uncertainty_deg", to_json(angle_sigmas(a.attitude), unit::deg)},
          {"covariance_enu_rad2", std::move(covariance)},
          {"gyro_noise_density", a.gyro_noise},
          {"accel_noise_density", a.accel_noise},
          {"base_displacement_m", a.base_displacement},
          {"innovation_square", a.innovation_square},
          {"innovation_correlation", a.innovation_correlation}};
}

Json to_json(const NavigatedSession& session) {
  const Navigated& n = session.navigated;
  Json out{{"session", session.session}, {"position_error", nullptr}, {"velocity_error_mps", nullptr}, {"attitude_error_arcsec", nullptr}};
  if (session.errors) {
    const NavigationError& end = session.errors->history.back();
    out["position_error"] = {{"east_m", end.position.x()},
                             {"north_m", end.position.y()},
                             {"up_m", end.position.z()},
                             {"horizontal_m", end.horizontal()},
                             {"rate_nmi_per_h", session.errors->rate / nmi_per_h}};
    out["velocity_error_mps"] = to_json(end.velocity);
    out["attitude_error_arcsec"] = to_json(end.attitude, unit::arcsec);
    out["error_time_s"] = end.time;
  }
  out["vertical"] = to_string(n.vertical);
  out["time_s"] = {n.solution.time.front(), n.solution.time.back()};
  out["alignment"] = n.aligned ? to_json(*n.aligned) : Json(nullptr);
  Json gaps = Json::array();
  for (const MissingTime& gap : n.gaps) gaps.push_back({{"begin_s", gap.begin}, {"length_s", gap.length}});
  out["gaps"] = std::move(gaps);
  out["saturated"] = n.saturated;
  out["warnings"] = n.warnings;
  if (session.errors)
    for (const auto& text : session.errors->warnings) out["warnings"].push_back(text);
  return out;
}

}  // namespace

std::string navigation_json(const std::vector<NavigatedSession>& sessions) {
  if (sessions.size() == 1) return to_json(sessions[0]).dump(2) + "\n";
  Json list = Json::array();
  std::vector<double> rates;
  for (const auto& session : sessions) {
    list.push_back(to_json(session));
    if (session.errors) rates.push_back(session.errors->rate / nmi_per_h);
  }
  Json rate = nullptr;
  if (!rates.empty()) rate = {{"rms", summary(rates).rms}, {"cep", summary(rates).cep}, {"sessions", rates.size()}};
  return Json{{"sessions", std::move(list)}, {"rate_nmi_per_h", std::move(rate)}}.dump(2) + "\n";
}

}  // namespace imulab
