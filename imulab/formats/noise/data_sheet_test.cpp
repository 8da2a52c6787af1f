// Data sheets as printed, against conversions by hand; bounds against the Allan deviation that they imply; bad input.
#include "imulab/formats/noise/data_sheet.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/temporary_folder.hpp"
#include <cmath>
#include <set>
#include <string>
#include <vector>

namespace imulab {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// SI of one printed unit, from pi / 180 = 0.017453292519943295, 1 h = 3600 s, g = 9.80665 m/s^2, 1 ft = 0.3048 m: an independent table.
constexpr double dps = 0.017453292519943295;          // deg/s
constexpr double mdps = 1.7453292519943295e-5;        // mdeg/s
constexpr double dph = 4.8481368110953598e-6;         // deg/h
constexpr double deg_root_h = 2.9088820866572159e-4;  // deg/sqrt(h)
constexpr double micro_g = 9.80665e-6, milli_g = 9.80665e-3;
constexpr double mps_root_h = 1.6666666666666667e-2;  // m/s/sqrt(h)
constexpr double fps_root_h = 5.08e-3;                // ft/s/sqrt(h)
constexpr double floor_of_B = 0.6642824702679601;     // sqrt(2 ln 2 / pi)

/// Expected values in SI; 0: the sheet does not print it. B from a printed stability is that over 0.664.
struct Printed {
  const char *device, *document, *text;
  double gyro_N = 0, gyro_B = 0, accel_N = 0, accel_B = 0;
};

const std::vector<Printed>& printed_sheets() {
  static const std::vector<Printed> all{
      {"ADIS16465", "Analog Devices, first page", "gyro.N = 0.15°/√hr, gyro.stability = 2°/hr", 0.15 * deg_root_h, 2 * dph / floor_of_B},
      {"ADIS16467", "Analog Devices, first page", "gyro.N = 0.15 °/√hr; gyro.stability = 2 °/hr", 0.15 * deg_root_h, 2 * dph / floor_of_B},
      {"ADIS16470", "Analog Devices, rev. C, first page", "gyro.N = 0.008°/sec/√Hz rms, gyro.stability = 8°/hr", 0.008 * dps, 8 * dph / floor_of_B},
      {"ADIS16475", "Analog Devices, first page", "gyro.N = 0.15°/√hr, gyro.stability = 2°/hr", 0.15 * deg_root_h, 2 * dph / floor_of_B},
      {"ADIS16495", "Analog Devices, rev. C, first page", "gyro.N = 0.09°/√hr, gyro.stability = 0.8°/hr", 0.09 * deg_root_h, 0.8 * dph / floor_of_B},
      {"ADIS16497", "Analog Devices, rev. D, first page", "gyro.N = 0.09 deg/rt-hr, gyro.stability = 0.8 deg/hr", 0.09 * deg_root_h,
       0.8 * dph / floor_of_B},
      {"ADIS16505", "Analog Devices, first page", "gyro.N = 0.13°/√hr, gyro.stability = 2.3°/hr", 0.13 * deg_root_h, 2.3 * dph / floor_of_B},
      {"MTi-300", "Movella leaflet, May 2023",
       "gyro.N = 0.01 º/s/√Hz, gyro.stability = 10 deg/h, accel.N = 60 µg/√Hz, accel.stability = 15 µg, kind = typical", 0.01 * dps,
       10 * dph / floor_of_B, 60 * micro_g, 15 * micro_g / floor_of_B},
      {"MTi-1", "as quoted in doi:10.2478/tar-2023-0022",
       "gyro.N = 0.007°/s/√Hz, gyro.stability = 10°/h, accel.N = 120μg/√Hz, accel.stability = 0.03 mg", 0.007 * dps, 10 * dph / floor_of_B,
       120 * micro_g, 0.03 * milli_g / floor_of_B},
      {"STIM300", "Safran, rev. 9, as quoted in NavToolkit",
       "gyro.N = 0.15 deg/sqrt(hr), gyro.B = 0.5 deg/hr, accel.N = 0.06 m/s/sqrt(hr), accel.B = 0.05 mg", 0.15 * deg_root_h, 0.5 * dph,
       0.06 * mps_root_h, 0.05 * milli_g},
      {"HG1700", "Honeywell N61-1619-000-001, as quoted in NavToolkit",
       "gyro.N = 0.125 deg/sqrt(hr) max, gyro.B = 1 deg/hr, accel.N = 0.065 ft/s/sqrt(hr) max, accel.B = 1 mg", 0.125 * deg_root_h, 1 * dph,
       0.065 * fps_root_h, 1 * milli_g},
      {"HG9900", "Honeywell N61-1638-000-000, as quoted in NavToolkit", "gyro.N = 0.002 deg/sqrt(hr) max, gyro.B = 0.0035 deg/hr", 0.002 * deg_root_h,
       0.0035 * dph},
      {"ICM-42688-P", "TDK DS-000347, rev. 1.7, p. 1", "gyro.N = 2.8 mdps/√Hz, accel.N = 70 µg/√Hz", 2.8 * mdps, 0, 70 * micro_g},
      {"ICM-42688-V", "TDK, p. 1", "gyro.N = 2.8 mdps/rtHz, accel.N = 70 ug/rtHz", 2.8 * mdps, 0, 70 * micro_g},
      {"ICM-42605", "TDK DS-000292, rev. 1.5, p. 1", "gyro.N = 3.8 mdps/√Hz, accel.N = 70 μg/√Hz", 3.8 * mdps, 0, 70 * micro_g},
      {"ICM-40609-D", "TDK DS-000330, rev. 1.2, p. 1", "gyro.N = 4.5mdps/√Hz, accel.N = 100μg/√Hz", 4.5 * mdps, 0, 100 * micro_g},
      {"ICM-20602", "TDK, p. 1", "gyro.N = 4 mdps/√Hz, accel.N = 100 µg/√Hz", 4 * mdps, 0, 100 * micro_g},
      {"ICG-20660", "TDK, p. 1", "gyro.N = 6.5mdps/√Hz", 6.5 * mdps},
      {"ICM-20948", "TDK DS-000189, rev. 1.3, p. 12", "accel.N = 230 µg/√Hz", 0, 0, 230 * micro_g},
      {"BMI270", "Bosch BST-BMI270-DS000-07, rev. 1.5", "gyro.N = 0.007 dps/sqrt(Hz) typ, accel.N = 0.16 mg/sqrt(Hz) typ", 0.007 * dps, 0,
       0.16 * milli_g},
      {"MPU-6050", "InvenSense PS-MPU-6000A-00, rev. 3.4, p. 12 and 13", "gyro.N = 0.005 º/s/√Hz, accel.N = 400 µg/√Hz", 0.005 * dps, 0,
       400 * micro_g},
      // 100 Hz and first order: 0.05 / sqrt(157.08) deg/s/sqrt(Hz).
      {"MPU-6050 by its RMS", "the same, p. 12", "gyro.rms = 0.05 º/s-rms, gyro.bandwidth = 100 Hz", 3.98942280401433e-3 * dps},
      {"MPU-9250", "InvenSense PS-MPU-9250A-01, rev. 1.0, p. 8 and 9", "gyro.N = 0.01 º/s/√Hz, accel.N = 300 µg/√Hz", 0.01 * dps, 0, 300 * micro_g},
      // 92 Hz and 94 Hz, first order: 0.1 / sqrt(144.51) deg/s/sqrt(Hz), 8 / sqrt(147.65) mg/sqrt(Hz).
      {"MPU-9250 by its RMS", "the same", "gyro.rms = 0.1 º/s-rms, gyro.bandwidth = 92 Hz, accel.rms = 8 mg-rms, accel.bandwidth = 94 Hz",
       8.318521584049795e-3 * dps, 0, 0.6583640704591531 * milli_g},
      {"BMI160", "Bosch BST-BMI160-DS000, as quoted in public code", "gyro.N = 0.007 deg/s/sqrt(Hz), accel.N = 180 ug/sqrt(Hz) typ", 0.007 * dps, 0,
       180 * micro_g},
      {"BMX160", "Bosch, as quoted in public code", "gyro.N = 0.007 deg/s/sqrt(Hz), accel.N = 180 ug/sqrt(Hz)", 0.007 * dps, 0, 180 * micro_g},
      {"BMI088", "Bosch BST-BMI088-DS001, as quoted in public code", "gyro.N = 0.014 dps/√Hz, accel.N = 175 µg/√Hz", 0.014 * dps, 0, 175 * micro_g},
      {"VN-100", "VectorNav, rev. 2, as quoted in public code", "gyro.N = 0.0035 °/s/√Hz, accel.N = 0.14 mg/√Hz, accel.stability = 0.04 mg",
       0.0035 * dps, 0, 0.14 * milli_g, 0.04 * milli_g / floor_of_B},
      {"ADIS16448", "Analog Devices, as quoted in public notes on EuRoC", "gyro.N = 0.66°/√hr, gyro.stability = 14.5 °/hr, accel.N = 0.11 m/s/√hr",
       0.66 * deg_root_h, 14.5 * dph / floor_of_B, 0.11 * mps_root_h},
      {"ADIS16448 by its densities", "the same", "gyro.N = 0.0135 °/s/√Hz, accel.N = 0.23 mg/√Hz", 0.0135 * dps, 0, 0.23 * milli_g},
      {"ADIS16260", "Analog Devices, as quoted in public code", "gyro.N = 0.044 deg/s/sqrt(Hz)", 0.044 * dps},
      {"HG4930", "Honeywell manual of July 2017, as quoted in a public survey", "gyro.N = 0.04 °/√h, gyro.stability = 0.25 °/h", 0.04 * deg_root_h,
       0.25 * dph / floor_of_B},
      {"LSM6DSV", "ST, as quoted by Luxonis", "gyro.N = 2.8 mdps/sqrt(Hz) typ, accel.N = 60 ug/sqrt(Hz) typ", 2.8 * mdps, 0, 60 * micro_g},
      // Noise bandwidth of ODR / 2 at 104 Hz: 1.8 / sqrt(52) mg/sqrt(Hz).
      {"LSM6DSO, normal mode", "ST DS12140, rev. 2, p. 10", "accel.rms = 1.8 mg(RMS), accel.noise_bandwidth = 52 Hz", 0, 0,
       0.249615088301353 * milli_g},
  };
  return all;
}

TEST(DataSheet, ValuesAsPrintedAreThoseOfATableOfConversions) {
  for (const Printed& sheet : printed_sheets()) {
    const NoiseAnalysis noise = data_sheet_noise(parse_data_sheet(sheet.text));
    EXPECT_EQ(noise.axes.size(), (sheet.gyro_N > 0 ? 3u : 0u) + (sheet.accel_N > 0 ? 3u : 0u)) << sheet.device;
    for (const NoiseAxis& axis : noise.axes) {
      const bool gyro = axis.name.starts_with("gyro");
      const double N = gyro ? sheet.gyro_N : sheet.accel_N, B = gyro ? sheet.gyro_B : sheet.accel_B;
      EXPECT_NEAR(axis.fit->N.value / N, 1, 1e-12) << sheet.device << ", " << sheet.document << ", " << axis.name;
      EXPECT_EQ(axis.fit->B.determined, B > 0) << sheet.device;
      if (B > 0) EXPECT_NEAR(axis.fit->B.value / B, 1, 2e-8) << sheet.device << ", " << sheet.document << ", " << axis.name;
    }
  }
  std::set<std::string_view> devices;
  for (const Printed& sheet : printed_sheets())
    devices.insert(std::string_view(sheet.device).substr(0, std::string_view(sheet.device).find(" by its")));
  EXPECT_GE(devices.size(), 30u);
}

double N_of(const std::string& text) { return data_sheet_noise(parse_data_sheet(text)).axes.at(0).fit->N.value; }

TEST(DataSheet, SpellingsOfAUnitAreOneUnit) {
  for (const char* unit : {"deg/s/sqrt(Hz)", "dps/rtHz", "°/s/√Hz", "º/sec/√Hz", "(deg/s)/sqrt(Hz)", "deg/s/Hz^0.5", "DPS/√(Hz)", "deg / s / sqrt Hz",
                           "deg/s·Hz^(-0.5)", "deg/sqrt(s)", "degrees/s/Hz½", "°/s/√Hz rms", "deg/s/sqrt(Hz) typical"})
    EXPECT_NEAR(N_of(std::string("gyro.N = 2 ") + unit) / (2 * dps), 1, 1e-12) << unit;
  for (const auto& [unit, size] : std::vector<std::pair<const char*, double>>{{"mdps/√Hz", mdps},
                                                                              {"deg/h/sqrt(Hz)", dph},
                                                                              {"deg/√h", deg_root_h},
                                                                              {"deg/rt hr", deg_root_h},
                                                                              {"rad/s/√Hz", 1},
                                                                              {"µrad/s/√Hz", 1e-6},
                                                                              {"mrad/√h", 1e-3 / 60},
                                                                              {"arcsec/√s", dph}})
    EXPECT_NEAR(N_of(std::string("gyro.N = 3 ") + unit) / (3 * size), 1, 1e-12) << unit;
  for (const auto& [unit, size] : std::vector<std::pair<const char*, double>>{{"ug/sqrt(Hz)", micro_g},
                                                                              {"mg/√Hz", milli_g},
                                                                              {"m/s/√h", mps_root_h},
                                                                              {"ft/s/rt-hr", fps_root_h},
                                                                              {"m/s²/√Hz", 1},
                                                                              {"m/s2/rtHz", 1},
                                                                              {"m/sec^2/sqrt(Hz)", 1},
                                                                              {"mGal/√Hz", 1e-5},
                                                                              {"g/√Hz", 9.80665}})
    EXPECT_NEAR(N_of(std::string("accel.N = 3 ") + unit) / (3 * size), 1, 1e-12) << unit;
  // A power spectral density is the square.
  EXPECT_NEAR(N_of("gyro.psd = 1e-4 (deg/s)^2/Hz") / (1e-2 * dps), 1, 1e-12);
  EXPECT_NEAR(N_of("accel.psd = 4900 ug^2/Hz") / (70 * micro_g), 1, 1e-12);
  // In-run stability of ADIS16505 as printed, 26.5 um/sec^2.
  const NoiseAnalysis adis = data_sheet_noise(parse_data_sheet("accel.N = 1 mg/√Hz, accel.stability = 26.5 μm/sec²"));
  EXPECT_NEAR(adis.axes[0].fit->B.value / (26.5e-6 / floor_of_B), 1, 2e-8);
}

/// The noise of a first-order low-pass of -3 dB at 80 Hz, summed over frequency, has the variance that the bandwidth's formula gives.
TEST(DataSheet, AnRmsInABandwidthIsThatOfAFirstOrderLowPass) {
  const double N = N_of("gyro.rms = 0.06 deg/s, gyro.bandwidth = 80 Hz");
  double variance = 0;
  for (double hz = 0.005; hz < 4e4; hz += 0.01) variance += N * N / (1 + std::pow(hz / 80, 2)) * 0.01;
  variance += N * N * 80 * 80 / 4e4;  // above 40 kHz
  EXPECT_NEAR(std::sqrt(variance) / (0.06 * dps), 1, 1e-4);
  EXPECT_NEAR(N_of("gyro.rms = 0.06 deg/s, gyro.noise_bandwidth = 80 Hz") / (0.06 * dps / std::sqrt(80)), 1, 1e-12);
}

/// The minimum over averaging times of the Allan deviation of N, B and K.
double minimum_deviation(double N, double B, double K) {
  double least = INFINITY;
  for (double tau = 1e-3; tau < 1e9; tau *= 1.001) {
    const double variance = N * N / tau + std::pow(floor_of_B * B, 2) + K * K * tau / 3;
    least = std::min(least, std::sqrt(variance));
  }
  return least;
}

TEST(DataSheet, BoundsAreReachedByTheDeviationThatTheSheetPrints) {
  const double N = 0.002 * dps, m = 5 * dph;
  const NoiseFit by_minimum = *data_sheet_noise(parse_data_sheet("gyro.N = 0.002 deg/s/sqrt(Hz), gyro.stability = 5 deg/h")).axes[0].fit;
  EXPECT_TRUE(by_minimum.B.bounded && by_minimum.B.determined && by_minimum.K.bounded && !by_minimum.K.determined);
  EXPECT_NEAR(minimum_deviation(N, by_minimum.B.upper, 0) / m, 1, 1e-6) << "K = 0, at averaging times without end";
  EXPECT_NEAR(minimum_deviation(N, 0, by_minimum.K.upper) / m, 1, 1e-6) << "B = 0";
  const NoiseFit by_B = *data_sheet_noise(parse_data_sheet("gyro.N = 0.002 deg/s/sqrt(Hz), gyro.B = 5 deg/h")).axes[0].fit;
  EXPECT_FALSE(by_B.B.bounded);
  EXPECT_NEAR(minimum_deviation(N, 0, by_B.K.upper) / (floor_of_B * by_B.B.value), 1, 1e-6);
  const NoiseFit by_K = *data_sheet_noise(parse_data_sheet("gyro.N = 0.002 deg/s/sqrt(Hz), gyro.K = 2 deg/h/sqrt(h)")).axes[0].fit;
  EXPECT_NEAR(minimum_deviation(N, 0, 2 * dph / 60) / (floor_of_B * by_K.B.upper), 1, 1e-6);
  EXPECT_TRUE(by_K.K.determined && !by_K.K.bounded && by_K.B.bounded && !by_K.B.determined);
  // N alone: the walk that exports assume without a log, and the flicker that is as high where it meets the white noise.
  const NoiseFit by_N = *data_sheet_noise(parse_data_sheet("gyro.N = 0.002 deg/s/sqrt(Hz)")).axes[0].fit;
  EXPECT_NEAR(by_N.K.upper / N, 0.1, 1e-12);
  EXPECT_NEAR(minimum_deviation(N, 0, by_N.K.upper) / (floor_of_B * by_N.B.upper), 1, 1e-6);
}

TEST(DataSheet, AMaximumIsItsOwnBoundAndATypicalValueHasNone) {
  for (const char* text : {"gyro.N <= 0.1 deg/sqrt(h)", "gyro.N = <0.1 deg/sqrt(h)", "gyro.N ≤ 0.1 deg/sqrt(h)", "gyro.N = 0.1 deg/sqrt(h) max",
                           "kind = maximum, gyro.N = 0.1 deg/sqrt(h)", "gyro.N = 0.1 deg/sqrt(h); kind = maximum"}) {
    const NoiseFit x = *data_sheet_noise(parse_data_sheet(text)).axes[0].fit;
    EXPECT_EQ(x.N.upper, x.N.value) << text;
    EXPECT_EQ(sheet_standing(x, x.N), "maximum") << text;
    EXPECT_EQ(sheet_standing(x, x.K), "assumed") << text;
  }
  for (const char* text : {"gyro.N = 0.1 deg/sqrt(h)", "gyro.N = 0.1 deg/sqrt(h) typ", "kind = maximum, gyro.N = 0.1 deg/sqrt(h) typical"}) {
    const NoiseFit x = *data_sheet_noise(parse_data_sheet(text)).axes[0].fit;
    EXPECT_EQ(sheet_standing(x, x.N), "typical") << text;
  }
  for (const char* more : {"gyro.stability = 1 deg/h", "gyro.B = 1 deg/h", "gyro.K = 1 deg/h/sqrt(h)"}) {
    const NoiseFit x = *data_sheet_noise(parse_data_sheet(std::string("gyro.N = 0.1 deg/sqrt(h), ") + more)).axes[0].fit;
    EXPECT_EQ(sheet_standing(x, x.K.bounded ? x.K : x.B), "bounded") << more;
  }
}

TEST(DataSheet, AnAxisReplacesItsTriad) {
  const NoiseAnalysis noise =
      data_sheet_noise(parse_data_sheet("gyro.N = 1 deg/sqrt(h), gyro.z.rms = 1 deg/s, gyro.bandwidth = 50 Hz, gyro.x.B = 3 deg/h"));
  EXPECT_NEAR(noise.axes[0].fit->N.value / deg_root_h, 1, 1e-12);
  EXPECT_NEAR(noise.axes[2].fit->N.value / (dps / std::sqrt(25 * M_PI)), 1, 1e-12);
  EXPECT_TRUE(noise.axes[0].fit->B.determined);
  EXPECT_FALSE(noise.axes[1].fit->B.determined);
}

TEST(DataSheet, AFileHasTheSameKeys) {
  const std::string toml =
      "[noise]\nname = \"ICM-42688-P, rev. 1.7\"\nkind = \"typical\"\nrate = \"1 kHz\"\n"
      "gyro.N = \"2.8 mdps/√Hz\"\ngyro.x.N = \"<= 3.2 mdps/√Hz\"\naccel = { N = \"70 µg/√Hz\" }\n";
  const NoiseAnalysis noise = data_sheet_noise(parse_data_sheet_file(toml, "sheet.toml"));
  EXPECT_EQ(noise.recording, "ICM-42688-P, rev. 1.7");
  EXPECT_DOUBLE_EQ(noise.interval_s, 1e-3);
  EXPECT_NEAR(noise.axes[0].fit->N.value / (3.2 * mdps), 1, 1e-12);
  EXPECT_EQ(sheet_standing(*noise.axes[0].fit, noise.axes[0].fit->N), "maximum");
  EXPECT_NEAR(noise.axes[1].fit->N.value / (2.8 * mdps), 1, 1e-12);
  EXPECT_NEAR(noise.axes[5].fit->N.value / (70 * micro_g), 1, 1e-12);
  const auto message = [](const std::string& text) { return [text] { parse_data_sheet_file(text, "sheet.toml"); }; };
  EXPECT_THAT(message("[noise]\n\ngyro.N = \"2.8 mdps/Hz\"\n"),
              ThrowsMessage<Error>(HasSubstr("sheet.toml:3: noise.gyro.N: \"mdps/Hz\" is not a unit of N")));
  EXPECT_THAT(message("[noise]\ngyro.M = \"2.8 mdps/Hz\"\n"), ThrowsMessage<Error>(HasSubstr("sheet.toml:2: noise.gyro.M: is not a known key")));
  EXPECT_THAT(message("[noise]\ngyro.N = 2.8\n"), ThrowsMessage<Error>(HasSubstr("expected text in quotes")));
  EXPECT_THAT(message("[noise]\n"), ThrowsMessage<Error>(HasSubstr("sheet.toml: noise: has no value")));
  EXPECT_THAT(message("[imu]\n"), ThrowsMessage<Error>(HasSubstr("noise")));
}

TEST(DataSheet, AFileOfNoiseIsNoDataSheet) {
  const TemporaryFolder folder;
  folder.write("n.json", " {\"format\": \"imulab.noise/1\"}");
  EXPECT_THAT([&] { read_data_sheet((folder / "n.json").string()); },
              ThrowsMessage<Error>(HasSubstr("n.json: is JSON; expected TOML with [noise]. A noise.json is what --datasheet writes: give it to")));
}

TEST(DataSheet, ItsFileOfNoiseReadsBack) {
  const NoiseAnalysis noise = data_sheet_noise(parse_data_sheet("gyro.N = 2 mdps/√Hz, gyro.stability = 3 deg/h, accel.N <= 70 µg/√Hz"));
  const std::string text = noise_json(noise);
  const ImuNoise back = parse_noise(text, "noise.json");
  EXPECT_TRUE(back.from_data_sheet);
  EXPECT_EQ(back.gyro[1]->N.value, noise.axes[1].fit->N.value);
  EXPECT_TRUE(std::isinf(back.gyro[1]->N.upper) && std::isinf(back.gyro[1]->N.standard_uncertainty));
  EXPECT_EQ(back.accel[2]->N.upper, noise.axes[5].fit->N.value);
  EXPECT_TRUE(back.gyro[0]->B.bounded && back.gyro[0]->K.bounded && !back.gyro[0]->N.bounded);
  const nlohmann::json json = nlohmann::json::parse(text);
  EXPECT_EQ(json.at("source"), "data sheet");
  EXPECT_EQ(json.at("axes").at(0).at("coefficients").at("B").at("bounded"), true);
  EXPECT_FALSE(json.at("axes").at(0).contains("tau") || json.contains("deviation") || json.at("axes").at(0).contains("fit"));
  // What predictions take of it: the bound that a printed stability implies, but no term that the sheet says nothing about.
  EXPECT_EQ(noise_sizes(back).gyro.B, back.gyro[0]->B.upper);
  EXPECT_EQ(noise_sizes(back).gyro.K, 0);
  std::string other = text;
  other.replace(other.find("data sheet"), 10, "catalogue!");
  EXPECT_THAT([&] { parse_noise(other, "noise.json"); }, ThrowsMessage<Error>(HasSubstr("source")));
}

TEST(DataSheet, BadInputIsNamed) {
  struct Bad {
    const char *text, *message;
  };
  for (const Bad& bad : {
           Bad{"gyro.N = 5 furlong/s", "gyro.N: \"furlong/s\" is not a known unit; expected one such as deg/s/sqrt(Hz), mdps/sqrt(Hz)"},
           {"accel.N = 5 deg/sqrt(h)", "accel.N: \"deg/sqrt(h)\" is not a unit of N; expected one such as ug/sqrt(Hz), mg/sqrt(Hz), m/s/sqrt(h)"},
           {"gyro.N = 5 deg/h", "is not a unit of N; it is a unit of gyro.rms"},
           {"gyro.psd = 5 mdps/sqrt(Hz)", "is not a unit of psd; it is a unit of gyro.N; expected one such as (deg/s)^2/Hz"},
           {"gyro.N = 5", "gyro.N: has no unit; expected one such as deg/s/sqrt(Hz)"},
           {"gyro.N = deg/s", "gyro.N: \"deg/s\": expected a number above 0 and its unit"},
           {"gyro.N = -1 deg/sqrt(h)", "expected a number above 0"},
           {"gyro.N = nan deg/sqrt(h)", "expected a number above 0"},
           {"gyro.N = 1e999 deg/sqrt(h)", "expected a number above 0"},
           {"gyros.N = 1 deg/sqrt(h)", "gyros.N: is not a value of a data sheet; did you mean gyro.N?"},
           {"gyro.q.N = 1 deg/sqrt(h)", "is not a value of a data sheet"},
           {"gyro.N 1 deg/sqrt(h)", "expected KEY = NUMBER UNIT"},
           {"gyro.N = 0,0038 deg/s/sqrt(Hz)", "gyro.N: \"0,0038 deg/s/sqrt(Hz)\": has a decimal comma; expected a point, as in 0.0038"},
           {"gyro.N = 0.1 deg/sqrt(h),accel.N = 1,5 mg/√Hz", "accel.N: \"1,5 mg/√Hz\": has a decimal comma"},
           {"gyro.ARW = 3 deg/sqrt(h)", "gyro.ARW: is not a value of a data sheet; did you mean gyro.N?"},
           {"VRW = 3 m/s/sqrt(h)", "did you mean accel.N?"},
           {"gyro bias instability = 3 deg/h", "did you mean gyro.B?"},
           {"accelerometer.in-run bias stability = 3 ug", "did you mean accel.stability?"},
           {"gyro.RRW = 3 deg/h/sqrt(h)", "did you mean gyro.K?"},
           {"gyro.scale = 3 ppm", "gyro.scale: is not a value of a data sheet; expected one of gyro.N, gyro.psd"},
           {"", "has no value; expected KEY = NUMBER UNIT"},
           {"kind = typical", "has no value"},
           {"kind = usual, gyro.N = 1 deg/sqrt(h)", "kind: \"usual\" is not allowed; expected typical or maximum"},
           {"gyro.N = 1 deg/sqrt(h), gyro.N = 2 deg/sqrt(h)", "gyro.N: is given twice: \"gyro.N = 1 deg/sqrt(h)\""},
           {"gyro.B = 1 deg/h", "gyro: has no white noise; expected gyro.N, gyro.psd, or gyro.rms with gyro.bandwidth"},
           {"gyro.N = 1 deg/sqrt(h), gyro.psd = 1 (deg/s)^2/Hz", "gyro: gives the white noise twice"},
           {"gyro.x.N = 1 deg/sqrt(h)", "gyro.y: has no white noise"},
           {"gyro.rms = 1 deg/s", "needs one bandwidth; expected gyro.bandwidth (-3 dB, first order) or noise_bandwidth"},
           {"gyro.rms = 1 deg/s, gyro.bandwidth = 5 Hz, gyro.noise_bandwidth = 5 Hz", "needs one bandwidth"},
           {"rate = 5 m, gyro.N = 1 deg/sqrt(h)", "rate: \"m\" is not a unit of rate"},
           {"gyro.N = 1 ((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((deg", "is not a known unit"},
           {"gyro.N = 1 deg^99/s", "is not a known unit"},
       })
    EXPECT_THAT([&] { data_sheet_noise(parse_data_sheet(bad.text)); }, ThrowsMessage<Error>(HasSubstr(bad.message))) << bad.text;
}

TEST(DataSheet, ALogIsComparedWithItsValues) {
  NoiseAnalysis log;
  NoiseAxis axis{.name = "gyro.y", .unit = "rad/s"};
  axis.fit.emplace();
  axis.fit->N = {1e-4, 1e-6, 0.98e-4, 1.02e-4, true};
  axis.fit->B = undetermined_below(4e-6);
  axis.fit->K = {2e-7, 1e-8, 1.8e-7, 2.2e-7, true};
  for (const double deviation : {3e-6, 1e-6, 2e-6})
    axis.deviation.push_back({.tau = 1, .deviation = deviation, .lower_95 = 0.9 * deviation, .upper_95 = 1.2 * deviation});
  log.axes.push_back(axis);
  const DataSheet sheet = parse_data_sheet(
      "gyro.N = 1.01e-4 rad/s/sqrt(Hz), gyro.B = 5e-6 rad/s, gyro.K = 1e-7 rad/s/sqrt(s), gyro.stability = 1.1e-6 rad/s, accel.N = 1 ug/sqrt(Hz)");
  const std::vector<SheetComparison> rows = compare_with_sheet(log, sheet);
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[0].name, "gyro.y.N");
  EXPECT_TRUE(rows[0].contained());
  EXPECT_NEAR(rows[0].ratio(), 1 / 1.01, 1e-12);
  EXPECT_TRUE(std::isnan(rows[1].value)) << "B is not determined";
  EXPECT_FALSE(rows[1].contained()) << "5e-6 is above its bound";
  EXPECT_FALSE(rows[2].contained());
  EXPECT_EQ(rows[3].name, "gyro.y.stability");
  EXPECT_EQ(rows[3].value, 1e-6);
  EXPECT_TRUE(rows[3].contained());
  log.axes[0].deviation.pop_back();  // now the deviation still falls at the log's end
  EXPECT_TRUE(std::isnan(compare_with_sheet(log, sheet)[3].value));
  log.axes[0].unit = "count";
  EXPECT_THAT([&] { compare_with_sheet(log, sheet); }, ThrowsMessage<Error>(HasSubstr("in counts")));
}

TEST(DataSheet, TheStabilityOfALogIsThatOfItsB) {
  NoiseAnalysis log;
  NoiseAxis& axis = log.axes.emplace_back();
  axis.name = "gyro.x", axis.unit = "rad/s";
  axis.fit.emplace();
  axis.fit->B = {1e-5, 1e-6, 0.8e-5, 1.2e-5, true};
  axis.deviation.resize(3);  // the least of few scattered points may be far below
  const std::vector<SheetComparison> rows = compare_with_sheet(log, parse_data_sheet("gyro.N = 1e-5 rad/s/sqrt(Hz), gyro.stability = 0.5e-5 rad/s"));
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_NEAR(rows[1].value, floor_of_B * 1e-5, 1e-12);
  EXPECT_NEAR(rows[1].lower, floor_of_B * 0.8e-5, 1e-12);
  EXPECT_NEAR(rows[1].upper, floor_of_B * 1.2e-5, 1e-12);
}

}  // namespace
}  // namespace imulab
