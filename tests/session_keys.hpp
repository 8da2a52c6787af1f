// The keys of session files, by table, read from the descriptions that the reader itself uses; those of missions, laboratories and data sheets,
// which its messages list; and the columns of fleet stores.
#pragma once

#include "imulab/error.hpp"
#include "imulab/fleet/store/database.hpp"
#include "imulab/formats/laboratory/file.hpp"
#include "imulab/formats/noise/data_sheet.hpp"
#include "imulab/formats/session/fields.hpp"
#include "imulab/formats/session/mission.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/page_tables.hpp"
#include "tests/temporary_folder.hpp"
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace imulab {

/// A visitor of descriptions that collects their keys. Of choices it takes the value number `turn`, so that the keys of each kind are seen.
class SessionKeys {
 public:
  SessionKeys(std::string name, TableKeys& keys, std::size_t turn) : name_(std::move(name)), keys_(keys), turn_(turn) {}

  template <class Value>
  void text(std::string_view key, const Value&) {
    add(key, std::is_same_v<Value, std::string>);
  }
  void number(std::string_view key, double, const fields::Number& kind) { add(key, kind.presence == fields::Presence::required); }
  void number(std::string_view key, const std::optional<double>&, const fields::Number&) { add(key, false); }
  template <class Values>
  void numbers(std::string_view key, const Values&, const fields::Number& kind) {
    add(key, kind.presence == fields::Presence::required);
  }
  template <class Values>
  void number_or_numbers(std::string_view key, const Values&, const fields::Number& kind) {
    add(key, kind.presence == fields::Presence::required);
  }
  template <class Values>
  void pair(std::string_view key, const Values&, const fields::Number&) {
    add(key, false);
  }
  template <class Values>
  void triple(std::string_view key, const Values&, const fields::Number&) {
    add(key, false);
  }
  template <class Values>
  void pairs(std::string_view key, const Values&, const fields::Number&) {
    add(key, false);
  }
  void spread(std::string_view key, const Spread&, double) { add(key, false); }
  template <class Value>
  void choice(std::string_view key, Value& value, const std::vector<Value>& values, fields::Presence presence = fields::Presence::required) {
    add(key, presence == fields::Presence::required);
    value = values[turn_ % values.size()];
  }
  void choice(std::string_view key, std::string& value, const std::vector<std::string_view>& values, fields::Presence presence) {
    add(key, presence == fields::Presence::required);
    value = values[turn_ % values.size()];
  }
  void column(std::string_view key, std::optional<Column>& value) {
    add(key, false);
    value = Column(1);
  }
  void columns(std::string_view key, const std::vector<Column>&, const std::vector<std::size_t>&) { add(key, true); }
  template <class Value>
  void axis(std::string_view key, const Value&) {
    add(key, false);
  }
  template <class Value>
  void axes(std::string_view key, const Value&) {
    add(key, false);
  }
  void clock_zero(std::string_view key, std::int64_t, int) { add(key, false); }
  template <class Body>
  void table(std::string_view key, fields::Presence presence, const Body& body) {
    add(key, presence == fields::Presence::required);
    SessionKeys inner(std::regex_replace(std::string(key), std::regex("^accel"), "gyro"), keys_, turn_);  // both triads have the same keys
    body(inner);
  }
  template <class T, class Body>
  void table_of(std::string_view key, std::optional<T>&, const Body& body) {
    T value{};
    table(key, fields::Presence::optional, [&](SessionKeys& inner) { body(inner, value); });
  }
  void check(bool, std::string_view, const std::string&) {}

 private:
  void add(std::string_view key, bool required) { keys_[name_].insert({std::string(key), required}); }

  std::string name_;
  TableKeys& keys_;
  std::size_t turn_;
};

inline TableKeys keys_of_session_files() {
  using namespace session_io;
  TableKeys keys;
  for (std::size_t turn = 0; turn < 8; ++turn) {  // no choice has more values that matter
    const auto visit = [&](const char* name, auto value, auto... context) {
      SessionKeys f(name, keys, turn);
      transfer(f, value, context...);
    };
    visit("(root)", Session{});
    visit("[imu]", ImuDeclaration{}), visit("[site]", Site{}), visit("[[reference]]", Reference{}), visit("[rig]", RigDeclaration{}, false);
    visit("[[recording]]", RecordingSource{}), visit("[[step]]", StepText{}), visit("[initial]", InitialState{}), visit("[[aid]]", Aid{});
    Session session;
    SessionKeys navigation("[navigation]", keys, turn);
    transfer_navigation(navigation, session);
  }
  keys["(root)"].insert({"format", true});
  for (const Effect& effect : effects()) keys["[imu]"].erase({std::string(effect.declared()), false});  // which have a table of their own
  for (const char* shown : {"effects", "orthogonality_arcsec", "zero_arcsec"}) keys.erase(shown);  // in a table of effects, and in their own rows
  return keys;
}

/// A table of a text, with all its required keys and without others.
struct TextOfTable {
  std::string name, before;
  std::vector<std::string> required;
  std::string after;

  std::string with(const std::vector<std::string>& lines) const { return fmt::format("{}{}\n{}", before, fmt::join(lines, "\n"), after); }
};

/// `message_of` gives the message about a text; where it has an unknown key, it lists the keys of the table.
template <class MessageOf>
void add_keys_read(const TextOfTable& table, const MessageOf& message_of, TableKeys& keys) {
  EXPECT_THAT(message_of(table.with(table.required)), testing::Not(testing::HasSubstr("is missing"))) << table.name;
  std::vector<std::string> lines = table.required;
  lines.emplace_back("zzzzzzzz = 0");
  const std::string message = message_of(table.with(lines)), begin = "is not a known key; expected one of ";
  ASSERT_NE(message.find(begin), std::string::npos) << table.name << ": " << message;
  std::istringstream names(message.substr(message.find(begin) + begin.size()));
  for (std::string name; std::getline(names >> std::ws, name, ',');) {
    std::erase_if(lines = table.required, [&](const std::string& line) { return line.starts_with(name + " "); });
    const bool required = lines.size() < table.required.size() && message_of(table.with(lines)).find(name + ": is missing") != std::string::npos;
    keys[table.name].insert({name, required});
  }
}

template <class Parse>
auto messages_of_reader(const Parse& parse) {
  return [=](const std::string& text) -> std::string {
    try {
      parse(text);
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
}

inline TableKeys keys_of_missions() {
  const TemporaryFolder folder;
  std::ofstream(folder / "t.csv")
      << "t,latitude_deg,longitude_deg,height_m,ve,vn,vu,roll_deg,pitch_deg,heading_deg\n0,0,0,0,0,0,0,0,0,0\n1,0,0,0,0,0,0,0,0,0\n";
  const auto message = messages_of_reader([&](const std::string& text) { parse_mission(text, folder / "m.toml"); });
  const std::string root = "format = 'imulab.mission/1'\n", start = "[start]\nlatitude_deg = 0\nlongitude_deg = 0\nheight_m = 0\n",
                    moves = start + "speed_mps = 9\n[[segment]]\nkind = 'straight'\nduration_s = 1\n", point = "[[temperature]]\n",
                    points = point + "time_s = 0\ndegC = 0\n";
  TableKeys keys;
  const auto add = [&](const std::string& name, const std::string& before, const std::vector<std::string>& required, const std::string& after = "") {
    add_keys_read({"mission " + name, before, required, after}, message, keys);
  };
  add("(root)", "", {"format = 'imulab.mission/1'"}, moves + points);
  add("[imu]", root + moves + "[imu]\n", {"name = 'a'"});
  add("[start]", root + "[start]\n", {"latitude_deg = 0", "longitude_deg = 0", "height_m = 0"}, "[[segment]]\nkind = 'rest'\nduration_s = 1\n");
  add("[track]", root + "[track]\n", {"file = 't.csv'"});
  add("[[temperature]]", root + moves + point, {"time_s = 0", "degC = 0"});
  for (const std::string name : {"[gyro_temperature]", "[accel_temperature]"}) add(name, root + moves + points + name + "\n", {});
  const std::vector<std::pair<std::string, std::vector<std::string>>> segments{{"rest", {"duration_s = 1"}},
                                                                               {"straight", {"duration_s = 1"}},
                                                                               {"accelerate", {"to_mps = 20", "duration_s = 1"}},
                                                                               {"brake", {"duration_s = 9"}},
                                                                               {"turn", {"angle_deg = 90", "radius_m = 99"}},
                                                                               {"s_turn", {"angle_deg = 90", "radius_m = 99"}},
                                                                               {"climb", {"angle_deg = 1", "duration_s = 9"}},
                                                                               {"dive", {"angle_deg = 1", "duration_s = 9"}},
                                                                               {"pitch", {"angle_deg = 1", "rate_dps = 1"}},
                                                                               {"rotate", {"axis = 'x'", "angle_deg = 1", "rate_dps = 1"}},
                                                                               {"repeat", {"last = 1", "times = 2"}}};
  for (const auto& [kind, required] : segments) {
    const std::string segment = "mission " + kind, begin = root + (kind == "rest" ? start : moves) + "[[segment]]\n";
    add(kind, begin + "kind = '" + kind + "'\n", required);
    for (const TableKey& common : {TableKey{"kind", false}, TableKey{"at_s", false}})
      if (keys[segment].erase(common) > 0) keys["mission [[segment]]"].insert(common);  // which have a row of their own
  }
  EXPECT_THAT(message(root + moves + "[[segment]]\n"), testing::HasSubstr("kind: is missing"));
  keys["mission [[segment]]"].erase({"kind", false}), keys["mission [[segment]]"].insert({"kind", true});
  add("[errors]", root + moves + "[errors]\n", {});
  for (const char* inner : {"gyro", "accel", "start", "barometer"})
    add(fmt::format("[errors.{}]", inner), fmt::format("{}{}[errors.{}]\n", root, moves, inner), {});
  return keys;
}

inline TableKeys keys_of_laboratories() {
  const auto message = messages_of_reader([](const std::string& text) { parse_laboratory(text, "l.toml"); });
  const std::string root = "format = 'imulab.laboratory/1'\n";
  TableKeys keys;
  add_keys_read({"laboratory (root)", "", {"format = 'imulab.laboratory/1'"}, ""}, message, keys);
  std::set<TableKey> texts;
  for (const TableKey& key : keys["laboratory (root)"]) {
    const std::string name = "[" + key.name + "]";
    if (message(root + name + "\n").empty())
      add_keys_read({"laboratory " + name, root + name + "\n", {}, ""}, message, keys);
    else
      texts.insert(key);
  }
  keys["laboratory (root)"] = texts;
  return keys;
}

inline TableKeys keys_of_data_sheets() {
  const auto message = messages_of_reader([](const std::string& text) { parse_data_sheet_file(text, "s.toml"); });
  TableKeys keys;
  add_keys_read({"data sheet [noise]", "[noise]\n", {}, ""}, message, keys);
  for (const std::string triad : {"gyro", "accel"}) {
    keys["data sheet [noise]"].erase({triad, false});  // which have rows of their own
    add_keys_read({"data sheet " + triad, "[noise." + triad + "]\n", {}, ""}, message, keys);
  }
  return keys;
}

inline TableKeys columns_of_stores() {
  const TemporaryFolder folder;
  fleet::Database store(folder / "fleet.db", fleet::Access::write);
  fleet::expect_schema(store, fleet::Access::write);
  TableKeys keys;
  for (const char* table : fleet::store_tables)
    for (fleet::Statement columns(store, fmt::format("SELECT name FROM pragma_table_info('{}')", table)); columns.next();)
      keys[fmt::format("store {}", table)].insert({columns.text(0), false});
  return keys;
}

}  // namespace imulab
