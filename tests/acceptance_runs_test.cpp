// The runs of an acceptance test come back as they were, and those that were kept are not made again.
#include <gmock/gmock.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/acceptance/shared_runs.hpp"
#include "tests/temporary_folder.hpp"
#include <atomic>
#include <cmath>

namespace imulab::acceptance {
namespace {

/// While it lives, runs are kept in a folder.
struct KeptIn {
  explicit KeptIn(const std::filesystem::path& folder) { shared_runs().checkpoint = folder; }
  ~KeptIn() { shared_runs() = {}; }
  KeptIn(const KeptIn&) = delete;
  KeptIn& operator=(const KeptIn&) = delete;
};

Run drawn_run(std::uint64_t seed) {
  const auto n = static_cast<Eigen::Index>(seed % 3);  // also none
  Run run{{CoefficientIndex(static_cast<int>(seed)), CoefficientIndex(7)}, Eigen::VectorXd::Constant(n, std::sqrt(seed)), {}, {}};
  run.covariance = Eigen::MatrixXd::Constant(n, 2, 1.0 / static_cast<double>(seed));
  return run;
}

void expect_drawn(const std::vector<Run>& runs) {
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Run drawn = drawn_run(i + 1);
    EXPECT_EQ(runs[i].indices, drawn.indices);
    EXPECT_EQ(runs[i].error, drawn.error);
    EXPECT_EQ(runs[i].covariance, drawn.covariance);
    EXPECT_EQ(runs[i].information.size(), 0);
  }
}

TEST(AcceptanceRuns, ComeBackAsTheyWere) {
  expect_drawn(run_all(drawn_run, 7));
  const TemporaryFolder folder;
  const KeptIn kept(folder / "kept");
  expect_drawn(run_all(drawn_run, 7, "a name"));
}

TEST(AcceptanceRuns, AreNotMadeAgain) {
  const TemporaryFolder folder;
  const KeptIn kept(folder / "kept");
  std::atomic<int> made = 0;
  const std::function<double(std::size_t)> run = [&](std::size_t i) { return ++made, std::sin(static_cast<double>(i)); };
  const auto first = runs_of<double>("runs", 20, run);
  EXPECT_EQ(made, 20);
  EXPECT_EQ(runs_of<double>("runs", 20, run), first);
  EXPECT_EQ(made, 20);
  EXPECT_THROW(runs_of<double>("runs", 21, run), Error) << "another number";
  EXPECT_EQ(made, 20);
}

TEST(AcceptanceRuns, WhatIsCutShortIsRefused) {
  acceptance::Run drawn = drawn_run(2);
  std::string bytes;
  write_run(bytes, drawn);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    std::string_view cut(bytes.data(), size);
    EXPECT_THROW(read_run(cut, drawn), Error) << size;
  }
}

}  // namespace
}  // namespace imulab::acceptance
