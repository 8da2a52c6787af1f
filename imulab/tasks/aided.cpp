#include "imulab/tasks/aided.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/model/finding_table.hpp"
#include "imulab/report/aided_page.hpp"
#include "imulab/results/aided.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <system_error>
#include <utility>

namespace imulab {

std::vector<Outage> regular_outages(const std::string& text, double begin, double end) {
  std::istringstream in(text);
  double every = 0, length = 0, first = 0;
  char comma = 0, second = ',';
  const bool two = in >> every >> comma >> length && comma == ',';
  const bool three = two && !in.eof() && in >> second >> first && second == ',';
  std::string rest;
  if (!two || (!in.eof() && in >> rest) || !(every > length && length > 0) || (three && !(first >= 0)))
    throw OptionError("outages",
                      fmt::format("{} is no EVERY,LENGTH or EVERY,LENGTH,FIRST; expected seconds with EVERY above LENGTH, as in 60,10", text));
  std::vector<Outage> out;
  for (double t = begin + (three ? first : every); t + length < end; t += every) out.push_back({t, t + length});
  if (out.empty()) throw OptionError("outages", fmt::format("{}: the recording of {:.1f} s is too short for one", text, end - begin));
  return out;
}

void check_aided(const NavigateVerbOptions& o) {
  if (!o.aided) {
    if (o.filter) throw OptionError("filter", "belongs to --aided; expected both");
    if (!o.outages.empty()) throw OptionError("outages", "belongs to --aided; expected both");
    return;
  }
  if (o.sessions.size() > 1) throw OptionError("aided", "takes a single SESSION");
  for (const auto& [name, given] : {std::pair("vertical", o.vertical.has_value()), std::pair("barometer", !o.barometer.empty()),
                                    std::pair("align", o.align), std::pair("heading", o.heading_deg.has_value())})
    if (given) throw OptionError(name, "does not go with --aided, whose start, height and errors come from the aids");
  if (!o.truth.empty())
    throw OptionError("truth", "does not go with --aided; expected --outages, which compares the solution with the withheld aids");
  if (o.require)
    throw OptionError(
        "require",
        "does not go with --aided; expected --outages, or limits for what is predicted: imulab predict --require, imulab budget --require");
}

namespace {

/// The calibration was made of this recording too.
bool made_of(const Calibration& calibration, const std::filesystem::path& recording) {
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(recording, error);
  return !error &&
         std::ranges::any_of(calibration.sources, [&](const SourceFile& s) { return s.bytes == bytes && s.sha256 == file_sum(recording).sha256; });
}

}  // namespace

AnswerOf<AidedNavigation> aided_answer(const std::string& name, const Calibration& calibration, const Session& session, Recording recording,
                                       const NavigateVerbOptions& o, const std::vector<std::string>& told, AidedOptions options) {
  if (session.aids.empty())
    throw Error(fmt::format("{}: has no aids; expected [[aid]], as kind = \"gnss\" with a file (docs/theory/aided.md)", session.file));
  AidsReading reading = read_aids(session, session.recordings.front(), recording);
  options.causal = o.filter;
  if (!o.outages.empty()) options.outages = regular_outages(o.outages, recording.time_s(0), recording.time_s(recording.size() - 1));
  AidedNavigation navigation = navigate_aided(calibration, session, std::move(recording), reading.aids, options);
  if (const std::string& file = session.recordings.front().file; made_of(calibration, session_path(session, file))) {
    navigation.findings.add<Code::calibrated_on_same>().place = file;
  }
  const auto all = std::make_shared<const AidedNavigation>(std::move(navigation));
  std::vector<std::string> warnings = std::move(reading.warnings);
  const std::vector<std::string> found = all->findings.all();
  warnings.insert(warnings.end(), found.begin(), found.end());
  std::vector<std::string> on_page = told;
  on_page.insert(on_page.end(), warnings.begin(), warnings.end());
  const Conclusion conclusion = conclude(all->findings.doubtful() ? Verdict::doubtful : Verdict::good, aided_headline(*all), {});
  return {{.json = [all, name] { return aided_json(name, *all); },
           .table = [all, name](bool) { return aided_table(name, *all); },
           .page = [all, name, conclusion, on_page] { return aided_page(name, *all, conclusion, on_page); },
           .warnings = warnings,
           .told = told,
           .shortcomings = {},
           .conclusion = conclusion},
          all};
}

}  // namespace imulab
