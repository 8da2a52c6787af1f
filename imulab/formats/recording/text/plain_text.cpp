#include "imulab/formats/recording/text/plain_text.hpp"

#include "imulab/core/memory.hpp"
#include "imulab/core/parallel.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/recording/text/csv_rows.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/parallel.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

namespace imulab::recording_io {
namespace {

constexpr std::size_t bytes_of_head = std::size_t{1} << 18;
constexpr double with_rewritten = 2.2;  // the file and the text that is made of it

}  // namespace

TextRewriter::TextRewriter(TextRequest request) : request_(std::move(request)) {}

/// Passes bytes through the first stages, to lines of UTF-8 between delimiters.
void TextRewriter::unify(std::string_view bytes, bool last, std::string& out) {
  std::string decoded;
  std::string_view text = bytes;
  if (decoder_) {
    decoder_->add(bytes, last, decoded);
    text = decoded;
  }
  if (json_) return json_->add(text, last, out);
  if (!labels_) return void(out.append(text));
  std::string joined;
  if (!rest_.empty()) joined = rest_ + std::string(text), text = joined;
  const std::size_t whole = last ? text.size() : text.rfind('\n') + 1;
  labels_->add(text.substr(0, whole), out);
  rest_ = text.substr(whole);
}

/// Finds the stages that a text needs; false where more of it has to come.
bool TextRewriter::find_stages(std::string_view bytes, bool complete) {
  const auto read_as = recognize_bytes(bytes, complete);
  if (!read_as) return false;
  bytes_ = *read_as;
  std::string decoded;
  std::string_view text = bytes.substr(std::min(bytes_.mark, bytes.size()));
  if (!bytes_.is_plain()) {
    Decoder(bytes_).add(bytes, complete, decoded);
    text = decoded;
  }
  json_.reset(), labels_.reset();
  JsonRows json(request_.file, text, complete);
  if (json.shape() == JsonRows::Shape::more) return false;
  if (json.shape() != JsonRows::Shape::none) {
    json_ = std::move(json);
  } else if (Labels labels(text.substr(0, text.size() < bytes_of_head || complete ? text.size() : text.rfind('\n') + 1)); labels.found()) {
    labels_ = std::move(labels);
  }
  return true;
}

/// The dialect of a text after the first stages.
std::optional<Dialect> TextRewriter::find_dialect(std::string_view bytes, bool complete) {
  TextRewriter stages(*this);
  std::string unified;
  std::string_view text = bytes.substr(std::min(bytes_.mark, bytes.size()));
  if (!bytes_.is_plain()) stages.decoder_.emplace(bytes_);
  if (stages.decoder_ || json_ || labels_) {
    stages.unify(stages.decoder_ ? bytes : text, complete, unified);
    text = unified;
  }
  return recognize_dialect(request_.file, complete ? text : text.substr(0, text.rfind('\n') + 1), complete,
                           declared_dialect(request_.layout, request_.file));
}

bool TextRewriter::start(std::string_view bytes, bool complete) {
  const std::string_view head = bytes.substr(0, bytes_of_head);
  const bool whole = head.size() == bytes.size();
  const auto at_first = [&](auto&& find) { return find(head, complete && whole) || (!whole && find(bytes, complete)); };
  if (!at_first([&](std::string_view text, bool last) { return find_stages(text, last); })) return false;
  std::optional<Dialect> dialect;
  if (!at_first([&](std::string_view text, bool last) {
        dialect = needs_whole() && !last ? std::nullopt : find_dialect(text, last);
        return dialect.has_value();
      }))
    return false;
  dialect_ = *std::move(dialect);
  if (!dialect_.is_plain()) lines_.emplace(dialect_, request_.topic);
  set_hints();
  decoder_.reset();
  if (!bytes_.is_plain() || bytes_.mark > 0) decoder_.emplace(bytes_);
  return true;
}

void TextRewriter::set_hints() {
  hints_.delimiter = dialect_.delimiter;
  hints_.rewritten = lines_.has_value();
  std::vector<std::string> words;
  if (bytes_.encoding != Encoding::utf8) words.emplace_back("UTF-16");
  if (json_) words.emplace_back("JSON"), hints_.names = json_->names(), hints_.counts_elements = json_->counts_elements();
  if (labels_)
    words.emplace_back(labels_->names_all() ? "labeled numbers" : "stamps of a console"), hints_.names = labels_->names(),
                                                                                          hints_.units = labels_->units();
  if (std::string own = dialect_.words(); !own.empty()) words.push_back(std::move(own));
  for (const std::string& word : words) hints_.words += ", " + word;
  for (std::size_t i = 0; i < dialect_.uses.size(); ++i) {
    const FieldUse use = dialect_.uses[i];
    if (use == FieldUse::number_or_text || use == FieldUse::sensor) continue;
    const bool joined = i > 0 && dialect_.uses[i - 1] == FieldUse::joined_date;
    if (!joined) hints_.times.push_back(i);
  }
}

void TextRewriter::rewrite_lines(std::string_view lines, std::string& out) {
  constexpr std::size_t worth_it = std::size_t{1} << 20;  // bytes
  const std::size_t text_size = lines.size(), count = std::min<std::size_t>(parallel_threads(), text_size / worth_it);
  if (count < 2 || !lines_->is_independent()) return lines_->add(lines, out);
  std::vector<std::string_view> parts;
  for (std::size_t left = count; left > 1; --left) parts.push_back(take_lines(lines, lines.size() / left));
  parts.push_back(lines);
  std::vector<std::string> rewritten(parts.size());
  rewritten.front() = std::move(out);
  rewritten.front().reserve(rewritten.front().size() + text_size + text_size / 8);  // the others follow it
  parallel_for(parts.size(), [&](std::size_t p) { LineRewriter(*lines_).add(parts[p], rewritten[p]); });
  out = std::move(rewritten.front());
  for (std::size_t p = 1; p < rewritten.size(); ++p) out.append(rewritten[p]), rewritten[p] = {};
}

void TextRewriter::add(std::string_view bytes, bool last, std::string& out) {
  if (!lines_) return unify(bytes, last, out);
  std::string unified = std::exchange(unified_, {});
  const bool passes = !decoder_ && !json_ && !labels_ && unified.empty();
  if (!passes) unify(bytes, last, unified);
  const std::string_view text = passes ? bytes : std::string_view(unified);
  if (last) return rewrite_lines(text, out);
  const std::size_t whole = text.rfind('\n') + 1;
  lines_->add(text.substr(0, whole), out);
  unified_ = text.substr(whole);
}

std::vector<std::string> TextRewriter::notes() const { return json_ ? json_->notes() : std::vector<std::string>{}; }

TextFile::TextFile(const std::filesystem::path& path, const std::string& topic, const std::string& layout, Part part)
    : file_(input_name(path)), topic_(topic), mapped_(path), rewriter_({file_, topic, layout}) {
  rewrite(mapped_->text(), part);
}

TextFile::TextFile(std::string_view bytes, TextRequest request) : file_(request.file), topic_(request.topic), rewriter_(std::move(request)) {
  rewrite(bytes, Part::all);
}

void TextFile::rewrite(std::string_view bytes, Part part) {
  text_ = bytes;
  const auto leave_erased = [&](std::string_view all) {
    const std::string_view kept = without_erased(all);
    if (kept.empty() && !all.empty()) throw Error(file_ + ": is not text; expected CSV or plain columns of numbers");
    if (const std::size_t erased = all.size() - kept.size(); erased > 1)
      notes_.push_back(fmt::format("{}: ends with {} bytes of erased memory (0xFF or 0), which are left out", file_, erased));
    return kept;
  };
  const auto read_as = recognize_bytes(bytes, true);
  if (read_as->encoding == Encoding::utf8) text_ = bytes = leave_erased(bytes);
  rewriter_.start(bytes, true);
  const std::vector<std::string_view> names(sensors().begin(), sensors().end());
  if (!topic_.empty() && std::find(names.begin(), names.end(), topic_) == names.end())
    throw Error(fmt::format("{}: topic {} is not there; expected {}", file_, excerpt(topic_),
                            names.empty() ? "no topic, since no column names the sensor of a row" : "one of " + text::listed(names)));
  if (rewriter_.is_plain()) return text_.remove_prefix(std::min(rewriter_.mark(), text_.size()));
  if (const std::size_t head = 4 * bytes_of_head; part == Part::head && head < bytes.size() && !rewriter_.needs_whole()) {
    rewriter_.add(bytes.substr(0, head), false, rewritten_);
    times_as_long_ = static_cast<double>(bytes.size()) / static_cast<double>(head);
    text_ = rewritten_;
    return;
  }
  expect_memory(with_rewritten * static_cast<double>(bytes.size()), file_ + ": rewriting its text");
  rewriter_.add(bytes, true, rewritten_);
  mapped_.reset();
  text_ = read_as->encoding == Encoding::utf8 ? std::string_view(rewritten_) : leave_erased(rewritten_);
  for (std::string& note : rewriter_.notes()) notes_.push_back(std::move(note));
}

void TextFile::release() const {
  if (mapped_) mapped_->release(mapped_->text().size());
}

}  // namespace imulab::recording_io
