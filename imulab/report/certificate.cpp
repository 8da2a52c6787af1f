#include "imulab/report/certificate.hpp"

#include "imulab/error.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/report/assets.hpp"
#include "imulab/report/calibration_facts.hpp"
#include "imulab/report/certificate_parts.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/start.hpp"
#include "imulab/rig/rig_errors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace imulab::report {

namespace {

constexpr std::size_t longest_statement = 400;  // characters: what is longer belongs into a document of its own

/// Text as a string of a style sheet. Only characters that end a string, a line or the style have to be hidden.
std::string style_string(std::string_view text) {
  std::string out;
  for (const char c : escaped(shortened(text, 60))) {
    if (c == '\\')
      out += "\\5c ";
    else
      out += c == '\n' || c == '\t' ? ' ' : c;
  }
  for (const auto& [entity, hidden] : {std::pair{"&lt;", "\\3c "}, {"&gt;", "\\3e "}, {"&quot;", "\\22 "}, {"&#39;", "\\27 "}, {"&amp;", "\\26 "}})
    for (std::size_t at = 0; (at = out.find(entity, at)) != std::string::npos;) out.replace(at, std::string_view(entity).size(), hidden);
  return "\"" + out + "\"";
}

std::string serial_text(const Calibration& c) { return c.serial.empty() ? "serial number not declared" : "serial number " + c.serial; }
std::string numbered(const Certificate& c) { return c.number.empty() ? "Calibration certificate" : "Calibration certificate " + c.number; }

/// What stands on each printed page: the browser counts them.
std::string page_boxes(const Certificate& c) {
  const std::string font = "font:8pt system-ui,\"DejaVu Sans\",sans-serif;color:#4d5965";
  return fmt::format(
      "@page{{@top-left{{content:{};{}}}@top-right{{content:{};{}}}@bottom-right{{content:\"page \" counter(page) \" of \" "
      "counter(pages);{}}}}}",
      style_string(numbered(c)), font, style_string(serial_text(c.report.result.calibration)), font, font);
}

/// The same where a screen shows sheets.
std::string running_line(const Certificate& c) {
  return fmt::format("<p class=\"running\">{} · {}</p>\n", escaped(shortened(numbered(c), 80)),
                     escaped(shortened(serial_text(c.report.result.calibration), 80)));
}

std::string lines_of(const std::string& name, const std::string& address) {
  return name.empty() || address.empty() ? name + address : name + "\n" + address;
}

std::string head_part(const Certificate& c) {
  const Laboratory& lab = c.laboratory;
  const std::string accredited =
      lab.accreditation.empty() ? "This is not an accredited certificate." : "Accreditation, as declared: " + lab.accreditation;
  return fmt::format(
      "<div class=\"head\"><div class=\"laboratory\"><strong>{}</strong>\n{}</div><div class=\"number\">certificate number<br><b>{}</b></div></div>\n"
      "<h1 id=\"certificate\">Calibration certificate</h1>\n<p>{}</p>\n",
      lab.name.empty() ? "Laboratory: " + or_line("") : escaped(shortened(lab.name, 120)),
      lab.address.empty() ? "address: " + or_line("") : escaped(shortened(lab.address, longest_statement)),
      c.number.empty() ? "<span class=\"fill short\"></span>" : escaped(shortened(c.number, 60)), escaped(shortened(accredited, longest_statement)));
}

/// A doubtful calibration is a result too; the one who receives it must not miss that.
std::string doubt_part(const Quality& quality) {
  if (quality.verdict != Verdict::doubtful) return "";
  constexpr std::size_t shown = 3;
  std::vector<std::string> because;
  for (const std::string& reason : quality.findings.reasons()) because.push_back(shortened(reason, 240));
  const std::size_t more = because.size() > shown ? because.size() - shown : 0;
  if (more > 0) because.resize(shown), because.push_back(fmt::format("{} more in the appendix", more));
  return "<div class=\"notice\"><strong id=\"verdict\">This calibration is doubtful</strong>: the stated uncertainties may be too small, and no "
         "statement of conformity is made" +
         (because.empty() ? std::string(".") : ", because" + list(because)) + "</div>\n";
}

std::string item_part(const Certificate& c) {
  const Calibration& of = c.report.result.calibration;
  const Laboratory& lab = c.laboratory;
  Statements s;
  s.add("customer", lines_of(lab.customer.name, lab.customer.address));
  s.add_known("information from the customer", lab.customer.information);
  const std::string name = declared_name(of);
  s.add("item", name.empty() ? "" : "inertial measurement unit " + name);
  s.add_html("manufacturer and type", or_line(lab.item.manufacturer) + ", " + or_line(lab.item.type));
  s.add("serial number", of.serial);
  s.add_known("firmware", of.firmware);
  s.add_known("filter of the readings", of.filter);
  s.add_html("received on, in what condition", or_line(lab.item.received) + ", " + or_line(lab.item.condition));
  s.add("date of measurement", measured_text(of));
  s.add("date of issue", lab.issued);
  s.add("adjustment or repair", lab.item.adjustment);
  return "<h2>Customer and item</h2>\n" + s.html();
}

std::string conditions_part(const Certificate& c) {
  const Calibration& of = c.report.result.calibration;
  const auto& declared = c.laboratory.conditions;
  const std::string place = !declared.place.empty() ? declared.place : of.station;
  Statements s;
  s.add("place of calibration", place);
  s.add("ambient temperature", declared.temperature);
  s.add_known("thermal readings of the item", thermal_readings(of));
  s.add("relative humidity", declared.humidity);
  s.add("pressure", declared.pressure);
  s.add("gravity, and its source", c.report.session ? gravity_text(c.report.session->site) : "");
  const std::string latitude = c.report.session ? latitude_text(c.report.session->site) : "";
  s.add_known("latitude", latitude.substr(0, latitude.find(':')));
  s.add_known("warm-up", of.warm_up);
  s.add_known("power cycles", of.power_cycles);
  return "<h2>Conditions</h2>\n" + s.html();
}

std::string procedure_part(const Certificate& c) {
  const Calibration& of = c.report.result.calibration;
  const Method* method = find_method(of.method);
  std::string name = of.method;
  if (method != nullptr) name += fmt::format(": {} ({})", method->summary, method->reference);
  Statements s;
  s.add("procedure of the laboratory", c.laboratory.procedure.name);
  s.add("method", name);
  s.add_known("test", test_text(of, c.report));
  s.add_known("positions", positions_text(of.quality));
  if (c.report.session) s.add_known("machine", rigs_text(*c.report.session));
  s.add("deviations from the procedure", c.laboratory.procedure.deviations);
  s.add("measured by", of.operated_by);
  return "<h2>Procedure</h2>\n" + s.html();
}

std::string certificate_head(const Certificate& c) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{}: {}</title>\n<style>{}\n{}</style></head>\n",
      escaped(shortened(numbered(c), 60)), escaped(shortened(serial_text(c.report.result.calibration), 60)), assets::certificate_css, page_boxes(c));
}

}  // namespace

