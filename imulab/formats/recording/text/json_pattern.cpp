#include "imulab/formats/recording/text/json_pattern.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

namespace imulab::recording_io {
namespace {

constexpr std::size_t longest_row = 8192, longest_scalar = 64;

using CharSet = std::array<bool, 256>;

constexpr CharSet set_of_number() {
  CharSet set{};
  for (const char c : {'0', '1', '2', '3', '4', '5', '6', '7', '8', '9', '.', '-', '+', 'e', 'E'}) set[static_cast<unsigned char>(c)] = true;
  return set;
}

/// Of strings that append_json_field takes as they are.
constexpr CharSet set_of_string() {
  CharSet set{};
  set.fill(true);
  for (const char c : {'"', '\\', ',', '\n', '\r'}) set[static_cast<unsigned char>(c)] = false;
  return set;
}

constexpr CharSet of_number = set_of_number(), of_string = set_of_string();

bool is_plain_number(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return of_number[static_cast<unsigned char>(c)]; });
}

}  // namespace

std::optional<JsonPattern> JsonPattern::of(std::string_view row, const std::vector<JsonField>& fields, std::size_t columns) {
  if (columns == 0) return std::nullopt;
  JsonPattern pattern;
  Piece piece;
  std::size_t begin = 0, next = 0;  // of the piece; the column
  for (const JsonField& field : fields) {
    if (field.column) {
      if (*field.column < next) return std::nullopt;
      piece.line.append(*field.column - next + (next > 0 ? 1 : 0), ',');
      next = *field.column + 1;
    }
    const std::string_view text = field.value.text;
    if (field.value.is_string || is_plain_number(text)) {
      const auto place = static_cast<std::size_t>(text.data() - row.data());
      piece.text = row.substr(begin, place - begin);
      piece.is_string = field.value.is_string;
      piece.kept = field.column.has_value();
      begin = place + text.size();
      pattern.pieces_.push_back(std::exchange(piece, {}));
    } else if (field.column) {
      append_json_field(field.value, piece.line);
    }
  }
  piece.text = row.substr(begin);
  piece.line.append(columns - std::max<std::size_t>(next, 1), ',');
  pattern.pieces_.push_back(std::move(piece));
  std::size_t longest = 0;
  for (const Piece& p : pattern.pieces_) longest += p.line.size() + longest_scalar;
  if (longest > longest_row) return std::nullopt;
  return pattern;
}

std::size_t JsonPattern::add_row(std::string_view text, std::string& out) const {
  const char *at = text.data(), *const end = at + text.size();
  std::array<char, longest_row> line;
  char* to = line.data();
  for (const Piece& piece : pieces_) {
    if (static_cast<std::size_t>(end - at) < piece.text.size() || std::memcmp(at, piece.text.data(), piece.text.size()) != 0) return 0;
    at += piece.text.size();
    to = std::copy(piece.line.begin(), piece.line.end(), to);
    if (&piece == &pieces_.back()) break;
    const CharSet& set = piece.is_string ? of_string : of_number;
    const char *const scalar = at, *const last = at + std::min<std::size_t>(longest_scalar, static_cast<std::size_t>(end - at));
    while (at < last && set[static_cast<unsigned char>(*at)]) {
      *to = *at++;
      to += piece.kept ? 1 : 0;
    }
    if (at == scalar && !piece.is_string) return 0;
  }
  out.append(line.data(), to);
  return static_cast<std::size_t>(at - text.data());
}

}  // namespace imulab::recording_io
