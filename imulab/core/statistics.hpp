// Small statistics: robust location and scale, distributions' quantiles and tails (Boost.Math behind a light header).
//
//   chi_square_tail(11.07, 5)                                     // 0.05: P(X > 11.07)
//   student_quantile(0.975, 10)                                   // 2.228
#pragma once

#include <vector>

namespace imulab {

double median(std::vector<double> values);  ///< NaN for none
/// 1.4826 x median absolute deviation from the median: the standard deviation of a normal sample, insensitive to a few outliers.
double robust_sigma(const std::vector<double>& values);
/// The p quantile of a sample (linear interpolation between order statistics).
double quantile(std::vector<double> values, double p);

/// Mean of square / (variance + additional): 1 on average where these are the variances of what was squared.
double mean_ratio(const std::vector<double>& squares, const std::vector<double>& variances, double additional = 0);
/// The additional variance, common to all, with which that mean is 1; 0 where it is smaller without any.
double additional_variance(const std::vector<double>& squares, const std::vector<double>& variances);

double normal_quantile(double p);
double student_quantile(double p, double degrees_of_freedom);  ///< infinite degrees of freedom: the normal distribution's
double chi_square_quantile(double p, double degrees_of_freedom);
double chi_square_tail(double x, double degrees_of_freedom);                        ///< P(X > x)
double log_chi_square_tail(double x, double degrees_of_freedom);                    ///< ln P(X > x), also where P is too small for a double
double f_tail(double f, double degrees_of_freedom_1, double degrees_of_freedom_2);  ///< P(F > f)
double binomial_quantile(double p, double trials, double probability);

}  // namespace imulab
