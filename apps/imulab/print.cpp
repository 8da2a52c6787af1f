// The one way of text to people: what would steer a terminal is shown.
#include "apps/imulab/command.hpp"
#include "imulab/fleet/store/server.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/results/conclusion.hpp"

#include <fmt/core.h>

#include <string_view>
#include <utility>

namespace imulab::command {

void print(const std::string& text, std::FILE* out) {
  const std::string shown = printable(text);
  for (const Verdict verdict : {Verdict::good, Verdict::met, Verdict::doubtful, Verdict::not_met})
    if (const std::string word(to_string(verdict)); out == stdout && output_has_color() && shown.starts_with(word + ":"))
      return fmt::print("{}{}", in_color(is_favorable(verdict) ? Color::green : Color::yellow, word), shown.substr(word.size()));
  fmt::print(out, "{}", shown);
}

void print_json(const std::string& text) { fmt::print("{}", text); }

void print_json(const JsonFields& object, const Conclusion& conclusion, const std::vector<std::string>& warnings) {
  print_json(with_conclusion(fields_json(object), conclusion, warnings));
}

namespace {

/// Further lines of a message begin with blanks: a line end in a name makes no message of its own.
std::string as_one_message(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (out.ends_with('\n') && c != ' ') out += "  ";
    out += c;
  }
  return out;
}

/// "imulab: ..." on standard error, after all of standard output. The middle of a text without end is left out; a message may quote the command line,
/// and that a store's password.
void say(Color color, const std::string& what, const std::string& text) {
  constexpr std::size_t longest = 4096, kept = 1024;
  const std::string shown = text.size() <= longest ? text : text.substr(0, kept) + " ... " + text.substr(text.size() - kept);
  std::fflush(stdout);
  const std::string line = fmt::format("imulab: {}{}\n", errors_have_color() && !what.empty() ? in_color(color, what) : what,
                                       printable(as_one_message(fleet::without_passwords(shown))));
  std::fwrite(line.data(), 1, line.size(), stderr);  // which may be closed: the exit code says it, too
}

}  // namespace

void warn(const std::string& text) { say(Color::yellow, "warning: ", text); }
void note(const std::string& text) { say(Color::green, "", text); }
void complain(const std::string& text) { say(Color::red, "", text); }

}  // namespace imulab::command
