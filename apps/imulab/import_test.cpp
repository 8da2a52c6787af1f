// `imulab import`: a calibration that the other commands take.
#include "imulab/files.hpp"

#include <gmock/gmock.h>

#include "tests/export_unit.hpp"
#include "tests/run_command.hpp"

namespace imulab {
namespace {

using ::testing::HasSubstr;

TEST(ImportCommand, WritesACalibrationThatOtherCommandsTake) {
  const TemporaryFolder folder;
  Calibration c = export_test::si_unit();
  c.model.g_sensitivity.setZero();
  folder.write("calibration.json", calibration_text(c));
  ASSERT_EQ(run_imulab(folder, "export calibration.json --to vectornav -o registers.txt").exit_code, 0);
  const CommandResult imported = run_imulab(folder, "import registers.txt -o imported.json");
  ASSERT_EQ(imported.exit_code, 0) << imported.errors;
  EXPECT_EQ(imported.output, "imported.json: calibration of VectorNav, without uncertainties\n");
  EXPECT_EQ(read_calibration(folder / "imported.json").method, "import");
  EXPECT_EQ(run_imulab(folder, "compare calibration.json imported.json").exit_code, 0);
  folder.write("rest.csv", [] {
    std::string text = "t,gx,gy,gz,ax,ay,az\n";
    for (int i = 0; i < 200; ++i) text += std::to_string(0.01 * i) + ",0.01,-0.02,0.03,0.1,0.2,9.8\n";
    return text;
  }());
  folder.write("session.toml",
               "format = \"imulab.session/1\"\n[[recording]]\nfile = \"rest.csv\"\ntime = { column = \"t\", unit = \"s\" }\n"
               "gyro = { output = \"rate\", columns = [\"gx\", \"gy\", \"gz\"], unit = \"rad/s\" }\n"
               "accel = { output = \"rate\", columns = [\"ax\", \"ay\", \"az\"], unit = \"m/s^2\" }\n");
  const CommandResult compensated = run_imulab(folder, "compensate imported.json session.toml -o compensated.csv");
  EXPECT_EQ(compensated.exit_code, 0) << compensated.errors;
}

TEST(ImportCommand, KeepsFilesThatExist) {
  const TemporaryFolder folder;
  folder.write("matrix.txt", "1 0 0 0 1 0 0 0 1 0.1 0.2 0.3\n");
  folder.write("gyro.txt", "1 0 0 0 1 0 0 0 1 0.01 0.02 0.03\n");
  EXPECT_EQ(run_imulab(folder, "import matrix.txt -o matrix.txt --force").exit_code, 2);
  EXPECT_EQ(run_imulab(folder, "import matrix.txt --gyro gyro.txt -o gyro.txt --force").exit_code, 2);
  ASSERT_EQ(run_imulab(folder, "import matrix.txt --gyro gyro.txt -o c.json").exit_code, 0);
  EXPECT_NEAR(read_calibration(folder / "c.json").model.gyro.offset[2], -0.03, 1e-17);
  EXPECT_EQ(run_imulab(folder, "import matrix.txt -o c.json").exit_code, 2);
  EXPECT_EQ(run_imulab(folder, "import matrix.txt -o c.json --force").exit_code, 0);
  EXPECT_EQ(run_imulab(folder, "import none.txt -o d.json").exit_code, 2);
  EXPECT_EQ(run_imulab(folder, "import . -o d.json").exit_code, 2);
}

TEST(ImportCommand, TellsWhatItReadAsJson) {
  const TemporaryFolder folder;
  folder.write("matrix.txt", "1 0 0 0 1 0 0 0 1 0.1 0.2 0.3\n");
  const CommandResult result = run_imulab(folder, "import matrix.txt -o c.json --json");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.output, HasSubstr("\"format\": \"matrix and bias\""));
  EXPECT_THAT(result.errors, HasSubstr("imulab: warning: matrix.txt: the file has one triad"));
  const CommandResult streamed = run_shell(folder, std::string("cat matrix.txt | '") + command_path() + "' import - -o -");
  EXPECT_EQ(streamed.exit_code, 0) << streamed.errors;
  EXPECT_EQ(parse_calibration(streamed.output, "c").method, "import");
}

}  // namespace
}  // namespace imulab
