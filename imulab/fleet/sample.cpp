#include "imulab/fleet/sample.hpp"

#include "imulab/core/error.hpp"
#include "imulab/fleet/numbers_of_all.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
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
  fleet::Statement rows(store.database(), fmt::format("SELECT id, unit, station, operator, time FROM calibrations WHERE removed IS NULL {}",
                                                      method.empty() ? "" : "AND method = ?"));
  if (!method.empty()) rows.with(method);
  while (rows.next()) out.push_back({rows.integer(0), rows.integer(1), stations.place(rows.bytes(2)), operators.place(rows.bytes(3)), rows.real(4)});
  std::sort(out.begin(), out.end(),
            [](const SampleRow& a, const SampleRow& b) { return a.time != b.time ? a.time < b.time : a.calibration < b.calibration; });
  return out;
}

/// "name serial" of every unit, by its number.
std::unordered_map<std::int64_t, std::string> unit_titles(FleetStore& store) {
  std::unordered_map<std::int64_t, std::string> out;
  fleet::Statement rows(store.database(), "SELECT id, name, serial FROM units");
  while (rows.next()) out.emplace(rows.integer(0), rows.bytes(2).empty() ? rows.text(1) : fmt::format("{} {}", rows.text(1), rows.text(2)));
  return out;
}

void take_rows(FleetSample& s, const std::vector<SampleRow>& rows, const std::unordered_map<std::int64_t, std::string>& titles) {
  std::unordered_map<std::int64_t, Eigen::Index> units;
  std::vector<Eigen::Index> last;
  s.time.resize(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto [unit, added] = units.emplace(rows[k].unit, static_cast<Eigen::Index>(s.units.size()));
    if (added) {
      const auto title = titles.find(rows[k].unit);
      s.units.push_back(title != titles.end() ? title->second : fmt::format("unit {}", rows[k].unit));
      last.push_back(0);
    }
    last[static_cast<std::size_t>(unit->second)] = static_cast<Eigen::Index>(k);
    s.unit.push_back(unit->second);
    s.station.push_back(rows[k].station), s.operated_by.push_back(rows[k].operated_by);
    s.calibration.push_back(rows[k].calibration);
    s.time[static_cast<Eigen::Index>(k)] = rows[k].time;
  }
  std::sort(last.begin(), last.end());
  s.last = std::move(last);
}

/// Sums of the covariances of last calibrations with one list of coefficients.
struct LayoutSum {
  std::vector<double> triangle;
  double count = 0;
};

/// Every row's numbers in the columns of the whole table; the sums by layout.
struct NumbersScan {
  std::unordered_map<std::int64_t, Eigen::Index> row;
  std::vector<char> is_last;
  Eigen::MatrixXd values, variances;
  std::map<std::vector<CoefficientIndex>, LayoutSum> sums;
  std::array<bool, coefficient_count> any{};
  const std::vector<CoefficientIndex>* known = nullptr;  // the layout of the call before
  LayoutSum* sum = nullptr;

  void take(std::int64_t id, const std::vector<CoefficientIndex>& estimated, std::string_view data) {
    const auto at = row.find(id);
    if (at == row.end()) return;
    const std::size_t n = estimated.size();
    if (known != &estimated) {
      known = &estimated, sum = &sums[estimated];
      sum->triangle.resize(n * (n + 1) / 2);
      for (const CoefficientIndex c : estimated) any[static_cast<std::size_t>(c)] = true;
    }
    for (std::size_t i = 0; i < n; ++i) {
      values(estimated[i], at->second) = fleet::packed_number(data, i);
      variances(estimated[i], at->second) = fleet::packed_number(data, n + i * (i + 1) / 2 + i);
    }
    if (is_last[static_cast<std::size_t>(at->second)] == 0) return;
    sum->count += 1;
    for (std::size_t k = 0; k < sum->triangle.size(); ++k) sum->triangle[k] += fleet::packed_number(data, n + k);
  }
};

