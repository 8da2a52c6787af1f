#include "imulab/formats/recording/parts.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/recording/clock.hpp"
#include "imulab/recording/integers.hpp"
#include "imulab/recording/readings.hpp"
#include "imulab/recording/resampling.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <utility>

namespace imulab::recording_io {
namespace {

constexpr auto none = static_cast<std::size_t>(-1);

/// The columns of which one is the sum: "userAcceleration.x + gravity.x".
std::vector<Column> terms_of(const Column& column) {
  const std::string* const name = std::get_if<std::string>(&column);
  if (name == nullptr) return {column};
  std::vector<Column> terms;
  std::size_t begin = 0;
  for (std::size_t end = name->find(sum_sign); end != std::string::npos; end = name->find(sum_sign, begin)) {
    terms.emplace_back(name->substr(begin, end - begin));
    begin = end + sum_sign.size();
  }
  terms.emplace_back(name->substr(begin));
  return terms;
}

/// A triad or thermometer, which may name a file, topic and clock of its own.
template <class Source>
PartColumns request(std::vector<PartRequest>& requests, const RecordingSource& recording, const Source& source) {
  const PartRequest own{
      source.file.value_or(recording.file), source.topic.value_or(source.file ? "" : recording.topic), source.time.value_or(recording.time), {}};
  auto part = std::find_if(requests.begin(), requests.end(),
                           [&](const PartRequest& r) { return r.file == own.file && r.topic == own.topic && r.time == own.time; });
  if (part == requests.end()) part = requests.insert(requests.end(), own);
  PartColumns which{static_cast<std::size_t>(part - requests.begin()), {}, {}};
  for (const Column& column : source.columns) {
    const std::vector<Column> terms = terms_of(column);
    which.terms.push_back(terms.size());
    for (const Column& term : terms) {
      which.columns.push_back(part->columns.size());
      part->columns.push_back(term);
    }
  }
  return which;
}

/// For each row of `a` the row of `b` with the nearest stamp, where it is at most `reach` away and `a`'s row is the nearest to it as well.
std::vector<std::size_t> partners(const std::vector<std::int64_t>& a, const std::vector<std::int64_t>& b, std::int64_t reach) {
  std::vector<std::size_t> partner(a.size(), none);
  std::size_t j = 0;
  for (std::size_t i = 0; i < a.size() && j < b.size(); ++i) {
    const auto away = [&](std::size_t row_a, std::size_t row_b) { return std::abs(a[row_a] - b[row_b]); };
    while (j + 1 < b.size() && away(i, j + 1) < away(i, j)) ++j;
    if (away(i, j) > reach || (i + 1 < a.size() && away(i + 1, j) < away(i, j))) continue;
    partner[i] = j++;
  }
  return partner;
}

template <class T>
void gather(std::vector<T>& column, const std::vector<std::size_t>& rows) {  // rows ascend, so a row never moves down
  for (std::size_t k = 0; k < rows.size(); ++k) column[k] = column[rows[k]];
  column.resize(rows.size());
}

void keep_rows(TableRows& table, const std::vector<std::size_t>& rows) {
  if (rows.size() == table.time_ns.size()) return;
  LineNumbers lines;
  for (std::size_t k = 0; k < rows.size(); ++k) lines.add(k, table.lines[rows[k]]);
  table.lines = std::move(lines);
  gather(table.time_ns, rows);
  for (RawColumn& column : table.columns) gather(column.numbers, rows);
}

}  // namespace

void leave_out_lines(TableRows& table, std::size_t rows, const std::vector<std::size_t>& left_out) {
  LineNumbers lines;
  for (std::size_t i = 0, k = 0, next = 0; i < rows; ++i) {
    if (next < left_out.size() && left_out[next] == i)
      ++next;
    else
      lines.add(k++, table.lines[i]);
  }
  table.lines = std::move(lines);
}

RecordingParts requested_parts(const RecordingSource& source) {
  RecordingParts parts;
  if (!source.gyro.columns.empty()) parts.gyro = request(parts.requests, source, source.gyro);
  if (!source.accel.columns.empty()) parts.accel = request(parts.requests, source, source.accel);
  if (source.gyro.columns.empty()) parts.gyro.table = parts.accel.table;  // its rows are then the recording's
  if (source.accel.columns.empty()) parts.accel.table = parts.gyro.table;
  if (source.gyro_temperature) parts.gyro_temperature = request(parts.requests, source, *source.gyro_temperature);
  if (source.accel_temperature) parts.accel_temperature = request(parts.requests, source, *source.accel_temperature);
  return parts;
}

namespace {

/// True if most rows of two tables of one rate are stamped together: a tenth of an interval is as a computer stamps what it reads one after the
/// other.
bool stamped_together(const TableRows& a, const TableRows& b, double interval_s) {
  std::vector<double> apart;
  const std::vector<std::size_t> partner = partners(a.time_ns, b.time_ns, static_cast<std::int64_t>(0.5e9 * interval_s));
  for (std::size_t i = 0; i < partner.size(); ++i)
    if (partner[i] != none) apart.push_back(std::abs(static_cast<double>(a.time_ns[i] - b.time_ns[partner[i]])));
  return !apart.empty() && median(apart) <= 0.1e9 * interval_s;
}

/// A table at the stamps of another one; rows that it does not cover are left out.
void bring_to(TableRows& table, const TableRows& reference, const std::vector<std::size_t>& sensor_columns, bool increment, double own_interval_s,
              double interval_s) {
  std::vector<std::vector<double>> sensor, slow;
  std::vector<char> is_sensor(table.columns.size(), 0);
  for (const std::size_t c : sensor_columns) is_sensor[c] = 1;
  for (std::size_t c = 0; c < table.columns.size(); ++c) (is_sensor[c] ? sensor : slow).push_back(std::move(table.columns[c].numbers));
  Resampled means;
  means.covered.assign(reference.time_ns.size(), 1);
  if (!sensor.empty()) means = resample_means(table.time_ns, own_interval_s, sensor, increment, reference.time_ns, interval_s);
  slow = interpolate(table.time_ns, slow, reference.time_ns);
  for (std::size_t c = 0, s = 0, l = 0; c < table.columns.size(); ++c)
    table.columns[c].numbers = std::move(is_sensor[c] ? means.columns[s++] : slow[l++]);
  table.time_ns = reference.time_ns;
  table.lines = reference.lines;
  std::vector<std::size_t> covered;
  for (std::size_t i = 0; i < means.covered.size(); ++i)
    if (means.covered[i]) covered.push_back(i);
  keep_rows(table, covered);
}

}  // namespace

bool join_by_time(RecordingParts& parts, double interval_s, bool accel_increment, std::vector<std::string>& warnings) {
  const TableRows& reference = parts.tables[parts.gyro.table];
  bool resampled = false;
  for (std::size_t t = 0; t < parts.tables.size(); ++t) {
    TableRows& table = parts.tables[t];
    if (t == parts.gyro.table || table.time_ns == reference.time_ns) continue;
    const bool has_accel = t == parts.accel.table;
    const double own = table.time_ns.size() < 2 ? interval_s : stamp_intervals(table.time_ns).median;
    if (has_accel && same_interval(own, interval_s) && stamped_together(reference, table, interval_s)) continue;  // rows are matched
    if (table.time_ns.front() > reference.time_ns.back() || table.time_ns.back() < reference.time_ns.front())
      throw Error(fmt::format("{}: no time in common with {}; expected the same clock ({} to {} s here, {} to {} s there)", table.file,
                              reference.file, text::seconds_text(table.time_ns.front()), text::seconds_text(table.time_ns.back()),
                              text::seconds_text(reference.time_ns.front()), text::seconds_text(reference.time_ns.back())));
    bring_to(table, reference, has_accel ? parts.accel.columns : std::vector<std::size_t>{}, accel_increment, own, interval_s);
    resampled = resampled || has_accel;
    if (has_accel)
      warnings.push_back(
          fmt::format("{}: accelerometers every {:.6g} s, gyros every {:.6g} s, or at other instants: their readings are taken as means "
                      "over the gyros' intervals",
                      table.file, own, interval_s));
  }
  return resampled;
}

void match_rows(RecordingParts& parts, double interval_s, std::vector<std::string>& warnings) {
  TableRows& reference = parts.tables[parts.gyro.table];
  const std::size_t rows = reference.time_ns.size();
  if (parts.tables.size() == 1) return;
  std::vector<std::vector<std::size_t>> partner(parts.tables.size());
  for (std::size_t t = 0; t < parts.tables.size(); ++t)
    if (t != parts.gyro.table) partner[t] = partners(reference.time_ns, parts.tables[t].time_ns, static_cast<std::int64_t>(0.5e9 * interval_s));
  const auto matched = [&](std::size_t row) {
    return std::all_of(partner.begin(), partner.end(), [row](const auto& p) { return p.empty() || p[row] != none; });
  };
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < rows; ++i)
    if (matched(i)) kept.push_back(i);

