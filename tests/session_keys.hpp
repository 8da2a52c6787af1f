// The keys of session files, by table, read from the descriptions that the reader itself uses.
#pragma once

#include "imulab/formats/session/fields.hpp"

#include "tests/page_tables.hpp"
#include <map>
#include <set>
#include <string>
#include <vector>

namespace imulab {

/// A visitor of descriptions that collects their keys. Of choices it takes the value number `turn`, so that the keys of each kind are seen.
class SessionKeys {
 public:
  SessionKeys(std::string name, std::map<std::string, std::set<TableKey>>& keys, std::size_t turn)
      : name_(std::move(name)), keys_(keys), turn_(turn) {}

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
  std::map<std::string, std::set<TableKey>>& keys_;
  std::size_t turn_;
};

inline std::map<std::string, std::set<TableKey>> keys_of_session_files() {
  using namespace session_io;
  std::map<std::string, std::set<TableKey>> keys;
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

}  // namespace imulab
