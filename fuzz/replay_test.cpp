// The inputs of earlier fuzzing, given again to its targets in every build: the kept corpus with every input that was ever a finding, the files of
// tests/recordings and tests/imports, and the same cut short and with bytes changed.
#include <gmock/gmock.h>

#include "fuzz/targets.hpp"
#include "tests/run_command.hpp"
#include <algorithm>
#include <fcntl.h>
#include <random>
#include <unistd.h>
#include <vector>

extern "C" {
// Defined by the sanitizers, where the program has them.
void __sanitizer_set_report_fd(void*) __attribute__((weak));
void __sanitizer_set_death_callback(void (*)()) __attribute__((weak));
}

namespace imulab::fuzz {

namespace {

namespace fs = std::filesystem;

std::string replayed;  // for the message of a sanitizer
int errors = -1;

void say_what_was_replayed() {
  const std::string text = "while replaying " + replayed + "\n";
  [[maybe_unused]] const ssize_t written = ::write(errors, text.data(), text.size());
}

/// Commands print: into nothing, as long as this lives.
class Silence {
 public:
  Silence() : output_(::dup(STDOUT_FILENO)) {
    errors = ::dup(STDERR_FILENO);
    if (__sanitizer_set_report_fd != nullptr) __sanitizer_set_report_fd(reinterpret_cast<void*>(static_cast<std::intptr_t>(errors)));
    if (__sanitizer_set_death_callback != nullptr) __sanitizer_set_death_callback(say_what_was_replayed);
    const int nothing = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    std::fflush(stdout);
    ::dup2(nothing, STDOUT_FILENO), ::dup2(nothing, STDERR_FILENO);
    ::close(nothing);
  }
  ~Silence() {
    std::fflush(stdout);
    ::dup2(output_, STDOUT_FILENO), ::dup2(errors, STDERR_FILENO);
    ::close(output_);
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  int output_;
};

std::vector<fs::path> seeds_of(const Target& target) {
  const fs::path source = IMULAB_SOURCE;
  std::vector<fs::path> files;
  if (const fs::path own = source / "fuzz/corpus" / target.name; fs::exists(own))
    for (const auto& entry : fs::directory_iterator(own)) files.push_back(entry.path());
  std::istringstream endings(target.seeds);
  for (std::string ending; endings >> ending;)
    for (const char* folder : {"tests/recordings", "tests/imports"})
      for (const auto& entry : fs::directory_iterator(source / folder))
        if (entry.path().string().ends_with(ending)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// Cut at this many places, and with a byte or a run of bytes changed as often: the same on every machine.
std::vector<std::string> changed(const std::string& bytes, std::size_t times) {
  std::vector<std::string> all;
  std::mt19937_64 draw(bytes.size());  // its numbers are specified, those of distributions are not
  for (std::size_t k = 0; k < times && !bytes.empty(); ++k) {
    all.push_back(bytes.substr(0, draw() % bytes.size()));
    std::string other = bytes;
    other[draw() % bytes.size()] = static_cast<char>(draw() % 256);
    all.push_back(other);
    const std::size_t at = draw() % bytes.size(), count = std::min<std::size_t>(bytes.size() - at, 1 + draw() % 8);
    other.replace(at, count, draw() % 2 == 0 ? std::string(draw() % 16, static_cast<char>(draw() % 256)) : bytes.substr(draw() % bytes.size(), 8));
    all.push_back(std::move(other));
  }
  return all;
}

struct FuzzReplay : testing::TestWithParam<Target> {};

TEST_P(FuzzReplay, FindsNothing) {
  const Target& target = GetParam();
  const std::vector<fs::path> seeds = seeds_of(target);
  ASSERT_FALSE(seeds.empty());
  std::size_t inputs = 0;
  std::string what;
  const auto run = [&](const std::string& name, const std::string& bytes) {
    replayed = name;
    ++inputs;
    try {
      target.run(bytes);
    } catch (const std::exception& e) {
      what += name + ": " + e.what() + "\n";
    }
  };
  {
    const Silence silence;
    const std::size_t in_all = target.slow ? 60 : 1500, each = 1 + in_all / (3 * seeds.size());
    for (const fs::path& seed : seeds) {
      const std::string bytes = read_text(seed), name = seed.filename().string();
      run(name, bytes);
      int k = 0;
      for (const std::string& other : changed(bytes, each)) run(name + ", change " + std::to_string(k++), other);
    }
  }
  EXPECT_EQ(what, "");
  RecordProperty("inputs", static_cast<int>(inputs));
}

INSTANTIATE_TEST_SUITE_P(Targets, FuzzReplay, testing::ValuesIn(targets()), [](const auto& of) { return std::string(of.param.name); });

}  // namespace

}  // namespace imulab::fuzz
