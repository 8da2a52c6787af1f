// Reports in a browser: every chart draws, nothing is requested, no text runs, and the print is a certificate. Chromium without a window; three
// starts.
// ctest: once
#include "imulab/files.hpp"
#include "imulab/formats/text/file.hpp"

#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <cmath>
#include <map>
#include <regex>
#include <vector>

namespace imulab {
namespace {

using ::testing::HasSubstr;

constexpr const char* chromium =
    "chromium --headless=new --no-sandbox --disable-gpu --disable-dev-shm-usage --disable-background-networking --disable-component-update "
    "--no-first-run "
    "--user-data-dir=profile ";

/// In front of a page's own scripts: what goes wrong, told to the page around it. The page's policy is taken out, so that text that could run would
/// run.
const std::string watch = R"(<script>
window.problems = [];
window.addEventListener('error', function (e) { window.problems.push(String(e.message)); }, true);
</script>)";

/// Behind them: charts whose lines have left no color, pictures without size, axes without two ticks that are not zero or without a name, several
/// series without a legend, text that its background hides, the verdict.
const std::string judge = R"(<script>
function light(color) {
  var c = (color.match(/[0-9.]+/g) || [0, 0, 0, 0]).map(Number), alpha = c.length > 3 ? c[3] : 1;
  var part = c.slice(0, 3).map(function (v) { v /= 255; return v <= 0.04045 ? v / 12.92 : Math.pow((v + 0.055) / 1.055, 2.4); });
  return alpha < 0.5 ? null : 0.2126 * part[0] + 0.7152 * part[1] + 0.0722 * part[2];
}
function behind(e) {
  for (; e; e = e.parentElement) { var l = light(getComputedStyle(e).backgroundColor); if (l !== null) return l; }
  return 1;
}
function faint() {
  var out = [], walk = document.createTreeWalker(document.querySelector('main'), NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    var e = walk.currentNode.parentElement, style = getComputedStyle(e);
    if (!walk.currentNode.textContent.trim() || !e.getClientRects().length || e.closest('.legend,.on,script')) continue;
    var a = light(e.closest('svg') ? style.fill : style.color), b = behind(e);
    if (a !== null && (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05) < 4.5) out.push(walk.currentNode.textContent.trim().slice(0, 30));
  }
  return out;
}
function unread() {
  return Array.from(document.querySelectorAll('svg.plot')).filter(function (s) {
    var ticks = function (axis) {
      return Array.from(s.querySelectorAll('.' + axis + 'ticks text')).filter(function (t) { return t.textContent && t.textContent !== '0'; }).length;
    };
    var several = Number(s.getAttribute('data-series')) > 1, named = s.querySelector('.on') || (s.closest('section') || document).querySelector('.key');
    var mixed = ['x', 'y'].some(function (axis) {  // powers of ten beside plain numbers
      var texts = Array.from(s.querySelectorAll('.' + axis + 'ticks text')).map(function (t) { return t.textContent; });
      var raised = texts.filter(function (t) { return /[⁰¹²³⁴⁵⁶⁷⁸⁹]$/.test(t); }).length;
      return raised > 0 && raised < texts.filter(function (t) { return t !== '0'; }).length;
    });
    return mixed || ticks('x') < 2 || ticks('y') < 2 || !s.querySelector('.x') || !s.querySelector('.y') || (several && !named);
  }).map(function (s) { return s.getAttribute('aria-label'); });
}
function broken() {
  var out = [];
  document.querySelectorAll('td,th').forEach(function (cell) {
    if (!cell.getClientRects().length || cell.querySelector('.hash,code')) return;
    var walk = document.createTreeWalker(cell, NodeFilter.SHOW_TEXT);
    while (walk.nextNode()) {
      var node = walk.currentNode, word, words = /(^|[\s\/-])([^\s\/-]{2,40})(?=[\s\/-]|$)/g, range = document.createRange();
      while ((word = words.exec(node.textContent)) !== null) {
        range.setStart(node, word.index + word[1].length), range.setEnd(node, word.index + word[0].length);
        var lines = Array.from(range.getClientRects()).map(function (r) { return Math.round(r.top); });
        if (new Set(lines).size > 1) out.push(word[2]);
      }
    }
  });
  return out;
}
window.addEventListener('load', function () {
  var text = function (id) { var e = document.getElementById(id); return e ? e.textContent : ''; };
  var charts = Array.from(document.querySelectorAll('.chart')), empty = 0;
  charts.forEach(function (chart) {
    var colored = 0;
    chart.querySelectorAll('.live canvas').forEach(function (canvas) {
      if (!canvas.width || !canvas.height) return;
      var d = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
      for (var i = 0; i < d.length; i += 4)
        if (d[i + 3] > 200 && Math.max(d[i], d[i + 1], d[i + 2]) - Math.min(d[i], d[i + 1], d[i + 2]) > 60) ++colored;
    });
    if (colored < 100) ++empty;
  });
  var pictures = Array.from(document.querySelectorAll('svg')).filter(function (s) { return s.getClientRects().length > 0; });
  var flat = pictures.filter(function (s) { var b = s.getBBox(); return !(b.width > 50 && b.height > 20) || s.querySelectorAll('polyline,polygon,rect,circle,path').length == 0; });
  parent.postMessage([document.currentName, 'charts=' + charts.length + ' empty=' + empty + ' pictures=' + pictures.length + ' flat=' + flat.length,
    'requests=' + performance.getEntriesByType('resource').length, 'problems=' + window.problems.join('/'), 'ran=' + (window.ran || 0),
    'wide=' + (document.documentElement.scrollWidth > document.documentElement.clientWidth), 'unread=' + unread().join('/'), 'faint=' + faint().join('/'), 'broken=' + broken().join('/'),
    'verdict=' + text('verdict'), 'because=' + text('because')].join('|'), '*');
});
</script>)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