std::string or_line(const std::string& text) { return text.empty() ? "<span class=\"fill\"></span>" : escaped(shortened(text, longest_statement)); }

void Statements::add(std::string_view name, const std::string& value) { add_html(name, or_line(value)); }

void Statements::add_known(std::string_view name, const std::string& value) {
  if (!value.empty()) add(name, value);
}

void Statements::add_html(std::string_view name, const std::string& html) {
  rows_ += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", escaped(name), html);
}

}  // namespace imulab::report

namespace imulab {

std::string certificate_page(const Certificate& c) {
  using namespace report;
  const Calibration& calibration = c.report.result.calibration;
  if (calibration.estimated.empty())
    throw Unsupported("the calibration has no uncertainties; a certificate states results with their uncertainties; expected one that imulab made");
  if (const std::string first = measured_days(calibration)[0], &issued = c.laboratory.issued; !issued.empty() && issued < first)
    throw Error(fmt::format("issued: {} is before the day of the measurement, {}", issued, measured_text(calibration)));
  std::string out = certificate_head(c) + "<body><main>\n";
  out += "<section class=\"sheet\">" + running_line(c) + head_part(c) + doubt_part(calibration.quality) + item_part(c) + conditions_part(c) +
         procedure_part(c) + traceability_part(c) + "</section>\n";
  out +=
      "<section class=\"sheet\">" + running_line(c) + results_part(c) + conformity_part(calibration) + signature_part(c.laboratory) + "</section>\n";
  out += "<section class=\"sheet appendix\">" + running_line(c) + appendix_part(c) + "</section>\n";
  return out + "</main></body></html>\n";
}

}  // namespace imulab
