#include "imulab/formats/solution/solution.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/text/csv.hpp"
#include "imulab/formats/text/append_number.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/navigate.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <string>
#include <utility>

namespace imulab {

namespace {

const std::vector<Column> state_columns{"latitude_deg", "longitude_deg", "height_m", "ve", "vn", "vu", "roll_deg", "pitch_deg", "heading_deg"};

constexpr std::size_t bytes_at_once = 1 << 20;

}  // namespace

Solution read_solution(const std::filesystem::path& path) {
  const recording_io::TableRows table = recording_io::read_csv(path, {.column = "t"}, std::nullopt, state_columns);
  const auto v = [&](std::size_t column, std::size_t row) { return table.columns[column].numbers[row]; };
  Solution out;
  for (std::size_t i = 0; i < table.time_ns.size(); ++i) {
    if (std::abs(v(0, i)) > 90)
      throw Error(fmt::format("{}:{}: latitude_deg: {} is out of range; expected -90 to 90", table.file, table.lines[i], v(0, i)));
    NavigationState s;
    s.latitude = v(0, i) * unit::deg;
    s.longitude = v(1, i) * unit::deg;
    s.height = v(2, i);
    s.velocity = {v(3, i), v(4, i), v(5, i)};
    s.q_nb = Eigen::Quaterniond(attitude_matrix({v(6, i) * unit::deg, v(7, i) * unit::deg, v(8, i) * unit::deg}));
    out.time.push_back(1e-9 * static_cast<double>(table.time_ns[i]));
    out.states.push_back(s);
  }
  return out;
}

HeightRecord read_heights(const std::filesystem::path& path) {
  recording_io::TableRows table = recording_io::read_csv(path, {.column = "t"}, std::nullopt, {Column("height_m")});
  HeightRecord out;
  for (const std::int64_t ns : table.time_ns) out.time.push_back(1e-9 * static_cast<double>(ns));
  out.height = std::move(table.columns[0].numbers);
  return out;
}

SolutionFile::SolutionFile(const std::filesystem::path& path)
    : file_(path), text_("t,latitude_deg,longitude_deg,height_m,ve,vn,vu,roll_deg,pitch_deg,heading_deg\n") {}

void append_state(std::string& to, double time, const NavigationState& s, const EulerAngles& angles) {
  text::append_fixed(to, time, 9);
  const auto add = [&](double value, int decimals) { to += ',', text::append_fixed(to, value, decimals); };
  add(s.latitude / unit::deg, 12), add(s.longitude / unit::deg, 12), add(s.height, 6);
  for (const double value : s.velocity) add(value, 8);
  for (const double value : {angles.roll, angles.pitch, angles.heading}) add(value / unit::deg, 9);
}

void SolutionFile::add(double time, const NavigationState& s) {
  ++states_;
  const EulerAngles angles = euler_angles(s.q_nb.toRotationMatrix());
  const double heading = angles.heading < 0 ? angles.heading + 2 * std::numbers::pi : angles.heading;  // a compass counts from 0 to 360
  append_state(text_, time, s, {angles.roll, angles.pitch, heading});
  text_ += '\n';
  if (text_.size() < bytes_at_once) return;
  if (!file_.temporary().empty()) {
    file_.write(text_);
  } else {
    if (!waiting_) waiting_.emplace();
    waiting_->append(std::as_bytes(std::span(text_)));
  }
  text_.clear();
}

void SolutionFile::commit() {
  std::string piece;
  for (std::uint64_t begin = 0; waiting_ && begin < waiting_->size(); begin += piece.size()) {
    piece.resize(static_cast<std::size_t>(std::min<std::uint64_t>(bytes_at_once, waiting_->size() - begin)));
    waiting_->read(begin, std::as_writable_bytes(std::span(piece)));
    file_.write(piece);
  }
  file_.write(text_);
  text_.clear();
  file_.commit();
}

void write_solution(const std::filesystem::path& path, const Solution& solution) {
  validate(solution);
  SolutionFile file(path);
  for (std::size_t i = 0; i < solution.size(); ++i) file.add(solution.time[i], solution.states[i]);
  file.commit();
}

}  // namespace imulab
