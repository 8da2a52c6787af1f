// Messages about wrong session files.
#include "imulab/error.hpp"
#include "imulab/files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/session_text.hpp"
#include <string>

namespace imulab {
namespace {

using testing::HasSubstr;

TEST(SessionFile, NamesFileLineFieldAndWhatWasExpected) {
  const auto hold = [](const std::string& keys) { return session_head + "[[step]]\nkind = \"hold\"\n" + keys; };
  const auto reference = [](const std::string& keys) { return session_head + "[[reference]]\n" + keys; };
  const std::string clock_reference = "quantity = \"time\"\ninstrument = \"clock\"\ncertificate = \"C\"\n";
  const auto changed = [](const std::string& from, const std::string& to) {
    return session_head + std::string(session_recording).replace(session_recording.find(from), from.size(), to);
  };
  const auto repeated = [](const std::string& part, int times) {
    std::string out;
    for (int i = 0; i < times; ++i) out += part;
    return out;
  };
  const struct {
    std::string text, message;
  } cases[] = {
      {"", ":1: format: is missing"},
      {"format = \"imulab.session/2\"\n[imu]\nfuture = 1\n",
       ":1: format: \"imulab.session/2\" is a format this version does not know; expected \"imulab.session/1\""},
      {"format = \"toast\"\n", ":1: format: \"toast\" is not a session"},
      {"format = 3\n", ":1: format: is a number; expected text in quotes"},
      {session_head + "[imu\n", ":2: "},
      {session_head + "[imu]\nname = \"a" + '\0' + "b\"\n", ":3: a byte is 0 (NUL); expected text (TOML)"},
      {session_head + "# a note" + std::string(512, '\0'), ":2: a byte is 0 (NUL)"},
      {session_head + "[imu]\nname = \"x\"\n[[reference]]\nquantity = \"warmth\"\n[[reference]]\nquantity = 1\n",
       ":7: reference.quantity: is a number"},
      {session_head + "[imu]\nnamme = \"x\"\n", ":3: imu.namme: is not a known key; did you mean name?"},
      {session_head + "[imu]\nzzzzzzzz = \"x\"\n", ":3: imu.zzzzzzzz: is not a known key; expected one of name, serial, firmware, filter, grade"},
      {session_head + "[imu]\ngrade = \"navigation\"\n", ":2: imu.name: is missing"},
      {session_head + "[imu]\nname = \"x\"\ngyro_noise_density = -1\n", ":4: imu.gyro_noise_density: -1 is out of range; expected at least 0"},
      {session_head + "[imu]\nname = \"x\"\nnoise = \"loud\"\n",
       ":4: imu.noise: \"loud\" is not allowed; expected white, full, or the file of an analysis, noise.json"},
      {session_head + "a" + repeated(".a", 31000) + " = 1\n", ":2: a key has more than 32 parts"},
      {session_head + "[a" + repeated(" . \"a.b\"", 40) + "]\n", ":2: a key has more than 32 parts"},
      {session_head + "[imu]\nname = \"x\"\ngyro_noise = { rate_random_walk = -1 }\n",
       ":4: imu.gyro_noise.rate_random_walk: -1 is out of range; expected at least 0"},
      {session_head + "[imu]\nname = \"x\"\naccel_noise = { bias_stability = 1 }\n",
       ":4: imu.accel_noise.bias_stability: is not a known key; did you mean bias_instability?"},
      {session_head + "sites = 1\n", ":2: sites: is not a known key; did you mean site?"},
      {session_head + "site = 1\n", ":2: site: is a number; expected a table"},
      {session_head + "[site]\nlatitude_deg = 91\n", ":3: site.latitude_deg: 91 is out of range; expected -90 to 90"},
      {session_head + "[site]\nlatitude_deg = \"N\"\n", ":3: site.latitude_deg: is text; expected a number"},
      {session_head + "[site]\nheight_m = nan\n", ":3: site.height_m: is not finite"},
      {session_head + "[site]\ngravity_mps2 = 980.1\n", ":3: site.gravity_mps2: 980.1 is out of range; expected 9 to 10.5"},
      {session_head + "[rig]\nkind = \"swing\"\n",
       ":3: rig.kind: \"swing\" is not allowed; expected one of turntable, rate_table, centrifuge, chamber, none"},
      {session_head + "[rig]\nkind = \"none\"\nangle_sigma_arcsec = -3\n", ":4: rig.angle_sigma_arcsec: -3 is out of range; expected at least 0"},
      {session_head + "[rig]\nkind = \"none\"\nangle_sigma_arcsec = { fix = 3 }\n",
       ":4: rig.angle_sigma_arcsec.fix: is not a known key; did you mean fixed?"},
      {session_head + "[rig]\nkind = \"none\"\northogonality_arcsec = { inner = [1] }\n",
       ":4: rig.orthogonality_arcsec.inner: 1 numbers; expected 2"},
      {session_head + "[rig]\nkind = \"centrifuge\"\nangle_sigma_arcsec = 3\n", ":4: rig.angle_sigma_arcsec: is not a known key"},
      {session_head + "[rig]\nkind = \"centrifuge\"\nramp_K_per_min = 3\n", ":4: rig.ramp_K_per_min: is not a known key"},
      {session_head + "[rig]\nkind = \"chamber\"\nrate_sigma_ppm = 3\n", ":4: rig.rate_sigma_ppm: is not a known key"},
      {session_head + "[rig]\nkind = \"turntable\"\nmount_sigma_arcsec = 3\n", ":4: rig.mount_sigma_arcsec: is not a known key"},
      {session_head + "[rig]\nkind = \"chamber\"\ntime_constant_s = -1\n", ":4: rig.time_constant_s: -1 is out of range; expected at least 0"},
      {session_head + "[[rig]]\nkind = \"none\"\n[[rig]]\nkind = \"none\"\n", ":4: rig.name: is missing; expected because there are several rigs"},
      {reference("quantity = \"angle\"\n"),
       ":3: reference.quantity: \"angle\" is not allowed; expected one of acceleration, rotation, time, temperature"},
      {reference("quantity = \"time\"\ninstrument = \"clock\"\n"), ":2: reference.certificate: is missing"},
      {reference("quantity = \"time\"\ninstrument = \"\"\ncertificate = \"C\"\n"), ":4: reference.instrument: is empty"},
      {reference("quantity = \"time\"\ninstrument = \"clock\"\ncertificate = \"\"\n"), ":5: reference.certificate: is empty"},
      {"format = \"imulab.session/1\"\nmeasured = \"yesterday\"\n", ":2: measured: is no time; expected UTC as in \"2026-03-31\""},
      {"format = \"imulab.session/1\"\nvalid_until = \"2027-02-30\"\n", ":2: valid_until: is no date; expected one as in \"2026-03-31\""},
      {reference(clock_reference + "date = \"2026-02-30\"\n"), ":6: reference.date: is no date; expected one as in \"2026-03-31\""},
      {reference(clock_reference + "date = \"2026-2-3 \"\n"), ":6: reference.date: is no date"},
      {reference(clock_reference) + "[[reference]]\n" + clock_reference, ":7: reference.quantity: repeats the quantity of an earlier reference"},
      {changed("file = \"r.csv\"\n", ""), ":2: recording.file: is missing"},
      {changed("file = \"r.csv\"\n", "file = \"r.csv\"\nrate_hz = 0\n"), ":4: recording.rate_hz: 0 is out of range; expected 0.001 to 1000000"},
      {changed("file = \"r.csv\"\n", "file = \"r.csv\"\nrig = \"q\"\n"), ":4: recording.rig: \"q\" is not a rig of this session"},
      {changed("unit = \"s\"", "unit = \"min\""), ":4: recording.time.unit: \"min\" is not allowed; expected one of s, ms, us, ns"},
      {changed("unit = \"s\"", "unit = \"s\", zero = -5"), ":4: recording.time.zero: is negative, but it is subtracted from every stamp; expected"},
      {changed("unit = \"s\"", "unit = \"s\", zero = 1e25"), ":4: recording.time.zero: is more than 292 years"},
      {changed("column = \"t\"", "column = 0"), ":4: recording.time.column: column 0 is out of range; expected 1 or more"},
      {changed("column = \"t\"", "column = 1.5"), ":4: recording.time.column: is a number; expected a column's name or its number"},
      {changed("\"gx\", ", ""), ":5: recording.gyro.columns: 2 columns; expected 3"},
      {changed("\"gx\", ", "\"gz\", "), ":5: recording.gyro.columns: names the same column twice"},
      {changed("unit = \"count\" }\naccel", "unit = \"furlong\" }\naccel"),
       ":5: recording.gyro.unit: \"furlong\" is not allowed; expected one of count, rad/s, deg/s, mdeg/s, deg/min, deg/h"},
      {changed("unit = \"count\" }\naccel", "unit = \"deg\" }\naccel"),
       ":5: recording.gyro.unit: \"deg\" is not allowed; expected one of count, rad/s, deg/s, mdeg/s, deg/min, deg/h"},
      {changed("output = \"rate\", unit = \"count\" }\naccel", "output = \"increment\", unit = \"deg/s\" }\naccel"),
       ":5: recording.gyro.unit: \"deg/s\" is not allowed; expected one of count, rad, deg"},
      {changed("unit = \"count\" }\naccel", "unit = \"count\", limits = [5, 5] }\naccel"), ":5: recording.gyro.limits: are not in order"},
      {changed("accel = {", "gyro_temperature = { columns = [1, 2], unit = \"degC\" }\naccel = {"),
       ":6: recording.gyro_temperature.columns: 2 columns; expected 1 or 3"},
      {changed("accel = {", "gyro_temperature = { columns = [1], unit = \"degF\" }\naccel = {"),
       ":6: recording.gyro_temperature.unit: \"degF\" is not allowed; expected one of degC, K, raw"},
      {changed("accel = {", "gyro_temperature = { columns = [1], unit = \"raw\", per_K = 1 }\naccel = {"),
       ":6: recording.gyro_temperature.per_K: is given alone; expected both at_25_degC and per_K"},
      {changed("accel = {", "gyro_temperature = { columns = [1], unit = \"raw\", at_25_degC = 5000, per_K = 0 }\naccel = {"),
       ":6: recording.gyro_temperature.per_K: is 0"},
      {changed("file = \"r.csv\"\n", "file = \"r.csv\"\nextent = \"some\"\n"),
       ":4: recording.extent: \"some\" is not allowed; expected one of all, steps"},
      {session_head + session_recording + session_recording, ":8: recording.file: repeats the file of an earlier recording"},
      {hold(""), ":2: step.duration_s: is missing; expected duration_s (a procedure) or start_s and end_s"},
      {hold("start_s = 1\n"), ":4: step.start_s: is given alone"},
      {hold("start_s = 1\nend_s = 1\n"), ":5: step.end_s: 1 is not after start_s"},
      {hold("start_s = 1\nend_s = 2\nduration_s = 1\n"), ":6: step.duration_s: cannot be combined with start_s and end_s"},
      {hold("duration_s = 0\n"), ":4: step.duration_s: 0 is out of range; expected more than 0"},
      {hold("duration_s = 1\nangle_deg = 5\n"), ":5: step.angle_deg: is not a known key"},
      {hold("duration_s = 1\nup = \"+z\"\n"), ":5: step.up: is given alone; expected both up and outward"},
      {hold("duration_s = 1\nup = \"+z\"\noutward = \"-z\"\n"), ":6: step.outward: is parallel to up"},
      {hold("duration_s = 1\nup = \"z\"\noutward = \"-z\"\n"), ":5: step.up: \"z\" is not allowed; expected one of +x, +y, +z, -x, -y, -z"},
      {hold("start_s = 0\nend_s = 2\n[[step]]\nkind = \"hold\"\nstart_s = 1.5\nend_s = 3\n"),
       ":8: step.start_s: 1.5 is before the end of the previous step; expected at least 2"},
      {session_head + "[[step]]\nkind = \"rotate\"\naxis = \"outer\"\nangle_deg = 90\nrate_dps = -10\n",
       ":6: step.rate_dps: -10 is out of range; expected more than 0"},
      {session_head + "[[step]]\nkind = \"rotate\"\naxis = \"outer\"\nangle_deg = 0\nrate_dps = 10\n", ":5: step.angle_deg: is 0"},
      {session_head + "[[step]]\nkind = \"rotate\"\naxis = \"up\"\nangle_deg = 9\nrate_dps = 10\n",
       ":4: step.axis: \"up\" is not allowed; expected one of outer, middle, inner"},
      {session_head + "[[step]]\nkind = \"spin\"\nduration_s = 3\nrate_dps = 10\nradius_m = [1, 2]\n", ":6: step.radius_m: 2 numbers; expected 3"},
      {session_head + session_recording + "[[step]]\nkind = \"hold\"\nduration_s = 1\nrecording = \"x.csv\"\n",
       ":10: step.recording: \"x.csv\" is not a recording of this session; expected r.csv"},
      {session_head + "[initial]\nlatitude_deg = 1\nlongitude_deg = 2\nheight_m = 3\nvelocity_enu_mps = [1, 2]\n",
       ":6: initial.velocity_enu_mps: 2 numbers; expected 3"},
      {session_head + "[truth]\n", ":2: truth.file: is missing"},
  };
  for (const auto& c : cases) {
    try {
      parse_session(c.text);
      ADD_FAILURE() << "accepted:\n" << c.text;
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr("session.toml" + c.message)) << c.text;
    }
  }
}

TEST(SessionFile, NamesAMissingFile) {
  EXPECT_THAT([] { read_session("/nowhere/session.toml"); }, testing::ThrowsMessage<Error>(HasSubstr("/nowhere/session.toml: cannot be opened")));
}

}  // namespace
}  // namespace imulab
