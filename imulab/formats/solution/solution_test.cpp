#include "imulab/formats/solution/solution.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/navigate.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include "tests/temporary_folder.hpp"
#include <filesystem>
#include <future>
#include <string>
#include <sys/stat.h>

namespace imulab {
namespace {

const std::string header = "t,latitude_deg,longitude_deg,height_m,ve,vn,vu,roll_deg,pitch_deg,heading_deg\n";

TEST(SolutionFile, ReadsBackWhatWasWritten) {
  Solution written;
  for (int i = 0; i < 3; ++i) {
    NavigationState s;
    s.latitude = 0.7 + 1e-6 * i;
    s.longitude = -2.1;
    s.height = 1234.5 + i;
    s.velocity = {1, -2, 3. * i};
    s.q_nb = Eigen::Quaterniond(attitude_matrix({0.1, -0.2, 3.1 + i}));
    written.time.push_back(0.01 * i);
    written.states.push_back(s);
  }
  const TemporaryFolder folder;
  write_solution(folder / "nav.csv", written);
  const Solution read = read_solution(folder / "nav.csv");
  ASSERT_EQ(read.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const NavigationState &a = written.states[i], &b = read.states[i];
    EXPECT_DOUBLE_EQ(read.time[i], written.time[i]);
    EXPECT_NEAR(b.latitude, a.latitude, 1e-14);  // the last of twelve decimals of a degree: 0.1 um
    EXPECT_NEAR(b.longitude, a.longitude, 1e-14);
    EXPECT_NEAR(b.height, a.height, 1e-6);
    EXPECT_LT((b.velocity - a.velocity).norm(), 1e-7);
    EXPECT_LT(a.q_nb.angularDistance(b.q_nb), 1e-10);
  }
}

TEST(SolutionFile, IsTheSameOnAStreamWhichGetsItWholeOrNotAtAll) {
  const TemporaryFolder folder;
  const std::filesystem::path pipe = folder / "pipe", plain = folder / "nav.csv";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const auto add_states = [](SolutionFile& file) {
    constexpr int states = 25'000;  // many of them wait in the temporary file, the last ones in memory
    for (int i = 0; i < states; ++i) {
      NavigationState s;
      s.latitude = 0.7 + 1e-6 * i, s.longitude = -2.1 + 1e-7 * i, s.height = 0.1 * i;
      s.velocity = {1e-3 * i, -2, 3};
      s.q_nb = Eigen::Quaterniond(attitude_matrix({0.1, -0.2, 1e-4 * i}));
      file.add(0.01 * i, s);
    }
  };
  SolutionFile file(plain);
  add_states(file);
  file.commit();
  const std::string written(MappedFile(plain).text());
  for (const bool finished : {true, false}) {
    std::future<std::string> read = std::async(std::launch::async, [&] { return std::string(MappedFile(pipe).text()); });
    {
      SolutionFile stream(pipe);
      add_states(stream);
      EXPECT_EQ(stream.states(), file.states());
      if (finished) stream.commit();
    }
    EXPECT_TRUE(read.get() == (finished ? written : "")) << finished;
  }
}

TEST(SolutionFile, RefusesWhatIsNoSolution) {
  const TemporaryFolder folder;
  const auto message = [&](const std::string& rows) {
    try {
      read_solution(folder.write("truth.csv", rows));
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_THAT(message(header + "0,91,0,0,0,0,0,0,0,0\n"), testing::HasSubstr("truth.csv:2: latitude_deg: 91"));
  EXPECT_THAT(message(header + "0,nan,0,0,0,0,0,0,0,0\n"), testing::HasSubstr("truth.csv:2"));
  EXPECT_THAT(message(header + "1,0,0,0,0,0,0,0,0,0\n0,0,0,0,0,0,0,0,0,1\n"), testing::HasSubstr("truth.csv:3"));
  EXPECT_THAT(message("t,latitude_deg\n0,1\n"), testing::HasSubstr("longitude_deg"));
  EXPECT_THAT(message(header), testing::HasSubstr("truth.csv"));
}

}  // namespace
}  // namespace imulab
