#include "imulab/fleet/store/sample.hpp"

#include "imulab/core/error.hpp"
#include "imulab/formats/text/decimal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
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

struct UnitTitle {
  std::string title, serial;  // "name serial"
};

/// Of every unit, by its number.
std::unordered_map<std::int64_t, UnitTitle> unit_titles(FleetStore& store) {
  std::unordered_map<std::int64_t, UnitTitle> out;
  fleet::Statement rows(store.database(), "SELECT id, name, serial FROM units");
  while (rows.next()) {
    const bool named = rows.bytes(2).empty();
    out.emplace(rows.integer(0),
                named ? UnitTitle{rows.text(1), rows.text(1)} : UnitTitle{fmt::format("{} {}", rows.text(1), rows.text(2)), rows.text(2)});
  }
  return out;
}

void take_rows(FleetSample& s, const std::vector<SampleRow>& rows, const std::unordered_map<std::int64_t, UnitTitle>& titles) {
  std::unordered_map<std::int64_t, Eigen::Index> units;
  std::vector<Eigen::Index> last;
  s.time.resize(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto [unit, added] = units.emplace(rows[k].unit, static_cast<Eigen::Index>(s.units.size()));
    if (added) {
      const auto title = titles.find(rows[k].unit);
      s.units.push_back(title != titles.end() ? title->second.title : fmt::format("unit {}", rows[k].unit));
      s.serials.push_back(title != titles.end() ? title->second.serial : s.units.back());
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

/// True if only the prior sets a value. The prior of an optional term is zero, and a term that the data say nothing of stays there. It does so to
/// rounding where the accelerometers' frame turns it together with others.
bool is_prior_alone(CoefficientIndex index, double value, double variance) {
  constexpr double rounding = 1e-5;  // of the uncertainty: a value that is measured is that close to zero once in 100,000 times
  return is_optional(coefficient(index).term) && std::isfinite(variance) && std::abs(value) <= rounding * std::sqrt(variance);
}

/// Every row's numbers in the columns of the whole table.
struct NumbersScan {
  std::unordered_map<std::int64_t, Eigen::Index> row;
  Eigen::MatrixXd values, variances;
  std::array<bool, coefficient_count> any{}, left_to_prior{};

  void take(std::int64_t id, const std::vector<CoefficientIndex>& estimated, std::string_view data) {
    const auto at = row.find(id);
    if (at == row.end()) return;
    const std::size_t n = estimated.size();
    for (std::size_t i = 0; i < n; ++i) {
      const CoefficientIndex index = estimated[i];
      const double value = fleet::packed_number(data, i), variance = fleet::packed_number(data, n + i * (i + 1) / 2 + i);
      const bool by_prior = is_prior_alone(index, value, variance);
      (by_prior ? left_to_prior : any)[static_cast<std::size_t>(index)] = true;
      if (by_prior) continue;
      values(index, at->second) = value;
      variances(index, at->second) = variance;
    }
  }
};

/// Columns that at least half of the last calibrations have together: of those that half have each, without the rarest until this holds.
std::vector<Eigen::Index> common_columns(const FleetSample& s) {
  const Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> has = !Eigen::MatrixXd(s.values(s.last, Eigen::all)).array().isNaN();
  const auto half = [&](Eigen::Index count) { return 2 * count >= has.rows(); };
  std::vector<Eigen::Index> columns;
  for (Eigen::Index k = 0; k < has.cols(); ++k)
    if (half(has.col(k).count())) columns.push_back(k);
  const auto together = [&] {
    Eigen::Array<bool, Eigen::Dynamic, 1> all = Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(has.rows(), true);
    for (const Eigen::Index k : columns) all = all && has.col(k);
    return all.count();
  };
  while (!half(together()))
    columns.erase(std::min_element(columns.begin(), columns.end(), [&](auto a, auto b) { return has.col(a).count() < has.col(b).count(); }));
  return columns;
}

std::vector<CoefficientIndex> common_coefficients(const FleetSample& s) {
  std::vector<CoefficientIndex> out;
  for (const Eigen::Index k : s.common) out.push_back(s.coefficients[static_cast<std::size_t>(k)]);
  return out;
}

/// The mean of the covariances of the common columns, over the last calibrations that have them all.
Eigen::MatrixXd mean_covariance_of(FleetStore& store, const FleetSample& s, const std::unordered_map<std::int64_t, Eigen::Index>& row_of) {
  std::vector<char> counts(s.calibration.size());
  for (const Eigen::Index row : s.last) counts[static_cast<std::size_t>(row)] = !s.values(row, s.common).array().isNaN().any();
  const std::vector<CoefficientIndex> common = common_coefficients(s);
  const auto p = static_cast<Eigen::Index>(common.size());
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(p, p);
  double units = 0;
  const std::vector<CoefficientIndex>* known = nullptr;  // the layout of the call before, and where it has the common ones
  std::vector<std::size_t> place(common.size());
  fleet::each_numbers(store, [&](std::int64_t id, const std::vector<CoefficientIndex>& estimated, std::string_view data) {
    const auto at = row_of.find(id);
    if (at == row_of.end() || counts[static_cast<std::size_t>(at->second)] == 0) return;
    if (known != &estimated)
      std::transform(common.begin(), common.end(), place.begin(), [&](CoefficientIndex index) {
        return static_cast<std::size_t>(std::find(estimated.begin(), estimated.end(), index) - estimated.begin());
      });
    known = &estimated;
    units += 1;
    for (Eigen::Index i = 0; i < p; ++i)
      for (Eigen::Index j = 0; j <= i; ++j) {
        const auto [low, high] = std::minmax(place[static_cast<std::size_t>(i)], place[static_cast<std::size_t>(j)]);
        sum(i, j) += fleet::packed_number(data, estimated.size() + high * (high + 1) / 2 + low);
      }
  });
  return Eigen::MatrixXd(sum.selfadjointView<Eigen::Lower>()) / units;
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
  for (Eigen::Index k = 0; k < count; ++k) scan.row[s.calibration[static_cast<std::size_t>(k)]] = k;
  scan.values.setConstant(coefficient_count, count, std::numeric_limits<double>::quiet_NaN());
  scan.variances = scan.values;
  fleet::each_numbers(
      store, [&](std::int64_t id, const std::vector<CoefficientIndex>& estimated, std::string_view data) { scan.take(id, estimated, data); });
  std::vector<Eigen::Index> columns;
  for (const CoefficientIndex index : coefficient_indices()) {
    if (scan.any[static_cast<std::size_t>(index)])
      s.coefficients.push_back(index), columns.push_back(index);
    else if (scan.left_to_prior[static_cast<std::size_t>(index)])
      s.left_out.push_back(index);
  }
  s.values = scan.values(columns, Eigen::all).transpose();
  s.variances = scan.variances(columns, Eigen::all).transpose();
  const std::string damaged = store.database().file() + ": a number is damaged; imulab fleet check names all that are";
  for (Eigen::Index i = 0; i < s.values.size(); ++i) {
    const double value = s.values.data()[i], variance = s.variances.data()[i];
    if (std::isnan(value) && std::isnan(variance)) continue;
    if (!std::isfinite(value) || !(variance > 0) || !std::isfinite(variance)) throw Error(damaged);
  }
  s.common = common_columns(s);
  s.mean_covariance = mean_covariance_of(store, s, scan.row);
  return s;
}

namespace {

/// The covariance of the calibration in a row, of the sample's common columns; NaN where it has none.
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

namespace imulab::fleet {

namespace {

/// The coefficients of the rows' layouts.
std::map<std::int64_t, std::vector<CoefficientIndex>> layouts_of(Database& db) {
  std::map<std::int64_t, std::vector<CoefficientIndex>> out;
  for (Statement rows(db, "SELECT id, coefficients FROM layouts"); rows.next();)
    out[rows.integer(0)] = errors_at(db.file() + ": layout", [&] { return parse_layout(rows.bytes(1)); });
  return out;
}

void each_row(Database& db, const std::string& condition,
              const std::function<void(std::int64_t, const std::vector<CoefficientIndex>&, std::string_view)>& sink) {
  const auto layouts = layouts_of(db);
  for (Statement rows(db, "SELECT n.calibration, n.layout, n.data FROM numbers n " + condition); rows.next();) {
    const auto layout = layouts.find(rows.integer(1));
    if (layout == layouts.end() || rows.bytes(2).size() != packed_size(layout->second.size()))
      throw Error(fmt::format("{}: the numbers of calibration {} are damaged; imulab fleet check names all that is", db.file(), rows.integer(0)));
    sink(rows.integer(0), layout->second, rows.bytes(2));
  }
}

/// In quotes where it has to be.
std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::vector<CoefficientIndex> estimated_by_any(Database& db) {
  std::array<bool, coefficient_count> any{};
  for (const auto& [id, layout] : layouts_of(db))
    for (const CoefficientIndex index : layout) any[static_cast<std::size_t>(index)] = true;
  std::vector<CoefficientIndex> out;
  for (const CoefficientIndex index : coefficient_indices())
    if (any[static_cast<std::size_t>(index)]) out.push_back(index);
  return out;
}

}  // namespace

void each_numbers(FleetStore& store, const std::function<void(std::int64_t, const std::vector<CoefficientIndex>&, std::string_view)>& sink) {
  each_row(store.database(), "WHERE n.calibration NOT IN (SELECT id FROM calibrations WHERE removed IS NOT NULL) ORDER BY n.calibration", sink);
}

Numbers numbers_of(FleetStore& store, std::int64_t calibration) {
  Numbers out;
  each_row(store.database(), fmt::format("WHERE n.calibration = {}", calibration),
           [&](std::int64_t, const std::vector<CoefficientIndex>& estimated, std::string_view data) { out = unpacked(data, estimated); });
  if (out.estimated.empty()) throw Error(fmt::format("{}: has no calibration {}", store.database().file(), calibration));
  return out;
}

std::string fleet_csv(FleetStore& store) {
  std::map<std::int64_t, FleetRecord> records;
  for (FleetRecord& r : store.records()) records[r.id] = std::move(r);
  const std::vector<CoefficientIndex> columns = estimated_by_any(store.database());
  std::string csv = "calibration,serial,name,time,time_from,station,operator,method,options,verdict";
  for (const CoefficientIndex index : columns) csv += fmt::format(",{0},u({0})", coefficient(index).name);
  csv += "\n";
  each_numbers(store, [&](std::int64_t id, const std::vector<CoefficientIndex>& estimated, std::string_view data) {
    const FleetRecord& r = records[id];
    csv += fmt::format("{},{},{},{},{},{},{},{},{},{}", id, csv_text(r.serial), csv_text(r.name), time_text(r.occasion.time), r.occasion.time_from,
                       csv_text(r.occasion.station), csv_text(r.occasion.operated_by), csv_text(r.method), csv_text(r.options), csv_text(r.verdict));
    std::array<std::size_t, coefficient_count> place{};
    for (std::size_t i = 0; i < estimated.size(); ++i) place[static_cast<std::size_t>(estimated[i])] = i + 1;
    const std::size_t n = estimated.size();
    for (const CoefficientIndex index : columns) {
      const std::size_t i = place[static_cast<std::size_t>(index)];
      if (i == 0)
        csv += ",,";
      else
        csv += fmt::format(",{},{}", packed_number(data, i - 1), std::sqrt(packed_number(data, n + (i - 1) * i / 2 + i - 1)));
    }
    csv += "\n";
  });
  return csv;
}

}  // namespace imulab::fleet
