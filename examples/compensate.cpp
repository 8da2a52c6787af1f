// Compensates samples one by one, as a driver delivers them: a line "t gx gy gz ax ay az" of raw readings on standard input becomes one of angular
// rate [rad/s] and specific force [m/s^2] on standard output. With --reject-outliers spikes are replaced, and samples come out two samples later.
#include <cstdio>
#include <exception>
#include <imulab/compensate.hpp>
#include <imulab/error.hpp>
#include <imulab/files.hpp>
#include <imulab/outlier_filter.hpp>
#include <queue>
#include <string_view>

using namespace imulab;

void put(const SampleCompensator& compensator, double t, const OutlierFilter::Readings& r) {
  const auto [rate, force] =
      compensator({r[0], r[1], r[2]}, {r[3], r[4], r[5]});  // and the temperature as it is read, for a model with thermal terms
  std::printf("%.9g %.9g %.9g %.9g %.9g %.9g %.9g\n", t, rate[0], rate[1], rate[2], force[0], force[1], force[2]);
}

int main(int argc, char** argv) try {
  const bool reject = argc == 3 && std::string_view(argv[2]) == "--reject-outliers";
  if (argc != (reject ? 3 : 2)) throw Error("usage: compensate CALIBRATION [--reject-outliers]");
  const SampleCompensator compensator(read_calibration(argv[1]).model);  // of readings in rad/s and m/s^2; others by SampleOptions

  OutlierFilter filter;
  std::queue<double> times;  // of the samples inside the filter
  const auto put_filtered = [&](const OutlierFilter::Output& out) {
    put(compensator, times.front(), out.readings);
    times.pop();
  };
  double t;
  OutlierFilter::Readings r;
  while (std::scanf("%lf %lf %lf %lf %lf %lf %lf", &t, &r[0], &r[1], &r[2], &r[3], &r[4], &r[5]) == 7) {
    if (reject) {
      times.push(t);
      if (const auto out = filter.push(r)) put_filtered(*out);
    } else {
      put(compensator, t, r);
    }
  }
  while (const auto out = filter.rest()) put_filtered(*out);  // the last two
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
