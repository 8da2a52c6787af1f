// Parameter files of autopilots, read by the rules of the programs that load them.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

namespace imulab::export_test {

using Parameters = std::map<std::string, float>;

inline std::vector<std::string> split(const std::string& text, const char* separators, bool empty_ones) {
  std::vector<std::string> out;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find_first_of(separators, begin), text.size());
    if (empty_ones || end > begin) out.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return out;
}

inline float number(const std::string& text) {
  std::size_t used = 0;
  const float value = std::stof(text, &used);
  EXPECT_EQ(used, text.size()) << text;
  return value;
}

/// mavlink/qgroundcontrol, ParameterManager::readParametersFromStream: lines without # at their start, five fields between tabs; the first is the
/// vehicle, the last the type of MAVLink, which has to be the parameter's (6: int32, 9: float). PX4's names have at most 16 characters.
inline Parameters qgroundcontrol_loads(const std::string& text) {
  Parameters out;
  for (const std::string& line : split(text, "\n", false)) {
    if (line.starts_with('#')) continue;
    const std::vector<std::string> fields = split(line, "\t", true);
    EXPECT_EQ(fields.size(), 5u) << line;
    if (fields.size() != 5) continue;
    EXPECT_EQ(fields[0] + fields[1], "11") << "vehicle 1, its autopilot";
    const std::string& name = fields[2];
    EXPECT_LE(name.size(), 16u) << name;
    EXPECT_EQ(fields[4], name.ends_with("_ENABLE") ? "6" : "9") << name;
    EXPECT_TRUE(out.try_emplace(name, number(fields[3])).second) << name;
  }
  return out;
}

/// ArduPilot/pymavlink, mavparm.py, MAVParmDict.load (MAVProxy, `param load`): stripped lines without # at their start, commas as blanks, two words.
inline Parameters mavparm_loads(const std::string& text) {
  Parameters out;
  for (const std::string& line : split(text, "\n", false)) {
    const std::vector<std::string> words = split(line, ", \t\r", false);
    if (words.empty() || words[0].starts_with('#')) continue;
    EXPECT_EQ(words.size(), 2u) << "invalid line: " << line;
    if (words.size() != 2) continue;
    EXPECT_TRUE(out.try_emplace(words[0], number(words[1])).second) << words[0];
  }
  return out;
}

/// ArduPilot/ardupilot, AP_Param::read_param_defaults_file and parse_param_line: pieces of 98 characters, of which one with # at its start is none;
/// name and value between any of ", =", tab and line ends; names of at most 16 characters; the value as far as strtof understands it.
inline Parameters ap_param_loads(const std::string& text) {
  constexpr std::size_t piece = 98, longest_name = 16;
  Parameters out;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t newline = text.find('\n', begin), end = std::min({newline == std::string::npos ? text.size() : newline + 1, begin + piece});
    const std::string line = text.substr(begin, end - begin);
    begin = end;
    if (line.starts_with('#')) continue;
    const std::vector<std::string> words = split(line, ", =\t\r\n", false);
    if (words.size() < 2 || words[0].size() > longest_name) continue;
    out[words[0]] = std::strtof(words[1].c_str(), nullptr);
  }
  return out;
}

inline Parameters parameters_of(const std::string& text, bool px4) {
  if (px4) return qgroundcontrol_loads(text);
  const Parameters out = mavparm_loads(text);
  EXPECT_EQ(out, ap_param_loads(text)) << "the vehicle's own loader finds the same";
  return out;
}

}  // namespace imulab::export_test
