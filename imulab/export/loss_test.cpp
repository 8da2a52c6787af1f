// The stated loss of a target is its actual loss.
#include "imulab/export/loss.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/compensate.hpp"
#include "imulab/export/consumer_model.hpp"
#include "imulab/model/compensation_derivatives.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/export_unit.hpp"
#include <algorithm>
#include <functional>
#include <regex>

namespace imulab::export_test {
namespace {

using export_io::Held;
using ::testing::Contains;
using ::testing::HasSubstr;

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
    const Motion motion{.rate = 100 * unit::deg * random_direction(directions, 2 * i + 1), .force = unit::g * random_direction(directions, 2 * i)};
    const RawSample raw = decompensate(truth, motion, Vector3d::Constant(tau(truth.gyro)), Vector3d::Constant(tau(truth.accel)));
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
  for (const Case& k :
       {Case{"vectornav", [&](const RawSample& r) { return Motion{.rate = C_g * (r.gyro - b_g), .force = C_a * (r.accel - b_a)}; }},
        {"px4",
         [&](const RawSample& r) {
           return Motion{.rate = r.gyro - drift(m.gyro, r.gyro_tau) - b_g, .force = scale.cwiseProduct(r.accel - drift(m.accel, r.accel_tau) - b_a)};
         }},
        {"ardupilot",
         [&](const RawSample& r) {
           return Motion{.rate = r.gyro - drift(m.gyro, r.gyro_tau) - b_g, .force = scale.cwiseProduct(r.accel - drift(m.accel, r.accel_tau) - b_a)};
         }},
        {"kalibr",
         [&](const RawSample& r) {  // without its states, the biases
           const Vector3d a = C_a * r.accel;
           return Motion{.rate = C_g * (r.gyro - G * a), .force = a};
         }},
        {"euroc", [](const RawSample& r) { return Motion{.rate = r.gyro, .force = r.accel}; }}}) {
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
  const auto none = [](const RawSample& r) { return Motion{.rate = r.gyro, .force = r.accel}; };
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

TEST(ExportLoss, OfThermalTermsIsStatedWithoutARangeToo) {
  for (const double end : {0.0, 20.0}) {  // not known, and of no width
    Calibration c = thermal_unit(31);
    for (TriadModel* m : {&c.model.accel, &c.model.gyro}) m->temperature->range = {end, end};
    const SensorModel& m = c.model;
    double force = 0, rate = 0;
    const RandomStream random(3, "without range");
    for (std::uint64_t i = 0; i < 200; ++i)
      for (const double tau : {10.0, -10.0}) {
        RawSample raw{.accel = unit::g * random_direction(random, i)};
        const Motion none = compensate(m, raw);
        raw.accel_tau.setConstant(tau);
        force = std::max(force, (compensate(m, raw).force - none.force).cwiseAbs().maxCoeff());
        raw.accel_tau.setZero();
        raw.gyro_tau.setConstant(tau);
        rate = std::max(rate, (compensate(m, raw).rate - none.rate).cwiseAbs().maxCoeff());
      }
    for (const char* target : {"kalibr", "vectornav", "px4", "ardupilot"}) {
      const std::vector<std::string> sentences = export_target(target).left_out({c});
      EXPECT_NEAR(stated(sentences, "accelerometers' thermal terms") / force, 1, 0.05) << target;
      EXPECT_NEAR(stated(sentences, "gyros' thermal terms") / rate, 1, 0.05) << target;
      EXPECT_THAT(sentences, Contains(HasSubstr("at 10 degC from the reference; no range of temperatures is known"))) << target;
    }
    c.model.accel.temperature.reset();
    EXPECT_THAT(export_target("px4").left_out({c}), Contains(HasSubstr("accelerometers' thermal terms: their size is not known")));
    EXPECT_THAT(export_target("euroc").left_out({c}), Contains(HasSubstr("without the thermal terms")));
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

}  // namespace
}  // namespace imulab::export_test