const std::string dark_scheme = "@media screen and (prefers-color-scheme:dark)";

/// A copy of a name that ends with "dark" has the dark scheme.
std::string watched(const std::string& page, const std::string& name) {
  std::string text =
      std::regex_replace(page, std::regex("<meta http-equiv=\"Content-Security-Policy\"[^>]*>"), "", std::regex_constants::format_first_only);
  if (name.ends_with("dark")) text = replaced(text, dark_scheme, "@media screen");
  text = replaced(text, "<head>", "<head>" + watch + "<script>document.currentName = '" + name + "'</script>");
  return replaced(text, "</body>", judge + "</body>");
}

/// The text of each page's copy, by name.
struct Browsed {
  std::map<std::string, std::string> pages;
  std::vector<std::string> console, requests;
};

/// All pages at once, each as it is and as a watched copy at both widths; beside them a page that does what must be noticed.
Browsed browse(const TemporaryFolder& folder, const std::vector<std::string>& pages) {
  std::string frames = "<iframe src='probe.html'></iframe>";
  folder.write("probe.html", "<script>console.error('the probe speaks')</script><img src='http://imulab-probe.invalid/x.png'>");
  for (const std::string& page : pages) {
    const std::string text = read_text(folder / (page + ".html"));
    frames += "<iframe src='" + page + ".html' width=1280 height=600></iframe>";
    for (const auto& [name, width] : {std::pair{page + "-1280", "1280"}, {page + "-390", "390"}, {page + "-dark", "1280"}}) {
      folder.write(name + ".html", watched(text, name));
      frames += "<iframe src='" + name + ".html' width=" + std::string(width) + " height=600></iframe>";
    }
  }
  folder.write(
      "around.html",
      "<pre id=said></pre><script>addEventListener('message', function (e) { document.getElementById('said').textContent += '\\n' + e.data + "
      "'\\n'; });</script>" +
          frames);
  const CommandResult result = run_shell(folder, std::string(chromium) +
                                                     "--virtual-time-budget=20000 --enable-logging=stderr --v=0 --log-net-log=net.json "
                                                     "--dump-dom \"file://$PWD/around.html\"");
  EXPECT_EQ(result.exit_code, 0) << "chromium is in dependencies.txt";
  Browsed out;
  std::istringstream dom(result.output), errors(result.errors), net(read_text(folder / "net.json"));
  for (std::string line; std::getline(dom, line);)
    if (const auto bar = line.find('|'); bar != std::string::npos) out.pages[line.substr(0, bar)] = line.substr(bar + 1);
  for (std::string line; std::getline(errors, line);)
    if (line.find(":CONSOLE") != std::string::npos) out.console.push_back(line);
  const std::regex asked("\"initiator\":\"([^\"]*)\".*\"url\":\"([^\"]*)\"");
  for (std::string line; std::getline(net, line);)
    if (std::smatch m; std::regex_search(line, m, asked) && m[1] != "not an origin")
      out.requests.push_back(m[2]);  // the browser's own have no origin
  return out;
}

