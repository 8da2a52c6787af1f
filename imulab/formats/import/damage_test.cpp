// Damaged files of other programs: refused by file and line, and never more than an Error.
#include "imulab/error.hpp"
#include "imulab/exchange.hpp"
#include "imulab/files.hpp"

#include <gmock/gmock.h>

#include "tests/export_unit.hpp"
#include "tests/import_texts.hpp"
#include "tests/run_command.hpp"
#include <filesystem>

namespace imulab::export_test {
namespace {

using ::testing::StartsWith;

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

std::string error_of(const std::string& text, const ImportOptions& options = {}) {
  try {
    import(text, options);
  } catch (const Error& e) {
    return e.what();
  }
  return "accepted";
}

TEST(Import, DamageIsNamedByFileAndLine) {
  const ImuNoise noise = some_noise();
  const Calibration thermal = thermal_unit(), plain = si_unit();
  const std::string px4 = exported("px4", {thermal}), ardupilot = exported("ardupilot", {thermal}), vectornav = exported("vectornav", {plain}),
                    json = exported("json-matrix", {plain}), table = exported("csv", {plain}), yaml = chain;
  struct Damage {
    std::string text, message;
  };
  const Damage cases[] = {
      {"", "file: is empty; expected a calibration"},
      {" \n\t\n", "file: is empty"},
      {"hello", "file: is in no format that import knows; expected one of json-matrix"},
      {"{}", "file: is in no format"},
      {calibration_text(plain), "file: is a calibration of imulab already"},
      {std::string((std::size_t{1} << 20) + 1, '1'), "file: is longer than a MiB"},
      {replaced(yaml, "M: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]", "M: [[1, 0, 0], [0, 1, 0]]"),
       "file:13: imu0.gyroscopes.M: expected 3 rows of 3 numbers"},
      {replaced(yaml, "M: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]", "M: [[1, 0], [0, 1, 0], [0, 0, 1]]"), "file:13: imu0.gyroscopes.M: expected 3 rows"},
      {replaced(yaml, "M: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]", "M: 3"), "file:13: imu0.gyroscopes.M: expected 3 rows"},
      {replaced(yaml, "M: [[1, 0, 0]", "M: [[.nan, 0, 0]"), "file:13: imu0.gyroscopes.M[0][0]: expected a number, found \".nan\""},
      {replaced(yaml, "M: [[1, 0, 0]", "M: [[1e999, 0, 0]"), "file:13: imu0.gyroscopes.M[0][0]: expected a number"},
      {replaced(yaml, "M: [[1, 0, 0]", "M: [[0, 0, 0]"), "file:13: imu0.gyroscopes.M: is singular"},
      {replaced(yaml, "rows: 3", "rows: 9"), "file:11: imu0.accelerometers.M: expected 3 rows and 3 columns"},
      {replaced(yaml, "data: [0., -1.", "data: [5., -1."), "file:4: imu0.T_i_b: expected a rotation matrix"},
      {replaced(yaml, "    A: [0, 0, 0, 0, 0, 0, 0, 0, 0]\n", ""), "file:13: imu0.gyroscopes.A: is missing"},
      {replaced(yaml, "    A: ", "    M: "), "file:14: M: is given twice; expected each key once"},
      {replaced(yaml, "    A: [0, 0", "    A: [0, ["), "file:"},
      {replaced(yaml, "    A: [0,", "    A: &a [0,") + "x: *a\n", "file:16: an alias; expected values written out"},
      {"gyroscope_noise_density: " + std::string(30, '['), "file:1: nested deeper than 20"},
      {"gyroscope_noise_density: \n" + std::string(30, '-'), "file:"},
      {"gyroscope_noise_density:\n- - - - - - - - - - - - - - - - - - - - - - - 1\n", "file:2: nested deeper than 20"},
      {"gyroscope_noise_density: 1\n? [a]\n: 2\n", "file:2: a key that is no text"},
      {"gyroscope_noise_density: \"unfinished\n", "file:"},
      {"Tw: 1\n" + std::string(300000, '#'), "file: is longer than 256 KiB"},
      {replaced(px4, "CAL_ACC0_YOFF", "CAL_ACC0_XOFF"), "file:"},
      {replaced(px4, "CAL_GYRO0_ZOFF", "CAL_GYRO0_QOFF"), "file: CAL_GYRO0_ZOFF: is missing"},
      {replaced(px4, "TC_A0_TMIN", "TC_A0_QMIN"), "file: TC_A0_TMIN: is missing"},
      {"1 1 CAL_ACC0_XOFF nan 9\n", "file:1: CAL_ACC0_XOFF: expected a number, found \"nan\""},
      {"1 1 CAL_ACC0_XOFF\n", "file:1: 1 1 CAL_ACC0_XOFF: expected NAME,VALUE"},
      {replaced(ardupilot, "INS_ACCSCAL_Y", "INS_ACCSCAL_Q"), "file: INS_ACCSCAL_Y: is missing"},
      {"INS_ACCOFFS_X,\n", "file:1: INS_ACCOFFS_X,: expected NAME,VALUE"},
      {"INS_ACCOFFS_X,1\nINS_ACCOFFS_X 2\n", "file:2: INS_ACCOFFS_X: is given twice"},
      {replaced(vectornav, "$VNWRG,84,", "$VNWRG,85,"), "file: register 84: is missing"},
      {"$VNWRG,25,1,2,3*00\n", "file:1: register 25: expected 12 numbers"},
      {replaced(imucal_text, "\"b_a\": [0.05, -0.06, 0.04]", "\"b_a\": [0.05, -0.06]"), "file: b_a: expected 3 numbers"},
      {replaced(imucal_text, "\"R_a\"", "\"R_b\""), "file: R_a: is missing"},
      {replaced(imucal_text, "\"K_ga\"", "\"K_a\""), "file: K_a: is given twice"},
      {replaced(imucal_text, "\"deg/s\"", "\"furlong\""), "file: gyr_unit: expected m/s^2, g, rad/s, deg/s or a.u."},
      {std::string(imucal_text).substr(0, 300), "file:3: not JSON"},
      {replaced(json, "imulab.matrix/1", "imulab.matrix/2"), "file: format: expected \"imulab.matrix/1\""},
      {std::string("{\"format\": \"imulab.matrix/1\", \"a\": ") + std::string(5000, '['), "file: nested too deeply"},
      {replaced(psins_text, "1.01e+00", "1.01x"), "file:2: \"1.01x\": expected a number"},
      {replaced(psins_text, "Ka = [", "Kb = ["), "file: Ka: is missing"},
      {replaced(psins_text, "db = [", "Ka = ["), "file:14: Ka: is given twice"},
      {replaced(psins_text, "1.0e+01 \t-2.0e+01", "1.0e+01"), "file:6: eb: 2 numbers; expected 3"},
      {"Kg = [ 1 2 3\n", "file:1: a block without its ]"},
      {"Kg = [1 2 3 4 5 6 7 8 9 10];", "file:1: more than 9 numbers"},
      {replaced(table, "accel.offset.y,", "accel.offset.x,"), "file:"},
      {replaced(table, "gyro.matrix.zz,", "gyro.matrix.qq,"), "file: gyro.matrix.zz: is missing"},
      {"name,value,standard_uncertainty,unit\naccel.offset.x,nan,,\n", "file:2: accel.offset.x: expected a number, found \"nan\""},
      {"1 0 0\n0 1 0\n0 0 1\n", "file:3: 9 numbers; expected 12"},
      {"1 0 0\n0 1 zero\n0 0 1\n0 0 0\n", "file:2: \"zero\": expected a number"},
      {"1 0 0\n0 1 inf\n0 0 1\n0 0 0\n", "file:2: \"inf\": expected a number"},
      {"1 0 0\n0 0 0\n0 0 1\n0 0 0\n", "file: the accelerometers' matrix: is singular"},
      {"1 0 0 0 1 0 0 0 1\n1 1 0 0 1 0 0 0 1\n0 0 0\n", "file:2: the second matrix of imu_tk holds scales; expected a diagonal matrix"},
      {"1 2 3 4 5 6\n1 2 3 4 5 6\n1 2 3 4 5 6\n1 2 3 4 5 6\n", "file:1: lines of 6, 6, 6, 6 numbers; expected C and b of a triad as one line of 12"},
      {"1 0 0 0\n0 1 0\n0 0 1 0 0\n", "file:1: lines of 4, 3, 5 numbers; expected"},
      {replaced(vectornav, "-0.", "-1."), "file:"},
      {"$VNWRG,25,1,0,0,0,1,0,0,0,1,0,0,0\n", "file:1: register 25: has no checksum, the line may be cut; expected *XX"},
      {"$VNWRG,25,1,0,0,0,1,0,0,0,1,0,0,0*00\n", "file:1: register 25: its checksum is 00, that of its text "},
      {exported("euroc", {plain, &noise}), "file:"},
      {exported("kalibr-imu", {plain, &noise}), "file:"},
      {"imu0:\n  accelerometer_noise_density: 1e-3\n  gyroscope_noise_density: 1e-4\n  update_rate: 200.0\n",
       "file:2: holds noise and no calibration; expected imu0.accelerometers and imu0.gyroscopes, or imu0.Tw and imu0.Ta"},
      {"imu0:\n  model: \"imagined\"\n  Tw: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n  Ta: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n",
       "file:2: imu0.model: \"imagined\"; expected kalibr or rpng"},
      {replaced(json, "\"not_determined\": []", "\"not_determined\": [\"nothing\"]"), "file: not_determined: expected names of coefficients"},
      {replaced(table, "accel.readings,m/s^2", "accel.readings,furlong"), "file:"},
      {"1e308 0 0 0 1e308 0 0 0 1e308 1e308 0 0", "file: the accelerometers' numbers are too large"},
  };
  for (const Damage& d : cases) EXPECT_THAT(error_of(d.text), StartsWith(d.message)) << d.text.substr(0, 200);
  ImportOptions second;
  second.instance = 1;
  EXPECT_THAT(error_of(chain, second), StartsWith("file:3: imu1: is missing"));
}

TEST(Import, NoBytesDoMoreThanAnError) {
  const ImuNoise noise = some_noise();
  const Calibration thermal = thermal_unit();
  std::vector<std::string> seeds;
  for (const auto& entry : std::filesystem::directory_iterator(IMULAB_SOURCE "/tests/imports"))
    if (entry.path().extension() != ".md") {
      seeds.push_back(read_text(entry.path()));
      EXPECT_NO_THROW(import(seeds.back())) << entry.path();
    }
  for (const char* target : {"kalibr", "openvins", "px4", "ardupilot", "vectornav", "json-matrix"})
    seeds.push_back(exported(target, {thermal, &noise}));
  const RandomStream random(77, "damage");
  std::uint64_t draw = 0;
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random.uniform(draw++) * static_cast<double>(n)); };
  constexpr std::string_view alphabet =
      "[]{}:,-?&*!|>'\"%@`#\n\t \0\xff"
      "0.e+";
  int accepted = 0, refused = 0;
  for (const std::string& seed : seeds)
    for (int i = 0; i < 300; ++i) {
      std::string text = seed;
      for (std::size_t k = below(4) + 1; k-- > 0 && !text.empty();) {
        const std::size_t at = below(text.size()), kind = below(4);
        if (kind == 0) text.resize(at);
        if (kind == 1) text[at] = alphabet[below(alphabet.size())];
        if (kind == 2) text.erase(at, below(40));
        if (kind == 3) text.insert(at, text.substr(below(text.size()), below(100)));
      }
      try {
        const Imported imported = import(text);
        EXPECT_NO_THROW(parse_calibration(calibration_text(imported.calibration), "calibration.json")) << text;
        ++accepted;
      } catch (const Error&) {
        ++refused;
      }
    }
  EXPECT_GT(accepted, 100);  // much damage hits comments and digits
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace imulab::export_test
