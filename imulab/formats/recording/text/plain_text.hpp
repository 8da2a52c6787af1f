// A text of any dialect as the plain text that the reader of rows takes: each line in its place, so that messages name the file's own.
#pragma once

#include "imulab/formats/recording/text/csv_layout.hpp"
#include "imulab/formats/recording/text/dialect.hpp"
#include "imulab/formats/recording/text/encoding.hpp"
#include "imulab/formats/recording/text/json_rows.hpp"
#include "imulab/formats/recording/text/labels.hpp"
#include "imulab/formats/recording/text/line_rewriter.hpp"
#include "imulab/formats/text/file.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::recording_io {

/// What is read of a text: of interleaved rows those of one sensor; what is declared of the dialect.
struct TextRequest {
  std::string file;     ///< as messages name it
  std::string topic{};  ///< the sensor
  std::string layout{};
};

/// Recognizes a text once, and rewrites it piece by piece. Stages: bytes -> UTF-8 lines; JSON or labels -> lines between commas; numbers, dates and
/// quotes of a dialect -> plain ones. A stage with nothing to do passes the text on.
class TextRewriter {
 public:
  explicit TextRewriter(TextRequest request);

  /// Recognizes a text by all of it, or by its beginning; false where more of it has to come. Throws Error as recognize_dialect does.
  bool start(std::string_view bytes, bool complete);
  /// True if the text is as it should be: nothing has to be rewritten.
  bool is_plain() const { return bytes_.is_plain() && !json_ && !labels_ && dialect_.is_plain(); }
  /// The text from its beginning on, whether or not start() saw more. In one piece by several threads.
  void add(std::string_view bytes, bool last, std::string& out);

  /// What the layout of the plain text takes from here.
  const TextHints& hints() const { return hints_; }
  /// The names of interleaved sensors; one table has all rows where there are none.
  const std::vector<std::string>& sensors() const { return dialect_.sensors; }
  /// What was left out, at the end.
  std::vector<std::string> notes() const;
  bool needs_whole() const { return json_ && json_->is_whole(); }
  std::size_t mark() const { return bytes_.mark; }

 private:
  bool find_stages(std::string_view bytes, bool complete);
  std::optional<Dialect> find_dialect(std::string_view bytes, bool complete);
  void unify(std::string_view bytes, bool last, std::string& out);
  void set_hints();
  void rewrite_lines(std::string_view lines, std::string& out);

  TextRequest request_;
  TextBytes bytes_;
  std::optional<Decoder> decoder_;
  std::optional<JsonRows> json_;
  std::optional<Labels> labels_;
  Dialect dialect_;
  std::optional<LineRewriter> lines_;
  std::string rest_, unified_;  ///< the beginning of a line that is not complete, before and after the first stages
  TextHints hints_;
};

/// A text file, plain: mapped where it is so in the file, else rewritten in memory.
class TextFile {
 public:
  enum class Part { all, head };  ///< head: of a text that is rewritten, the first lines
  TextFile(const std::filesystem::path& path, const std::string& topic, const std::string& layout, Part part = Part::all);
  /// The same of a text in memory, which has to stay.
  TextFile(std::string_view bytes, TextRequest request);

  std::string_view text() const { return text_; }
  const TextHints& hints() const { return rewriter_.hints(); }
  const std::vector<std::string>& sensors() const { return rewriter_.sensors(); }
  const std::vector<std::string>& notes() const { return notes_; }
  /// What was read may leave memory.
  void release() const;
  /// The text is about so many times as long.
  double times_as_long() const { return times_as_long_; }

 private:
  void rewrite(std::string_view bytes, Part part);

  std::string file_, topic_;
  std::optional<MappedFile> mapped_;
  TextRewriter rewriter_;
  std::string rewritten_;
  double times_as_long_ = 1;
  std::string_view text_;
  std::vector<std::string> notes_;
};

}  // namespace imulab::recording_io
