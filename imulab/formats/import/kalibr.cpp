// Kalibr: the result form with matrices (ethz-asl/kalibr, commit 1f60227: IccSensors.py, ConfigReader.py). OpenVINS'
// kalibr_imu_chain.yaml (rpng/open_vins, commit 6948812: VioManagerOptions.h, state/State.h). Both are YAML with "imu0".
#include "imulab/formats/import/numbers.hpp"
#include "imulab/formats/import/yaml.hpp"
#include "imulab/formats/text/printable.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

namespace imulab::import_io {

namespace {

Matrix3d matrix3(const Source& s, const YamlNode& map, const std::string& path, const char* key) {
  return matrix_of(s, field_of(s, map, path, key), path + "." + key, 3, 3);
}

Matrix3d matrix3_or(const Source& s, const YamlNode& map, const std::string& path, const char* key, const Matrix3d& otherwise) {
  return map.find(key) != nullptr ? matrix3(s, map, path, key) : otherwise;
}

void expect_rotation(const Source& s, int line, const std::string& path, const Matrix3d& R) {
  constexpr double rounding = 1e-4;  // of matrices printed with six digits and more
  if (!((R * R.transpose() - Matrix3d::Identity()).norm() < rounding && R.determinant() > 0)) fail_at(s, line, path + ": expected a rotation matrix");
}

/// "imu0", or the one asked for; the root of a flat file.
const YamlNode& imu_of(const Source& s, const YamlNode& root, std::string& path) {
  if (root.kind != YamlNode::Kind::map) fail_at(s, root.line, "expected keys and values");
  path = fmt::format("imu{}", s.instance);
  if (root.find("imu0") == nullptr && s.instance == 0) return path.clear(), root;
  const YamlNode& imu = field_of(s, root, "", path);
  if (imu.kind != YamlNode::Kind::map) fail_at(s, imu.line, path + ": expected keys and values");
  return imu;
}

void name_si(SensorModel& m) {
  m.accel.raw_unit = "m/s^2";
  m.gyro.raw_unit = "rad/s";
}

constexpr const char* no_biases = "offsets are zero: the file holds no biases, its program estimates them while it runs";

}  // namespace

bool is_kalibr(std::string_view text) {
  return has_key(text, "accelerometer_noise_density") || has_key(text, "gyroscope_noise_density") || has_key(text, "C_gyro_i");
}
bool is_openvins(std::string_view text) { return has_key(text, "Tw") || has_key(text, "R_IMUtoGYRO"); }

ImportedModel read_kalibr(const Source& s) {
  const YamlNode root = parse_yaml(s);
  std::string path;
  const YamlNode& imu = imu_of(s, root, path);
  ImportedModel out;
  name_si(out.model);
  if (imu.find("gyroscopes") == nullptr && imu.find("accelerometers") == nullptr) {
    const std::string place = path + (path.empty() ? "" : ".");
    for (const char* key : {"accelerometer_noise_density", "gyroscope_noise_density"})  // at least these are what they are said to be
      number_of(s, field_of(s, imu, path, key), place + key);
    fail_at(s, imu.line, fmt::format("holds noise and no calibration; expected {0}accelerometers and {0}gyroscopes, or {0}Tw and {0}Ta", place));
  }
  const std::string accel_path = path + ".accelerometers", gyro_path = path + ".gyroscopes";
  const YamlNode &accel = field_of(s, imu, path, "accelerometers"), &gyro = field_of(s, imu, path, "gyroscopes");
  Matrix3d C_i_b = Matrix3d::Identity();
  if (const YamlNode* pose = imu.find("T_i_b")) {
    const Eigen::MatrixXd T_i_b = matrix_of(s, *pose, path + ".T_i_b", 4, 4);
    C_i_b = T_i_b.topLeftCorner<3, 3>();
    if (!T_i_b.topRightCorner<3, 1>().isZero(0))
      out.warnings.emplace_back("T_i_b: its translation is left out: forces are those at the IMU, not at the body's origin");
    expect_rotation(s, pose->line, path + ".T_i_b", C_i_b);
  }
  const Matrix3d M_a = matrix3(s, accel, accel_path, "M"), M_g = matrix3(s, gyro, gyro_path, "M"), A = matrix3(s, gyro, gyro_path, "A"),
                 C_gyro_i = matrix3(s, gyro, gyro_path, "C_gyro_i");
  expect_rotation(s, gyro.line, gyro_path + ".C_gyro_i", C_gyro_i);
  for (const auto& [M, name] : {std::pair{&M_a, "accelerometers.M"}, std::pair{&M_g, "gyroscopes.M"}}) {
    if ((*M)(0, 1) != 0 || (*M)(0, 2) != 0 || (*M)(1, 2) != 0)
      out.warnings.push_back(fmt::format("{}: has an upper triangle, which Kalibr's has not: taken as it stands", name));
    if (M->diagonal().minCoeff() < 0)
      out.warnings.push_back(fmt::format("{}: has a negative scale, an axis that is turned round: taken as it stands", name));
  }
  // a_b = C_i_b^T M_a^-1 a_m;  w_b = C_i_b^T C_gyro_i^T M_g^-1 (w_m - A C_gyro_i C_i_b a_b)
  out.model.accel.matrix = C_i_b.transpose() * inverse_at(s, accel.line, accel_path + ".M", M_a);
  out.model.gyro.matrix = C_i_b.transpose() * C_gyro_i.transpose() * inverse_at(s, gyro.line, gyro_path + ".M", M_g);
  out.model.g_sensitivity = -out.model.gyro.matrix * A * C_gyro_i * C_i_b;
  out.warnings.emplace_back(no_biases);
  for (const char* axis : {"rx_i", "ry_i", "rz_i"})
    if (accel.find(axis) != nullptr) {
      out.warnings.emplace_back("the accelerometers' positions (rx_i, ry_i, rz_i) are left out");
      break;
    }
  return out;
}

ImportedModel read_openvins(const Source& s) {
  const YamlNode root = parse_yaml(s);
  std::string path;
  const YamlNode& imu = imu_of(s, root, path);
  const Matrix3d I = Matrix3d::Identity();
  const Matrix3d Tw = matrix3(s, imu, path, "Tw"), Ta = matrix3(s, imu, path, "Ta"), R_gyro = matrix3_or(s, imu, path, "R_IMUtoGYRO", I),
                 R_accel = matrix3_or(s, imu, path, "R_IMUtoACC", I), Tg = matrix3_or(s, imu, path, "Tg", Matrix3d::Zero());
  ImportedModel out;
  for (const auto& [key, otherwise] :
       {std::pair{"R_IMUtoGYRO", "the identity"}, {"R_IMUtoACC", "the identity"}, {"Tg", "zero"}, {"model", "\"kalibr\""}})
    if (imu.find(key) == nullptr) out.warnings.push_back(fmt::format("{} is missing: taken as {}", key, otherwise));
  expect_rotation(s, imu.line, path + ".R_IMUtoGYRO", R_gyro);
  expect_rotation(s, imu.line, path + ".R_IMUtoACC", R_accel);
  Matrix3d Dw = inverse_at(s, imu.line, path + ".Tw", Tw), Da = inverse_at(s, imu.line, path + ".Ta", Ta);
  name_si(out.model);
  const YamlNode* model = imu.find("model");
  if (model != nullptr && model->text != "rpng" && model->text != "kalibr")
    fail_at(s, model->line, fmt::format("{}.model: \"{}\"; expected kalibr or rpng", path, excerpt(model->text)));
  const bool upper = model != nullptr && model->text == "rpng";
  // OpenVINS itself keeps one triangle of D: what the other holds has no effect.
  for (auto& [D, name] : {std::pair{&Dw, "Tw"}, std::pair{&Da, "Ta"}}) {
    const Matrix3d kept = upper ? Matrix3d(D->triangularView<Eigen::Upper>()) : Matrix3d(D->triangularView<Eigen::Lower>());
    if ((kept - *D).norm() > 1e-9 * D->norm())
      out.warnings.push_back(fmt::format("{}: its {} triangle is left out, as OpenVINS does for model \"{}\"", name, upper ? "lower" : "upper",
                                         upper ? "rpng" : "kalibr"));
    *D = kept;
  }
  // a_I = R_IMUtoACC^T Da a_m;  w_I = R_IMUtoGYRO^T Dw (w_m - Tg a_I)
  out.model.accel.matrix = R_accel.transpose() * Da;
  out.model.gyro.matrix = R_gyro.transpose() * Dw;
  out.model.g_sensitivity = -out.model.gyro.matrix * Tg;
  out.warnings.emplace_back(no_biases);
  return out;
}

}  // namespace imulab::import_io
