#include "imulab/files.hpp"
#include "imulab/formats/session/fields.hpp"
#include "imulab/formats/session/step_layout.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/format.h>

#include <cmath>

namespace imulab {
namespace {

using namespace session_io;

/// `value` in units of `factor`, as the shortest decimal that gives it back when it is read.
std::string in_unit(double value, double factor) {
  if (value == 0) return "0";  // also of -0, whose sign is lost where it is read
  const double quotient = value / factor;
  for (int digits = 1; digits <= 17; ++digits)
    if (const double d = std::stod(fmt::format("{:.{}g}", quotient, digits)); d * factor == value) return fmt::format("{}", d);
  for (const double d : {std::nextafter(quotient, HUGE_VAL), std::nextafter(quotient, -HUGE_VAL)})
    if (d * factor == value) return fmt::format("{}", d);
  return fmt::format("{}", quotient);
}

std::string toml_string(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      result += fmt::format("\\u{:04X}", static_cast<int>(c));
    } else {
      result += c;
    }
  }
  return with_escapes(result) + '"';
}

std::string column_text(const Column& column) {
  return std::holds_alternative<int>(column) ? fmt::format("{}", std::get<int>(column)) : toml_string(std::get<std::string>(column));
}

std::string axis_text(const BodyAxis& axis) { return fmt::format("\"{}{}\"", axis.sign > 0 ? '+' : '-', "xyz"[axis.index]); }

/// The counterpart of TomlFields: writes what it is given. Tables inside a table become inline ones.
class TomlText {
 public:
  void text(std::string_view key, const std::string& value) { add(key, toml_string(value)); }
  void text(std::string_view key, const std::optional<std::string>& value) {
    if (value) text(key, *value);
  }
  void number(std::string_view key, double value, const Number& kind) { add(key, in_unit(value, kind.factor)); }
  void number(std::string_view key, const std::optional<double>& value, const Number& kind) {
    if (value) number(key, *value, kind);
  }
  template <std::size_t N>
  void numbers(std::string_view key, const std::array<double, N>& values, const Number& kind) {
    list(key, values, [&](double value) { return in_unit(value, kind.factor); });
  }
  void pair(std::string_view key, const std::optional<std::array<double, 2>>& values, const Number& kind) {
    if (values) numbers(key, *values, kind);
  }
  void triple(std::string_view key, const std::optional<std::array<double, 3>>& values, const Number& kind) {
    if (values) numbers(key, *values, kind);
  }
  void pairs(std::string_view key, const std::vector<std::array<double, 2>>& values, const Number& kind) {
    if (values.empty()) return;
    list(key, values, [&](const auto& pair) { return fmt::format("[{}, {}]", in_unit(pair[0], kind.factor), in_unit(pair[1], kind.factor)); });
  }
  void number_or_numbers(std::string_view key, const std::array<double, 3>& values, const Number& kind) {
    if (values[0] != values[1] || values[0] != values[2]) return numbers(key, values, kind);
    if (values[0] != 0) number(key, values[0], kind);
  }
  void spread(std::string_view key, const Spread& value, double factor) {
    const std::string number = in_unit(value.value, factor);
    if (value.value != 0 || value.fixed) add(key, value.fixed ? fmt::format("{{ fixed = {} }}", number) : number);
  }
  template <class Enum>
  void choice(std::string_view key, Enum value, const std::vector<Enum>& values, Presence presence = Presence::required) {
    if (presence == Presence::required || value != values.front()) add(key, toml_string(to_string(value)));  // the first is the default
  }
  void choice(std::string_view key, const std::string& value, const std::vector<std::string_view>&, Presence presence) {
    if (presence == Presence::required || !value.empty()) add(key, toml_string(value));
  }
  void column(std::string_view key, const std::optional<Column>& value) {
    if (value) add(key, column_text(*value));
  }
  void columns(std::string_view key, const std::vector<Column>& values, const std::vector<std::size_t>&) { list(key, values, column_text); }
  void axis(std::string_view key, const std::optional<BodyAxis>& value) {
    if (value) add(key, axis_text(*value));
  }
  void axes(std::string_view key, const std::optional<std::array<BodyAxis, 3>>& value) {
    if (value) list(key, *value, axis_text);
  }
  void clock_zero(std::string_view key, std::int64_t zero_ns, int exponent) {
    std::int64_t one = 1;
    for (int i = 0; i < exponent; ++i) one *= 10;
    std::string value = fmt::format("{}", zero_ns / one);
    if (zero_ns % one != 0) value += fmt::format(".{:0{}}", zero_ns % one, exponent);
    if (zero_ns != 0) add(key, value);
  }
  template <class Body>
  void table(std::string_view key, Presence, const Body& body) {
    TomlText inner;
    body(inner);
    if (!inner.items_.empty()) add(key, inner.inline_table());
  }
  template <class T, class Body>
  void table_of(std::string_view key, std::optional<T>& value, const Body& body) {
    if (!value) return;
    TomlText inner;
    body(inner, *value);
    add(key, inner.inline_table());
  }
  void check(bool, std::string_view, std::string_view) const {}

