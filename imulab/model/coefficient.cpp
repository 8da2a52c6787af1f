#include "imulab/coefficient.hpp"

#include "imulab/core/nearest_name.hpp"
#include "imulab/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace imulab {

namespace {

constexpr std::array<Term, 8> terms_with(Term last) {
  return {Term::offset, Term::matrix, Term::quadratic, Term::cubic, Term::thermal, Term::matrix_thermal1, Term::matrix_thermal2, last};
}
constexpr std::array<Term, 8> accel_terms = terms_with(Term::lever_arm), gyro_terms = terms_with(Term::g_sensitivity);

/// Returns the columns of a term in one row: {first, past the last}.
std::array<int, 2> columns_of(Term term, int row) {
  if (is_vector(term)) return {row, row + 1};
  if (term == Term::thermal) return {1, 4};  // orders; the gauge fixes order 0
  return {0, 3};
}

std::string element_name(Term term, int row, int column) {
  const auto letter = [](int axis) { return std::string(1, "xyz"[axis]); };
  if (term == Term::thermal) return letter(row) + std::to_string(column);
  return is_vector(term) ? letter(row) : letter(row) + letter(column);
}

std::string si_unit_text(Triad triad, Term term, int column) {
  std::string out = triad == Triad::accel ? "m/s^2" : "rad/s";
  switch (term) {
    case Term::offset:
      return out;
    case Term::matrix:
      return "(" + out + ")/raw";
    case Term::quadratic:
      return "(" + out + ")/raw^2";
    case Term::cubic:
      return "(" + out + ")/raw^3";
    case Term::thermal:
      return column == 1 ? "raw/K" : "raw/K^" + std::to_string(column);
    case Term::matrix_thermal1:
      return "1/K";
    case Term::matrix_thermal2:
      return "1/K^2";
    case Term::g_sensitivity:
      return "(rad/s)/(m/s^2)";
    case Term::lever_arm:
      break;
  }
  return "m";
}

/// The rows and their texts.
struct CoefficientTable {
  std::array<std::array<std::string, 2>, coefficient_count> texts;
  std::array<Coefficient, coefficient_count> rows;

  CoefficientTable() {
    std::size_t at = 0;
    for (const Triad triad : {Triad::accel, Triad::gyro})
      for (const Term term : terms_of(triad))
        for (int row = 0; row < 3; ++row)
          for (int column = columns_of(term, row)[0]; column < columns_of(term, row)[1]; ++column, ++at) {
            const std::string name = std::string(to_string(triad)) + "." + std::string(to_string(term)) + "." + element_name(term, row, column);
            texts.at(at) = {name, si_unit_text(triad, term, column)};
            rows.at(at) = {texts[at][0], triad, term, row, column, texts[at][1]};
          }
  }
  CoefficientTable(const CoefficientTable&) = delete;
  CoefficientTable& operator=(const CoefficientTable&) = delete;
};

/// Returns the element of a model (const or not) for a row of the table.
template <class Model>
auto& element(Model& model, const Coefficient& c) {
  auto& triad = c.triad == Triad::accel ? model.accel : model.gyro;
  switch (c.term) {
    case Term::offset:
      return triad.offset(c.row);
    case Term::matrix:
      return triad.matrix(c.row, c.column);
    case Term::quadratic:
      return triad.quadratic(c.row);
    case Term::cubic:
      return triad.cubic(c.row);
    case Term::thermal:
      return triad.thermal(c.row, c.column);
    case Term::matrix_thermal1:
      return triad.matrix_thermal1(c.row, c.column);
    case Term::matrix_thermal2:
      return triad.matrix_thermal2(c.row, c.column);
    case Term::g_sensitivity:
      return model.g_sensitivity(c.row, c.column);
    case Term::lever_arm:
      break;
  }
  return model.lever_arm(c.row, c.column);
}

[[noreturn]] void unknown(std::string_view name) {
  std::vector<std::string_view> names;
  for (const Coefficient& c : coefficient_table()) {
    const std::string_view full = c.name, term = full.substr(0, full.rfind('.'));
    names.push_back(full);
    if (std::find(names.begin(), names.end(), term) == names.end()) names.push_back(term);
  }
  const std::string meant = did_you_mean(name, names);
  throw Error("unknown coefficient \"" + std::string(name) + "\"" +
              (meant.empty() ? "; expected triad.term.element such as gyro.matrix.xy, a term such as accel.offset, or gyro.matrix.diagonal, "
                               "gyro.matrix.off_diagonal"
                             : meant));
}

}  // namespace

std::span<const Coefficient> coefficient_table() {
  static const CoefficientTable table;
  return table.rows;
}

const Coefficient& coefficient(CoefficientIndex index) {
  if (index < 0 || index >= coefficient_count)
    throw Error("coefficient " + std::to_string(index) + " is not in the table; expected 0 to " + std::to_string(coefficient_count - 1));
  return coefficient_table()[static_cast<std::size_t>(index)];
}

std::span<const CoefficientIndex> coefficient_indices() {
  static const auto all = [] {
    std::array<CoefficientIndex, coefficient_count> places;
    for (std::size_t i = 0; i < places.size(); ++i) places[i] = CoefficientIndex(static_cast<int>(i));
    return places;
  }();
  return all;
}

CoefficientIndex coefficient_index(Triad triad, Term term, int row, int column) {
  const auto table = coefficient_table();
  const auto found = std::find_if(table.begin(), table.end(),
                                  [&](const Coefficient& c) { return c.triad == triad && c.term == term && c.row == row && c.column == column; });
  if (found == table.end()) throw Error("no coefficient " + std::string(to_string(triad)) + "." + std::string(to_string(term)) + " at this place");
  return CoefficientIndex(static_cast<int>(found - table.begin()));
}

