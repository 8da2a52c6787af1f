// A field that is added to a description is written, read and listed; and the documentation names every field that the descriptions of results have.
#include "imulab/error.hpp"
#include "imulab/formats/text/json_fields.hpp"
#include "imulab/model/calibration_fields.hpp"
#include "imulab/noise/noise_fields.hpp"
#include "imulab/results/result_fields.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/page_tables.hpp"
#include "tests/run_command.hpp"
#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>

namespace imulab {
namespace {

/// The names of all fields, those of tables and lists inside them included.
class FieldNames {
 public:
  static constexpr bool reads = false;
  std::vector<std::string> names;

  template <class Value>
  void operator()(std::string_view key, const Value&, const fields::How& = {}) {
    names.emplace_back(key);
    list<Value>();
  }
  template <class Describe>
  void table(std::string_view key, const Describe& describe_table, const fields::How& = {}) {
    names.emplace_back(key);
    describe_table(*this);
  }
  template <class Value>
  void list() {
    if constexpr (json_io::Described<FieldNames, Value>) {
      Value value{};
      describe(*this, value);
    } else if constexpr (json_io::Keyed<Value>) {
      list<std::decay_t<decltype(std::declval<Value>().begin()->second)>>();
    } else if constexpr (json_io::Optional<Value> || (json_io::List<Value> && !json_io::Matrix<Value>)) {
      list<typename Value::value_type>();
    }
  }
};

void describe_uncertainties(FieldNames& f, const Calibration&) {
  for (const char* name : {"standard_uncertainty", "covariance", "coefficients", "constant"}) f.names.emplace_back(name);
}

struct Turn {
  std::string axis;
  double angle = 0;
  int number = 0;
  std::optional<double> sigma;
  std::vector<double> rests;
};
struct Path {
  std::vector<Turn> turns;
  double length = 0;
};

template <class Fields>
void describe(Fields& f, Turn& turn) {
  f("axis", turn.axis), f("angle_deg", turn.angle, fields::in(0.5)), f("number", turn.number), f("sigma", turn.sigma, fields::if_any);
  f("rests_s", turn.rests, fields::optional);
}
template <class Fields>
void describe(Fields& f, Path& path) {
  f("turns", path.turns), f("length_m", path.length, fields::or_infinity);
  fields::check(f, path.length >= 0, "length_m", "is negative");
}

std::string message_of(const std::string& text) {
  try {
    const JsonValue json = json_io::parse_json(text, "path.json", "a path");
    Path path;
    read_into(json_io::Field(json, "path.json", ""), path);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(DescribedFields, AreWrittenReadAndListed) {
  const Path path{{{"x", 2, 7, {}, {1, NAN}}, {"y", 3, 8, 0.5, {}}}, INFINITY};
  const std::string text = json_text(written(path), JsonLayout::one_line);
  EXPECT_EQ(text,
            "{\"turns\":[{\"axis\":\"x\",\"angle_deg\":4.0,\"number\":7,\"rests_s\":[1.0,null]},"
            "{\"axis\":\"y\",\"angle_deg\":6.0,\"number\":8,\"sigma\":0.5,\"rests_s\":[]}],\"length_m\":null}\n");
  const JsonValue json = json_io::parse_json("{\"turns\": [{\"axis\": \"y\", \"angle_deg\": 6, \"number\": 8, \"sigma\": 0.5}], \"length_m\": null}",
                                             "path.json", "a path");
  Path back;
  read_into(json_io::Field(json, "path.json", ""), back);
  ASSERT_EQ(back.turns.size(), 1u);
  EXPECT_EQ(back.turns[0].angle, 3);
  EXPECT_EQ(back.turns[0].sigma, 0.5);
  EXPECT_TRUE(std::isinf(back.length));
  FieldNames names;
  names.list<Path>();
  EXPECT_THAT(names.names, testing::ElementsAre("turns", "axis", "angle_deg", "number", "sigma", "rests_s", "length_m"));
}

TEST(DescribedFields, ErrorsNameFileAndField) {
  EXPECT_EQ(message_of("{\"turns\": [{\"axis\": 1}], \"length_m\": 1}"), "path.json: turns[0].axis: expected a text, found 1");
  EXPECT_EQ(message_of("{\"turns\": [{\"axis\": \"x\"}], \"length_m\": 1}"), "path.json: turns[0].angle_deg: is missing");
  EXPECT_EQ(message_of("{\"turns\": {}, \"length_m\": 1}"), "path.json: turns: expected a list, found {}");
  EXPECT_EQ(message_of("{\"turns\": [], \"length_m\": -1}"), "path.json: length_m: is negative");
}

/// The names of all fields that values like these have.
template <class... Values>
std::set<std::string> names_of(Values... values) {
  FieldNames names;
  (describe(names, values), ...);
  return {names.names.begin(), names.names.end()};
}

/// The fields of each part of a page that is marked "fields", by its name.
std::map<std::string, std::set<std::string>> described_fields() {
  Calibration recorded;
  recorded.recorded_accel.emplace();
  Tolerance met;
  met.factor = 1;
  std::map<std::string, std::set<std::string>> fields{
      {"calibration", names_of(recorded)},
      {"noise", names_of(NoiseAnalysis(), NoiseFit(), BatchCoefficient(), NoiseBatch())},
      {"comparison", names_of(CoefficientDifference(), NamedComparison(), ComparedCalibration(), RequirementResult())},
      {"agreement", names_of(Agreement())},
      {"comparison of results", names_of(ResultComparison(), ComparedFigure())},
      {"prediction", names_of(PredictionSummary(), PredictedCoefficient(), AddedManoeuvres(), met, PlanSummary())}};
  fields["comparison"].merge(std::set<std::string>{"calibrations", "requirements"});  // beside the comparison
  return fields;
}

/// The keys of an object, those of tables and lists inside it included. Names in place of keys, as of coefficients, have other letters.
void add_keys_of(const nlohmann::json& json, std::set<std::string>& keys) {
  static const std::regex plain("[a-z0-9_]+");
  if (json.is_structured())
    for (const auto& [key, value] : json.items()) {
      if (json.is_object() && std::regex_match(key, plain)) keys.insert(key);
      add_keys_of(value, keys);
    }
}

constexpr const char* flight = R"(format = "imulab.mission/1"
rate_hz = 20
start = { latitude_deg = 45, longitude_deg = 8, height_m = 0, speed_mps = 20 }
errors = { grade = "navigation", vertical = "fixed" }
[[segment]]
kind = "turn"
angle_deg = 90
rate_dps = 2
[[segment]]
kind = "straight"
duration_s = 60
)";

constexpr const char* inputs = R"(set -e
imulab trajectory drive.toml --errors -o drive
imulab procedure six-position -o six.toml --rest 30
imulab simulate six.toml -o six
imulab procedure handheld --poses 12 -o hand.toml
for n in 1 2 3; do
  sed "s/^name = .*/name = 'unit'\nserial = '$n'/" hand.toml > one.toml
  for s in 5 6; do
    imulab simulate one.toml --seed $n -o all/$s/$n
    echo "# $s" >> all/$s/$n/session.toml
    imulab fleet calibrate all/$s/$n --method handheld --station $s --operator $s --measured 202$s-01-01
  done
done
imulab calibrate all/5/1 --method handheld -o c.json
cp fleet.db other.db
cp -r all/5/1 warm
cp -r all/5/1 other
awk -F, -v OFS=, 'NR > 1 { for (i = 2; i <= NF; ++i) $i += 0.01 * (rand() - 0.5) } 1' all/5/1/recording.csv > other/recording.csv
sed -i 's/^accel = .*/&\ngyro_temperature = { columns = ["gz"], unit = "degC" }/' warm/session.toml
cp -r drive doubtful
sed -i 's/,0[.]05/,0.0005/g' doubtful/gnss_1.csv
sed 's/^height_m/longitude_deg = 8\nheight_m/; $a [[aid]]\nkind = "gnss"' six.toml > aided.toml
)";

/// The fields that commands print, by the part of a page that has them.
std::map<std::string, std::set<std::string>> printed_fields() {
  const TemporaryFolder folder;
  std::ofstream(folder / "flight.toml") << flight;
  std::ofstream(folder / "drive.toml") << flight << "[[aid]]\nkind = 'gnss'\noutages_s = [[80, 90]]\n";
  const CommandResult made = run_shell(folder, "imulab() { '" + command_path() + "' \"$@\"; }\n" + inputs);
  EXPECT_EQ(made.exit_code, 0) << made.errors;
  const std::vector<std::pair<const char*, const char*>> commands{
      {"navigation", "navigate none drive"},
      {"navigation", "navigate none six --heading 0"},
      {"aided", "navigate none drive --aided"},
      {"budget", "budget flight.toml --runs 100"},
      {"budget", "budget drive.toml --runs 0"},
      {"inspection", "inspect six/recording.csv"},
      {"fleet", "fleet stats --require 'accel.bias <= 5 mg' --due 'accel.bias <= 5 mg' --store fleet.db"},
      {"simulate", "simulate aided.toml -o again"},
      {"trajectory", "trajectory drive.toml -o driven"},
      {"compensate", "compensate c.json warm -o corrected.csv"},
      {"verify", "verify c.json"},
      {"extrinsics", "extrinsics all/5/1 other"},
      {"export", "export c.json --to all -o files"},
      {"import", "import files/matrix.json -o imported.json"},
      {"report", "report c.json -o c.html"},
      {"live", "live drive/recording.csv --session drive"},
      {"live", "live doubtful/recording.csv --session doubtful --method drive"},
      {"live", "live all/5/1/recording.csv --session all/5/1 --method extrinsics"},
      {"fleet add", "fleet add c.json"},
      {"fleet calibrate", "fleet calibrate drive --method turntable"},
      {"fleet list", "fleet list"},
      {"fleet list", "fleet list --failures"},
      {"fleet show", "fleet show 1"},
      {"fleet check", "fleet check"},
      {"fleet merge", "fleet merge other.db"},
      {"fleet remove", "fleet remove 1"}};
  std::map<std::string, std::set<std::string>> fields;
  for (const auto& [part, command] : commands) {
    const CommandResult result = run_imulab(folder, std::string(command) + " --json");
    EXPECT_FALSE(result.output.empty()) << command << ": " << result.errors;
    std::istringstream objects(result.output);
    for (nlohmann::json object; objects >> std::ws && !objects.eof();) objects >> object, add_keys_of(object, fields[part]);
  }
  return fields;
}

/// Words of all code in a text.
std::set<std::string> words_of_code(const std::string& text) {
  static const std::regex code("`([^`]+)`"), word("[A-Za-z0-9_]+");
  std::set<std::string> words;
  for (std::sregex_iterator span(text.begin(), text.end(), code), end; span != end; ++span) {
    const std::string inside = (*span)[1];
    for (std::sregex_iterator at(inside.begin(), inside.end(), word); at != end; ++at) words.insert(at->str());
  }
  return words;
}

/// The first column of a part has fields alone, and all fields are in the part. Where the first column is headed "verb", this holds of the rest of
/// each row and the fields of its verb.
TEST(DescribedFields, AreThoseOfTheManual) {
  std::map<std::string, std::set<std::string>> all = described_fields(), shown, first;
  all.merge(printed_fields());
  for (const char* file : {"reference/calibration-file.md", "reference/fleet-store.md", "reference/navigate.md", "reference/noise.md",
                           "reference/results.md", "theory/aided.md"}) {
    const std::vector<std::string> page = page_lines(read_text(std::filesystem::path(IMULAB_SOURCE) / "docs" / file));
    for (const MarkedPart& part : marked_parts(page))
      for (std::size_t i = part.begin; part.kind == "fields" && i < part.end; ++i) {
        const std::size_t bar = std::min(page[i].find(" | "), page[i].size());
        const bool is_row = page[i].starts_with("| `") && !page[i - 1].empty(), of_verb = page[part.begin + 1].starts_with("| verb ");
        const std::string name = of_verb && is_row ? page[i].substr(3, bar - 4) : part.name;
        shown[name].merge(words_of_code(page[i].substr(of_verb ? bar : 0)));
        if (is_row) first[name].merge(words_of_code(of_verb ? page[i].substr(bar) : page[i].substr(0, bar)));
      }
  }
  const auto without = [](const std::set<std::string>& from, const std::set<std::string>& those) {
    std::set<std::string> rest;
    std::set_difference(from.begin(), from.end(), those.begin(), those.end(), std::inserter(rest, rest.end()));
    return rest;
  };
  for (const auto& [name, fields] : all) {
    EXPECT_THAT(without(without(fields, shown[name]), shown["all objects"]), testing::IsEmpty()) << name << ": are not in the manual";
    EXPECT_THAT(without(first[name], fields), testing::IsEmpty()) << name << ": are only in the manual";
    EXPECT_FALSE(first[name].empty()) << name;
  }
  first.erase("all objects");
  for (const auto& [name, fields] : first) EXPECT_TRUE(all.contains(name)) << name << ": nothing prints these fields";
}

}  // namespace
}  // namespace imulab
