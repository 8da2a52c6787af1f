// imulab report and --report as typed.
#include "imulab/calibration.hpp"
#include "imulab/files.hpp"

#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <algorithm>

namespace imulab {
namespace {

using ::testing::HasSubstr;

/// A handheld session and its calibration, made once.
class Report : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    for (const char* command :
         {"procedure handheld --poses 24 -o hand.toml", "simulate hand.toml -o hand", "calibrate hand --method handheld -o hand.json"})
      ASSERT_EQ(run_imulab(*folder_, command).exit_code, 0) << command;
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  /// The page, and nothing of it in a failure's message.
  static bool says(const std::string& file, const std::string& part) { return text(file).find(part) != std::string::npos; }
  static CommandResult run(const std::string& arguments) { return run_imulab(*folder_, arguments); }
  static std::string text(const std::string& file) { return read_text(*folder_ / file); }

  static TemporaryFolder* folder_;
};
TemporaryFolder* Report::folder_ = nullptr;

TEST_F(Report, ASavedCalibrationHasTheSamePictures) {
  ASSERT_EQ(run("calibrate hand --method handheld --report fresh.html").exit_code, 0);
  const CommandResult saved = run("report hand.json -o saved.html");
  ASSERT_EQ(saved.exit_code, 0) << saved.errors;
  EXPECT_THAT(saved.output, HasSubstr("written: saved.html"));
  for (const char* file : {"fresh.html", "saved.html"})
    for (const char* id : {"before-after", "recording", "residuals", "coverage", "coefficients", "uncertainty", "correlation", "not-covered",
                           "traceability", "origin"})
      EXPECT_TRUE(says(file, "<section id=\"" + std::string(id) + "\">")) << file;
  EXPECT_FALSE(says("saved.html", "Not on this page"));
}

TEST_F(Report, WhatIsMissingIsSaidWithTheReason) {
  ASSERT_EQ(run_shell(*folder_,
                      "mkdir away && cp hand.json away/moved.json && cd away && sed -i 's#\"hand/session.toml\"#\"gone/session.toml\"#' moved.json")
                .exit_code,
            0);
  ASSERT_EQ(run("report away/moved.json -o moved.html").exit_code, 0);
  EXPECT_TRUE(says("moved.html", "gone/session.toml was not found; --session-at names its new place"));
  EXPECT_FALSE(says("moved.html", "<section id=\"recording\">"));
  EXPECT_TRUE(says("moved.html", "<section id=\"coefficients\">"));
  ASSERT_EQ(run("report away/moved.json --session-at hand -o found.html").exit_code, 0);
  EXPECT_TRUE(says("found.html", "<section id=\"recording\">"));
}

TEST_F(Report, AChangedRecordingIsNotShown) {
  ASSERT_EQ(run_shell(*folder_, "cp -r hand changed && echo >> changed/recording.csv").exit_code, 0);
  ASSERT_EQ(run("report hand.json --session-at changed -o changed.html").exit_code, 0);
  EXPECT_TRUE(says("changed.html", "changed/recording.csv is not the file that was calibrated (its SHA-256 differs)"));
  EXPECT_FALSE(says("changed.html", "<section id=\"recording\">"));
}

TEST_F(Report, InputsAndOtherOutputsStay) {
  const std::string calibration = text("hand.json"), recording = text("hand/recording.csv");
  for (const char* command :
       {"report hand.json -o hand.json", "report hand.json -o ./hand.json", "report hand.json -o hand/recording.csv", "report hand.json -o hand",
        "calibrate hand --method handheld --report hand/recording.csv", "calibrate hand --method handheld --report hand/session.toml",
        "calibrate hand --method handheld -o new.json --report new.json", "compare hand.json hand/truth.json --report hand.json",
        "predict hand.toml --method hybrid --report hand.toml", "compensate hand.json hand -o out.csv --report out.csv",
        "compensate hand.json hand -o out.csv --report hand.json", "compare hand.json hand/truth.json --report -"}) {
    const CommandResult result = run(command);
    EXPECT_EQ(result.exit_code, 2) << command;
    EXPECT_THAT(result.errors, testing::AnyOf(HasSubstr("would overwrite"), HasSubstr("expected a file to write"))) << command;
  }
  EXPECT_EQ(text("hand.json"), calibration);
  EXPECT_EQ(text("hand/recording.csv"), recording);
  EXPECT_FALSE(std::filesystem::exists(*folder_ / "new.json"));
}

TEST_F(Report, AWrongFileIsNamed) {
  folder_->write("list.json", "[1, 2]");
  folder_->write("broken.json", "{\"format\": \"imulab.calibration/1\", \"model\": 3}");
  for (const auto& [command, message] :
       {std::pair{"report list.json -o x.html", "imulab: list.json: not a result"},
        {"report broken.json -o x.html", "imulab: broken.json: "},
        {"report nothing.json -o x.html", "imulab: nothing.json: "},
        {"report hand.json -o no/where/x.html", "no/where/x.html"},
        {"report hand/recording.csv -o x.html", "imulab: hand/recording.csv: is not JSON, but perhaps a recording; expected"}}) {
    const CommandResult result = run(command);
    EXPECT_EQ(result.exit_code, 2) << command;
    EXPECT_THAT(result.errors, HasSubstr(message)) << command;
  }
  EXPECT_FALSE(std::filesystem::exists(*folder_ / "x.html"));
}

TEST_F(Report, JsonOfOtherVerbsBecomesTheirPage) {
  ASSERT_EQ(run_shell(*folder_, "PATH=\"" + std::filesystem::path(command_path()).parent_path().string() +
                                    ":$PATH\"; imulab compare hand.json hand/truth.json --json --report a.html > c.json && imulab report c.json -o "
                                    "b.html && cmp a.html b.html")
                .exit_code,
            0);
  ASSERT_EQ(run("procedure six-position -o six.toml").exit_code, 0);
  ASSERT_EQ(
      run_shell(*folder_, "'" + command_path() + "' predict six.toml --runs 0 --json > p.json; '" + command_path() + "' report - -o p.html < p.json")
          .exit_code,
      0);
  EXPECT_TRUE(says("p.html", "<section id=\"shares\">"));
}

/// Each verb's saved JSON gives all that its own page has.
TEST_F(Report, SavedJsonHasTheSameParts) {
  folder_->write("drive.toml", R"(format = "imulab.mission/1"
rate_hz = 20
[start]
latitude_deg = 45
longitude_deg = 8
height_m = 400
speed_mps = 50
[[segment]]
kind = "straight"
duration_s = 120
[errors]
grade = "tactical"
)");
  ASSERT_EQ(run("trajectory drive.toml --errors -o drive").exit_code, 0);
  const auto parts = [](const std::string& file) {
    std::vector<std::string> found;
    const std::string page = text(file);
    for (const char* tag : {"<section id=\"", "<h3>", "<figure>"})
      for (std::size_t at = page.find(tag); at != std::string::npos; at = page.find(tag, at + 1))
        found.push_back(page.substr(at, std::string(tag) == "<section id=\"" ? page.find('>', at) - at : 8));
    return found;
  };
  for (const std::string grade : {"navigation", "tactical"})
    folder_->write(grade + ".json", run("budget drive.toml --runs 20 --json --grade " + grade).output);
  for (const char* verb : {"budget drive.toml --runs 20 --grade navigation,mems", "compare navigation.json tactical.json",
                           "plan --require \"gyro.offset <= 0.05 deg/h\"", "compensate hand.json hand -o compensated.csv",
                           "budget drive.toml --runs 20", "navigate none drive --vertical fixed"}) {
    const CommandResult fresh = run(std::string(verb) + " --json --report own.html");
    ASSERT_EQ(fresh.exit_code, 0) << verb << fresh.errors;
    folder_->write("saved.json", fresh.output);
    const CommandResult saved = run("report saved.json -o saved.html");
    ASSERT_EQ(saved.exit_code, 0) << verb << saved.errors;
    EXPECT_EQ(parts("saved.html"), parts("own.html")) << verb;
    const bool compares = std::string(verb).starts_with("compare") || std::string(verb).find(',') != std::string::npos;
    EXPECT_TRUE(!compares || text("saved.html") == text("own.html")) << verb << ": figures, warnings and curves, too";
    EXPECT_FALSE(parts("saved.html").empty()) << verb;
  }
}

/// What needs the readings is named; all else of the page is there.
TEST_F(Report, SavedNoiseHasAPage) {
  folder_->write("still.toml",
                 "format = \"imulab.session/1\"\n[imu]\nname = \"still\"\ngrade = \"mems\"\n[site]\nlatitude_deg = 47.0\nheight_m = 0.0\n"
                 "[rig]\nkind = \"none\"\n[[step]]\nkind = \"hold\"\nduration_s = 60\n");
  ASSERT_EQ(run("simulate still.toml -o still").exit_code, 0);
  ASSERT_EQ(run("noise still -o noise.json --report fresh_noise.html").exit_code, 0);
  const CommandResult saved = run("report noise.json -o saved_noise.html");
  ASSERT_EQ(saved.exit_code, 0) << saved.errors;
  for (const char* id : {"deviation", "spectrum", "coefficients", "axes"})
    for (const char* file : {"fresh_noise.html", "saved_noise.html"})
      EXPECT_TRUE(says(file, "<section id=\"" + std::string(id) + "\">")) << file << id;
  EXPECT_TRUE(says("saved_noise.html", "noise.json keeps no readings"));
  EXPECT_FALSE(says("fresh_noise.html", "Not on this page"));
  EXPECT_TRUE(says("fresh_noise.html", "<strong id=\"verdict\">gyro u(N) "));
  EXPECT_TRUE(says("fresh_noise.html", "rad/s/√Hz")) << "SI beside the user's unit";
  ASSERT_EQ(run("noise still still -o two.json").exit_code, 0);
  EXPECT_EQ(run("report two.json -o two.html").exit_code, 0);
  EXPECT_TRUE(says("two.html", "<h1>2 logs</h1>"));
}

/// A declared certificate counts where the method uses what it is of.
TEST_F(Report, TraceabilityIsAsDeclared) {
  const auto page_of = [](const std::string& name, const std::string& edit) {
    const std::string session = name + "/session.toml";
    EXPECT_EQ(run_shell(*folder_, "cp -r hand " + name + " && cat >> " + session + R"( <<END

[[reference]]
quantity = "acceleration"
instrument = "gravimeter <7>"
certificate = "G 17"
date = "2026-02-11"
statement = "U = 2e-7 m/s2"
[[reference]]
quantity = "rotation"
instrument = "table 3"
certificate = "T 5"
END
sed -i -e '1a warm_up = "45 min"' -e 's/^\[imu\]/[imu]\nfirmware = "2.1"/' )" +
                                      edit + " " + session)
                  .exit_code,
              0);
    const CommandResult made = run("calibrate " + name + " --method handheld -o " + name + ".json");
    EXPECT_EQ(made.exit_code, 0) << made.errors;
    EXPECT_EQ(run("report " + name + ".json -o " + name + ".html").exit_code, 0);
    return text(name + ".html");
  };
  EXPECT_TRUE((run("report hand.json -o plain.html"), says("plain.html", "Not traceable: none of the references below has a certificate")));
  page_of("computed", "");
  EXPECT_TRUE(says("computed.html", "G 17 of 2026-02-11: U = 2e-7 m/s2 (not used: gravity was not declared but computed)"));
  EXPECT_TRUE(says("computed.html", "T 5 (not used: the method takes no angle from an instrument)"));
  EXPECT_TRUE(says("computed.html", "Not traceable: no declared certificate is of what this calibration uses"));
  page_of("declared", "-e '/^\\[site\\]/a gravity_mps2 = 9.8062'");
  EXPECT_TRUE(says("declared.html",
                   "Traceable as the session declares it, by certificates that imulab does not check: acceleration. Not traceable: angle "
                   "and rate, time."));
  page_of("early", "-e '/^\\[site\\]/a gravity_mps2 = 9.8062' -e '1a measured = \"2026-02-10\"'");
  EXPECT_TRUE(says("early.html", "not used: dated after the measurement of 2026-02-10, for which it says nothing"));
  EXPECT_TRUE(says("early.html", "Not traceable: no declared certificate is of what this calibration uses"));
  ASSERT_EQ(run("report early.json --certificate -o early_certificate.html").exit_code, 0);
  EXPECT_TRUE(says("early_certificate.html", "<strong>not traceable</strong>: gravimeter &lt;7&gt;, certificate G 17 of 2026-02-11"));
  EXPECT_TRUE(says("declared.html", "gravimeter &lt;7&gt;"));
  EXPECT_TRUE(says("declared.html", "45 min"));
  EXPECT_TRUE(says("declared.html", "2.1"));
}

