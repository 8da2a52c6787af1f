// A table for spreadsheets and scripts: imulab's own coefficients, one a row, with their standard uncertainties.
#include "imulab/io/export/consumer_model.hpp"
#include "imulab/io/export/noise_values.hpp"
#include "imulab/io/export/targets.hpp"
#include "imulab/io/export/write.hpp"
#include "imulab/model/coefficient.hpp"

#include <fmt/format.h>

namespace imulab::export_io {

namespace {

std::string noise_rows(const NoiseValues& n) {
  std::string text = fmt::format("noise.rate,{},,Hz\n", number_text(n.rate_hz));
  for (const auto& [name, value, unit] :
       {std::tuple{"noise.accel.N", &n.accel_N, "m/s^2/sqrt(Hz)"}, std::tuple{"noise.accel.K", &n.accel_K, "m/s^3/sqrt(Hz)"},
        std::tuple{"noise.gyro.N", &n.gyro_N, "rad/s/sqrt(Hz)"}, std::tuple{"noise.gyro.K", &n.gyro_K, "rad/s^2/sqrt(Hz)"}}) {
    text += fmt::format("# {}: {}\n", name, value->comment);
    text += fmt::format("{},{},,{}\n", name, number_text(value->value), unit);
  }
  return text;
}

std::string temperature_rows(const TriadModel& m, const char* triad) {
  if (!m.temperature) return {};
  const std::string unit = plain(m.temperature->unit) == "degC" || m.temperature->unit == "K" ? m.temperature->unit : "raw";
  return fmt::format("{0}.temperature.reference,{1},,{4}\n{0}.temperature.lowest,{2},,{4}\n{0}.temperature.highest,{3},,{4}\n", triad,
                     number_text(m.temperature->reference), number_text(m.temperature->range[0]), number_text(m.temperature->range[1]), unit);
}

}  // namespace

std::string csv_text(const ExportInput& input) {
  const Calibration& c = input.calibration;
  consumer_model(c.model);  // finite and with an inverse
  const auto raw = [](const TriadModel& m, const char* si) { return m.raw_unit.empty() ? std::string(si) : plain(m.raw_unit); };
  std::string text = comment_head(
      input, "tables",
      {"V = u - (thermal.1 tau + thermal.2 tau^2), tau = T - reference: u a reading, V of its own axis",
       "force = offset + matrix V + quadratic V^2 + cubic V^3      rate = offset + matrix V + quadratic V^2 + cubic V^3 + g_sensitivity force",
       "so offsets are added to the output. Readings: accelerometers in " + raw(c.model.accel, "m/s^2") + ", gyros in " + raw(c.model.gyro, "rad/s") +
           "."},
      left_out_of_matrices(input));
  text += "name,value,standard_uncertainty,unit\n";
  for (const CoefficientIndex index : coefficient_indices()) {
    const auto sigma = standard_uncertainty(c, index);
    text += fmt::format("{},{},{},{}\n", coefficient(index).name, number_text(coefficient_value(c.model, index)), sigma ? number_text(*sigma) : "",
                        coefficient(index).unit);
  }
  text += temperature_rows(c.model.accel, "accel") + temperature_rows(c.model.gyro, "gyro");
  return input.noise == nullptr ? text : text + noise_rows(noise_values(input, "csv"));
}

}  // namespace imulab::export_io
