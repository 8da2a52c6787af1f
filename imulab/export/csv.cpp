// A table for spreadsheets and scripts: imulab's own coefficients, one a row, with their standard uncertainties.
#include "imulab/coefficient.hpp"
#include "imulab/core/text.hpp"
#include "imulab/export/consumer_model.hpp"
#include "imulab/export/noise_values.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"
#include "imulab/formats/text/csv_field.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

namespace imulab::export_io {

namespace {

/// Every coefficient of an axis: where it is determined with uncertainty and interval, else its bound.
std::string coefficient_rows(const std::string& name, const NoiseCoefficient& c, const char* unit) {
  std::string text;
  if (c.determined && !std::isfinite(c.standard_uncertainty))  // of a data sheet
    text = fmt::format("{},{},,{}\n", name, exact_number(c.value), unit);
  else if (c.determined)
    text = fmt::format("{0},{1},{2},{5}\n{0}.lower,{3},,{5}\n{0}.upper,{4},,{5}\n", name, exact_number(c.value), exact_number(c.standard_uncertainty),
                       exact_number(c.lower), exact_number(c.upper), unit);
  else if (std::isfinite(c.upper) && c.upper > 0)
    text = fmt::format("{}.upper,{},,{}\n", name, exact_number(c.upper), unit);
  return text;
}

std::string axis_noise_rows(const ImuNoise& noise) {
  std::string text = "# Of each axis; lower, upper: the interval of 95 %; a term with upper alone is not determined.\n";
  for (const bool accel : {true, false})
    for (std::size_t i = 0; i < 3; ++i) {
      const std::optional<NoiseCoefficients>& c = accel ? noise.accel[i] : noise.gyro[i];
      if (!c) continue;
      const std::string axis = fmt::format("noise.{}.{}.", accel ? "accel" : "gyro", "xyz"[i]);
      for (const NoiseTerm& term : noise_terms())
        text += coefficient_rows(axis + term.name, (*c).*(term.coefficient), accel ? term.accel_unit : term.gyro_unit);
      for (std::size_t k = 0; k < c->markov.size(); ++k) {
        text += coefficient_rows(fmt::format("{}markov{}.sigma", axis, k + 1), c->markov[k].sigma, accel ? "m/s^2" : "rad/s");
        text += coefficient_rows(fmt::format("{}markov{}.time", axis, k + 1), c->markov[k].time, "s");
      }
    }
  return text;
}

/// The form of the recording's readings, for programs that take them in this form.
std::string recorded_rows(const std::optional<RecordedAs>& recorded, const char* triad) {
  if (!recorded) return {};
  std::string text = fmt::format("# {}: recorded in {}, columns along {} {} {} of the body\n", triad, plain(recorded->unit), plain(recorded->axes[0]),
                                 plain(recorded->axes[1]), plain(recorded->axes[2]));
  if (recorded->counts_per_unit != 1) text += fmt::format("# {}: {} counts to one {}\n", triad, recorded->counts_per_unit, plain(recorded->unit));
  if (recorded->interval_s > 0) text += fmt::format("# {}: increments over {} s\n", triad, recorded->interval_s);
  return text;
}

std::string noise_rows(const NoiseValues& n) {
  std::string text = n.stream_rate_hz ? fmt::format("noise.rate,{},,Hz\n", exact_number(*n.stream_rate_hz)) : "";
  for (const auto& [name, value, unit] :
       {std::tuple{"noise.accel.N", &n.accel_N, "m/s^2/sqrt(Hz)"}, std::tuple{"noise.accel.K", &n.accel_K, "m/s^3/sqrt(Hz)"},
        std::tuple{"noise.gyro.N", &n.gyro_N, "rad/s/sqrt(Hz)"}, std::tuple{"noise.gyro.K", &n.gyro_K, "rad/s^2/sqrt(Hz)"}}) {
    text += fmt::format("# {}: {}\n", name, value->comment);
    if (!value->missing) text += fmt::format("{},{},,{}\n", name, exact_number(value->value), unit);
  }
  return text;
}

std::string temperature_rows(const TriadModel& m, const char* triad) {
  if (!m.temperature) return {};
  const std::string unit = plain(m.temperature->unit) == "degC" || m.temperature->unit == "K" ? m.temperature->unit : "raw";
  return fmt::format("{0}.temperature.reference,{1},,{4}\n{0}.temperature.lowest,{2},,{4}\n{0}.temperature.highest,{3},,{4}\n", triad,
                     exact_number(m.temperature->reference), exact_number(m.temperature->range[0]), exact_number(m.temperature->range[1]), unit);
}

/// Spreadsheets split comments, too: names in them open no cell that is run, and no quoted one, in which a formula or the next line would be hidden.
std::string with_plain_cells(const std::string& text) {
  std::string out;
  bool comment = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (i == 0 || text[i - 1] == '\n') comment = text[i] == '#';
    const bool opens = comment && i > 0 && (text[i - 1] == ',' || text[i - 1] == ';');
    const std::string_view cell = opens ? std::string_view(text).substr(i, text.find_first_of(",;\n", i) - i) : std::string_view();
    if (text::would_run(cell) || trimmed(cell).starts_with('"')) out += '\'';
    out += text[i];
  }
  return out;
}

}  // namespace