TEST_F(Report, ACertificateSaysWhatNobodyDeclared) {
  ASSERT_EQ(run("report hand.json --certificate -o bare.html").exit_code, 0);
  for (const char* part : {"This is not an accredited certificate.", "<strong>not traceable</strong>: no reference is declared", "95.45 %",
                           "No requirement was given: no statement of conformity is made.", "class=\"fill", "may be reproduced only in full",
                           "serial number not declared", "counter(pages)", "It is no statement that the laboratory or this certificate conforms"})
    EXPECT_TRUE(says("bare.html", part)) << part;
  EXPECT_FALSE(says("bare.html", "<script"));
  EXPECT_FALSE(says("bare.html", "±"));
}

TEST_F(Report, ACertificateStatesWhatWasMeasured) {
  folder_->write("warm.toml", "format = \"imulab.laboratory/1\"\n[conditions]\ntemperature = \"(23.0 +/- 0.5) degC\"\n");
  ASSERT_EQ(run_shell(*folder_, "cut -d, -f2- hand/recording.csv > UNNAMED.csv").exit_code, 0);
  ASSERT_EQ(run("calibrate UNNAMED.csv --method handheld --rate 100 --set latitude_deg=45 -o log.json").exit_code, 0);
  const CommandResult bare = run("report log.json --certificate --laboratory warm.toml -o log.html");
  ASSERT_EQ(bare.exit_code, 0) << bare.errors;
  EXPECT_THAT(bare.errors, HasSubstr("the certificate has no number"));
  EXPECT_EQ(run("report log.json --certificate --number 1 -o numbered.html").errors, "");
  EXPECT_EQ(run("report log.json --certificate --number " + std::string(37, '7') + " -o long.html").errors, "");
  EXPECT_TRUE(says("long.html", "content:\"Calibration certificate " + std::string(36, '7') + "… (61 characters)\""))
      << "the head of a page has room for 60";
  for (const char* part : {"ambient as declared (23.0 +/- 0.5) degC", "as its nominal rate says", "<th>time base</th><td>0</td><td>40000</td>",
                           "<tr><th>item</th><td><span class=\"fill\">"})
    EXPECT_TRUE(says("log.html", part)) << part;
  const Calibration c = read_calibration(*folder_ / "log.json");
  ASSERT_FALSE(c.quality.considered.empty());
  const std::string page = text("log.html"), appendix = page.substr(page.find("<h2>Appendix"), page.find("<h2>Model") - page.find("<h2>Appendix"));
  for (const CoefficientIndex index : c.estimated) {
    const std::string name(coefficient(index).name);
    const bool prior = std::find(c.quality.considered.begin(), c.quality.considered.end(), name) != c.quality.considered.end();
    EXPECT_EQ(appendix.find("<code>" + name + "</code>") == std::string::npos, prior) << name;
  }
  for (const char* part : {"as its nominal rate says", "not known here", "TOML"})
    EXPECT_EQ(says("numbered.html", part), part[0] == 'a' || part[0] == 'n');
  ASSERT_EQ(run("report hand.json --certificate --number 2 -o stamped.html").exit_code, 0);
  EXPECT_TRUE(says("stamped.html", "as its stamps say"));
  EXPECT_TRUE(says("stamped.html", "<th>time base</th><td>0</td><td>100</td>"));
}

