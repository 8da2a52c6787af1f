#include "imulab/fleet/store/sample.hpp"

#include "imulab/error.hpp"
#include "imulab/fleet.hpp"
#include "imulab/fleet/store/database.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <unordered_map>
#include <utility>

namespace imulab {

namespace {

/// A calibration's row without its numbers.
struct SampleRow {
  std::int64_t calibration, unit;
  Eigen::Index station, operated_by;
  double time;
};

/// The methods of the rows are one, by which what a calibration cannot know of a unit is the same in the next.
bool is_of_one_method(FleetStore& store, const std::string& method) {
  return !method.empty() || store.database().number("SELECT COUNT(DISTINCT method) FROM calibrations WHERE removed IS NULL") == 1;
}

/// Texts as numbers from 0.
struct NumberedNames {
  std::vector<std::string> names;
  std::map<std::string, Eigen::Index, std::less<>> places;
  Eigen::Index place(std::string_view name) {
    const auto found = places.find(name);
    if (found != places.end()) return found->second;
    names.emplace_back(name);
    return places[names.back()] = static_cast<Eigen::Index>(names.size()) - 1;
  }
};

std::vector<SampleRow> rows_of(FleetStore& store, const std::string& method, NumberedNames& stations, NumberedNames& operators) {
  std::vector<SampleRow> out;
  fleet::Statement rows(store.database(),
                        fmt::format("SELECT id, unit, station, operator, time FROM calibrations WHERE removed IS NULL {} ORDER BY id",
                                    method.empty() ? "" : "AND method = ?"));
  if (!method.empty()) rows.with(method);
  while (rows.next()) out.push_back({rows.integer(0), rows.integer(1), stations.place(rows.bytes(2)), operators.place(rows.bytes(3)), rows.real(4)});
  std::sort(out.begin(), out.end(),
            [](const SampleRow& a, const SampleRow& b) { return a.time != b.time ? a.time < b.time : a.calibration < b.calibration; });
  return out;
}

/// Titles "name serial" and serial numbers of the sample's units; `places`: theirs, by the numbers in the store.
void take_titles(FleetSample& s, FleetStore& store, const std::unordered_map<std::int64_t, Eigen::Index>& places) {
  for (const auto& [id, place] : places)
    s.units[static_cast<std::size_t>(place)] = s.serials[static_cast<std::size_t>(place)] = fmt::format("unit {}", id);
  fleet::Statement rows(store.database(), "SELECT id, name, serial FROM units");
  while (rows.next()) {
    const auto at = places.find(rows.integer(0));
    if (at == places.end()) continue;
    const auto place = static_cast<std::size_t>(at->second);
    const bool named = rows.bytes(2).empty();
    s.units[place] = named ? rows.text(1) : fmt::format("{} {}", rows.bytes(1), rows.bytes(2));
    s.serials[place] = rows.text(named ? 1 : 2);
  }
}

void take_rows(FleetSample& s, const std::vector<SampleRow>& rows, FleetStore& store) {
  std::unordered_map<std::int64_t, Eigen::Index> units;
  s.time.resize(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto [unit, added] = units.emplace(rows[k].unit, static_cast<Eigen::Index>(units.size()));
    if (added) s.last.push_back(0);
    s.last[static_cast<std::size_t>(unit->second)] = static_cast<Eigen::Index>(k);
    s.unit.push_back(unit->second);
    s.station.push_back(rows[k].station), s.operated_by.push_back(rows[k].operated_by);
    s.calibration.push_back(rows[k].calibration);
    s.time[static_cast<Eigen::Index>(k)] = rows[k].time;
  }
  std::sort(s.last.begin(), s.last.end());
  s.units.resize(units.size()), s.serials.resize(units.size());
  take_titles(s, store, units);
}

/// The rows of the sample by the numbers of their calibrations, in whose order the store is read.
class RowFinder {
 public:
  explicit RowFinder(const std::vector<std::int64_t>& calibration) : calibration_(calibration), order_(calibration.size()) {
    std::iota(order_.begin(), order_.end(), Eigen::Index{0});
    std::sort(order_.begin(), order_.end(), [&](auto a, auto b) { return at(a) < at(b); });
  }
  /// -1: the sample has not this one. The numbers that are asked for rise.
  Eigen::Index row(std::int64_t calibration) {
    while (next_ < order_.size() && at(order_[next_]) < calibration) ++next_;
    return next_ < order_.size() && at(order_[next_]) == calibration ? order_[next_] : -1;
  }
  void begin_again() { next_ = 0; }

