// Tells before any data how good a calibration will be and what limits it: Zhang's procedure (2010) on a table of 2 arcsec.
#include <cstdio>
#include <exception>
#include <imulab/predict.hpp>
#include <imulab/procedure.hpp>

using namespace imulab;

int main() try {
  const Session procedure = zhang_24_procedure({.rest = 60, .table = 2 * unit::arcsec, .grade = "navigation"});
  const Prediction prediction = predict("turntable", procedure);
  for (Eigen::Index i = 0; i < prediction.sigma.size(); ++i) {
    const Coefficient& c = coefficient(prediction.coefficients[static_cast<std::size_t>(i)]);
    const UserUnit unit = user_unit(c, prediction.sigma[i]);
    Eigen::Index source;  // with the largest share of the variance
    const double share = prediction.variance.row(i).maxCoeff(&source) / prediction.variance.row(i).sum();
    std::printf("%-24s %8.3g %-8s %3.0f %% from %s\n", c.name.data(), prediction.sigma[i] / unit.size, unit.name.data(), 100 * share,
                prediction.sources[static_cast<std::size_t>(source)].c_str());
  }
  for (const CoefficientIndex index : prediction.undetermined) std::printf("%-24s not determined\n", coefficient(index).name.data());
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