/// Calibrations, and a page of every kind.
void make_results(const TemporaryFolder& folder) {
  folder.write("mission.toml",
               "format = \"imulab.mission/1\"\nrate_hz = 5\n[start]\nlatitude_deg = 47\nlongitude_deg = 8\nheight_m = 400\n"
               "[[segment]]\nkind = \"accelerate\"\nto_mps = 200\nduration_s = 120\n[[segment]]\nkind = \"turn\"\nangle_deg = 60\nrate_dps = 1\n"
               "[errors]\ngrade = \"navigation\"\nvertical = \"fixed\"\n");
  folder.write(
      "still.toml",
      "format = \"imulab.session/1\"\n[imu]\nname = \"still\"\ngrade = \"mems\"\nnoise = \"full\"\n[site]\nlatitude_deg = 47.0\nheight_m = 0.0\n"
      "[rig]\nkind = \"none\"\n[[step]]\nkind = \"hold\"\nduration_s = 120\n");
  folder.write("truth.csv",
               "t,latitude_deg,longitude_deg,height_m,ve,vn,vu,roll_deg,pitch_deg,heading_deg\n0,45,0,0,0,0,0,0,0,0\n1000,45,0,0,0,0,0,0,0,0\n");
  for (const std::string command : {"procedure handheld --poses 24 -o hand.toml",
                                    "simulate hand.toml -o hand",
                                    "calibrate hand --method handheld -o hand.json --report calibration.html",
                                    "inspect hand/recording.csv --report inspection.html",
                                    "procedure six-position -o six.toml",
                                    "simulate six.toml -o six",
                                    "calibrate six --method turntable -o six.json --report turntable.html",
                                    "compare hand.json hand/truth.json --report comparison.html",
                                    "fleet add hand.json six.json",
                                    "fleet stats --report fleet.html",
                                    "predict six.toml --runs 200 --report prediction.html",
                                    "compensate hand.json hand -o out.csv --report compensation.html",
                                    "navigate six.json six --vertical fixed --truth truth.csv --report navigation.html",
                                    "budget mission.toml --runs 20 --report budget.html",
                                    "plan --require 'gyro.matrix.diagonal <= 20 ppm' --axes 2 --report plan.html",
                                    "simulate still.toml -o still",
                                    "noise still --report noise.html -o noise.json",
                                    "report noise.json -o saved_noise.html",
                                    "noise still still --report two_logs.html",
                                    "report six.json --certificate -o certificate.html",
                                    "budget mission.toml --runs 20 --grade navigation,tactical --report grades.html"}) {
    const CommandResult result = run_imulab(folder, command);
    EXPECT_EQ(result.exit_code, 0) << command << "\n" << result.errors;
  }
}