  for (std::size_t t = 0; t < parts.tables.size(); ++t) {
    TableRows& table = parts.tables[t];
    if (kept.empty() && t != parts.gyro.table)
      throw Error(fmt::format("{}: no row within half an interval of a row of {}; expected the same clock ({} to {} s here, {} to {} s there)",
                              table.file, reference.file, text::seconds_text(table.time_ns.front()), text::seconds_text(table.time_ns.back()),
                              text::seconds_text(reference.time_ns.front()), text::seconds_text(reference.time_ns.back())));
    if (const std::size_t dropped = table.time_ns.size() - kept.size(); dropped > 0)
      warnings.push_back(fmt::format("{}: {} of {} rows dropped, without a row of the recording's other file within half an interval", table.file,
                                     dropped, table.time_ns.size()));
  }
  for (std::size_t t = 0; t < parts.tables.size(); ++t) {
    if (t == parts.gyro.table) continue;
    std::vector<std::size_t> own;
    own.reserve(kept.size());
    for (const std::size_t row : kept) own.push_back(partner[t][row]);
    keep_rows(parts.tables[t], own);
  }
  keep_rows(reference, kept);
}

Readings take_readings(RecordingParts& parts, const RecordingSource& source) {
  const auto taken = [&](const PartColumns& which) {
    std::vector<std::vector<double>> columns;
    auto c = which.columns.begin();
    for (const std::size_t terms : which.terms)
      for (std::size_t k = 0; k < terms; ++k, ++c) {
        std::vector<double>& numbers = parts.tables[which.table].columns[*c].numbers;
        if (k == 0)
          columns.push_back(std::move(numbers));
        else
          std::transform(numbers.begin(), numbers.end(), columns.back().begin(), columns.back().begin(), std::plus<>());
      }
    return columns;
  };
  Readings readings{three_columns(taken(parts.gyro)), three_columns(taken(parts.accel)), recording_options(source)};
  for (auto [triad, integers] : {std::pair{&readings.gyro, source.gyro.integers}, {&readings.accel, source.accel.integers}})
    for (std::vector<double>& column : *triad) take_as(integers, column);
  readings.options.gyro.temperature = taken(parts.gyro_temperature);
  readings.options.accel.temperature = taken(parts.accel_temperature);
  return readings;
}

}  // namespace imulab::recording_io
