// Any bytes to every reader. What a reader refuses it says with an Error; what it accepts it must give back. Anything else is a finding: an exception
// of another kind, and whatever the sanitizers stop.
#pragma once

#include <string_view>
#include <vector>

namespace imulab::fuzz {

struct Target {
  const char* name;
  void (*run)(std::string_view bytes);
  const char* seeds = "";       ///< endings of files of tests/recordings and tests/imports to begin with, besides fuzz/corpus/NAME
  const char* dictionary = "";  ///< of fuzz/dictionaries
  bool slow = false;            ///< tens of inputs a second rather than thousands
};
const std::vector<Target>& targets();

/// Ends a target: it accepted what it should not have, or gave back something else.
[[noreturn]] void finding(const char* what);

// recording.cpp: each binary format and text, whole files.
void text_table(std::string_view bytes);
void dialect(std::string_view bytes);
void numpy(std::string_view bytes);
void matlab(std::string_view bytes);
void hdf5(std::string_view bytes);
void binary_rows(std::string_view bytes);
void ulog(std::string_view bytes);
void dataflash(std::string_view bytes);
void novatel(std::string_view bytes);
void archive(std::string_view bytes);
void workbook(std::string_view bytes);
void ros1(std::string_view bytes);
void mcap(std::string_view bytes);
void ros2(std::string_view bytes);
void solution(std::string_view bytes);
void aids(std::string_view bytes);
// recorded.cpp: a recording on its way.
void stream(std::string_view bytes);
void inspection(std::string_view bytes);
void rewritten_bag(std::string_view bytes);
// search.cpp
void search(std::string_view bytes);
// settings.cpp: files of settings and results.
void session(std::string_view bytes);
void mission(std::string_view bytes);
void calibration(std::string_view bytes);
void imported(std::string_view bytes);
void result(std::string_view bytes);
void noise(std::string_view bytes);
void requirement(std::string_view bytes);
// decimal.cpp
void decimal(std::string_view bytes);
// store.cpp
void fleet_store(std::string_view bytes);
void checkpoint(std::string_view bytes);
void part(std::string_view bytes);
// command.cpp
void command_line(std::string_view bytes);

}  // namespace imulab::fuzz
