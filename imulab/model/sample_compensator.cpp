#include "imulab/compensate.hpp"
#include "imulab/error.hpp"
#include "imulab/model/compensation_derivatives.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

namespace imulab {
namespace {

void check_form(const TriadModel& m, const char* triad, std::string_view unit, std::string_view temperature_unit,
                std::vector<std::string>& problems) {
  const std::string_view si = std::string_view(triad) == "gyro" ? "rad/s" : "m/s^2";
  if (unit != "count" && unit != si)
    problems.push_back(fmt::format("{}: the readings are in \"{}\"; expected count or {}", triad, unit, si));
  else if (!m.raw_unit.empty() && m.raw_unit != unit)
    problems.push_back(fmt::format("{}: the readings are in {}; expected {}, which the calibration was made from", triad, unit, m.raw_unit));
  if (temperature_unit != "degC" && temperature_unit != "K" && temperature_unit != "raw")
    problems.push_back(fmt::format("{}: the temperatures are in \"{}\"; expected degC, K or raw", triad, temperature_unit));
  else if (m.varies() && m.temperature && m.temperature->unit != temperature_unit)
    problems.push_back(fmt::format("{}: the temperatures are in {}; expected {}, which the calibration was made from", triad, temperature_unit,
                                   m.temperature->unit));
}

}  // namespace

SampleCompensator::SampleCompensator(const SensorModel& model, const SampleOptions& options) : model_(model) {
  std::vector<std::string> problems = problems_of(model);
  check_form(model.gyro, "gyro", options.gyro_unit, options.gyro_temperature_unit, problems);
  check_form(model.accel, "accel", options.accel_unit, options.accel_temperature_unit, problems);
  if (!options.leave_lever_arms && !model.lever_arm.isZero(0))
    problems.push_back("the model has lever arms, which act over several samples; expected a model without, or leave_lever_arms in the options");
  throw_problems("the model", problems);
  needs_temperature_ = model.gyro.varies() || model.accel.varies();
  if (model.gyro.temperature) gyro_temperature_ = *model.gyro.temperature;
  if (model.accel.temperature) accel_temperature_ = *model.accel.temperature;
}

Motion SampleCompensator::operator()(const Vector3d& gyro, const Vector3d& accel) const {
  if (needs_temperature_) throw Error("the model has thermal terms; expected the temperatures with each sample");
  return compensate(model_, {.gyro = gyro, .accel = accel});
}

}  // namespace imulab
