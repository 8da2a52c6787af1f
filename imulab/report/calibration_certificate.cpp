// The certificate states what was calibrated and how, what it does not cover, where its scales come from, and the files behind it.
#include "imulab/estimate/method.hpp"
#include "imulab/report/calibration_facts.hpp"
#include "imulab/report/calibration_parts.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/pictures.hpp"
#include "imulab/report/start.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::report {

namespace {

/// Rows of name and value; values that are empty are left out.
class Facts {
 public:
  void add(const std::string& name, const std::string& value) {
    if (!value.empty()) table_.rows.push_back({escaped(name), escaped(shortened(value, 1000))});
  }
  void add_hash(const std::string& name, const std::string& value) {
    if (!value.empty()) table_.rows.push_back({escaped(name), "<span class=\"hash\">" + escaped(value) + "</span>"});
  }
  std::string html() const { return table_.rows.empty() ? "" : table(table_); }

 private:
  Table table_{.head = {}, .rows = {}, .text_columns = true};
};

}  // namespace

std::string identification_section(const CalibrationReport& report) {
  const Calibration& c = report.result.calibration;
  Facts facts;
  facts.add("IMU", c.imu);
  facts.add("serial number", c.serial);
  facts.add("firmware", c.firmware);
  facts.add("filter of the readings", c.filter);
  facts.add("date", c.created);
  facts.add("data taken by", c.operated_by);
  facts.add("at the station", c.station);
  facts.add("measured", c.measured);
  facts.add("valid until", c.valid_until);
  facts.add("warm-up", c.warm_up);
  facts.add("power cycles", c.power_cycles);
  facts.add("method", c.method);
  facts.add("test", test_text(c, report));
  facts.add("positions", positions_text(c.quality));
  facts.add("axes", frame_text(c));
  facts.add("seconds of the gyros", clock_text(c.clock));
  if (report.session) {
    facts.add("gravity", gravity_text(report.session->site));
    facts.add("latitude", latitude_text(report.session->site));
    facts.add("rig", rigs_text(*report.session));
  }
  facts.add("readings", c.model.accel.raw_unit.empty() && c.model.gyro.raw_unit.empty()
                            ? ""
                            : fmt::format("accelerometers in {}, gyros in {}", c.model.accel.raw_unit, c.model.gyro.raw_unit));
  facts.add("accelerometer temperature", temperature_text(c.model.accel));
  facts.add("gyro temperature", temperature_text(c.model.gyro));
  facts.add("motion", ranges_text(report));
  const std::string sketch = figure(
      axes_sketch(), "Right-handed axes. At rest the axis that points up measures +1 g. A positive rate turns as the arc does: about z from x to y.");
  return section("identification", "What was calibrated, and how", "",
                 facts.html() + "<div class=\"small\">" + sketch + "</div>\n" + model_equation(c) + list(c.quality.findings.notes()));
}

std::string not_covered_section(const CalibrationReport& report, const std::string& temperature) {
  const Calibration& c = report.result.calibration;
  std::vector<std::string> out;
  if (!c.model.accel.temperature && !c.model.gyro.temperature) {
    const std::string own = thermal_readings(c);
    out.push_back("Temperature: the values hold at that of the " + std::string(calibrated_here(c) ? "recording" : "measurement") +
                  (!own.empty()           ? ", by the item's own readings " + own
                   : !temperature.empty() ? ", ambient as declared " + shortened(temperature, 200)
                                          : ", which is not known here: no thermal reading is on record") +
                  ".");
  } else
    out.emplace_back("Temperatures outside the calibrated range, fast changes of temperature, and hysteresis.");
  out.emplace_back("Repeatability: biases and scale factors change from one power-on to the next, and age. One calibration does not show by how much.");
  const std::string ranges = ranges_text(report);
  out.push_back(ranges.empty() ? "Rates and forces beyond those of the recording."
                               : "Rates and forces beyond those of the recording, " + ranges + ".");
  if (!has_estimated(c, Term::g_sensitivity, Triad::gyro)) out.emplace_back("The gyros' sensitivity to acceleration: not estimated.");
  out.emplace_back("Vibration, shock, magnetic fields, supply voltage, bandwidth and delay: not examined.");
  out.emplace_back("Noise and bias instability over time: an Allan deviation needs a long recording at rest.");
  if (find_method(c.method) != nullptr && c.frame == BodyFrame::accelerometers)
    out.emplace_back("The axes are the sensors' own: their orientation in the housing is not measured.");
  return section("not-covered", "What this does not cover", "", list(out));
}

std::string traceability_section(const CalibrationReport& report) {
  const std::vector<Reference>& references = report.result.calibration.references;
  Table t{.head = {"quantity", "comes from", "instrument", "certificate"}, .rows = {}, .text_columns = true};
  std::string with, without;
  for (const Origin& origin : origins_of(report)) {
    const auto r = std::find_if(references.begin(), references.end(), [&](const Reference& own) { return own.quantity == origin.quantity; });
    const bool declared = r != references.end();
    const std::string unused = declared ? why_unused(origin, *r, report.result.calibration) : "";
    std::string& names = declared && unused.empty() ? with : without;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", origin.name);
    t.rows.push_back({std::string(origin.name), escaped(origin.from), declared ? escaped(shortened(r->instrument, 1000)) : "",
                      declared ? certificate_text(*r, unused) : "none on record"});
  }
  return section("traceability", "Traceability", traceability_text(with, without, !references.empty()), table(t));
}

std::string origin_section(const CalibrationReport& report) {
  const Calibration& c = report.result.calibration;
  Facts facts;
  facts.add("calibrated with", c.software);
  std::string options;
  for (const auto& [name, value] : c.options) options += fmt::format("{}{} = {}", options.empty() ? "" : ", ", name, value);
  facts.add("options", options);
  facts.add("session", c.session_file);
  facts.add_hash("SHA-256", c.session_sha256);
  for (const SourceFile& s : c.sources) {
    facts.add("recording",
              fmt::format("{}: {} bytes, {} from {} on", s.file, s.bytes, seconds_text(s.last_s - s.first_s), stamp_and_date(s.first_s)));
    facts.add_hash("SHA-256", s.sha256);
  }
  return section("origin", "Files and versions", "", facts.html());
}

}  // namespace imulab::report