/// A name that runs wherever it is not text, turns what follows, rings, and does not end.
void make_hostile_page(const TemporaryFolder& folder) {
  std::string name = R"(<script>window.ran = 1</script><img src=x onerror=\"window.ran = 1\">&amp; '\" </title></script>\u202e\u0007\u0000\u200f)";
  name.append(10'000, 'x');
  std::string text = read_text(folder / "hand.json");
  text = replaced(text, R"("imu": "handheld")", "\"imu\": \"" + name + "\"");
  text = replaced(text, R"("warnings": [)", "\"warnings\": [\"" + name + "\"");
  text = replaced(text, R"("notes": [)", "\"notes\": [\"" + name + "\", ");
  folder.write("hostile.json", text);
  const CommandResult result = run_imulab(folder, "report hostile.json -o hostile.html");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  const std::string page = read_text(folder / "hostile.html");
  const auto says = [&](const char* part) { return page.find(part) != std::string::npos; };  // a failure would print the page
  EXPECT_FALSE(says("<script>window.ran"));
  EXPECT_TRUE(says("&lt;script&gt;window.ran = 1"));
  EXPECT_TRUE(says("[U+202E][U+0007][U+0000][U+200F]"));
}

/// Calibrations with uncertainties of 60 coefficients, which differ in each; and a comparison in which nothing is tested.
void make_large_and_empty_pages(const TemporaryFolder& folder) {
  Calibration c;
  c.imu = "sixty", c.method = "whole-unit", c.frame = BodyFrame::rig;
  for (TriadModel* triad : {&c.model.accel, &c.model.gyro}) triad->temperature = ThermalReading{.unit = "K", .reference = 300, .range = {280, 320}};
  const auto all = coefficient_indices();
  c.estimated.assign(all.begin(), all.begin() + 60);
  c.covariance = Eigen::VectorXd::Constant(60, 1e-12).asDiagonal();
  c.quality.verdict = Verdict::good;
  folder.write("sixty.json", calibration_text(c));
  for (std::size_t k = 0; k < 60; ++k)
    set_coefficient(c.model, c.estimated[k], coefficient_value(c.model, c.estimated[k]) + 1e-6 * static_cast<double>(k));
  folder.write("other.json", calibration_text(c));
  folder.write("exact.json", calibration_text(Calibration{}));
  for (const char* command :
       {"report sixty.json -o sixty.html", "compare sixty.json other.json --report sixty_compared.html",
        "compare sixty.json other.json hand.json --report several.html", "compare exact.json hand/truth.json --report untested.html"}) {
    const CommandResult result = run_imulab(folder, command);
    EXPECT_EQ(result.exit_code, 0) << command << result.errors;
  }
}

/// A requirement that is missed, values without uncertainties, and stamps of 2026 in nanoseconds.
void make_awkward_pages(const TemporaryFolder& folder) {
  EXPECT_EQ(run_imulab(folder, "calibrate hand --method handheld --require 'gyro.offset <= 0.0001 deg/h' --report missed.html").exit_code, 1);
  EXPECT_EQ(run_imulab(folder, "report hand/truth.json -o none.html").exit_code, 0);
  std::istringstream rows(read_text(folder / "hand/recording.csv"));
  std::string row, stamped;
  for (std::getline(rows, row), stamped = row + "\n"; std::getline(rows, row);) {
    const std::size_t comma = row.find(',');
    stamped += std::to_string(1'794'000'000'123'456'789 + std::llround(1e9 * std::stod(row.substr(0, comma)))) + row.substr(comma) + "\n";
  }
  std::filesystem::create_directory(folder / "stamped");
  folder.write("stamped/recording.csv", stamped);
  folder.write("stamped/session.toml", replaced(read_text(folder / "hand/session.toml"), "unit = \"s\"", "unit = \"ns\""));
  const CommandResult result = run_imulab(folder, "calibrate stamped --method handheld --report stamped.html");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  const std::string page = read_text(folder / "stamped.html");
  EXPECT_TRUE(page.find("from 2026-11-06T21:20:00.") != std::string::npos);
  for (const std::string& text : {page, result.output, result.errors}) {
    EXPECT_TRUE(text.find("1794000") == std::string::npos) << "a stamp where seconds from the first sample are expected";
    EXPECT_TRUE(text.find("1.794e+09") == std::string::npos);
  }
}

TEST(Page, EveryPageDrawsAndAsksNobodyAndNoTextRuns) {
  const TemporaryFolder folder;
  make_results(folder);
  make_hostile_page(folder);
  make_awkward_pages(folder);
  make_large_and_empty_pages(folder);
  const std::vector<std::string> pages{"calibration", "turntable", "comparison", "prediction",    "compensation", "navigation",
                                       "budget",      "plan",      "inspection", "noise",         "fleet",        "hostile",
                                       "missed",      "none",      "stamped",    "saved_noise",   "two_logs",     "grades",
                                       "sixty",       "several",   "untested",   "sixty_compared"};
  const Browsed browsed = browse(folder, pages);
  ASSERT_EQ(browsed.console.size(), 1u) << testing::PrintToString(browsed.console);
  EXPECT_THAT(browsed.console[0], HasSubstr("the probe speaks"));
  EXPECT_THAT(browsed.requests, testing::ElementsAre("http://imulab-probe.invalid/x.png"));
  for (const std::string& page : pages)
    for (const std::string width : {"-1280", "-390", "-dark"}) {
      const std::string said = browsed.pages.contains(page + width) ? browsed.pages.at(page + width) : "nothing";
      EXPECT_THAT(said,
                  testing::MatchesRegex(
                      "charts=[0-9]+ empty=0 pictures=[0-9]+ flat=0\\|requests=0\\|problems=\\|ran=0\\|wide=false\\|unread=\\|faint=\\|broken=\\|.*"))
          << page << width;
    }
  EXPECT_THAT(browsed.pages.at("calibration-1280"), HasSubstr("charts=2 empty=0"));
  const Calibration calibration = read_calibration(folder / "hand.json");
  std::string because;
  for (const std::string& reason : calibration.quality.findings.reasons()) because += reason;
  EXPECT_THAT(browsed.pages.at("calibration-390"),
              testing::EndsWith("|verdict=" + std::string(to_string(calibration.quality.verdict)) + "|because=" + because));
  for (const std::string& page : pages) EXPECT_LT(std::filesystem::file_size(folder / (page + ".html")), 2'000'000u) << page;
}

/// Two A4 pages, and the appendix from the third on; number and page on each.
void expect_certificate(const TemporaryFolder& folder) {
  const CommandResult printed =
      run_shell(folder, std::string(chromium) + "--no-pdf-header-footer --print-to-pdf=certificate.pdf \"file://$PWD/certificate.html\"");
  ASSERT_EQ(printed.exit_code, 0) << printed.errors;
  const std::string info = run_shell(folder, "pdfinfo certificate.pdf").output;
  std::smatch pages;
  ASSERT_TRUE(std::regex_search(info, pages, std::regex("Pages: +([0-9]+)"))) << info;
  EXPECT_THAT(info, HasSubstr("A4"));
  for (int k = 1; k <= std::stoi(pages[1]); ++k) {
    const std::string text =
        run_shell(folder, "pdftotext -layout -f " + std::to_string(k) + " -l " + std::to_string(k) + " certificate.pdf -").output;
    EXPECT_THAT(text, HasSubstr("page " + std::to_string(k) + " of " + pages[1].str()));
    EXPECT_THAT(text, HasSubstr("Calibration certificate 2026-017"));
    EXPECT_THAT(text, HasSubstr("serial number"));
    if (k == 2) EXPECT_THAT(text, HasSubstr("signature, date"));
    if (k == 3) EXPECT_THAT(text, HasSubstr("Appendix"));
  }
}

TEST(Page, APrintedCalibrationIsACertificate) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_shell(folder, "'" + command_path() + "' procedure handheld --poses 24 -o hand.toml && '" + command_path() +
                                  "' simulate hand.toml -o hand && '" + command_path() +
                                  "' calibrate hand --method handheld -o hand.json --report page.html && '" + command_path() +
                                  "' report hand.json --certificate --number 2026-017 -o certificate.html")
                .exit_code,
            0);
  // Chromium prints one page a start.
  expect_certificate(folder);
  const CommandResult printed = run_shell(folder, std::string(chromium) + "--no-pdf-header-footer --print-to-pdf=page.pdf \"file://$PWD/page.html\"");
  ASSERT_EQ(printed.exit_code, 0) << printed.errors;
  const std::string info = run_shell(folder, "pdfinfo page.pdf").output;
  std::smatch pages;
  ASSERT_TRUE(std::regex_search(info, pages, std::regex("Pages: +([0-9]+)"))) << info;
  EXPECT_GE(std::stoi(pages[1]), 6);
  EXPECT_LE(std::stoi(pages[1]), 9) << "a certificate is no book";
  EXPECT_THAT(info, HasSubstr("A4"));
  EXPECT_THAT(run_shell(folder, "pdftotext -l 1 page.pdf -").output, HasSubstr("good"));
  const std::string text = run_shell(folder, "pdftotext -layout page.pdf -").output;
  for (const char* part : {"What to do", "Before and after", "Coefficients", "gyro.g_sensitivity.zz", "Type A and type B", "What this does not cover",
                           "Not traceable", "SHA-256"})
    EXPECT_THAT(text, HasSubstr(part));
  EXPECT_THAT(run_shell(folder, "pdftotext -f " + pages[1].str() + " page.pdf -").output, HasSubstr("imulab")) << "an empty last page";
}

}  // namespace
}  // namespace imulab
