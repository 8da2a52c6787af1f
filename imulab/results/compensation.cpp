#include "imulab/results/compensation.hpp"

#include "imulab/formats/text/json_fields.hpp"
#include "imulab/results/conclusion.hpp"
#include "imulab/results/over_time.hpp"
#include "imulab/results/thinned.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <utility>

namespace imulab {

using fields::Presence;

template <class Fields>
void describe(Fields& f, Overview& o) {
  const auto columns = [&](const char* key, Columns3& lists, double size, Presence presence) {
    f(key, lists, {.presence = presence, .size = size, .things = "lists of numbers", .digits = 6});
    for (const auto& list : lists)
      fields::check(f, list.size() == o.time.size() || (presence == Presence::optional && list.empty()), key,
                    "expected lists of " + std::to_string(o.time.size()) + " numbers");
  };
  f("samples_per_interval", o.samples_per_interval), f("first_s", o.first_s, fields::optional),
      f("time_s", o.time, {.digits = result_io::stamp_digits});
  if constexpr (Fields::reads)
    if (!f.at().has("first_s") && !o.time.empty()) o.first_s = o.time.front();
  columns("rate_deg_per_s", o.rate, unit::deg, Presence::required), columns("force_mps2", o.force, 1, Presence::required);
  if (Fields::reads || !o.temperature[0].empty()) columns("temperature", o.temperature, 1, Presence::optional);
}

template <class Fields>
void describe(Fields& f, CompensatedFile& c) {
  f("file", c.file), f("samples", c.samples), f("saturated", c.saturated), f("outside_calibrated_temperatures", c.out_of_range);
  f("outliers_replaced", c.replaced);
  if constexpr (Fields::reads)
    if (f.at().has("overview")) c.overview.emplace();
  if (c.overview) f("recording", c.recording), f("rate_hz", c.rate_hz), f("gaps", c.gaps), f("overview", *c.overview);
}

template <class Fields>
void describe(Fields& f, CompensationSummary& s) {
  f("files", s.files);
  fields::check(f, !s.files.empty(), "files", "is empty; expected at least one recording");
  f.table("calibration", [&](auto& t) {
    t("file", s.calibration_file), t("imu", s.imu);
    fields::choice(t, "verdict", s.quality.verdict, quality_verdicts, "good or doubtful", fields::optional);
    fields::via(
        t, "because", [&] { return s.quality.findings.reasons(); },
        [&](const std::vector<std::string>& reasons) { s.quality.findings.append(Severity::doubt, reasons); }, fields::optional);
  });
}

Conclusion conclusion_of(const CompensationSummary& summary) {
  std::size_t samples = 0, reserved = 0;
  for (const CompensatedFile& c : summary.files) samples += c.samples, reserved += c.saturated + c.out_of_range + c.replaced;
  std::string headline = fmt::format("{} samples compensated", samples);
  if (reserved > 0) headline += fmt::format(", {} times with a reading at a limit, outside the calibrated temperatures or replaced", reserved);
  if (summary.quality.verdict == Verdict::doubtful) headline += "; the calibration is doubtful";
  return {reserved > 0 || summary.quality.verdict == Verdict::doubtful ? Verdict::doubtful : Verdict::good, std::move(headline)};
}

std::string compensation_json(const CompensationSummary& summary) { return result_text("compensation", written(summary), JsonLayout::long_lists); }

CompensationSummary result_io::compensation_of(const json_io::Field& root) {
  CompensationSummary out;
  read_into(root, out);
  return out;
}

}  // namespace imulab