TEST_F(Report, ACertificateHasTheLaboratorysStatements) {
  folder_->write("lab.toml",
                 "format = \"imulab.laboratory/1\"\nname = \"Lab </style><script>1\"\nissued = \"2026-03-31\"\n[customer]\nname = \"Nordic\"\n"
                 "[signatory]\nname = \"M. Keller\"\n");
  ASSERT_EQ(run("report hand.json --certificate --number '7\"}</style><script>2' --laboratory lab.toml -o lab.html").exit_code, 0);
  for (const char* part : {"Lab &lt;/style&gt;&lt;script&gt;1", "Nordic", "M. Keller", "2026-03-31", "7\\22 }\\3c /style\\3e "})
    EXPECT_TRUE(says("lab.html", part)) << part;
  EXPECT_FALSE(says("lab.html", "<script"));
  folder_->write("typo.toml", "format = \"imulab.laboratory/1\"\nadress = \"x\"\n");
  const CommandResult typo = run("report hand.json --certificate --laboratory typo.toml -o typo.html");
  EXPECT_EQ(typo.exit_code, 2);
  EXPECT_THAT(typo.errors, HasSubstr("typo.toml:2: adress: is not a known key; did you mean address?"));
  EXPECT_EQ(run("report hand.json --number 7 -o x.html").exit_code, 2);
  EXPECT_EQ(run("report hand/truth.json --certificate -o x.html").exit_code, 1);
}

