#include "imulab/model/conclusion.hpp"

#include "imulab/calibration.hpp"
#include "imulab/core/stated_limit.hpp"
#include "imulab/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

namespace imulab {

std::string reached_text(const RequirementResult& r) {
  if (!std::isfinite(r.reached)) return "not determined";
  try {
    const StatedLimit stated = parse_limits(r.text, "", "").front();
    const double reached = r.reached * stated.number / r.limit;
    std::string text;
    const auto rounded = [](double value, int digits) {
      const std::string shown = fmt::format("{:.{}g}", value, digits);
      std::from_chars(shown.data(), shown.data() + shown.size(), value);
      return fmt::format("{:.9g}", value);
    };
    for (int digits = 3; digits <= 9; ++digits) {  // as many as distinguish it from the limit
      text = rounded(reached, digits);
      if (reached == stated.number || text != rounded(stated.number, digits)) break;
    }
    return text + " " + stated.unit;
  } catch (const Error&) {  // a text from another program
    return fmt::format("{:.3g}", r.reached);
  }
}

std::string requirement_text(const RequirementResult& r) {
  return fmt::format("{} {}; required: {}{}", r.coefficient, reached_text(r), r.text, r.note.empty() ? "" : " (" + r.note + ")");
}

std::string judged_text(const RequirementResult& r) {
  return fmt::format("{}: {} ({}: {}{}{})", r.text, r.met ? "met" : "not met", r.coefficient, reached_text(r), r.note.empty() ? "" : "; ", r.note);
}

Verdict verdict_about(Verdict measured, const std::vector<RequirementResult>& requirements) {
  if (requirements.empty() || measured == Verdict::doubtful) return measured;
  return std::all_of(requirements.begin(), requirements.end(), [](const RequirementResult& r) { return r.met; }) ? Verdict::met : Verdict::not_met;
}

Conclusion conclude(Verdict measured, std::string headline, std::vector<RequirementResult> requirements) {
  Conclusion out{verdict_about(measured, requirements), std::move(headline), std::move(requirements)};
  if (out.verdict == Verdict::doubtful)
    for (RequirementResult& r : out.requirements) r.met = false;
  if (out.verdict != Verdict::met && out.verdict != Verdict::not_met) return out;
  const auto worse = [](const RequirementResult& a, const RequirementResult& b) { return a.reached / a.limit < b.reached / b.limit; };
  std::vector<RequirementResult> shown = out.requirements;
  if (out.verdict == Verdict::not_met) std::erase_if(shown, [](const RequirementResult& r) { return r.met; });
  out.headline = requirement_text(*std::max_element(shown.begin(), shown.end(), worse));
  if (shown.size() > 1) out.headline += fmt::format("; {} more {}", shown.size() - 1, to_string(out.verdict));
  return out;
}

std::string conclusion_text(const Conclusion& c) {
  return c.verdict == Verdict::none ? c.headline : fmt::format("{}: {}", to_string(c.verdict), c.headline);
}

bool is_favorable(Verdict verdict) { return verdict == Verdict::good || verdict == Verdict::met; }

std::string missed_requirements(const Conclusion& c) {
  std::string list;
  for (const RequirementResult& r : c.requirements)
    if (!r.met || c.verdict == Verdict::doubtful) list += (list.empty() ? "" : ", ") + r.text;
  if (list.empty()) return list;
  return (c.verdict == Verdict::doubtful ? "a doubtful result meets no requirement: " : "not met: ") + list;
}

}  // namespace imulab
