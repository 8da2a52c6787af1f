// What a target is said to lose is what it loses; names, units and values that a target cannot take are refused or named.
#include "imulab/io/export/loss.hpp"

#include "imulab/core/error.hpp"
#include "imulab/io/export/consumer_model.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/model/lever_arm.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/export_unit.hpp"
#include <functional>
#include <regex>
#include <sstream>

namespace imulab::export_test {
namespace {

using export_io::Held;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::ThrowsMessage;

/// The size in a sentence "...: up to 1.9 mg at 1 g" in SI; NaN where no sentence begins so.
double stated(const std::vector<std::string>& sentences, const std::string& begin) {
  static const std::regex size("up to ([-+.0-9e]+) (ug|mg|deg/h|deg/s)");
  for (const std::string& sentence : sentences) {
    std::smatch match;
    if (!sentence.starts_with(begin) || !std::regex_search(sentence, match, size)) continue;
    const double factor = match[2] == "ug" ? unit::ug : match[2] == "mg" ? 1e3 * unit::ug : match[2] == "deg/h" ? unit::deg_per_h : unit::deg;
    return std::stod(match[1]) * factor;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// The largest difference of an axis between `compensate` and another correction over random motions of 1 g and 100 deg/s, at random temperatures
/// (half of them at the ends, where a polynomial is often largest).
struct Difference {
  double force = 0, rate = 0;
};
Difference measured(const SensorModel& truth, const std::function<Motion(const RawSample&)>& other, bool over_temperature) {
  const RandomStream directions(1, "loss"), temperatures(2, "loss");
  Difference most;
  for (std::uint64_t i = 0; i < 50000; ++i) {
    const auto tau = [&](const TriadModel& m) {
      if (!over_temperature || !m.temperature) return 0.0;
      const double u = temperatures.uniform(i), T0 = m.temperature->range[0], T1 = m.temperature->range[1];
      return (u < 0.25 ? T0 : u > 0.75 ? T1 : T0 + (T1 - T0) * (2 * u - 0.5)) - m.temperature->reference;
    };
    const Motion motion{unit::g * random_direction(directions, 2 * i), 100 * unit::deg * random_direction(directions, 2 * i + 1)};
    const RawSample raw = decompensate(truth, motion, Vector3d::Constant(tau(truth.accel)), Vector3d::Constant(tau(truth.gyro)));
    const Motion m = other(raw);
    most.force = std::max(most.force, (m.force - motion.force).cwiseAbs().maxCoeff());
    most.rate = std::max(most.rate, (m.rate - motion.rate).cwiseAbs().maxCoeff());
  }
  return most;
}

TEST(ExportLoss, OfAllTermsTogetherIsTheDifferenceFromCompensate) {
  Calibration c = thermal_unit(21);
  c.model.accel.quadratic = {2e-5, -3e-5, 1e-5};
  const SensorModel& m = c.model;
  const export_io::ConsumerModel consumer = export_io::consumer_model(m);
  const Vector3d b_a = consumer.accel.b, b_g = consumer.gyro.b;
  const Matrix3d C_a = consumer.accel.C, C_g = consumer.gyro.C, G = consumer.G;
  const Vector3d scale = C_a.diagonal();
  const auto drift = [](const TriadModel& t, const Vector3d& tau) {
    return Vector3d(t.thermal.col(1).cwiseProduct(tau) + t.thermal.col(2).cwiseProduct(tau.cwiseAbs2()));
  };
  struct Case {
    const char* target;
    std::function<Motion(const RawSample&)> equation;
  };
  for (const Case& k : {Case{"vectornav",
                             [&](const RawSample& r) {
                               return Motion{C_a * (r.accel - b_a), C_g * (r.gyro - b_g)};
                             }},
                        {"px4",
                         [&](const RawSample& r) {
                           return Motion{scale.cwiseProduct(r.accel - drift(m.accel, r.accel_tau) - b_a), r.gyro - drift(m.gyro, r.gyro_tau) - b_g};
                         }},
                        {"ardupilot",
                         [&](const RawSample& r) {
                           return Motion{scale.cwiseProduct(r.accel - drift(m.accel, r.accel_tau) - b_a), r.gyro - drift(m.gyro, r.gyro_tau) - b_g};
                         }},
                        {"kalibr",
                         [&](const RawSample& r) {  // without its states, the biases
                           const Vector3d a = C_a * r.accel;
                           return Motion{a, C_g * (r.gyro - G * a)};
                         }},
                        {"euroc", [](const RawSample& r) {
                           return Motion{r.accel, r.gyro};
                         }}}) {
    const std::vector<std::string> sentences = export_target(k.target).left_out({c});
    const Difference d = measured(m, k.equation, true);
    EXPECT_NEAR(stated(sentences, "accelerometers, ") / d.force, 1, 0.05) << k.target;  // all of it together
    EXPECT_NEAR(stated(sentences, "gyros, ") / d.rate, 1, 0.05) << k.target;
  }
}

TEST(ExportLoss, OfOneTermIsThatOfACalibrationThatHasItAlone) {
  struct Case {
    const char *begin, *target;
    bool of_accel;
    std::function<void(SensorModel&)> put;
  };
  const Calibration full = thermal_unit(22);
  const auto none = [](const RawSample& r) { return Motion{r.accel, r.gyro}; };
  for (const Case& k :
       {Case{"accelerometers' off-diagonal terms", "px4", true,
             [&](SensorModel& m) {
               m.accel.matrix = full.model.accel.matrix;
               m.accel.matrix.diagonal().setOnes();
             }},
        {"gyros' off-diagonal terms", "px4", false,
         [&](SensorModel& m) {
           m.gyro.matrix = full.model.gyro.matrix;
           m.gyro.matrix.diagonal().setOnes();
         }},
        {"gyros' scale factors", "ardupilot", false, [&](SensorModel& m) { m.gyro.matrix.diagonal() = full.model.gyro.matrix.diagonal(); }},
        {"gyros' g-sensitivity", "vectornav", false, [&](SensorModel& m) { m.g_sensitivity = full.model.g_sensitivity; }},
        {"accelerometers' thermal terms", "kalibr", true,
         [&](SensorModel& m) {
           m.accel.thermal = full.model.accel.thermal;
           m.accel.temperature = full.model.accel.temperature;
         }},
        {"gyros' thermal terms", "kalibr", false,
         [&](SensorModel& m) {
           m.gyro.thermal = full.model.gyro.thermal;
           m.gyro.temperature = full.model.gyro.temperature;
         }},
        {"accelerometers' quadratic and cubic terms", "px4", true,
         [&](SensorModel& m) {
           m.accel.quadratic = {1e-5, -4e-5, 2e-5};
         }},
        {"accelerometers' offsets", "openvins", true, [&](SensorModel& m) { m.accel.offset = full.model.accel.offset; }}}) {
    Calibration c;
    c.model.accel.raw_unit = "m/s^2";
    c.model.gyro.raw_unit = "rad/s";
    c.covariance.resize(0, 0);
    k.put(c.model);
    const std::vector<std::string> sentences = export_target(k.target).left_out({c});
    const Difference d = measured(c.model, none, true);
    EXPECT_NEAR(stated(sentences, k.begin) / (k.of_accel ? d.force : d.rate), 1, 0.05) << k.begin;
    EXPECT_EQ(sentences.size(), 1u) << k.begin << ": a term that is zero is not lost";
  }
}

TEST(ExportLoss, OfLeverArmsIsTheCentripetalAcceleration) {
  Calibration c = si_unit();
  c.model.lever_arm << 0.01, 0, 0, 0, 0.03, 0, 0, 0, 0.02;
  // The y accelerometer, 3 cm along its own axis, turned across it: w^2 r
  const double expected = std::pow(100 * unit::deg, 2) * 0.03;
  EXPECT_NEAR(stated(export_target("kalibr").left_out({c}), "lever arms") / expected, 1, 0.01);
  c.model.lever_arm << 0.01, -0.02, 0.03, 0, 0, 0, 0, 0, 0;
  const RandomStream random(5, "lever arms");
  double most = 0;
  for (std::uint64_t i = 0; i < 10000; ++i)
    most = std::max(most, size_effect(100 * unit::deg * random_direction(random, i), Vector3d::Zero(), c.model.lever_arm).cwiseAbs().maxCoeff());
  EXPECT_NEAR(stated(export_target("px4").left_out({c}), "lever arms") / most, 1, 0.01);
}

TEST(ExportRefusal, CountsAreNoReadingsForProgramsThatTakeSi) {
  Calibration c = si_unit();
  c.model.accel.raw_unit = "count";
  const ImuNoise noise = some_noise();
  for (const char* target : {"kalibr", "openvins", "px4", "ardupilot", "vectornav"})
    EXPECT_THAT(
        [&] {
          exported(target, {c, &noise});
        },
        ThrowsMessage<Error>(AllOf(HasSubstr("the accelerometers' readings are in counts"), HasSubstr("expected m/s^2"))))
        << target;
  for (const char* target : {"json-matrix", "csv", "c-header", "euroc"}) EXPECT_NO_THROW(exported(target, {c, &noise})) << target;
}

TEST(ExportRefusal, NoiseThatATargetNeedsIsAskedFor) {
  const Calibration c = si_unit();
  for (const char* target : {"kalibr-imu", "kalibr", "openvins", "vins", "euroc", "ros"})
    EXPECT_THAT([&] { exported(target, {c}); }, ThrowsMessage<Error>(HasSubstr("expected --noise noise.json"))) << target;
  for (const char* target : {"px4", "ardupilot", "vectornav", "csv", "json-matrix"}) EXPECT_NO_THROW(exported(target, {c})) << target;
  for (const char* target : {"csv", "json-matrix"})
    EXPECT_THAT(export_target(target).left_out({c}), testing::ElementsAre("noise: not known; give --noise noise.json")) << target;
}

TEST(ExportRefusal, NoiseWithoutValueOrBoundIsNamed) {
  const Calibration c = si_unit();
  ImuNoise noise = some_noise();
  noise.accel[2]->N = undetermined(std::numeric_limits<double>::infinity());
  EXPECT_THAT(
      [&] {
        exported("euroc", {c, &noise});
      },
      ThrowsMessage<Error>(HasSubstr("accelerometers' N of axis z has neither a value nor an upper bound")));
  noise.accel[2].reset();  // a constant axis has no noise: the others count
  EXPECT_THAT(exported("euroc", {c, &noise}), HasSubstr("z no noise"));
  noise.accel[0].reset(), noise.accel[1].reset();
  EXPECT_THAT([&] { exported("euroc", {c, &noise}); }, ThrowsMessage<Error>(HasSubstr("no axis with noise")));
  noise = some_noise();
  noise.gyro_unit = "count";
  EXPECT_THAT([&] { exported("euroc", {c, &noise}); }, ThrowsMessage<Error>(HasSubstr("in counts")));
  noise = some_noise();
  noise.interval_s = 0;
  EXPECT_THAT([&] { exported("euroc", {c, &noise}); }, ThrowsMessage<Error>(HasSubstr("expected --rate HZ")));
}

TEST(ExportRefusal, SingularAndLeftHandedMatricesAndNumbersThatAreNotFinite) {
  const ImuNoise noise = some_noise();
  for (const char* target : {"kalibr", "openvins", "px4", "ardupilot", "vectornav", "json-matrix", "csv"}) {
    Calibration c = si_unit();
    c.model.gyro.matrix.row(1).setZero();
    EXPECT_THAT([&] { exported(target, {c, &noise}); }, ThrowsMessage<Error>(HasSubstr("gyro.matrix: is singular"))) << target;
    c = si_unit();
    c.model.accel.offset.x() = std::nan("");
    EXPECT_THAT([&] { exported(target, {c, &noise}); }, ThrowsMessage<Error>(HasSubstr("not finite"))) << target;
  }
  Calibration c = si_unit();
  c.model.gyro.matrix.row(1) *= -1;
  for (const char* target : {"kalibr", "openvins"})
    EXPECT_THAT([&] { exported(target, {c, &noise}); }, ThrowsMessage<Error>(HasSubstr("the gyros' axes form a left-handed triad"))) << target;
}

TEST(ExportWarning, NumbersOutsideATargetsRangeAreNamed) {
  Calibration c = si_unit();
  c.model.accel.matrix = Vector3d(1.25, 1, 3.5).asDiagonal();
  c.model.accel.offset = {0, 4, 0};
  const auto px4 = export_target("px4").warnings({c}), ardupilot = export_target("ardupilot").warnings({c});
  EXPECT_THAT(px4, testing::ElementsAre("CAL_ACC0_ZSCALE is 3.5: outside 0.1 to 3, which PX4 accepts"));
  EXPECT_THAT(ardupilot, testing::UnorderedElementsAre("INS_ACCSCAL_X is 1.25: outside 0.8 to 1.2, which ArduPilot accepts",
                                                       "INS_ACCSCAL_Z is 3.5: outside 0.8 to 1.2, which ArduPilot accepts",
                                                       "INS_ACCOFFS_Y is -4: outside -3.5 to 3.5, which ArduPilot accepts"));
  EXPECT_THAT(export_target("px4").warnings({si_unit()}), IsEmpty());
}

/// What a program reads of a file: all but comments.
std::string without_comments(const std::string& text) {
  std::istringstream lines(text);
  std::string out;
  for (std::string line; std::getline(lines, line);)
    if (!line.starts_with('#')) out += line + "\n";
  return out;
}

TEST(ExportRefusal, NoNameBreaksOutOfAComment) {
  const std::string hostile =
      "a\nimu0: {model: x}\r\nb \"*/ # : ' \u2028 \x85 \x1b[31m $VNWRG,25,0\n1\t1\tCAL_ACC0_XOFF\t9\t9\n" + std::string(100000, 'x');
  const ImuNoise good_noise = some_noise();
  ImuNoise noise = some_noise();
  noise.recording = hostile;
  const Calibration good = thermal_unit();
  Calibration c = thermal_unit();
  c.imu = c.method = c.created = c.software = c.serial = hostile;
  for (const ExportTarget& target : export_targets()) {
    if (target.name == "c-header") continue;  // has no lines of this form: apps/imulab/export_test.cpp
    const std::string text = target.text({c, &noise});
    if (target.name == "json-matrix") {
      EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), [&] {
        const std::string t = target.text({good, &good_noise});
        return std::count(t.begin(), t.end(), '\n');
      }());
      continue;
    }
    EXPECT_EQ(without_comments(text), without_comments(target.text({good, &good_noise}))) << target.name;
    for (const char byte : text) ASSERT_TRUE(byte == '\n' || byte == '\r' || byte == '\t' || (byte >= ' ' && byte <= '~')) << target.name;
    EXPECT_LT(text.size(), 20000u) << target.name;
  }
}

TEST(ExportTargets, EveryFileSaysWhatItHoldsAtItsHead) {
  const ImuNoise noise = some_noise();
  const Calibration c = thermal_unit();
  for (const ExportTarget& target : export_targets()) {
    const std::string text = target.text({c, &noise});
    if (target.name == "c-header") continue;
    for (const std::string& lost : target.left_out({c, &noise})) EXPECT_THAT(text, HasSubstr(lost)) << target.name;
    if (target.name == "json-matrix") continue;
    EXPECT_THAT(text, HasSubstr("# Calibration of \"unit\", method truth, 2026-11-20T12:00:00Z, for ")) << target.name;
  }
}

}  // namespace
}  // namespace imulab::export_test