 private:
  std::int64_t at(Eigen::Index row) const { return calibration_[static_cast<std::size_t>(row)]; }
  const std::vector<std::int64_t>& calibration_;
  std::vector<Eigen::Index> order_;
  std::size_t next_ = 0;
};

/// True if only the prior sets a value. The prior of an optional term is zero, and a term that the data say nothing of stays there. It does so to
/// rounding where the accelerometers' frame turns it together with others.
bool is_prior_alone(CoefficientIndex index, double value, double variance) {
  constexpr double rounding = 1e-5;  // of the uncertainty: a value that is measured is that close to zero once in 100,000 times
  return is_optional(coefficient(index).term) && std::isfinite(variance) && std::abs(value) <= rounding * std::sqrt(variance);
}

/// The covariances of those last calibrations that have the coefficients of the first one, added up while the values are read: often these are all.
struct CovarianceSum {
  std::vector<CoefficientIndex> estimated;
  std::bitset<coefficient_count> has;
  std::vector<double> triangle;
  std::ptrdiff_t units = 0;

  void add(const std::vector<CoefficientIndex>& its, const std::bitset<coefficient_count>& its_has, std::string_view data) {
    const std::size_t n = its.size();
    if (estimated.empty()) estimated = its, has = its_has, triangle.assign(n * (n + 1) / 2, 0);
    if (estimated != its || has != its_has) return;
    for (std::size_t k = 0; k < triangle.size(); ++k) triangle[k] += fleet::packed_number(data, n + k);
    units += 1;
  }
};

/// Takes values and variances of all calibrations from the store into columns, which are all that is kept of them: 16 bytes a number, 24 with
/// constant variances.
void take_numbers(FleetSample& s, FleetStore& store, RowFinder& rows, CovarianceSum& sum, bool one_method) {
  std::vector<bool> is_last(s.calibration.size());
  for (const Eigen::Index row : s.last) is_last[static_cast<std::size_t>(row)] = true;
  const std::vector<CoefficientIndex> possible = fleet::estimated_by_any(store);
  std::array<Eigen::Index, coefficient_count> column{};
  for (std::size_t k = 0; k < possible.size(); ++k) column[static_cast<std::size_t>(possible[k])] = static_cast<Eigen::Index>(k);
  s.values.setConstant(s.time.size(), std::ssize(possible), std::numeric_limits<double>::quiet_NaN());
  s.variances = s.values;
  std::array<bool, coefficient_count> any{}, left_to_prior{};
  fleet::each_numbers(store, [&](std::int64_t id, const std::vector<CoefficientIndex>& estimated, std::string_view data) {
    const Eigen::Index row = rows.row(id);
    if (row < 0) return;
    const std::size_t n = estimated.size();
    std::bitset<coefficient_count> has;
    for (std::size_t i = 0; i < n; ++i) {
      const auto index = static_cast<std::size_t>(estimated[i]);
      const double value = fleet::packed_number(data, i), variance = fleet::packed_number(data, n + i * (i + 1) / 2 + i);
      const bool by_prior = is_prior_alone(estimated[i], value, variance);
      (by_prior ? left_to_prior : any)[index] = true;
      if (by_prior) continue;
      if (!std::isfinite(value) || !(variance > 0) || !std::isfinite(variance))
        throw Error(store.database().file() + ": a number is damaged; imulab fleet check names all that are");
      s.values(row, column[index]) = value, s.variances(row, column[index]) = variance;
      if (one_method && data.size() > sizeof(double) * fleet::packed_numbers(n)) {
        if (s.constant_variances.size() == 0) s.constant_variances.setZero(s.values.rows(), s.values.cols());
        s.constant_variances(row, column[index]) = fleet::packed_number(data, fleet::packed_numbers(n) + i);
      }
      has.set(index);
    }
    if (is_last[static_cast<std::size_t>(row)]) sum.add(estimated, has, data);
  });
  std::vector<Eigen::MatrixXd*> tables{&s.values, &s.variances};
  if (s.constant_variances.size() > 0) tables.push_back(&s.constant_variances);
  Eigen::Index used = 0;
  for (std::size_t k = 0; k < possible.size(); ++k) {
    const auto from = static_cast<Eigen::Index>(k);
    if (any[static_cast<std::size_t>(possible[k])]) {
      s.coefficients.push_back(possible[k]);
      for (Eigen::MatrixXd* const table : tables)
        if (used != from) table->col(used) = table->col(from);
      ++used;
    } else if (left_to_prior[static_cast<std::size_t>(possible[k])]) {
      s.left_out.push_back(possible[k]);
    }
  }
  for (Eigen::MatrixXd* const table : tables) table->conservativeResize(Eigen::NoChange, used);
}

/// Columns that at least half of the last calibrations have together: of those that half have each, without the rarest until this holds.
std::vector<Eigen::Index> common_columns(const FleetSample& s) {
  const auto has = [&](Eigen::Index row, Eigen::Index column) { return !std::isnan(s.values(row, column)); };
  const auto half = [&](std::ptrdiff_t count) { return 2 * count >= std::ssize(s.last); };
  std::vector<std::ptrdiff_t> count(s.coefficients.size());
  std::vector<Eigen::Index> columns;
  for (std::size_t k = 0; k < count.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    count[k] = std::count_if(s.last.begin(), s.last.end(), [&](Eigen::Index row) { return has(row, column); });
    if (half(count[k])) columns.push_back(column);
  }
  const auto all = [&](Eigen::Index row) { return std::all_of(columns.begin(), columns.end(), [&](auto column) { return has(row, column); }); };
  while (!half(std::count_if(s.last.begin(), s.last.end(), all)))
    columns.erase(std::min_element(columns.begin(), columns.end(),
                                   [&](auto a, auto b) { return count[static_cast<std::size_t>(a)] < count[static_cast<std::size_t>(b)]; }));
  return columns;
}

std::vector<CoefficientIndex> common_coefficients(const FleetSample& s) {
  std::vector<CoefficientIndex> out;
  for (const Eigen::Index k : s.common) out.push_back(s.coefficients[static_cast<std::size_t>(k)]);
  return out;
}

/// Covariances of these coefficients in a calibration's packed numbers, added to the lower triangle.
class TriangleSum {
 public:
  explicit TriangleSum(const std::vector<CoefficientIndex>& common) : common_(common), place_(common.size()) {
    sum_.setZero(std::ssize(common), std::ssize(common));
  }
  /// `number`: of the packed triangle, by its place.
  template <class Number>
  void add(const std::vector<CoefficientIndex>& estimated, const Number& number) {
    if (known_ != estimated) {
      known_ = estimated;
      std::transform(common_.begin(), common_.end(), place_.begin(), [&](CoefficientIndex index) {
        return static_cast<std::size_t>(std::find(estimated.begin(), estimated.end(), index) - estimated.begin());
      });
    }
    for (Eigen::Index i = 0; i < sum_.rows(); ++i)
      for (Eigen::Index j = 0; j <= i; ++j) {
        const auto [low, high] = std::minmax(place_[static_cast<std::size_t>(i)], place_[static_cast<std::size_t>(j)]);
        sum_(i, j) += number(high * (high + 1) / 2 + low);
      }
  }
  Eigen::MatrixXd over(std::ptrdiff_t units) const { return Eigen::MatrixXd(sum_.selfadjointView<Eigen::Lower>()) / static_cast<double>(units); }

