// For tests of bad input: a session folder made by the command, whose files a test damages before it uses them.
#pragma once

#include "tests/run_command.hpp"
#include <stdexcept>
#include <string>
#include <vector>

namespace imulab {

/// session.toml and recording.csv as text, one string per line: line 0 is the header, so that line n of the file is element n - 1.
struct SessionText {
  std::string session;
  std::vector<std::string> lines;

  /// Replaces the first `from` in session.toml, which must be present.
  void declare(const std::string& from, const std::string& to) {
    const std::size_t at = session.find(from);
    if (at == std::string::npos) throw std::logic_error("session.toml has no " + from);
    session.replace(at, from.size(), to);
  }
  static std::vector<std::string> fields(const std::string& line) {
    std::vector<std::string> out{""};
    for (const char c : line) {
      if (c == ',')
        out.emplace_back();
      else
        out.back() += c;
    }
    return out;
  }
  void set(std::size_t line, std::size_t column, const std::string& text) {
    std::vector<std::string> row = fields(lines[line - 1]);
    row.at(column) = text;
    join(line, row);
  }
  /// change(row) edits the numbers of every row: t, gx, gy, gz, ax, ay, az.
  template <class Change>
  void for_rows(Change change) {
    for (std::size_t line = 2; line <= lines.size(); ++line) {
      std::vector<double> row;
      for (const std::string& field : fields(lines[line - 1])) row.push_back(std::stod(field));
      change(row);
      std::vector<std::string> texts;
      for (const double x : row) {
        char text[40];
        std::snprintf(text, sizeof text, "%.12g", x);
        texts.emplace_back(text);
      }
      join(line, texts);
    }
  }
  std::string recording(const std::string& line_end = "\n") const {
    std::string text;
    for (const std::string& line : lines) text += line + line_end;
    return text;
  }
  void write(const TemporaryFolder& folder, const std::string& name = "session") const {
    std::filesystem::create_directories(folder / name);
    folder.write(name + "/session.toml", session);
    folder.write(name + "/recording.csv", recording());
  }

 private:
  void join(std::size_t line, const std::vector<std::string>& row) {
    std::string text;
    for (const std::string& field : row) text += (text.empty() && &field == row.data() ? "" : ",") + field;
    lines[line - 1] = text;
  }
};

/// The session that `imulab procedure handheld` and `imulab simulate` make with the default seed: 20 rests, 144 s at 100 Hz. Made once.
inline const SessionText& hand_held_session() {
  static const SessionText made = [] {
    const TemporaryFolder folder;
    for (const char* arguments : {"procedure handheld --poses 20 -o hand.toml", "simulate hand.toml -o session"})
      if (const CommandResult result = run_imulab(folder, arguments); result.exit_code != 0) throw std::runtime_error(result.errors);
    SessionText text{read_text(folder / "session/session.toml"), {}};
    std::istringstream rows(read_text(folder / "session/recording.csv"));
    for (std::string line; std::getline(rows, line);) text.lines.push_back(line);
    return text;
  }();
  return made;
}

}  // namespace imulab
