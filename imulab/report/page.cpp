#include "imulab/report/page.hpp"

#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/recording/origin.hpp"
#include "imulab/report/assets.hpp"
#include "imulab/report/html.hpp"
#include "imulab/results/calibration.hpp"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <cstdint>
#include <map>
#include <utility>

namespace imulab::report {

namespace {

/// SHA-256 in base 64, as a content security policy names a script.
std::string script_hash(std::string_view script) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const std::string hex = sha256(script);
  std::string out;
  for (std::size_t i = 0; i < hex.size(); i += 6) {
    std::string group = hex.substr(i, 6);
    const std::size_t missing = (6 - group.size()) / 2;
    group.resize(6, '0');
    const auto bits = static_cast<std::uint32_t>(std::stoul(group, nullptr, 16));
    for (std::size_t k = 0; k < 4; ++k) out += k < 4 - missing ? digits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

std::string head(const Page& page) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; img-src data:; "
      "script-src 'sha256-{}' 'sha256-{}'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><meta name=\"color-scheme\" content=\"light dark\">\n<title>{}: "
      "{}</title>\n<style>{}\n{}</style></head>\n",
      script_hash(assets::dygraph_js), script_hash(assets::page_js), escaped(page.kind), escaped(shortened(page.title, 60)), assets::dygraph_css,
      assets::page_css);
}

std::string banner(const PageVerdict& v) {
  constexpr std::array classes{"good", "doubtful", "neutral"};
  constexpr std::array signs{"✓", "!", "i"};
  const auto tone = static_cast<std::size_t>(v.tone);
  std::string out =
      fmt::format("<div class=\"verdict {}\"><span class=\"sign\" aria-hidden=\"true\">{}</span><div><strong id=\"verdict\">{}</strong>",
                  classes[tone], signs[tone], escaped(v.word));
  if (!v.meaning.empty()) out += fmt::format("<p class=\"meaning\">{}</p>", escaped(v.meaning));
  out += list(v.because, "because");
  if (!v.actions.empty()) out += "<p class=\"todo\">What to do</p>" + list(v.actions, "actions");
  return out + "</div></div>\n";
}

std::string figures(const std::vector<KeyFigure>& all) {
  if (all.empty()) return {};
  std::string out = "<dl class=\"figures\">";
  for (const KeyFigure& f : all) out += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>", escaped(f.name), escaped(f.value));
  return out + "</dl>\n";
}

/// What a reader can go to. `body` is a page's own HTML: repeated identifiers get a number.
std::vector<std::pair<std::string, std::string>> numbered_sections(std::string& body) {
  constexpr std::string_view begin = "<section id=\"", heading = "<h2>";
  std::vector<std::pair<std::string, std::string>> out;
  std::map<std::string, int> times;
  for (std::size_t at = 0; (at = body.find(begin, at)) != std::string::npos;) {
    at += begin.size();
    const std::size_t end = body.find('"', at);
    std::string id = body.substr(at, end - at);
    if (const int n = ++times[id]; n > 1) body.insert(end, fmt::format("-{}", n)), id += fmt::format("-{}", n);
    const std::size_t from = body.find(heading, end) + heading.size();
    out.emplace_back(id, body.substr(from, body.find("</h2>", from) - from));
  }
  return out;
}

/// Of a page with many sections.
std::string contents(const std::vector<std::pair<std::string, std::string>>& sections) {
  constexpr std::size_t many = 5;
  if (sections.size() < many) return {};
  std::string out = "<nav class=\"contents\" aria-label=\"On this page\">";
  for (const auto& [id, heading] : sections) out += fmt::format("<a href=\"#{}\">{}</a> ", id, heading);
  return out + "</nav>\n";
}

}  // namespace

void take_conclusion(PageVerdict& v, const Conclusion& c) {
  if (c.verdict == Verdict::none) return;
  v.word = to_string(c.verdict);
  v.tone = is_favorable(c.verdict) ? Tone::good : Tone::doubtful;
  std::vector<std::string> because;
  for (const RequirementResult& r : c.requirements) because.push_back((r.met ? "met: " : "not met: ") + requirement_text(r));
  if (because.size() == 1) because.clear();  // the headline says it
  v.because.insert(v.because.begin(), because.begin(), because.end());
  if (c.headline.empty()) return;
  v.meaning = c.headline;
  if (v.meaning.back() != '.') v.meaning += '.';
  const bool is_name = v.meaning.substr(0, v.meaning.find(' ')).find('.') != std::string::npos;  // of a coefficient
  if (!is_name) v.meaning[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(v.meaning[0])));
}

std::string page_text(const Page& page) {
  std::string out = head(page), body = page.body;
  const auto sections = numbered_sections(body);
  out += fmt::format("<body><header><p class=\"kind\">{}</p><h1>{}</h1><p class=\"subtitle\">{}</p>{}</header>\n<main>\n", escaped(page.kind),
                     escaped(shortened(page.title, 120)), escaped(page.subtitle), contents(sections));
  out += banner(page.verdict) + figures(page.figures) + body;
  out += fmt::format("</main>\n<footer>{}. This page contains all it shows; it loads nothing.</footer>\n", escaped(software()));
  return out + fmt::format("<script>{}</script>\n<script>{}</script>\n</body></html>\n", assets::dygraph_js, assets::page_js);
}

std::vector<KeyFigure> key_figures(const std::function<double(CoefficientIndex)>& sigma) {
  std::vector<KeyFigure> out;
  for (const auto& [triad, name] : {std::pair{"accel", "accelerometer"}, {"gyro", "gyro"}}) {
    const std::array<std::array<std::string_view, 2>, 3> kinds{
        {{"matrix.diagonal", "scale"}, {"matrix.off_diagonal", name_of_off_diagonal(triad, sigma)}, {"offset", "bias"}}};
    for (const auto& [term, kind] : kinds)
      if (const std::string worst = worst_text(fmt::format("{}.{}", triad, term), sigma); !worst.empty())
        out.push_back({"u = " + readable_unit(worst), fmt::format("{} {}", name, kind)});
  }
  return out;
}

std::string worst_axis_note(const std::vector<KeyFigure>& figures) {
  return figures.empty() ? "" : "<p class=\"note\">Standard uncertainty of the worst axis of each kind.</p>\n";
}

}  // namespace imulab::report