 private:
  std::vector<CoefficientIndex> common_, known_;  // known_: of the call before, with their places
  std::vector<std::size_t> place_;
  Eigen::MatrixXd sum_;
};

/// The mean of the covariances of the common columns, over the last calibrations that have them all.
Eigen::MatrixXd mean_covariance_of(FleetStore& store, const FleetSample& s, RowFinder& rows, const CovarianceSum& known) {
  std::vector<bool> counts(s.calibration.size());
  for (const Eigen::Index row : s.last)
    counts[static_cast<std::size_t>(row)] =
        std::none_of(s.common.begin(), s.common.end(), [&](Eigen::Index column) { return std::isnan(s.values(row, column)); });
  const std::vector<CoefficientIndex> common = common_coefficients(s);
  const std::ptrdiff_t units = std::count(counts.begin(), counts.end(), true);
  TriangleSum sum(common);
  if (units == known.units && std::all_of(common.begin(), common.end(), [&](auto index) { return known.has[static_cast<std::size_t>(index)]; })) {
    sum.add(known.estimated, [&](std::size_t place) { return known.triangle[place]; });
    return sum.over(units);
  }
  rows.begin_again();
  fleet::each_numbers(store, [&](std::int64_t id, const std::vector<CoefficientIndex>& estimated, std::string_view data) {
    const Eigen::Index row = rows.row(id);
    if (row >= 0 && counts[static_cast<std::size_t>(row)])
      sum.add(estimated, [&](std::size_t place) { return fleet::packed_number(data, estimated.size() + place); });
  });
  return sum.over(units);
}

}  // namespace

FleetSample load_sample(FleetStore& store, const std::string& method) {
  FleetSample s;
  NumberedNames stations, operators;
  const std::vector<SampleRow> rows = rows_of(store, method, stations, operators);
  if (rows.empty())
    throw Error(
        fmt::format("{}: has no calibration{}; expected one at least", store.database().file(), method.empty() ? "" : " by the method " + method));
  take_rows(s, rows, store);
  s.stations = std::move(stations.names), s.operators = std::move(operators.names);
  RowFinder by_number(s.calibration);
  CovarianceSum sum;
  take_numbers(s, store, by_number, sum, is_of_one_method(store, method));
  s.common = common_columns(s);
  s.mean_covariance = mean_covariance_of(store, s, by_number, sum);
  return s;
}

namespace {

/// Reads the covariances of calibrations by one statement.
class CovarianceReader {
 public:
  CovarianceReader(FleetStore& store, const FleetSample& sample)
      : calibration_(sample.calibration),
        layouts_(fleet::layouts_of(store)),
        columns_(common_coefficients(sample)),
        store_(store),
        statement_(store.database(), "SELECT layout, data FROM numbers WHERE calibration = ?") {}

