#include "imulab/report/html.hpp"

#include "imulab/formats/text/figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>

namespace imulab::report {

namespace {

constexpr std::size_t longest_text = 1000;  // characters: no sentence is longer

struct Character {
  std::uint32_t code = 0xFFFD;
  std::size_t bytes = 1;
};

/// The character at the front; the replacement character and one byte for what is not UTF-8.
Character first_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(text[i])); };
  const std::uint32_t lead = byte(0);
  if (lead < 0x80) return {lead, 1};
  const std::size_t bytes = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < bytes) return {};
  std::uint32_t code = lead & (0x7Fu >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xC0u) != 0x80) return {};
    code = code << 6 | (byte(i) & 0x3Fu);
  }
  constexpr std::uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  return code < least[bytes] || code > 0x10FFFF || surrogate ? Character{} : Character{code, bytes};
}

/// Control characters but line ends and tabs, and those that change the direction or hide: shown by their names.
bool invisible(std::uint32_t c) {
  if (c < 0x20) return c != '\n' && c != '\t';
  return (c >= 0x7F && c <= 0x9F) || c == 0xAD || c == 0x61C || (c >= 0x200B && c <= 0x200F) || (c >= 0x2028 && c <= 0x202E) ||
         (c >= 0x2060 && c <= 0x206F) || c == 0xFEFF || (c >= 0xFFF0 && c <= 0xFFFB) || (c >= 0xE0000 && c <= 0xE0FFF);
}

std::string with_minus_sign(std::string text) {
  if (text.starts_with('-') && text.find_first_of("123456789") == std::string::npos) text.erase(0, 1);  // no minus zero
  if (text.starts_with('-')) text.replace(0, 1, "−");
  return text;
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const Character c = first_character(text);
    switch (c.code) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      case 0xFFFD:
        out += "\xEF\xBF\xBD";
        break;
      default:
        if (invisible(c.code))
          out += fmt::format("[U+{:04X}]", c.code);
        else
          out += text.substr(0, c.bytes);
    }
    text.remove_prefix(c.bytes);
  }
  return out;
}

std::string shortened(std::string_view text, std::size_t most) {
  std::size_t characters = 0, kept = text.size();
  for (std::size_t at = 0; at < text.size(); at += first_character(text.substr(at)).bytes, ++characters)
    if (characters == most) kept = at;
  return characters <= most ? std::string(text) : fmt::format("{}… ({} characters)", text.substr(0, kept), characters);
}

std::string name_of_file(std::string_view path) {
  const std::size_t topic = std::min(path.find(':'), path.size());
  std::filesystem::path file = std::filesystem::absolute(path.substr(0, topic)).lexically_normal();
  if (!file.has_filename() || file.filename() == "session.toml") file = file.parent_path();
  return file.has_filename() ? file.filename().string() + std::string(path.substr(topic)) : std::string(path);
}

std::string relative_url(std::string_view path) {
  constexpr std::string_view plain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~/";
  std::string out;
  for (const char c : path)
    out += plain.find(c) != std::string_view::npos ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  return out;
}

std::string number_text(double value, int digits) { return std::isfinite(value) ? with_minus_sign(text::number(value, digits)) : "not determined"; }

bool are_raised(const std::vector<double>& ticks) {
  return std::ranges::any_of(ticks, [](double v) { return v != 0 && (std::abs(v) < 1e-3 || std::abs(v) >= 1e5); });
}

std::string tick_text(double value, bool raised) {
  const double size = std::abs(value);
  if (size == 0 || !(raised || are_raised({value}))) return with_minus_sign(fmt::format("{:.6g}", value));
  const int exponent = static_cast<int>(std::floor(std::log10(size) + 1e-9));
  constexpr std::string_view digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string power = exponent < 0 ? "⁻" : "";
  for (const char c : fmt::format("{}", std::abs(exponent))) power += digits[c - '0'];
  const double mantissa = value / std::pow(10.0, exponent);
  return (std::abs(mantissa - 1) < 1e-6 ? "10" : with_minus_sign(fmt::format("{:.3g}·10", mantissa))) + power;
}

std::string rounded_to(double value, double uncertainty) { return with_minus_sign(text::to_digits_of(uncertainty, value)); }

std::string uncertainty_text(double uncertainty) { return std::isfinite(uncertainty) ? text::two_digits(uncertainty) : "not determined"; }

std::string readable_unit(std::string_view unit) {
  std::string out(unit);
  for (const auto& [from, to] : {std::pair{"^2", "²"}, {"^3", "³"}, {"ug", "µg"}})
    for (std::size_t at = 0; (at = out.find(from, at)) != std::string::npos; at += std::string_view(to).size()) out.replace(at, 2, to);
  return out;
}

std::string table(const Table& t) {
  const auto side = [&](std::size_t column) { return std::find(t.left.begin(), t.left.end(), column) == t.left.end() ? "" : " class=\"left\""; };
  std::string out = fmt::format("<div class=\"scroll\"><table{}>", t.text_columns ? " class=\"text\"" : "");
  if (!t.head.empty()) {
    out += "<thead><tr>";
    for (std::size_t k = 0; k < t.head.size(); ++k) out += fmt::format("<th{}>{}</th>", side(k), t.head[k]);
    out += "</tr></thead>";
  }
  out += "<tbody>\n";
  for (const auto& row : t.rows) {
    out += "<tr>";
    for (std::size_t k = 0; k < row.size(); ++k) out += fmt::format("<{0}{1}>{2}</{0}>", k == 0 ? "th" : "td", side(k), row[k]);
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

std::string section(std::string_view id, std::string_view heading, std::string_view lead, const std::string& content) {
  if (content.empty() && lead.empty()) return {};
  return fmt::format("<section id=\"{}\"><h2>{}</h2>\n{}{}</section>\n", id, escaped(heading), lead.empty() ? "" : paragraph(lead), content);
}

std::string figure(const std::string& picture, std::string_view caption, bool wide) {
  return fmt::format("<figure{}><div class=\"scroll\">{}</div><figcaption>{}</figcaption></figure>\n", wide ? " class=\"wide\"" : "", picture,
                     escaped(caption));
}

std::string beside(const std::vector<std::string>& figures) {
  std::string out;
  for (const std::string& f : figures) out += f;
  return out.empty() ? out : "<div class=\"beside\">" + out + "</div>\n";
}

std::string list(const std::vector<std::string>& texts, std::string_view id) {
  if (texts.empty()) return {};
  std::string out = id.empty() ? "<ul>" : fmt::format("<ul id=\"{}\">", id);
  for (const std::string& text : texts) out += "<li>" + escaped(shortened(text, longest_text)) + "</li>";
  return out + "</ul>\n";
}

std::string paragraph(std::string_view text) { return "<p>" + escaped(shortened(text, 3 * longest_text)) + "</p>\n"; }

std::string folded(std::string_view summary, const std::string& content) {
  return fmt::format("<details><summary>{}</summary>\n{}</details>\n", escaped(summary), content);
}

}  // namespace imulab::report
