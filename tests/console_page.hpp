// What a page of the documentation shows: the commands of its ```console blocks in their order, and what each prints.
//
// A line "$ command" is run by the shell ("> " continues it). "# exit code N" after it is the expected exit code (0 if absent). A line that begins
// with "imulab: " is one of standard error. Other lines, if there are any, are standard output. Both have the same words as the command prints, and
// numbers within 1 %, or within what "# tolerance N %" states. A line "..." stands for any lines; at the end of a line, for any words.
#pragma once

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace imulab {

struct DocumentedCommand {
  std::size_t line = 0;  ///< of the page, from 0
  std::string text;
  int exit_code = 0;
  double tolerance = 0.01;  ///< of numbers, relative
  std::vector<std::string> output, errors;
  std::vector<std::size_t> output_lines, error_lines;  ///< of the page
};

inline std::vector<std::string> page_lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

inline std::vector<DocumentedCommand> commands_of(const std::string& page) {
  std::vector<DocumentedCommand> commands;
  const std::vector<std::string> lines = page_lines(page);
  bool inside = false;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string& line = lines[i];
    if (line.starts_with("```")) {
      inside = line == "```console";
    } else if (inside && line.starts_with("$ ")) {
      commands.push_back({.line = i, .text = line.substr(2)});
    } else if (inside && !commands.empty() && line.starts_with(">")) {
      commands.back().text.append("\n").append(line, std::min<std::size_t>(2, line.size()));
    } else if (inside && !commands.empty() && line.starts_with("# exit code ")) {
      commands.back().exit_code = std::stoi(line.substr(12));
    } else if (inside && !commands.empty() && line.starts_with("# tolerance ")) {
      commands.back().tolerance = std::stod(line.substr(12)) / 100;
    } else if (inside && !commands.empty() && line.starts_with("imulab: ")) {
      commands.back().errors.push_back(line);
      commands.back().error_lines.push_back(i);
    } else if (inside && !commands.empty()) {
      commands.back().output.push_back(line);
      commands.back().output_lines.push_back(i);
    }
  }
  return commands;
}

/// A line as its words, each number replaced by #, and the numbers. A digit behind a letter belongs to the word.
struct LineParts {
  std::string words{};
  std::vector<double> numbers{};

  explicit LineParts(const std::string& line) {
    const auto digit = [&](std::size_t i) { return i < line.size() && std::isdigit(static_cast<unsigned char>(line[i])) != 0; };
    const auto sign = [&](std::size_t i) { return i < line.size() && (line[i] == '-' || line[i] == '+'); };
    enum { nothing, word, number } before = nothing;
    for (std::size_t i = 0; i < line.size();) {
      if (before != word && (digit(i) || (before == nothing && sign(i) && digit(i + 1)))) {
        std::size_t end = i + 1;
        const auto skip_digits = [&] {
          while (digit(end)) ++end;
        };
        skip_digits();
        if (end < line.size() && line[end] == '.' && digit(end + 1)) ++end, skip_digits();
        if (const std::size_t exponent = end + (sign(end + 1) ? 2 : 1); end < line.size() && line[end] == 'e' && digit(exponent))
          end = exponent, skip_digits();
        numbers.push_back(std::strtod(line.substr(i, end - i).c_str(), nullptr));
        words += '#';
        i = end;
        before = number;
      } else {
        const char c = line[i++];
        if (c != ' ' || (!words.empty() && words.back() != ' ')) words += c;
        before = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' ? word : nothing;
      }
    }
    if (words.ends_with(' ')) words.pop_back();
  }
};

/// Whether a line says what the page shows. `words_alone`: whatever its numbers.
inline bool says(const std::string& shown, const std::string& line, double tolerance, bool words_alone = false) {
  LineParts wanted(shown);
  const LineParts said(line);
  const bool open = wanted.words.ends_with("...");
  if (open) wanted.words.resize(wanted.words.size() - 3);
  if (open ? !said.words.starts_with(wanted.words) : said.words != wanted.words) return false;
  if (said.numbers.size() < wanted.numbers.size()) return false;  // a # of the text
  return words_alone || std::equal(wanted.numbers.begin(), wanted.numbers.end(), said.numbers.begin(),
                                   [&](double a, double b) { return std::abs(a - b) <= tolerance * std::max(std::abs(a), std::abs(b)); });
}

/// What the page shows of a command's output, and what it should show.
struct ShownOutput {
  std::vector<std::string> differences;        ///< for people
  std::vector<std::vector<std::string>> anew;  ///< lines in place of each that is shown, and those behind the last
  std::vector<std::string> errors_anew;        ///< a line in place of each of standard error
};

/// The printed line, as far as the page shows it.
inline std::string as_shown(const std::string& shown, const std::string& printed) {
  if (!shown.ends_with("...")) return printed;
  std::istringstream in(shown);
  std::size_t end = 0;
  for (auto words = std::distance(std::istream_iterator<std::string>(in), {}); words > 1 && end != std::string::npos; --words)
    end = printed.find(' ', printed.find_first_not_of(' ', end));
  return printed.substr(0, end) + " ...";
}