  std::string lines() const {
    std::string result;
    for (const std::string& item : items_) result += item + "\n";
    return result;
  }
  /// The items as a section of the file.
  std::string section(std::string_view title) const { return fmt::format("\n{}\n{}", title, lines()); }

 private:
  std::string inline_table() const { return fmt::format("{{ {} }}", fmt::join(items_, ", ")); }
  template <class Values, class ToText>
  void list(std::string_view key, const Values& values, const ToText& to_text) {
    std::vector<std::string> texts;
    for (const auto& value : values) texts.push_back(to_text(value));
    add(key, fmt::format("[{}]", fmt::join(texts, ", ")));
  }
  void add(std::string_view key, const std::string& value) { items_.push_back(fmt::format("{} = {}", key, value)); }

  std::vector<std::string> items_;
};

template <class Table, class... Context>
std::string table_text(std::string_view title, Table table, Context... context) {
  TomlText text;
  transfer(text, table, context...);
  return text.section(title);
}

/// Values that a step shares with the one before it in its recording are left out.
StepText step_text(const Step& step, const Step& before, bool several_recordings) {
  StepText text;
  const auto degrees = [](double rad) { return std::stod(in_unit(rad, unit::deg)); };
  text.kind = step.kind;
  if (several_recordings && !step.recording.empty()) text.recording = step.recording;
  text.start_s = step.start;
  text.end_s = step.end;
  if (step.kind == StepKind::hold)
    for (std::size_t a = 0; a < 3; ++a) text.angles_deg[a] = degrees(step.angles[a]);
  text.axis = step.axis;
  text.angle_deg = degrees(step.angle);
  text.rate_dps = degrees(step.rate);
  if (step.acceleration) text.acceleration_dps2 = degrees(*step.acceleration);
  if (step.mount && step.mount != before.mount) text.up = step.mount->up, text.outward = step.mount->outward;
  text.radius_m = step.radius;
  if (step.temperature != before.temperature) text.temperature_degC = step.temperature;
  return text;
}

/// The step by its duration, if that puts it where it is.
std::optional<StepText> in_durations(const StepText& timed, const Step& step, double previous_end, StepLayout& layout) {
  const auto decimal = [](double seconds) { return std::round(seconds * 1e9) / 1e9; };  // 60, not 59.99999999999
  StepText text = timed;
  text.start_s.reset(), text.end_s.reset();
  constexpr double same_time = 1e-6;  // s: sums of decimal durations, far below a sample
  const auto places_it = [&](const StepText& written) {
    StepLayout trial = layout;
    Step placed;
    if (trial.place(written, step.recording, placed)) return false;
    if (std::abs(placed.start - step.start) > same_time || std::abs(placed.end - step.end) > same_time) return false;
    layout = trial;
    return true;
  };
  if (step.kind != StepKind::rotate) text.duration_s = decimal(step.end - step.start);
  if (text.duration_s == 0.0) return std::nullopt;
  if (places_it(text)) return text;
  text.move_s = decimal(step.start - previous_end);
  if (step.kind != StepKind::rotate && *text.move_s >= 0 && places_it(text)) return text;
  return std::nullopt;
}

std::string text_of(const Session& session, bool durations) {
  Session copy = session;  // transfer takes what it can also read
  TomlText description, navigation;
  description.text("format", std::string(session_format));
  transfer(description, copy);
  transfer_navigation(navigation, copy);
  std::string text = description.lines();
  if (session.imu != ImuDeclaration{}) text += table_text("[imu]", session.imu);
  if (session.site != Site{}) text += table_text("[site]", session.site);
  for (const Reference& reference : session.references) text += table_text("[[reference]]", reference);
  const bool several = session.rigs.size() > 1;
  for (const RigDeclaration& rig : session.rigs) text += table_text(several ? "[[rig]]" : "[rig]", rig, several);
  for (const RecordingSource& recording : session.recordings) text += table_text("[[recording]]", recording);
  StepLayout layout;
  std::map<std::string, Step> last;
  for (const Step& step : session.steps) {
    Step& before = last[step.recording];
    StepText written = step_text(step, before, session.recordings.size() != 1);
    if (durations) {
      if (const auto short_form = in_durations(written, step, before.end, layout)) {
        written = *short_form;
      } else {
        Step placed;
        layout.place(written, step.recording, placed);
      }
    }
    const auto [mount, temperature] = std::pair(before.mount, before.temperature);
    before = step;
    if (!step.mount) before.mount = mount;
    if (!step.temperature) before.temperature = temperature;
    text += table_text("[[step]]", written);
  }
  if (session.initial) text += table_text("[initial]", *session.initial);
  if (session.truth_file) text += fmt::format("\n[truth]\nfile = {}\n", toml_string(*session.truth_file));
  if (session.vertical || session.barometer_file) text += navigation.section("[navigation]");
  for (const Aid& aid : session.aids) text += table_text("[[aid]]", aid);
  return text;
}

}  // namespace

std::string session_text(const Session& session) { return text_of(session, false); }
std::string procedure_text(const Session& session) { return text_of(session, true); }
void write_session(const std::filesystem::path& path, const Session& session) { write_whole(path, session_text(session)); }

}  // namespace imulab
