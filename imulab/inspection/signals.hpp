// The columns of one table of a recording, before anybody knows what they are.
#pragma once

#include "imulab/finding_code.hpp"
#include "imulab/session.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

struct Signal {
  std::string name;                          ///< of the column; empty where the file has none
  std::string unit;                          ///< where the file's format states it; else empty
  Column column = 1;                         ///< how a session names it
  std::vector<double> values;                ///< one a row; NaN where the field holds no number
  std::size_t table = 0;                     ///< of several that were joined: which
  Integers integers = Integers::as_written;  ///< as which the values are taken
};

/// A question that the data do not answer, about the declaration of a key; without a key there is none.
struct Question {
  std::string key = {}, text = {}, advice = {};
  Code code = Code::open_question;

  bool empty() const { return key.empty(); }
  std::string line() const { return key + ": " + text + (advice.empty() ? "" : "; " + advice); }
};

/// Where a table that was joined to another one comes from, and its clock.
struct SignalPart {
  std::string file, topic;  ///< empty where they are the first table's
  TimeSource time;
  Question open;  ///< about its clock
};

struct SignalTable {
  std::string file;
  std::string topic;   ///< of a file with several tables; else empty
  std::string format;  ///< in words: "CSV, delimiter \",\", a header in line 1"
  std::vector<Signal> signals;
  std::vector<SignalPart> parts;   ///< of the tables after the first
  std::size_t first_line = 0;      ///< of a text: that of the first row, where a row follows in every line
  std::optional<double> rate_hz;   ///< that the file states beside its columns
  std::string rate_name;           ///< under this name
  std::vector<std::string> notes;  ///< what reading met, with its consequence

  std::size_t rows() const { return signals.empty() ? 0 : signals.front().values.size(); }
};

}  // namespace imulab
