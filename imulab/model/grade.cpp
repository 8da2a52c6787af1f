#include "imulab/grade.hpp"

#include "imulab/core/nearest_name.hpp"
#include "imulab/error.hpp"
#include "imulab/model/published_grades.hpp"
#include "imulab/units.hpp"

#include <algorithm>
#include <array>
#include <string>

namespace imulab {

namespace {

using namespace unit;
constexpr double sqrt_hour = 60;  // sqrt(s)

/// Returns sizes from ug/g^2, ug/g^3, ppm/(deg/s), ppb/(deg/s)^2, deg/h/g.
constexpr TermSizes terms(double accel_quadratic, double accel_cubic, double gyro_quadratic, double gyro_cubic, double g_sensitivity) {
  return {accel_quadratic * ug / (g * g), accel_cubic * ug / (g * g * g), gyro_quadratic * ppm / deg, gyro_cubic * 1e-9 / (deg * deg),
          g_sensitivity * deg_per_h / g};
}

// docs/reference/grades.md has the source of every number.
constexpr std::array<Grade, 5> catalogue{{
    {.name = "strategic",
     .gyro_bias = 1e-3 * deg_per_h,
     .accel_bias = 10 * ug,
     .gyro_scale = 5 * ppm,
     .accel_scale = 5 * ppm,
     .gyro_misalignment = 0.5 * arcsec,
     .accel_misalignment = 0.5 * arcsec,
     .g_sensitivity = 0,
     .terms = terms(5, 1, 0.0001, 1e-05, 0.0001),
     .gyro_noise = {.Q = 0.02 * arcsec,
                    .N = 1e-4 * deg_per_sqrt_h,
                    .B = 1e-4 * deg_per_h,
                    .K = 1e-4 * deg_per_h / sqrt_hour,
                    .R = {},
                    .turn_on = {1e-4 * deg_per_h}},
     .accel_noise = {.Q = 1e-6, .N = 1 * ug_per_sqrt_hz, .B = 0.2 * ug, .K = 0.1 * ug / sqrt_hour, .R = {}, .turn_on = {1 * ug}}},
    {.name = "navigation",
     .gyro_bias = 0.01 * deg_per_h,
     .accel_bias = 70 * ug,
     .gyro_scale = 20 * ppm,
     .accel_scale = 20 * ppm,
     .gyro_misalignment = 10 * arcsec,
     .accel_misalignment = 10 * arcsec,
     .g_sensitivity = 0,
     .terms = terms(20, 5, 0.001, 0.0001, 0.01),
     .gyro_noise = {.Q = 0.2 * arcsec,
                    .N = 1e-3 * deg_per_sqrt_h,
                    .B = 1e-3 * deg_per_h,
                    .K = 1e-3 * deg_per_h / sqrt_hour,
                    .R = {},
                    .turn_on = {3e-3 * deg_per_h}},
     .accel_noise = {.Q = 1e-5, .N = 5 * ug_per_sqrt_hz, .B = 3 * ug, .K = 2 * ug / sqrt_hour, .R = {}, .turn_on = {20 * ug}}},
    {.name = "tactical",
     .gyro_bias = 3 * deg_per_h,
     .accel_bias = 300 * ug,
     .gyro_scale = 150 * ppm,
     .accel_scale = 150 * ppm,
     .gyro_misalignment = 60 * arcsec,
     .accel_misalignment = 60 * arcsec,
     .g_sensitivity = 0,
     .terms = terms(50, 20, 0.02, 0.01, 0.3),
     .gyro_noise = {.Q = 1 * arcsec,
                    .N = 0.1 * deg_per_sqrt_h,
                    .B = 0.3 * deg_per_h,
                    .K = 0.3 * deg_per_h / sqrt_hour,
                    .R = {0.1 * deg_per_h / hour},
                    .turn_on = {1 * deg_per_h}},
     .accel_noise = {.Q = 1e-4, .N = 100 * ug_per_sqrt_hz, .B = 30 * ug, .K = 30 * ug / sqrt_hour, .R = {10 * ug / hour}, .turn_on = {100 * ug}}},
    {.name = "mems",
     .gyro_bias = 1 * deg,
     .accel_bias = 0.3,
     .gyro_scale = 0.01,
     .accel_scale = 0.01,
     .gyro_misalignment = 0.01,
     .accel_misalignment = 0.01,
     .g_sensitivity = 0.05 * deg / g,
     .terms = terms(500, 200, 1, 1, 180),
     .gyro_noise = {.Q = 0,
                    .N = 0.3 * deg_per_sqrt_h,
                    .B = 10 * deg_per_h,
                    .K = 10 * deg_per_h / sqrt_hour,
                    .R = {10 * deg_per_h / hour},
                    .turn_on = {0.1 * deg},
                    .resolution = 500.0 / 32768 * deg,
                    .range = 500 * deg},
     .accel_noise = {.Q = 0,
                     .N = 150 * ug_per_sqrt_hz,
                     .B = 50 * ug,
                     .K = 100 * ug / sqrt_hour,
                     .R = {50 * ug / hour},
                     .turn_on = {5e-3 * g},
                     .resolution = 4.0 / 32768 * g,
                     .range = 4 * g}},
    // Dai 2011: ranges of coefficients from table 2; stability and full scale from table 1 (with a margin for nonlinear readings at full scale).
    {.name = "mems-30g",
     .gyro_bias = 0.5 * deg,
     .accel_bias = 30e-3 * g,
     .gyro_scale = 0.01,
     .accel_scale = 0.01,
     .gyro_misalignment = 3.2e-3,
     .accel_misalignment = 12e-3,
     .g_sensitivity = 0.026 * deg / g,
     .terms = terms(65, 13, 200, 0.7, 95),  // RMS of the ranges below
     .gyro_noise = {.Q = 0, .N = 0.02 * deg, .B = 30 * deg_per_h, .K = 0, .R = {}, .turn_on = {}, .resolution = 0, .range = 550 * deg},
     .accel_noise = {.Q = 0, .N = 100 * ug_per_sqrt_hz, .B = 0, .K = 0, .R = {1e-3 * g / hour}, .turn_on = {}, .resolution = 0, .range = 36 * g},
     .ranges = NonlinearRanges{.gyro_misalignment = {0.1e-2, 0.5e-2},
                               .accel_misalignment = {0.1e-2, 2e-2},
                               .gyro_quadratic = {1.5e-4 / deg, 2.5e-4 / deg},
                               .accel_quadratic = {2e-5 / g, 1e-4 / g},
                               .gyro_cubic = {4e-10 / (deg * deg), 1e-9 / (deg * deg)},
                               .accel_cubic = {5e-6 / (g * g), 2e-5 / (g * g)},
                               .g_sensitivity = {0.01 * deg / g, 0.04 * deg / g},
                               .gyro_drift = 0.6 * deg,
                               .accel_drift = 20e-3 * g,
                               .gyro_curvature = 0.2 * deg,
                               .accel_curvature = 7e-3 * g}},
}};

// Xu 2024 table 1. Strategic: 30 m per hour; a nonorthogonality or scale below a limit begins at zero.
constexpr std::array<PublishedGrade, 3> published{{
    {"strategic", {0, 30 / hour}, {1e-4 * deg_per_h, 0.01 * deg_per_h}, {1 * ug, 50 * ug}, {0, 1 * arcsec}, {0, 10 * ppm}},
    {"navigation",
     {0.5 * nmi_per_h, 2 * nmi_per_h},
     {0.01 * deg_per_h, 1 * deg_per_h},
     {50 * ug, 100 * ug},
     {1 * arcsec, 30 * arcsec},
     {10 * ppm, 50 * ppm}},
    {"tactical",
     {10 * nmi_per_h, 20 * nmi_per_h},
     {1 * deg_per_h, 10 * deg_per_h},
     {100 * ug, 1000 * ug},
     {30 * arcsec, 100 * arcsec},
     {50 * ppm, 500 * ppm}},
}};

// Xu 2024 table 2.
constexpr std::array<AirlinerSystem, 3> systems{{
    {"LTN-90", "LG-8028", "A310, A300-600", 1 * nmi_per_h, 0.01 * deg_per_h},
    {"LTN-101", "LG-8028", "A380, A319, A320, A321", 0.8 * nmi_per_h, 0.01 * deg_per_h},
    {"Laseref", "GG-1342", "B737, B747, B757, B767", 2 * nmi_per_h, 0.1 * deg_per_h},
}};

template <class Entry>
const Entry& named(std::span<const Entry> entries, std::string_view what, std::string_view name) {
  std::vector<std::string_view> names;
  for (const Entry& e : entries) {
    if (e.name == name) return e;
    names.emplace_back(e.name);
  }
  throw Error(std::string(what) + " = \"" + std::string(name) + "\": unknown" + expected_name(name, names));
}

}  // namespace

std::span<const Grade> grades() { return catalogue; }
std::span<const PublishedGrade> published_grades() { return published; }
std::span<const AirlinerSystem> airliner_systems() { return systems; }

const Grade& grade(std::string_view name) { return named(grades(), "grade", name); }
const AirlinerSystem& airliner_system(std::string_view name) { return named(airliner_systems(), "system", name); }

}  // namespace imulab