TEST_F(Report, ACertificateOfADoubtfulCalibrationMakesNoStatementOfConformity) {
  ASSERT_EQ(run_shell(*folder_,
                      "'" + command_path() +
                          "' calibrate hand --method handheld --require 'accel.offset <= 5 mg' -o met.json >/dev/null && "
                          "sed 's/\"verdict\": \"good\"/\"verdict\": \"doubtful\"/; s/\"because\": \\[\\]/\"because\": [\"a reason of its own\"]/' "
                          "met.json > unsure.json")
                .exit_code,
            0);
  ASSERT_EQ(run("report met.json --certificate -o met.html").exit_code, 0);
  EXPECT_TRUE(says("met.html", "<strong>met</strong>"));
  ASSERT_EQ(run("report unsure.json --certificate -o unsure.html").exit_code, 0);
  EXPECT_TRUE(says("unsure.html", "This calibration is doubtful"));
  EXPECT_TRUE(says("unsure.html", "a reason of its own"));
  EXPECT_TRUE(says("unsure.html", "<td>no statement</td>"));
  EXPECT_FALSE(says("unsure.html", "<strong>met</strong>"));
}

TEST_F(Report, ADoubtfulVerdictGivesItsReasons) {
  ASSERT_EQ(run_shell(*folder_,
                      "sed 's/\"verdict\": \"good\"/\"verdict\": \"doubtful\"/; s/\"because\": \\[\\]/\"because\": [\"a reason of its own\"]/' "
                      "hand.json > doubt.json")
                .exit_code,
            0);
  ASSERT_EQ(run("report doubt.json -o doubt.html").exit_code, 0);
  EXPECT_TRUE(says("doubt.html", "<strong id=\"verdict\">doubtful</strong>"));
  EXPECT_TRUE(says("doubt.html", "<ul id=\"because\"><li>a reason of its own</li></ul>"));
  EXPECT_TRUE(says("doubt.html", "Resolve each reason above"));
}

TEST_F(Report, RestsOutsideTheRecordingAreLeftOut) {
  ASSERT_EQ(
      run_shell(*folder_, "sed 's/\"end_s\": [0-9.]*/\"end_s\": 1e300/; s/\"begin_s\": [0-9.]*/\"begin_s\": -1e300/' hand.json > far.json").exit_code,
      0);
  const CommandResult result = run("report far.json -o far.html");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_TRUE(says("far.html", "no pictures of gravity at rest: none were found"));
}

TEST_F(Report, ATruthHasNoVerdict) {
  ASSERT_EQ(run("report hand/truth.json -o truth.html").exit_code, 0);
  EXPECT_TRUE(says("truth.html", "Values without uncertainties: there is nothing to judge"));
  EXPECT_TRUE(says("truth.html", "<code>gyro.matrix.xy</code>"));
  EXPECT_TRUE(says("truth.html", "the file names no recordings with their hashes"));
}

}  // namespace
}  // namespace imulab
