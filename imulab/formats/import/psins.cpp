// PSINS' calibration as its function clbtfile writes it (psins toolbox, clbtfile.m; the equations of imuclbt.m and imuadderr.m):
//
//   Kg = [ 9 numbers ];  eb = [ 3, deg/h ];  Ka = [ 9 ];  db = [ 3, ug ];  Ka2 = [ 3, ug/g^2 ];  Kap = [ 3, ppm ];  rx, ry, rz = [ 3, cm ];  tGA = [
//   ms ]; gSens = [ 9, deg/h/g ];  sf = [ 6 ];
//
//   f = Ka (f_m - Ka2 f_m^2) - db,  w = Kg w_m - eb - gSens f_m
//
// with PSINS' own g and ug.
#include "imulab/formats/import/numbers.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <map>

namespace imulab::import_io {

namespace {

/// PSINS' glv.g0 (glvf.m: WGS-84's at the equator), of which its ug is a millionth.
constexpr double psins_g0 = 9.7803267714, psins_ug = 1e-6 * psins_g0;

struct Block {
  int line = 0;
  std::vector<double> values;
};

/// "NAME = [ numbers ];", over any number of lines. MATLAB's comments are gone.
std::map<std::string, Block> blocks_of(const Source& s) {
  constexpr std::size_t most = 9;
  std::map<std::string, Block> blocks;
  Block* open = nullptr;
  for (const Line& line : lines_of(s.text)) {
    std::string_view rest = line.text;
    while (!rest.empty()) {
      if (open == nullptr) {
        const std::size_t equals = rest.find('='), bracket = rest.find('[');
        const auto names = words_of(rest.substr(0, equals));
        if (equals == std::string_view::npos || bracket == std::string_view::npos || bracket < equals || names.size() != 1)
          fail_at(s, line.number, fmt::format("\"{}\": expected NAME = [ numbers ];", excerpt(rest)));
        const auto [place, is_new] = blocks.try_emplace(std::string(names[0]));
        if (!is_new) fail_at(s, line.number, excerpt(names[0]) + ": is given twice; expected each name once");
        open = &place->second;
        open->line = line.number;
        rest.remove_prefix(bracket + 1);
      }
      const std::size_t close = rest.find(']');
      for (const std::string_view word : words_of(rest.substr(0, close))) {
        const auto value = finite_number(word);
        if (!value) fail_at(s, line.number, fmt::format("\"{}\": expected a number", excerpt(word)));
        if (open->values.size() == most) fail_at(s, line.number, "more than 9 numbers in one block; expected no more");
        open->values.push_back(*value);
      }
      if (close == std::string_view::npos) break;
      open = nullptr;
      rest.remove_prefix(close + 1);
      rest.remove_prefix(std::min(rest.find_first_not_of(" \t\r;"), rest.size()));
    }
  }
  if (open != nullptr) fail_at(s, open->line, "a block without its ]; expected NAME = [ numbers ];");
  return blocks;
}

}  // namespace

bool is_psins(std::string_view text) {
  for (const Line& line : lines_of(text)) {
    const auto words = words_of(line.text, " \t\r=[;");
    if (!words.empty() && (words[0] == "Kg" || words[0] == "Ka") && line.text.find('=') != std::string_view::npos) return true;
  }
  return false;
}

ImportedModel read_psins(const Source& s) {
  const std::map<std::string, Block> blocks = blocks_of(s);
  const auto values = [&](const char* name, std::size_t count, bool required) -> const Block* {
    const auto found = blocks.find(name);
    if (found == blocks.end()) {
      if (required) fail_at(s, 0, fmt::format("{}: is missing; expected {} = [ {} numbers ];", name, name, count));
      return nullptr;
    }
    if (found->second.values.size() != count)
      fail_at(s, found->second.line, fmt::format("{}: {} numbers; expected {}", name, found->second.values.size(), count));
    return &found->second;
  };
  const auto vector = [&](const char* name, bool required) -> Vector3d {
    const Block* block = values(name, 3, required);
    return block == nullptr ? Vector3d(Vector3d::Zero()) : Vector3d(block->values[0], block->values[1], block->values[2]);
  };
  const Matrix3d Kg = matrix_from(values("Kg", 9, true)->values.data()), Ka = matrix_from(values("Ka", 9, true)->values.data());
  const Vector3d eb = vector("eb", true) * unit::deg_per_h, db = vector("db", true) * psins_ug;
  if (const Block* sf = values("sf", 6, false))
    for (const double factor : sf->values)
      if (factor != 1)
        fail_at(s, sf->line, "sf: scales of increments in pulses, which need the sample interval; expected a calibration with sf of one");
  ImportedModel out;
  SensorModel& m = out.model;
  m.accel.raw_unit = "m/s^2";
  m.gyro.raw_unit = "rad/s";
  m.accel.matrix = Ka;
  m.accel.offset = -db;
  m.gyro.matrix = Kg;
  m.gyro.offset = -eb;
  if (const Block* block = values("gSens", 9, false)) {  // PSINS takes the reading, imulab the compensated force: f_m = Ka^-1 (f + db)
    m.g_sensitivity = -matrix_from(block->values.data()) * (unit::deg_per_h / psins_g0) * inverse_at(s, 0, "Ka", Ka);
    m.gyro.offset += m.g_sensitivity * db;
  }
  const Vector3d Ka2 = vector("Ka2", false) * (psins_ug / (psins_g0 * psins_g0));
  if (!Ka2.isZero(0)) {
    m.accel.quadratic = -Ka.diagonal().cwiseProduct(Ka2);
    out.warnings.emplace_back("Ka2: its share across axes (Ka2 times the off-diagonal of Ka) is left out");
  }
  for (const char* name : {"Kap", "rx", "ry", "rz"})
    if (!vector(name, false).isZero(0)) out.warnings.push_back(fmt::format("{}: is not zero and is left out", name));
  if (const Block* block = values("tGA", 1, false); block != nullptr && block->values[0] != 0)
    out.warnings.emplace_back("tGA: is not zero and is left out");
  return out;
}

}  // namespace imulab::import_io
