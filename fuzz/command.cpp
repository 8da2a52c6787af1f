// Any command line, an argument a line, in a folder of small files of its own.
#include "apps/imulab/command.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"

#include "fuzz/fuzzed_file.hpp"
#include "fuzz/targets.hpp"
#include "tests/fleet_draw.hpp"
#include "tests/temporary_folder.hpp"
#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <fcntl.h>
#include <string>
#include <unistd.h>
#include <vector>

namespace imulab::fuzz {

namespace {

namespace fs = std::filesystem;

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

/// A command may do as much as its numbers say, and write where its names say: such a line is left alone.
bool is_small_and_here(const std::vector<std::string>& arguments) {
  constexpr std::size_t most_arguments = 24, most_digits = 3;
  if (arguments.empty() || arguments.size() > most_arguments) return false;
  if (arguments[0] == "demo") return std::find(arguments.begin(), arguments.end(), "--help") != arguments.end();
  for (const std::string& a : arguments) {
    if (a.find('\0') != std::string::npos || a.find("..") != std::string::npos) return false;
    std::size_t digits = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (a[i] == '/' && (i == 0 || std::isalnum(static_cast<unsigned char>(a[i - 1])) == 0)) return false;
      const bool counts = std::isdigit(static_cast<unsigned char>(a[i])) != 0 || ((a[i] == 'e' || a[i] == 'E') && digits > 0);
      digits = counts ? digits + 1 : 0;
      if (digits > most_digits) return false;
    }
  }
  return true;
}

/// The files that each command finds, by name.
std::vector<std::pair<std::string, std::string>> given_files() {
  std::vector<std::pair<std::string, std::string>> files;
  files.emplace_back(
      "m.toml",
      "format = \"imulab.mission/1\"\nrate_hz = 10\n[start]\nlatitude_deg = 45\nlongitude_deg = 10\nheight_m = 100\n[[segment]]\nkind = "
      "\"rest\"\nduration_s = 20\n[errors]\ngrade = \"navigation\"\n");
  files.emplace_back("c.json", calibration_text(drawn_calibration(1, 0)));
  files.emplace_back("d.json", calibration_text(drawn_calibration(1, 1)));
  files.emplace_back("noise.json", "{\"format\":\"imulab.noise/1\",\"interval_s\":0.02,\"axes\":[]}");
  // Six faces, half a second each, at 50 Hz.
  std::string rows = "t,gx,gy,gz,ax,ay,az\n";
  for (int i = 0; i < 300; ++i) {
    const int face = i / 50, axis = face / 2;
    std::string forces;
    for (int k = 0; k < 3; ++k) forces += "," + std::to_string((k == axis ? (face % 2 == 0 ? 9.8 : -9.8) : 0.0) + 0.001 * ((7 * i + k) % 5));
    rows += std::to_string(0.02 * i) + ",0.00" + std::to_string(i % 3) + ",0,0.001" + forces + "\n";
  }
  files.emplace_back("S/recording.csv", rows);
  std::string session =
      "format = \"imulab.session/1\"\n[imu]\nname = \"unit 0\"\nserial = \"1000\"\ngrade = \"mems\"\n[site]\ngravity_mps2 = 9.8\n[[recording]]\nfile "
      "= "
      "\"recording.csv\"\nrate_hz = 50\ntime = { column = \"t\", unit = \"s\" }\ngyro = { columns = [\"gx\", \"gy\", \"gz\"], output = \"rate\", "
      "unit = "
      "\"rad/s\" }\naccel = { columns = [\"ax\", \"ay\", \"az\"], output = \"rate\", unit = \"m/s^2\" }\n";
  files.emplace_back("S/session.toml", session);
  files.emplace_back("p.toml",
                     "format = \"imulab.session/1\"\n[imu]\nname = \"x\"\ngrade = \"mems\"\n[site]\nlatitude_deg = 45\n[[rig]]\nkind = "
                     "\"turntable\"\n[[step]]\nkind = \"hold\"\nduration_s = 5\n[[step]]\nkind = \"rotate\"\naxis = \"inner\"\nangle_deg = "
                     "90\nrate_dps = 30\n[[step]]\nkind = \"hold\"\nduration_s = 5\n");
  return files;
}

/// Standard input is empty, and relative names are in this folder; as before at the end.
class Elsewhere {
 public:
  explicit Elsewhere(const fs::path& folder) : before_(::open(".", O_RDONLY | O_CLOEXEC)), input_(::dup(STDIN_FILENO)) {
    const int nothing = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    ::dup2(nothing, STDIN_FILENO);
    ::close(nothing);
    if (::chdir(folder.c_str()) != 0) std::abort();
  }
  ~Elsewhere() {
    if (::fchdir(before_) != 0) std::abort();
    ::close(before_);
    if (input_ >= 0) ::dup2(input_, STDIN_FILENO), ::close(input_);
  }
  Elsewhere(const Elsewhere&) = delete;
  Elsewhere& operator=(const Elsewhere&) = delete;

 private:
  int before_, input_;
};

}  // namespace

void command_line(std::string_view bytes) {
  const std::vector<std::string> arguments = lines_of(bytes);
  if (!is_small_and_here(arguments)) return;
  static const TemporaryFolder folder;
  static const auto files = given_files();
  const fs::path place = folder / "w";
  fs::remove_all(place);
  fs::create_directories(place / "S");
  for (const auto& [name, text] : files) write_bytes(place / name, text);
  const Elsewhere elsewhere(place);
  const int code = command::run(arguments);
  if (code < 0 || code > 2) finding("an exit code that is none");
  for (const auto& entry : fs::recursive_directory_iterator("."))
    if (const std::string name = entry.path().filename().string(); name.find(".part-") != std::string::npos) finding("a folder is left behind");
}

}  // namespace imulab::fuzz
