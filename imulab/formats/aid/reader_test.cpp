// Aids of sessions: their tables, and the files of receivers, on the recording's clock.
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/recording.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/temporary_folder.hpp"
#include <cmath>
#include <string>
#include <vector>

namespace imulab {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string aid_head = "format = \"imulab.session/1\"\n";

/// The message of the Error; "none" without one.
template <class F>
std::string aid_error(const F& f) {
  try {
    f();
  } catch (const Error& e) {
    return e.what();
  }
  return "none";
}

TEST(SessionAid, EveryKeyIsReadAndWrittenBack) {
  const Session session =
      parse_session(aid_head +
                        "[[aid]]\nkind = \"gnss\"\nfile = \"drive.pos\"\nlever_arm_m = [0.0, 0.5, 1.2]\nlever_arm_sigma_m = 0.05\n"
                        "delay_s = 0.1\ndelay_sigma_s = 0.02\nposition_sigma_m = 1.5\nvelocity_sigma_mps = 0.05\n"
                        "correlation_s = 60.0\noutages_s = [[300, 360], [600, 660.5]]\nrate_hz = 4\njumps_s = [[1, 2]]\njump_m = 20\n"
                        "[[aid]]\nkind = \"vehicle\"\nside_slip_sigma_mps = 0.1\nlever_arm_m = [0, -1, 0]\n"
                        "[[aid]]\nkind = \"wheels\"\nfile = \"w.csv\"\nspeed_sigma_mps = 0.2\n"
                        "[[aid]]\nkind = \"barometer\"\nfile = \"b.csv\"\nheight_sigma_m = 2\n"
                        "[[aid]]\nkind = \"heading\"\nfile = \"h.csv\"\nheading_sigma_deg = 1.5\n"
                        "[[aid]]\nkind = \"zero_velocity\"\nvelocity_sigma_mps = 0.01\n",
                    "s.toml");
  ASSERT_EQ(session.aids.size(), 6u);
  const Aid& gnss = session.aids[0];
  EXPECT_EQ(gnss.lever_arm, Eigen::Vector3d(0, 0.5, 1.2));
  EXPECT_EQ(gnss.outages, (std::vector<Outage>{{300, 360}, {600, 660.5}}));
  EXPECT_EQ(gnss.jump, 20);
  EXPECT_EQ(session.aids[4].value_sigma, 1.5 * unit::deg);
  Session again = parse_session(session_text(session), "s.toml");
  again.sha256 = session.sha256;
  EXPECT_TRUE(again == session) << session_text(session);
}

TEST(SessionAid, WhatIsWrongIsNamedWithItsLine) {
  const auto error = [](const std::string& table) { return aid_error([&] { parse_session(aid_head + table, "s.toml"); }); };
  EXPECT_EQ(error("[[aid]]\nkind = \"vehicle\"\nfile = \"a.csv\"\n").substr(0, 42), "s.toml:4: aid.file: is not a known key; ex");
  EXPECT_EQ(error("[[aid]]\nkind = \"gnss\"\nlever_arm_m = [0, 1]\n"), "s.toml:4: aid.lever_arm_m: 2 numbers; expected 3");
  EXPECT_EQ(error("[[aid]]\nkind = \"gnss\"\nposition_sigma_m = 0\n"), "s.toml:4: aid.position_sigma_m: 0 is out of range; expected more than 0");
  EXPECT_THAT(error("[[aid]]\nkind = \"gnss\"\noutages_s = [[60, 30]]\n"), HasSubstr("s.toml:4: aid.outages_s: are not in order"));
  EXPECT_THAT(error("[[aid]]\nkind = \"gnss\"\noutages_s = [60, 90]\n"), HasSubstr("s.toml:4: aid.outages_s: is no list of pairs"));
  EXPECT_THAT(error("[[aid]]\nkind = \"gnss\"\njumps_s = [[60, 90]]\n"), HasSubstr("jump_m: is missing"));
  EXPECT_THAT(error("[[aid]]\nkind = \"gps\"\n"), HasSubstr("s.toml:3: aid.kind: \"gps\" is not allowed; expected one of gnss, vehicle, wheels"));
  Session in_memory;
  in_memory.aids.emplace_back().delay = NAN;
  EXPECT_THAT(aid_error([&] { validate(in_memory); }), HasSubstr("aid.delay_s"));
}

/// 10 s at 100 Hz that begin at `begin_s`, and the session of one aid from the text of its file.
struct AidCase {
  TemporaryFolder folder;
  Session session;
  RecordingSource source;
  Recording recording;