/// Both are aligned with the least cost: a line that says the same costs nothing, other numbers little, other words more the fewer they share.
class OutputAlignment {
 public:
  OutputAlignment(const std::vector<std::string>& shown, const std::vector<std::string>& printed, double tolerance)
      : shown_(shown), printed_(printed), tolerance_(tolerance), cost_(shown.size() + 1, std::vector<double>(printed.size() + 1)) {
    for (std::size_t i = shown.size() + 1; i-- > 0;)
      for (std::size_t j = printed.size() + 1; j-- > 0;) cost_[i][j] = std::min({pair(i, j), skip_shown(i, j), skip_printed(i, j), end(i, j)});
  }

  ShownOutput result() const {
    ShownOutput out{{}, std::vector<std::vector<std::string>>(shown_.size() + 1), {}};
    for (std::size_t i = 0, j = 0; i < shown_.size() || j < printed_.size();) {
      if (cost_[i][j] == pair(i, j)) {
        if (!says(shown_[i], printed_[j], tolerance_)) out.differences.push_back("shows:  " + shown_[i] + "\nprints: " + printed_[j]);
        out.anew[i].push_back(as_shown(shown_[i], printed_[j]));
        ++i, ++j;
      } else if (cost_[i][j] == skip_printed(i, j)) {
        if (!any(i)) out.anew[i].push_back(printed_[j]), out.differences.push_back("prints: " + printed_[j]);
        ++j;
      } else {
        if (any(i)) out.anew[i].push_back(shown_[i]);
        if (!any(i)) out.differences.push_back("shows:  " + shown_[i]);
        ++i;
      }
    }
    return out;
  }

 private:
  static constexpr double lost = 5, added = 1, never = 1e300;

  /// "...", with spaces before it.
  bool any(std::size_t i) const {
    return i < shown_.size() && shown_[i].ends_with("...") && shown_[i].find_first_not_of(' ') == shown_[i].size() - 3;
  }
  double end(std::size_t i, std::size_t j) const { return i == shown_.size() && j == printed_.size() ? 0 : never; }
  double skip_shown(std::size_t i, std::size_t j) const { return i == shown_.size() ? never : cost_[i + 1][j] + (any(i) ? 0 : lost); }
  double skip_printed(std::size_t i, std::size_t j) const { return j == printed_.size() ? never : cost_[i][j + 1] + (any(i) ? 0 : added); }

  double pair(std::size_t i, std::size_t j) const {
    if (i == shown_.size() || j == printed_.size() || any(i)) return never;
    return cost_[i + 1][j + 1] + difference(shown_[i], printed_[j]);
  }

  double difference(const std::string& shown, const std::string& printed) const {
    if (says(shown, printed, tolerance_)) return 0;
    if (says(shown, printed, tolerance_, true)) return 1;
    const auto words = [](const std::string& line) {
      std::istringstream in(LineParts(line).words);
      return std::set<std::string>(std::istream_iterator<std::string>(in), {});
    };
    const std::set<std::string> a = words(shown), b = words(printed);
    const auto both = std::count_if(a.begin(), a.end(), [&](const std::string& word) { return word != "#" && b.contains(word); });
    return 2 + 6 * (1 - static_cast<double>(both) / static_cast<double>(std::max<std::size_t>({a.size(), b.size(), 1})));
  }

  const std::vector<std::string>&shown_, &printed_;
  double tolerance_;
  std::vector<std::vector<double>> cost_;  ///< least, of the lines from these on
};

/// A command whose output is not shown has none to compare; each line shown of standard error is printed somewhere in it.
inline ShownOutput compared(const DocumentedCommand& command, const std::string& printed, const std::string& errors) {
  std::vector<std::string> lines = page_lines(printed);
  while (!lines.empty() && lines.back().empty()) lines.pop_back();
  ShownOutput out;
  if (!command.output.empty()) out = OutputAlignment(command.output, lines, command.tolerance).result();
  const std::vector<std::string> error_lines = page_lines(errors);
  for (const std::string& shown : command.errors) {
    const auto said = [&](bool words_alone) {
      return std::ranges::find_if(error_lines, [&](const std::string& line) { return says(shown, line, command.tolerance, words_alone); });
    };
    const auto same = said(false), alike = said(true);
    if (same == error_lines.end()) out.differences.push_back("did not say: " + shown + "\nbut: " + errors);
    out.errors_anew.push_back(same != error_lines.end() ? as_shown(shown, *same) : alike != error_lines.end() ? as_shown(shown, *alike) : shown);
  }
  return out;
}

/// The page with what the commands print now.
inline std::string written_anew(const std::string& page, const std::vector<DocumentedCommand>& commands, const std::vector<ShownOutput>& outputs) {
  std::vector<std::string> lines = page_lines(page);
  for (std::size_t k = 0; k < commands.size(); ++k)
    for (std::size_t i = 0; i < outputs[k].errors_anew.size(); ++i) lines[commands[k].error_lines[i]] = outputs[k].errors_anew[i];
  for (std::size_t k = commands.size(); k-- > 0;) {
    const auto& places = commands[k].output_lines;
    if (outputs[k].anew.size() != places.size() + 1) continue;  // it did not run
    const auto& behind = outputs[k].anew.back();
    lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(places.back()) + 1, behind.begin(), behind.end());
    for (std::size_t i = places.size(); i-- > 0;) {
      const auto at = lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(places[i]));
      lines.insert(at, outputs[k].anew[i].begin(), outputs[k].anew[i].end());
    }
  }
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

}  // namespace imulab
