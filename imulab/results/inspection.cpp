#include "imulab/results/inspection.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/json_fields.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/model/calibration_fields.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace imulab {
namespace {

std::vector<std::string> supported_methods(const Inspection& inspection) {
  std::vector<std::string> names;
  for (const MethodFinding& method : inspection.methods)
    if (method.supported) names.push_back(method.name);
  return names;
}

}  // namespace

std::string inspection_headline(const Inspection& inspection) {
  if (!inspection.problems().empty()) return "not usable: the file has to be fixed first";
  if (!inspection.complete())
    return fmt::format("open: {} question{} that the data do not answer; declare with --set KEY=VALUE", inspection.ambiguous().size(),
                       inspection.ambiguous().size() == 1 ? "" : "s");
  const std::vector<std::string> methods = supported_methods(inspection);
  if (methods.empty()) return "understood: but the data support no calibration by rests alone (see below)";
  return fmt::format("understood: calibrate with --method {}", fmt::join(methods, " or --method "));
}

std::string inspection_text(const Inspection& inspection) {
  const std::string headline = inspection_headline(inspection);
  const std::size_t word = headline.find(": ") + 2;
  std::string out = text::wrapped(headline.substr(0, word), headline.substr(word));
  for (const std::string& problem : inspection.problems()) out += text::wrapped("  ! ", one_line(problem));
  for (const std::string& question : inspection.ambiguous()) out += text::wrapped("  ? ", one_line(question));
  out += fmt::format("\n{}\n", one_line(inspection.file));
  out += text::wrapped("  ", fmt::format("{}; {} rows{}", one_line(inspection.format), inspection.rows,
                                         inspection.rate_hz ? fmt::format(", {:.6g} s", inspection.duration_s) : ""));
  for (const std::string& line : inspection.evidence()) out += text::wrapped("  ", one_line(line));
  std::string unused;
  for (const ColumnFinding& column : inspection.columns)
    if (column.role == "unused") unused += (unused.empty() ? "" : ", ") + column.name;
  if (!unused.empty()) out += text::wrapped("  ", "not used: " + one_line(unused));
  if (!inspection.methods.empty()) out += "\nmethods\n";
  for (const MethodFinding& method : inspection.methods)
    out += text::wrapped(fmt::format("  {:<11}{:<5}", method.name, method.supported ? "yes" : "no"), method.why);
  return out;
}

template <class Fields>
void describe(Fields& f, const ColumnFinding& c) {
  f("name", c.name), f("role", c.role), f("unit", c.unit), f("evidence", c.evidence);
}

template <class Fields>
void describe(Fields& f, const Inspection& i) {
  f("file", i.file), f("topic", i.topic), f("format", i.format), f("rows", i.rows), f("columns", i.columns);
  f.table("time",
          [&](auto& time) { time("unit", i.source.time.unit), time("rate_hz", i.rate_hz), time("jitter_s", i.jitter_s), time("gaps", i.gaps); });
  f("evidence", i.evidence()), f("ambiguous", i.ambiguous()), f("problems", i.problems()), f("methods", supported_methods(i)),
      f("findings", i.findings);
}

std::string inspection_json(const Inspection& inspection) { return json_text(written(inspection)); }

std::string inspected_session_text(const Inspection& inspection, const Session& session) {
  if (!inspection.complete())
    throw Error(fmt::format("{}: no session can be written: {}", inspection.file,
                            fmt::join(inspection.problems().empty() ? inspection.ambiguous() : inspection.problems(), "; ")));
  std::string out = "# Written by imulab inspect, which found in the recording:\n";
  for (std::string line : inspection.evidence()) {
    std::replace_if(
        line.begin(), line.end(), [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; }, '?');  // a name may hold anything
    out += "# - " + line + "\n";
  }
  if (session.site.given_gravity_sigma && !session.site.latitude)
    out += fmt::format("# The place is not declared: gravity is as anywhere on Earth, which leaves the accelerometers' scale open by {:.2g} %.\n",
                       100 * *session.site.given_gravity_sigma / *session.site.given_gravity);
  return out + session_text(session);
}

}  // namespace imulab
