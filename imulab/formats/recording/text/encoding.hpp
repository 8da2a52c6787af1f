// Texts as editors and spreadsheets save them -> UTF-8 with \n at the end of a line.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace imulab::recording_io {

enum class Encoding { utf8, utf16_low_first, utf16_high_first };

/// How the bytes of a text are read.
struct TextBytes {
  Encoding encoding = Encoding::utf8;
  std::size_t mark = 0;           ///< bytes of a byte order mark
  bool carriage_returns = false;  ///< end lines by themselves

  bool is_plain() const { return encoding == Encoding::utf8 && !carriage_returns; }
};

/// By a byte order mark, by zeros in every other byte, and by the ends of lines. Nothing where more bytes have to come.
std::optional<TextBytes> recognize_bytes(std::string_view head, bool complete);

/// True if the first bytes of a file may be those of a text: no zero, but for UTF-16 and what erased memory leaves at the end.
bool may_be_text(std::string_view head);

/// The text without the bytes 0xFF or 0 at its end, which memory has that was erased and not yet written.
std::string_view without_erased(std::string_view text);

/// Translates bytes as they come; a character that is cut waits for the next ones.
class Decoder {
 public:
  explicit Decoder(TextBytes bytes) : bytes_(bytes), skip_(bytes.mark) {}
  void add(std::string_view bytes, bool last, std::string& out);

 private:
  void unit(unsigned value, std::string& out);

  TextBytes bytes_;
  std::size_t skip_;
  std::string rest_;
  unsigned high_ = 0;  ///< first half of a surrogate pair
  bool returned_ = false;
};

/// A name in Windows-1252, where it is no UTF-8: "gyro [°/s]".
std::string utf8_name(std::string_view name);

}  // namespace imulab::recording_io