std::string csv_text(const ExportInput& input) {
  const Calibration& c = input.calibration;
  const std::vector<std::string> undetermined = not_determined(c);
  consumer_model(c.model);  // finite and with an inverse
  const auto raw = [](const TriadModel& m, const char* si) { return m.raw_unit.empty() ? std::string(si) : plain(m.raw_unit); };
  std::string text = comment_head(
      input, "tables",
      {"Holds: every coefficient of the model with its standard uncertainty (inf: not determined by the data), noise with intervals.",
       "V = u - (thermal.1 tau + thermal.2 tau^2 + thermal.3 tau^3), tau = T - reference, T not beyond its range: u a reading, V of its own axis",
       "force = S (offset + matrix V + quadratic V^2 + cubic V^3)      rate = S (offset + matrix V + quadratic V^2 + cubic V^3) + g_sensitivity "
       "force",
       "S = 1 + matrix_thermal1 tau + matrix_thermal2 tau^2, tau of the row's axis; rows of matrix_thermal and thermal.3 that are left out are 0",
       "so offsets are added to the output. Readings: accelerometers in " + raw(c.model.accel, "m/s^2") + ", gyros in " + raw(c.model.gyro, "rad/s") +
           ".",
       fmt::format("u: along x, y, z of the body. Frame of the body: {}.", to_string(c.frame))},
      left_out_of_matrices(input));
  text += "name,value,standard_uncertainty,unit\n";
  for (const CoefficientIndex index : coefficient_indices()) {
    auto sigma = standard_uncertainty(c, index);
    if (is_extended(coefficient(index)) && !sigma && coefficient_value(c.model, index) == 0) continue;
    if (std::find(undetermined.begin(), undetermined.end(), coefficient(index).name) != undetermined.end())
      sigma = std::numeric_limits<double>::infinity();
    text += fmt::format("{},{},{},{}\n", coefficient(index).name, exact_number(coefficient_value(c.model, index)),
                        sigma ? (std::isfinite(*sigma) ? exact_number(*sigma) : "inf") : "", coefficient(index).unit);
  }
  text += fmt::format("accel.readings,{},,\ngyro.readings,{},,\n", text::csv_field(raw(c.model.accel, "m/s^2")),
                      text::csv_field(raw(c.model.gyro, "rad/s")));
  text += recorded_rows(c.recorded_accel, "accel") + recorded_rows(c.recorded_gyro, "gyro");
  text += temperature_rows(c.model.accel, "accel") + temperature_rows(c.model.gyro, "gyro");
  if (input.noise != nullptr) text += noise_rows(noise_values(input, "csv")) + axis_noise_rows(*input.noise);
  return with_plain_cells(text);
}

}  // namespace imulab::export_io
