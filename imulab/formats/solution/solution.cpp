#include "imulab/formats/solution/solution.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/text/csv.hpp"
#include "imulab/formats/text/append_number.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/navigate.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <string>
#include <utility>

namespace imulab {

namespace {

const std::vector<Column> state_columns{"latitude_deg", "longitude_deg", "height_m", "ve", "vn", "vu", "roll_deg", "pitch_deg", "heading_deg"};

constexpr std::ptrdiff_t of_state = 11;  // numbers
constexpr std::size_t numbers_at_once = 10'000 * of_state;

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

void SolutionFile::add(double time, const NavigationState& s) {
  ++states_;
  if (!file_.temporary().empty()) return write(time, s);
  const Eigen::Vector4d q = s.q_nb.coeffs();
  for (const double number : {time, s.latitude, s.longitude, s.height, s.velocity.x(), s.velocity.y(), s.velocity.z(), q[0], q[1], q[2], q[3]})
    waiting_.push_back(number);
  if (waiting_.size() < numbers_at_once) return;
  if (!waiting_file_) waiting_file_.emplace();
  waiting_file_->append<double>(waiting_);
  waiting_.clear();
}

void append_state(std::string& to, double time, const NavigationState& s, const EulerAngles& angles) {
  text::append_fixed(to, time, 9);
  const auto add = [&](double value, int decimals) { to += ',', text::append_fixed(to, value, decimals); };
  add(s.latitude / unit::deg, 12), add(s.longitude / unit::deg, 12), add(s.height, 6);
  for (const double value : s.velocity) add(value, 8);
  for (const double value : {angles.roll, angles.pitch, angles.heading}) add(value / unit::deg, 9);
}

void SolutionFile::write(double time, const NavigationState& s) {
  const EulerAngles angles = euler_angles(s.q_nb.toRotationMatrix());
  const double heading = angles.heading < 0 ? angles.heading + 2 * std::numbers::pi : angles.heading;  // a compass counts from 0 to 360
  append_state(text_, time, s, {angles.roll, angles.pitch, heading});
  text_ += '\n';
  if (text_.size() < 1 << 20) return;
  file_.write(text_);
  text_.clear();
}

void SolutionFile::commit() {
  const auto write_all = [this](const std::vector<double>& numbers) {
    for (auto n = numbers.begin(); n != numbers.end(); n += of_state) {
      NavigationState s;
      s.latitude = n[1], s.longitude = n[2], s.height = n[3];
      s.velocity = {n[4], n[5], n[6]};
      s.q_nb.coeffs() = Eigen::Vector4d(n[7], n[8], n[9], n[10]);
      write(n[0], s);
    }
  };
  std::vector<double> numbers(numbers_at_once);
  for (std::size_t begin = 0; waiting_file_ && begin < waiting_file_->size(); begin += numbers_at_once)
    waiting_file_->read(begin, numbers), write_all(numbers);
  write_all(waiting_);
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