  /// Of the sample's common columns; NaN where the calibration in this row has none.
  Eigen::MatrixXd of_row(Eigen::Index row) {
    const std::int64_t id = calibration_[static_cast<std::size_t>(row)];
    if (!statement_.with(id).next()) throw Error(fmt::format("{}: has no calibration {}", store_.database().file(), id));
    const std::vector<CoefficientIndex>& estimated = fleet::expect_numbers(store_, layouts_, id, statement_.integer(0), statement_.bytes(1));
    if (known_ != &estimated) take_places(estimated);
    const auto p = std::ssize(columns_);
    const std::string_view data = statement_.bytes(1);
    Eigen::MatrixXd out = Eigen::MatrixXd::Constant(p, p, std::numeric_limits<double>::quiet_NaN());
    for (Eigen::Index i = 0; i < p; ++i)
      for (Eigen::Index j = 0; j <= i; ++j) {
        const auto [low, high] = std::minmax(place_[static_cast<std::size_t>(i)], place_[static_cast<std::size_t>(j)]);
        if (high < estimated.size()) out(i, j) = out(j, i) = fleet::packed_number(data, estimated.size() + high * (high + 1) / 2 + low);
      }
    statement_.reset();
    return out;
  }

 private:
  void take_places(const std::vector<CoefficientIndex>& estimated) {
    known_ = &estimated;
    place_.clear();
    for (const CoefficientIndex index : columns_)
      place_.push_back(static_cast<std::size_t>(std::find(estimated.begin(), estimated.end(), index) - estimated.begin()));
  }

  std::vector<std::int64_t> calibration_;
  fleet::Layouts layouts_;
  std::vector<CoefficientIndex> columns_;
  const std::vector<CoefficientIndex>* known_ = nullptr;  // the layout of the call before, and where it has the columns
  std::vector<std::size_t> place_;
  FleetStore& store_;
  fleet::Statement statement_;
};

std::function<Eigen::MatrixXd(Eigen::Index row)> covariances_of(FleetStore& store, const FleetSample& sample) {
  return [reader = std::make_shared<CovarianceReader>(store, sample)](Eigen::Index row) { return reader->of_row(row); };
}

}  // namespace

FleetStatistics fleet_statistics(FleetStore& store, const FleetOptions& options, const std::string& method) {
  const fleet::Snapshot one_state(store.database());
  FleetSample sample = load_sample(store, method);
  const auto covariance = covariances_of(store, sample);
  return fleet_statistics(std::move(sample), covariance, options);
}

FleetPrior fleet_prior(FleetStore& store) {
  const fleet::Snapshot one_state(store.database());
  const FleetSample sample = load_sample(store);
  const std::string& file = store.database().file();
  FleetPrior prior = [&] {
    try {
      return fleet_prior(sample, covariances_of(store, sample));
    } catch (const Error& e) {
      throw Error(fmt::format("{}: {}", file, e.what()));
    }
  }();
  prior.fleet = file;
  fleet::Statement kinds(store.database(),
                         "SELECT DISTINCT u.accel_unit, u.gyro_unit FROM units u JOIN calibrations c ON c.unit = u.id WHERE c.removed IS NULL");
  kinds.next();
  prior.accel_unit = kinds.text(0), prior.gyro_unit = kinds.text(1);
  if (kinds.next()) throw Error(file + ": has units with readings in counts and others in SI; expected one kind of unit for a prior");
  return prior;
}

}  // namespace imulab