CoefficientIndex coefficient_index(std::string_view name) {
  const auto table = coefficient_table();
  const auto found = std::find_if(table.begin(), table.end(), [&](const Coefficient& c) { return c.name == name; });
  if (found == table.end()) unknown(name);
  return CoefficientIndex(static_cast<int>(found - table.begin()));
}

namespace {

/// A bias is an offset with the other sign: "gyro.bias.x" selects gyro.offset.x.
std::string without_bias(std::string_view selector) {
  constexpr std::string_view bias = ".bias";
  std::string out(selector);
  if (const std::size_t at = out.find(bias); at != std::string::npos) out.replace(at, bias.size(), ".offset");
  return out;
}

}  // namespace

std::vector<CoefficientIndex> select_coefficients(std::string_view selected_by) {
  const std::string selector = without_bias(selected_by);
  std::vector<CoefficientIndex> selected;
  for (const CoefficientIndex i : coefficient_indices()) {
    const Coefficient& c = coefficient(i);
    const std::string term = std::string(to_string(c.triad)) + "." + std::string(to_string(c.term));
    const bool in_group = !is_vector(c.term) && c.term != Term::thermal && selector == term + (c.row == c.column ? ".diagonal" : ".off_diagonal");
    if (selector == c.name || selector == term || in_group) selected.push_back(i);
  }
  if (selected.empty()) unknown(selected_by);
  return selected;
}

std::vector<CoefficientIndex> select_each(std::initializer_list<std::string_view> selectors) {
  std::vector<CoefficientIndex> indices;
  for (const std::string_view selector : selectors)
    for (const CoefficientIndex index : select_coefficients(selector)) indices.push_back(index);
  return indices;
}

bool contains(const std::vector<CoefficientIndex>& indices, CoefficientIndex index) {
  return std::find(indices.begin(), indices.end(), index) != indices.end();
}

std::vector<std::string> problems_of(const std::vector<CoefficientIndex>& indices) {
  std::vector<std::string> problems;
  std::array<bool, coefficient_count> seen{};
  for (const CoefficientIndex index : indices) {
    const std::size_t before = problems.size();
    collect_problem(problems, [&] { coefficient(index); });
    if (problems.size() == before && std::exchange(seen[static_cast<std::size_t>(index)], true))
      problems.push_back(std::string(coefficient(index).name) + " is listed twice");
  }
  return problems;
}

std::vector<std::string> problems_of(const SensorModel& model) {
  std::vector<std::string> problems;
  for (const CoefficientIndex index : coefficient_indices())
    if (!std::isfinite(coefficient_value(model, index)))
      problems.push_back(std::string(coefficient(index).name) + " is not finite; expected a finite number");
  for (const auto& [triad, m, unit] : {std::tuple{"accel", &model.accel, "m/s^2"}, std::tuple{"gyro", &model.gyro, "rad/s"}}) {
    const auto expect = [&, name = triad](bool good, const std::string& problem) {
      if (!good) problems.push_back(std::string(name) + ": " + problem);
    };
    expect(m->raw_unit.empty() || m->raw_unit == "count" || m->raw_unit == unit,
           "the raw readings are in \"" + m->raw_unit + "\"; expected count or " + unit);
    expect(m->thermal.col(0).isZero(0), "the constant of a thermal polynomial is not 0; expected it in the offset");
    if (!m->temperature) {
      expect(!m->varies(), "the model has thermal terms, but no reference temperature; expected one");
      continue;
    }
    const ThermalReading& t = *m->temperature;
    expect(std::isfinite(t.reference), "the reference temperature is not finite; expected a finite number");
    expect(t.unit == "degC" || t.unit == "K" || t.unit == "raw", "the temperatures are in \"" + t.unit + "\"; expected degC, K or raw");
    expect(t.range[0] <= t.range[1], "the range of the temperatures is not in order; expected [lowest, highest]");
  }
  return problems;
}

double coefficient_value(const SensorModel& model, CoefficientIndex index) { return element(model, coefficient(index)); }

Eigen::VectorXd coefficient_values(const SensorModel& model, const std::vector<CoefficientIndex>& indices) {
  Eigen::VectorXd values(std::ssize(indices));
  std::transform(indices.begin(), indices.end(), values.begin(), [&](CoefficientIndex index) { return coefficient_value(model, index); });
  return values;
}

void set_coefficient(SensorModel& model, CoefficientIndex index, double value) { element(model, coefficient(index)) = value; }

std::span<const Term> terms_of(Triad triad) { return triad == Triad::accel ? accel_terms : gyro_terms; }

bool is_scale(const Coefficient& c) { return c.term == Term::matrix && c.row == c.column; }

bool is_optional(Term term) { return term != Term::offset && term != Term::matrix; }

bool is_vector(Term term) { return term == Term::offset || term == Term::quadratic || term == Term::cubic; }

std::string_view to_string(Triad triad) { return triad == Triad::accel ? "accel" : "gyro"; }

std::string_view to_string(Term term) {
  switch (term) {
    case Term::offset:
      return "offset";
    case Term::matrix:
      return "matrix";
    case Term::quadratic:
      return "quadratic";
    case Term::cubic:
      return "cubic";
    case Term::thermal:
      return "thermal";
    case Term::matrix_thermal1:
      return "matrix_thermal1";
    case Term::matrix_thermal2:
      return "matrix_thermal2";
    case Term::g_sensitivity:
      return "g_sensitivity";
    case Term::lever_arm:
      break;
  }
  return "lever_arm";
}

}  // namespace imulab