  explicit AidCase(std::string_view name, std::string_view text, double begin_s, TimeScale scale = TimeScale::gps, AidKind kind = AidKind::gnss) {
    folder.write(name, text);
    session.file = (folder / "session.toml").string();
    source.file = "recording.csv";
    source.time.scale = scale;
    Aid& aid = session.aids.emplace_back();
    aid.kind = kind;
    aid.file = name;
    std::vector<double> t;
    for (int i = 0; i <= 1000; ++i) t.push_back(begin_s + 0.01 * i);
    const std::vector<double> zero(t.size());
    recording = make_recording(t, {zero, zero, zero}, {zero, zero, zero});
  }
  AidsReading read() const { return read_aids(session, source, recording); }
  AidRecord record() const { return read().aids.at(0).record; }
  std::string error() const {
    return aid_error([&] { read(); });
  }
};

// 2025-07-08 19:34:18 of GPS time, as seconds since 1970, and as a week and its seconds.
constexpr double pos_begin = 1752003258;
constexpr double pos_of_week = 243258;

const std::string pos_columns =
    "%  GPST            latitude(deg) longitude(deg) height(m) Q ns sdn(m) sde(m) sdu(m) sdne(m) sdeu(m) sdun(m) age(s) ratio vn(m/s) ve(m/s) "
    "vu(m/s) "
    "sdvn sdve sdvu sdvne sdveu sdvun\n";
std::string pos_row(const std::string& time) {
  return time + " 40.0966268 -105.1474483 1601.474 1 21 0.0099 0.0098 0.0100 0 0 0 0 0 0.5 -0.2 0.1 0.06 0.05 0.04 0 0 0\n";
}

TEST(RtklibSolution, GivesPositionAndVelocityInEastNorthUp) {
  const AidCase drive("drive.pos", pos_columns + pos_row("2025/07/08 19:34:18.499") + pos_row("2025/07/08 19:34:18.749"), pos_begin);
  const AidsReading reading = drive.read();
  EXPECT_TRUE(reading.warnings.empty());
  EXPECT_EQ(reading.aids[0].scale, TimeScale::recording);
  const AidRecord& r = reading.aids[0].record;
  EXPECT_THAT(r.time, ElementsAre(1'752'003'258'499'000'000, 1'752'003'258'749'000'000)) << "on the recording's clock, which counts from 1970";
  EXPECT_EQ(r.position[0], Eigen::Vector3d(40.0966268 * unit::deg, -105.1474483 * unit::deg, 1601.474));
  EXPECT_EQ(r.position_sigma[1], Eigen::Vector3d(0.0098, 0.0099, 0.01)) << "RTKLIB has north first";
  EXPECT_EQ(r.velocity[0], Eigen::Vector3d(-0.2, 0.5, 0.1));
  EXPECT_EQ(r.velocity_sigma[0], Eigen::Vector3d(0.05, 0.06, 0.04));
}

TEST(RtklibSolution, CountsTimeByDatesOrWeeksOfGpsUtcOrJapan) {
  const auto first = [](const std::string& text, double begin, TimeScale scale) {
    return 1e-9 * static_cast<double>(AidCase("a.pos", text, begin, scale).record().time[0]) - begin;
  };
  const auto with = [](std::string scale) { return "%  " + scale + pos_columns.substr(7); };
  const double near = 1e-6;  // a double of seconds since 1970 has microseconds
  EXPECT_NEAR(first(pos_columns + pos_row("2374 243258.499"), pos_begin, TimeScale::gps), 0.499, near);
  EXPECT_NEAR(first(pos_columns + pos_row("2374 243258.499"), pos_of_week, TimeScale::gps), 0.499, near)
      << "a clock that counts from the week's begin";
  EXPECT_NEAR(first(pos_columns + pos_row("2374 243258.499"), pos_begin - 315964800, TimeScale::gps), 0.499, near) << "or from 1980";
  EXPECT_NEAR(first(pos_columns + pos_row("2025/07/08 19:34:18.499"), pos_begin - 18, TimeScale::utc), 0.499, near) << "18 leap seconds";
  EXPECT_NEAR(first(with("UTC ") + pos_row("2025/07/08 19:34:00.499"), pos_begin, TimeScale::gps), 0.499, near);
  EXPECT_NEAR(first(with("JST ") + pos_row("2025/07/09 04:34:00.499"), pos_begin, TimeScale::gps), 0.499, near);
  EXPECT_EQ(leap_seconds(1483228799), 17);
  EXPECT_EQ(leap_seconds(1483228800), 18) << "2017-01-01";
}

TEST(RtklibSolution, ReadsDegreesMinutesAndSecondsAndOtherSeparators) {
  const AidCase drive("drive.pos", "%  GPST,latitude(d'\"),longitude(d'\"),height(m),Q\n2374,243258.5,40,30,36.0,-0,30,36.0,1601.5,5\n", pos_begin);
  const AidRecord r = drive.record();
  EXPECT_DOUBLE_EQ(r.position[0].x(), 40.51 * unit::deg);
  EXPECT_DOUBLE_EQ(r.position[0].y(), -0.51 * unit::deg);
  EXPECT_TRUE(r.velocity.empty() && r.position_sigma.empty());
}

TEST(RtklibSolution, WhatIsWrongIsNamedWithItsLine) {
  const auto error = [](const std::string& rows) { return AidCase("d.pos", pos_columns + rows, pos_begin).error(); };
  const std::string good = pos_row("2374 243258.5");
  EXPECT_THAT(error(good + "2374 243259.5 40.1\n" + good), HasSubstr("d.pos:3: 3 fields; expected 24"));
  EXPECT_THAT(error(good + pos_row("2374 243257.5")), HasSubstr("d.pos:3: time runs back by 1 s"));
  EXPECT_THAT(error(good + pos_row("2374 x")), HasSubstr("d.pos:3: 2374 x is not a date and time of day, or a GPS week"));
  EXPECT_THAT(error("2374 243258.5 -105.14 40.09 1601" + good.substr(good.find(" 1 21"))), HasSubstr("(latitude and longitude seem to be swapped)"));
  EXPECT_THAT(error("2374 243258.5 40.1 nan 1601" + good.substr(good.find(" 1 21"))), HasSubstr("d.pos:2: nan is not a number"));
  EXPECT_THAT(error("2374 243258.5 40.1 20 1e9" + good.substr(good.find(" 1 21"))), HasSubstr("d.pos:2: height: 1e+09 m is out of range"));
  EXPECT_THAT(error(""), HasSubstr("d.pos: has no row"));
  EXPECT_THAT(error("%  GPST  x-ecef(m)  y-ecef(m)  z-ecef(m)\n" + good), HasSubstr("d.pos:2: has x-ecef in place of latitude"));
  EXPECT_THAT(error(pos_row("2374 200000")), HasSubstr("d.pos: its stamps, 1751960000 to 1751960000 s, do not overlap the time of the recording"));
  const AidCase cut("d.pos", pos_columns + good + "2374 2432", pos_begin);
  EXPECT_THAT(cut.read().warnings, ElementsAre(HasSubstr("d.pos: ends inside a row")));
  const AidCase twice("d.pos", pos_columns + good + good, pos_begin);
  EXPECT_THAT(twice.read().warnings, ElementsAre(HasSubstr("1 rows repeat the stamp")));
  AidCase wheels("d.pos", pos_columns + good, pos_begin, TimeScale::gps, AidKind::wheels);
  EXPECT_THAT(wheels.error(), HasSubstr("is RTKLIB's solution, and the aid's kind is wheels"));
}

TEST(AidCsv, HasTheColumnsOfItsKind) {
  const AidCase drive("a.csv",
                      "t,latitude_deg,longitude_deg,height_m,east_sigma_m,north_sigma_m,up_sigma_m\n0.5,52,13,120,0,0,0\n1.5,52,13.1,121,0,0,0\n", 0,
                      TimeScale::own);
  const AidsReading reading = drive.read();
  EXPECT_THAT(reading.warnings, ElementsAre(HasSubstr("6 standard deviations are stated as 0")));
  EXPECT_EQ(reading.aids[0].scale, TimeScale::recording) << "t counts on the recording's clock";
  EXPECT_THAT(reading.aids[0].record.time, ElementsAre(500'000'000, 1'500'000'000));
  EXPECT_TRUE(reading.aids[0].record.position_sigma.empty());
  const AidRecord heading = AidCase("h.csv", "gps_s,heading_deg\n1436038460,90\n", 1436038458, TimeScale::gps, AidKind::heading).record();
  EXPECT_DOUBLE_EQ(heading.value[0], 90 * unit::deg);
  EXPECT_THAT(AidCase("w.csv", "t,speed\n0,1\n", 0, TimeScale::own, AidKind::wheels).error(), HasSubstr("expected speed_mps"));
  EXPECT_THAT(AidCase("w.csv", "t,ve,vn\n0,1,2\n", 0).error(), HasSubstr("has some of the columns ve, vn, vu"));
}

TEST(AidClock, AnUnknownClockIsGuessedAndSaid) {
  const std::string text = pos_columns + pos_row("2374 243258.5") + pos_row("2374 243259.5");
  const AidsReading by_date = AidCase("a.pos", text, pos_begin - 18, TimeScale::own).read();
  EXPECT_EQ(by_date.aids[0].scale, TimeScale::own);
  EXPECT_THAT(by_date.warnings, ElementsAre(HasSubstr("offset is estimated, from that of their dates on")));
  EXPECT_EQ(by_date.aids[0].record.time[0] - 1'752'003'240'000'000'000, 500'000'000);
  const AidsReading by_begin = AidCase("a.pos", text, 77, TimeScale::own).read();
  EXPECT_THAT(by_begin.warnings, ElementsAre(HasSubstr("from both beginning together on")));
  EXPECT_THAT(by_begin.aids[0].record.time, ElementsAre(77'000'000'000, 78'000'000'000));
  AidCase declared("a.pos", text, 77, TimeScale::own);
  EXPECT_FALSE(declared.read().aids[0].delay_sigma);
  declared.session.aids[0].delay_sigma = 0.02;  // of the receiver, not of the guess
  EXPECT_NEAR(declared.read().aids[0].delay_sigma.value(), 1, 1e-3);
}

TEST(AidReader, SwappedPlacesAreSeenByTheSession) {
  AidCase drive("a.csv", "t,latitude_deg,longitude_deg,height_m\n0.5,13,52,120\n", 0, TimeScale::own);
  drive.session.site.latitude = 52 * unit::deg, drive.session.site.longitude = 13 * unit::deg;
  EXPECT_THAT(drive.error(), AllOf(HasSubstr("a.csv: begins at latitude 13"), HasSubstr("expected them swapped")));
  drive.folder.write("recording.csv", "t,gx\n0,1\n");
  drive.session.aids[0].file = "absent.pos";
  EXPECT_THAT(drive.error(), AllOf(HasSubstr("absent.pos: is no file beside the session, and "), HasSubstr("recording.csv has no topics")));
}

}  // namespace
}  // namespace imulab