/// The coefficients of the most frequent layout, and the mean of its covariances.
void take_common(FleetSample& s, const NumbersScan& scan) {
  const auto most =
      std::max_element(scan.sums.begin(), scan.sums.end(), [](const auto& a, const auto& b) { return a.second.count < b.second.count; });
  if (most == scan.sums.end() || most->second.count == 0) return;
  const std::vector<CoefficientIndex>& layout = most->first;
  const LayoutSum& sum = most->second;
  const auto n = static_cast<Eigen::Index>(layout.size());
  Eigen::MatrixXd mean(n, n);
  for (Eigen::Index i = 0, k = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j, ++k) mean(i, j) = mean(j, i) = sum.triangle[static_cast<std::size_t>(k)] / sum.count;
  std::vector<Eigen::Index> order(layout.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](Eigen::Index a, Eigen::Index b) { return layout[static_cast<std::size_t>(a)] < layout[static_cast<std::size_t>(b)]; });
  s.mean_covariance = mean(order, order);
  for (const Eigen::Index k : order)
    s.common.push_back(std::find(s.coefficients.begin(), s.coefficients.end(), layout[static_cast<std::size_t>(k)]) - s.coefficients.begin());
}

std::vector<CoefficientIndex> common_coefficients(const FleetSample& s) {
  std::vector<CoefficientIndex> out;
  for (const Eigen::Index k : s.common) out.push_back(s.coefficients[static_cast<std::size_t>(k)]);
  return out;
}

}  // namespace

FleetSample load_sample(FleetStore& store, const std::string& method) {
  FleetSample s;
  NumberedNames stations, operators;
  const std::vector<SampleRow> rows = rows_of(store, method, stations, operators);
  if (rows.empty())
    throw Error(
        fmt::format("{}: has no calibration{}; expected one at least", store.database().file(), method.empty() ? "" : " by the method " + method));
  take_rows(s, rows, unit_titles(store));
  s.stations = std::move(stations.names), s.operators = std::move(operators.names);
  const auto count = static_cast<Eigen::Index>(rows.size());
  NumbersScan scan;
  scan.is_last.resize(rows.size());
  for (const Eigen::Index k : s.last) scan.is_last[static_cast<std::size_t>(k)] = 1;
  for (Eigen::Index k = 0; k < count; ++k) scan.row[s.calibration[static_cast<std::size_t>(k)]] = k;
  scan.values.setConstant(coefficient_count, count, std::numeric_limits<double>::quiet_NaN());
  scan.variances = scan.values;
  fleet::each_numbers(
      store, [&](std::int64_t id, const std::vector<CoefficientIndex>& estimated, std::string_view data) { scan.take(id, estimated, data); });
  std::vector<Eigen::Index> columns;
  for (const CoefficientIndex index : coefficient_indices())
    if (scan.any[static_cast<std::size_t>(index)]) s.coefficients.push_back(index), columns.push_back(index);
  s.values = scan.values(columns, Eigen::all).transpose();
  s.variances = scan.variances(columns, Eigen::all).transpose();
  const std::string damaged = store.database().file() + ": a number is damaged; imulab fleet check names all that are";
  for (Eigen::Index i = 0; i < s.values.size(); ++i) {
    const double value = s.values.data()[i], variance = s.variances.data()[i];
    if (std::isnan(value) && std::isnan(variance)) continue;
    if (!std::isfinite(value) || !(variance > 0) || !std::isfinite(variance)) throw Error(damaged);
  }
  take_common(s, scan);
  return s;
}

namespace {

/// Of the calibration in a row, of the sample's common columns; NaN where it has none.
std::function<Eigen::MatrixXd(Eigen::Index row)> covariances_of(FleetStore& store, const FleetSample& sample) {
  return [&store, calibration = sample.calibration, columns = common_coefficients(sample)](Eigen::Index row) {
    const fleet::Numbers numbers = fleet::numbers_of(store, calibration[static_cast<std::size_t>(row)]);
    const auto p = static_cast<Eigen::Index>(columns.size());
    Eigen::MatrixXd out = Eigen::MatrixXd::Constant(p, p, std::numeric_limits<double>::quiet_NaN());
    std::vector<Eigen::Index> place, from;
    for (Eigen::Index k = 0; k < p; ++k) {
      const auto found = std::find(numbers.estimated.begin(), numbers.estimated.end(), columns[static_cast<std::size_t>(k)]);
      if (found != numbers.estimated.end()) place.push_back(k), from.push_back(found - numbers.estimated.begin());
    }
    out(place, place) = numbers.covariance(from, from);
    return out;
  };
}

}  // namespace

FleetStatistics fleet_statistics(FleetStore& store, const FleetOptions& options, const std::string& method) {
  FleetSample sample = load_sample(store, method);
  const auto covariance = covariances_of(store, sample);
  return fleet_statistics(std::move(sample), covariance, options);
}

FleetPrior fleet_prior(FleetStore& store) {
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
