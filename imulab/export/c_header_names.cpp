#include "imulab/export/c_header_names.hpp"

#include "imulab/core/error.hpp"
#include "imulab/export/c_header_text.hpp"
#include "imulab/formats/text/file.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace imulab::firmware {

namespace {

// Of ASCII, whatever the locale.
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_of_name(char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '_'; }

/// C99 tells names apart by their first 63 characters; the longest part that follows a prefix has 30: _FIXED_ACCEL_TEMPERATURE_BITS.
constexpr std::size_t longest_prefix = 32;

}  // namespace

void expect_prefix(std::string_view prefix) {
  const bool of_name = std::all_of(prefix.begin(), prefix.end(), is_of_name);
  // C++ keeps names with two underscores in a row, and C those that begin with one.
  const bool free = !prefix.empty() && is_letter(prefix.front()) && prefix.back() != '_' && prefix.find("__") == std::string_view::npos;
  if (!of_name || !free || prefix.size() > longest_prefix)
    throw Error(
        fmt::format("\"{}\" cannot begin a name in C; expected a letter, then letters, digits and single underscores between them, {} in all at "
                    "most: imu1",
                    harmless(prefix), longest_prefix));
}

std::string macro_prefix(std::string_view prefix) {
  std::string out(prefix);
  for (char& c : out)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return out;
}

std::string with_prefix(std::string_view source, std::string_view prefix) {
  constexpr std::string_view name = "imulab_", macro = "IMULAB_";
  const std::string macros = macro_prefix(prefix);
  std::string out;
  for (std::size_t i = 0; i < source.size();) {
    const bool begins = is_of_name(source[i]) && (i == 0 || !is_of_name(source[i - 1]));
    const bool is_macro = source.substr(i).starts_with(macro);
    if (begins && (is_macro || source.substr(i).starts_with(name))) {
      out.append(is_macro ? std::string_view(macros) : prefix).append("_");
      i += name.size();
    } else {
      out += source[i++];
    }
  }
  return out;
}

std::string guarded(const std::string& comment, const std::string& source, std::string_view prefix) {
  const std::string macros = macro_prefix(prefix), own = fmt::format("{}_HEADER_{}", macros, sha256(comment + source).substr(0, 16));
  return fmt::format(
      "{0}#ifndef {1}\n"
      "#define {1}\n"
      "#ifdef {2}_HEADER\n"
      "#error \"Two different calibration headers with the prefix {3}: one would be used for both IMUs. Give each its own, as in imulab export "
      "calibration.json --to c-header --prefix imu1\"\n"
      "#else\n"
      "#define {2}_HEADER\n\n"
      "{4}#endif\n#endif\n",
      comment, own, macros, prefix, source);
}

}  // namespace imulab::firmware
