#include "imulab/formats/recording/text/json_scan.hpp"

#include <algorithm>
#include <charconv>

namespace imulab::recording_io {
namespace {

/// The place behind a string that begins at `place`; npos where it does not end.
std::size_t behind_string(std::string_view text, std::size_t place) {
  for (std::size_t i = place + 1; i < text.size(); ++i) {
    if (text[i] == '"') return i + 1;
    if (text[i] == '\\') ++i;
  }
  return std::string_view::npos;
}

bool is_of_word(char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' || c == '+' || c == '.'; }

std::size_t behind_word(std::string_view text, std::size_t place) {
  while (place < text.size() && is_of_word(text[place])) ++place;
  return place;
}

/// A pass over one value.
class Scan {
 public:
  Scan(std::string_view text, const std::function<void(std::string_view, const JsonScalar&)>& each) : text_(text), each_(each) {}

  bool value(int depth) {
    constexpr int deepest = 8;
    blanks();
    if (at_ == text_.size() || depth > deepest) return false;
    if (text_[at_] == '{' || text_[at_] == '[') return members(text_[at_] == '{', depth);
    const bool is_string = text_[at_] == '"';
    const std::size_t end = is_string ? behind_string(text_, at_) : behind_word(text_, at_);
    if (end == std::string_view::npos || end == at_) return false;
    each_(path_, {text_.substr(at_ + (is_string ? 1 : 0), end - at_ - (is_string ? 2 : 0)), is_string});
    at_ = end;
    return true;
  }
  bool at_end() {
    blanks();
    return at_ == text_.size();
  }

 private:
  void blanks() { at_ = skip_json_blanks(text_, at_); }

  bool members(bool named, int depth) {
    const char close = named ? '}' : ']';
    const std::size_t length = path_.size();
    ++at_;
    blanks();
    if (at_ < text_.size() && text_[at_] == close) return ++at_, true;
    for (std::size_t number = 1;; ++number) {
      if (length > 0) path_.push_back('.');
      if (!(named ? key() : index(number)) || !value(depth + 1)) return false;
      path_.resize(length);
      blanks();
      if (at_ == text_.size()) return false;
      const char c = text_[at_++];
      if (c == close) return true;
      if (c != ',') return false;
      blanks();
    }
  }
  bool key() {
    if (at_ == text_.size() || text_[at_] != '"') return false;
    const std::size_t end = behind_string(text_, at_);
    if (end == std::string_view::npos) return false;
    path_.append(text_.substr(at_ + 1, end - at_ - 2));
    at_ = skip_json_blanks(text_, end);
    return at_ < text_.size() && text_[at_++] == ':';
  }
  bool index(std::size_t number) {
    char digits[24];
    path_.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
    return true;
  }

  std::string_view text_;
  const std::function<void(std::string_view, const JsonScalar&)>& each_;
  std::size_t at_ = 0;
  std::string path_;
};

}  // namespace

std::size_t skip_json_blanks(std::string_view text, std::size_t place) {
  while (place < text.size() && (text[place] == ' ' || text[place] == '\n' || text[place] == '\r' || text[place] == '\t')) ++place;
  return place;
}

JsonExtent skip_json(std::string_view text, std::size_t place) {
  constexpr std::size_t deepest = 64;
  place = skip_json_blanks(text, place);
  std::string open;
  for (; place < text.size();) {
    const char c = text[place];
    if (c == '"') {
      place = behind_string(text, place);
      if (place == std::string_view::npos) return {JsonEnd::cut, text.size()};
    } else if (c == '{' || c == '[') {
      if (open.size() == deepest) return {JsonEnd::wrong, place};
      open.push_back(c == '{' ? '}' : ']');
      ++place;
      continue;
    } else if (c == '}' || c == ']') {
      if (open.empty() || open.back() != c) return {JsonEnd::wrong, place};
      open.pop_back();
      ++place;
    } else if (c == ',' || c == ':' || c == ' ' || c == '\n' || c == '\r' || c == '\t') {
      if (open.empty()) return {JsonEnd::wrong, place};
      ++place;
      continue;
    } else {
      const std::size_t end = behind_word(text, place);
      if (end == place) return {JsonEnd::wrong, place};
      place = end;
    }
    if (open.empty()) return {JsonEnd::whole, place};
  }
  return {JsonEnd::cut, text.size()};
}

bool for_json_scalars(std::string_view text, const std::function<void(std::string_view path, const JsonScalar& value)>& each) {
  Scan scan(text, each);
  return scan.value(0) && scan.at_end();
}

bool for_json_members(std::string_view text, const std::function<void(std::string_view key, std::string_view value)>& each) {
  std::size_t at = skip_json_blanks(text, 0);
  if (at == text.size() || (text[at] != '{' && text[at] != '[')) return false;
  const bool named = text[at] == '{';
  at = skip_json_blanks(text, at + 1);
  while (at < text.size() && text[at] != '}' && text[at] != ']') {
    std::string_view key;
    if (named) {
      const std::size_t end = text[at] == '"' ? behind_string(text, at) : std::string_view::npos;
      if (end == std::string_view::npos) return false;
      key = text.substr(at + 1, end - at - 2);
      at = skip_json_blanks(text, end);
      if (at == text.size() || text[at++] != ':') return false;
      at = skip_json_blanks(text, at);
    }
    const JsonExtent value = skip_json(text, at);
    if (value.how != JsonEnd::whole) return false;
    each(key, text.substr(at, value.end - at));
    at = skip_json_blanks(text, value.end);
    if (at < text.size() && text[at] == ',') at = skip_json_blanks(text, at + 1);
  }
  return at < text.size();
}

void append_json_field(const JsonScalar& value, std::string& out) {
  if (!value.is_string && value.text == "null") return;
  if (!value.is_string && value.text == "true") return void(out.push_back('1'));
  if (!value.is_string && value.text == "false") return void(out.push_back('0'));
  const std::size_t begin = out.size();
  out.append(value.text);
  if (value.is_string)
    std::replace_if(
        out.begin() + static_cast<std::ptrdiff_t>(begin), out.end(), [](char c) { return c == '\n' || c == '\r' || c == '"'; }, ' ');
  if (value.is_string && value.text.find(',') != std::string_view::npos) {
    out.insert(begin, 1, '"');
    out.push_back('"');
  }
}

}  // namespace imulab::recording_io
