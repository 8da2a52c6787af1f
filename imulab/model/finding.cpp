#include "imulab/finding.hpp"

#include "imulab/model/finding_table.hpp"

#include <algorithm>
#include <array>

namespace imulab {

namespace {

std::string as_warning(const Finding& f) { return (f.place.empty() ? "" : f.place + ": ") + f.text + (f.advice.empty() ? "" : "; " + f.advice); }

template <class Wanted, class Text>
std::vector<std::string> texts_of(const Findings& findings, const Wanted& wanted, const Text& text) {
  std::vector<std::string> out;
  for (const Finding& f : findings)
    if (wanted(f)) out.push_back(text(f));
  return out;
}

}  // namespace

std::string_view to_string(Verdict verdict) {
  constexpr std::array<std::string_view, 5> names{"", "good", "doubtful", "met", "not met"};
  return names[static_cast<std::size_t>(verdict)];
}

std::string_view to_string(Severity severity) {
  constexpr std::array<std::string_view, 3> names{"note", "warning", "doubt"};
  return names[static_cast<std::size_t>(severity)];
}

std::string_view name_of(Code code) { return finding_row(code).name; }

Code code_of(std::string_view name) {
  const auto found = std::ranges::find(finding_table, name, &FindingRow::name);
  return found == finding_table.end() ? Code::other : found->code;
}

void Findings::append(Severity severity, const std::vector<std::string>& texts) {
  for (const std::string& text : texts) push_back({.code = Code::other, .severity = severity, .text = text});
}

void Findings::prepend(Severity severity, const std::vector<std::string>& texts) {
  Findings first;
  first.append(severity, texts);
  prepend(first);
}

bool Findings::has(Code code) const { return std::ranges::find(*this, code, &Finding::code) != end(); }
bool Findings::doubtful() const { return std::ranges::find(*this, Severity::doubt, &Finding::severity) != end(); }

std::vector<std::string> Findings::of(Severity severity) const {
  return texts_of(
      *this, [severity](const Finding& f) { return f.severity == severity; }, as_warning);
}
std::vector<std::string> Findings::reasons() const {
  return texts_of(
      *this, [](const Finding& f) { return f.severity == Severity::doubt; }, [](const Finding& f) { return f.text; });
}
std::vector<std::string> Findings::warnings() const {
  const auto wanted = [](const Finding& f) { return f.severity == Severity::warning || (f.severity == Severity::doubt && !f.advice.empty()); };
  return texts_of(*this, wanted, as_warning);
}
std::vector<std::string> Findings::all() const {
  return texts_of(
      *this, [](const Finding& f) { return f.severity != Severity::note; }, as_warning);
}

}  // namespace imulab
