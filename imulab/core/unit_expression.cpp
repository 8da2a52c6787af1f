#include "imulab/core/unit_expression.hpp"

#include "imulab/core/text.hpp"
#include "imulab/units.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

namespace imulab {
namespace {

struct NamedUnit {
  std::string_view name;
  UnitExpression unit;
};

constexpr double foot = 0.3048;  // m (exact)

constexpr NamedUnit named_units[] = {
    {"deg", {unit::deg, 1}},
    {"mdeg", {1e-3 * unit::deg, 1}},
    {"udeg", {1e-6 * unit::deg, 1}},
    {"arcmin", {unit::deg / 60, 1}},
    {"arcsec", {unit::arcsec, 1}},
    {"rad", {1, 1}},
    {"mrad", {1e-3, 1}},
    {"urad", {1e-6, 1}},
    {"nrad", {1e-9, 1}},
    {"dps", {unit::deg, 1, 0, -1}},
    {"mdps", {1e-3 * unit::deg, 1, 0, -1}},
    {"udps", {1e-6 * unit::deg, 1, 0, -1}},
    {"dph", {unit::deg_per_h, 1, 0, -1}},
    {"g", {unit::g, 0, 1, -2}},
    {"mg", {1e-3 * unit::g, 0, 1, -2}},
    {"ug", {unit::ug, 0, 1, -2}},
    {"ng", {1e-3 * unit::ug, 0, 1, -2}},
    {"gal", {1e-2, 0, 1, -2}},
    {"mgal", {1e-5, 0, 1, -2}},
    {"m", {1, 0, 1}},
    {"cm", {1e-2, 0, 1}},
    {"mm", {1e-3, 0, 1}},
    {"um", {1e-6, 0, 1}},
    {"ft", {foot, 0, 1}},
    {"s", {1, 0, 0, 1}},
    {"s2", {1, 0, 0, 2}},
    {"sec", {1, 0, 0, 1}},
    {"sec2", {1, 0, 0, 2}},
    {"min", {60, 0, 0, 1}},
    {"h", {unit::hour, 0, 0, 1}},
    {"hr", {unit::hour, 0, 0, 1}},
    {"hour", {unit::hour, 0, 0, 1}},
    {"hz", {1, 0, 0, -1}},
    {"khz", {1e3, 0, 0, -1}},
};

/// Signs and spellings that stand for letters of the grammar below.
constexpr std::pair<std::string_view, std::string_view> spellings[] = {
    {" ", ""},     {"degrees", "deg"}, {"degree", "deg"}, {"°", "deg"}, {"º", "deg"}, {"µ", "u"},       {"μ", "u"},
    {"√", "sqrt"}, {"²", "^2"},        {"½", "^0.5"},     {"·", "*"},   {"⋅", "*"},   {"(1/2)", "0.5"}, {"1/2", "0.5"},
};

std::string in_plain_letters(std::string_view text) {
  std::string out = lowered(text);
  for (const auto& [sign, letters] : spellings)
    for (std::size_t at = 0; (at = out.find(sign, at)) != std::string::npos; at += letters.size()) out.replace(at, sign.size(), letters);
  return out;
}

/// unit = power { ("*" | "/") power }; power = base [ "^" ( number | "(" number ")" ) ]; base = "(" unit ")" | ( "sqrt" | "rt" | "rt-" ) base | name.
class UnitReader {
 public:
  explicit UnitReader(std::string_view text) : rest_(text) {}

  std::optional<UnitExpression> unit() {
    std::optional<UnitExpression> out = power();
    while (out && !rest_.empty() && (rest_.front() == '*' || rest_.front() == '/')) {
      const double sign = taken("/") ? -1 : (taken("*"), 1);
      const std::optional<UnitExpression> next = power();
      out = next ? std::optional(out->times(*next, sign)) : std::nullopt;
    }
    return out;
  }
  bool at_end() const { return rest_.empty(); }

 private:
  bool taken(std::string_view word) {
    if (!rest_.starts_with(word)) return false;
    rest_.remove_prefix(word.size());
    return true;
  }

  std::optional<UnitExpression> power() {
    const std::optional<UnitExpression> of = base();
    if (!of || !taken("^")) return of;
    const bool enclosed = taken("(");
    double exponent = 0;
    const auto [after, failure] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), exponent);
    if (failure != std::errc() || !(std::abs(exponent) <= 4)) return std::nullopt;
    rest_.remove_prefix(static_cast<std::size_t>(after - rest_.data()));
    if (enclosed && !taken(")")) return std::nullopt;
    return UnitExpression().times(*of, exponent);
  }

  std::optional<UnitExpression> base() {
    if (++depth_ > most_nested) return std::nullopt;
    if (taken("sqrt") || taken("rt-") || taken("rt")) {
      const std::optional<UnitExpression> of = base();
      return of ? std::optional(UnitExpression().times(*of, 0.5)) : std::nullopt;
    }
    if (taken("(")) {
      const std::optional<UnitExpression> inner = unit();
      return taken(")") ? inner : std::nullopt;
    }
    const std::string_view name = rest_.substr(0, rest_.find_first_of("*/^()"));
    for (const NamedUnit& known : named_units)
      if (known.name == name) return taken(name), known.unit;
    return std::nullopt;
  }

  static constexpr int most_nested = 50;
  std::string_view rest_;
  int depth_ = 0;
};

}  // namespace

UnitExpression UnitExpression::times(const UnitExpression& other, double power) const {
  return {size * std::pow(other.size, power), angle + power * other.angle, length + power * other.length, time + power * other.time};
}

std::optional<UnitExpression> parse_unit_expression(std::string_view text) {
  const std::string plain = in_plain_letters(text);
  UnitReader reader(plain);
  const std::optional<UnitExpression> out = reader.unit();
  return reader.at_end() ? out : std::nullopt;
}

std::optional<double> size_of_unit_like(std::string_view text, std::string_view name, double size) {
  const std::optional<UnitExpression> found = parse_unit_expression(text), known = parse_unit_expression(name);
  if (!found || !known || !found->has_dimension_of(*known)) return std::nullopt;
  return size * (found->size / known->size);
}

bool is_same_unit(std::string_view one, std::string_view other) {
  constexpr double rounding = 1e-12;
  const std::optional<double> ratio = size_of_unit_like(one, other, 1);
  return ratio && std::abs(*ratio - 1) < rounding;
}

}  // namespace imulab
