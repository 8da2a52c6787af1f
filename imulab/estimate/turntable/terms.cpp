#include "imulab/estimate/turntable/terms.hpp"

#include "imulab/core/error.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/kernel/optional_terms.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <string>
#include <utility>

namespace imulab::turntable {

std::vector<CoefficientIndex> chosen_coefficients(const std::vector<CoefficientIndex>& wanted, std::string_view accel_unit,
                                                  std::string_view gyro_unit) {
  const std::vector<CoefficientIndex> chosen = kernel::chosen_coefficients(
      wanted, select_each({"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix", "gyro.g_sensitivity"}), "turntable");
  enum class Share { none, some, all };
  const auto share = [&](const std::string& selector) {
    const std::vector<CoefficientIndex> whole = select_coefficients(selector);
    const auto n = std::count_if(whole.begin(), whole.end(), [&](CoefficientIndex index) { return contains(chosen, index); });
    return n == std::ssize(whole) ? Share::all : n > 0 ? Share::some : Share::none;
  };
  for (const auto& [triad, unit] : {std::pair{std::string("accel"), accel_unit}, {std::string("gyro"), gyro_unit}}) {
    const Share diagonal = share(triad + ".matrix.diagonal"), others = share(triad + ".matrix.off_diagonal");
    if (diagonal == Share::some || others == Share::some || (others == Share::all && diagonal == Share::none))
      throw TermsError(fmt::format("{0}.matrix in parts: the method turntable estimates all of it, or {0}.matrix.diagonal, or none", triad));
    if (unit == "count" && (share(triad + ".offset") == Share::none || diagonal == Share::none))
      throw TermsError(fmt::format("without {0}.offset or {0}.matrix.diagonal: readings in counts have no offset and scale to start from", triad));
  }
  for (const char* term : {"accel.offset", "gyro.offset", "gyro.g_sensitivity"})
    if (share(term) == Share::some) throw TermsError(fmt::format("{} in parts: the method turntable estimates all of it or none", term));
  return chosen;
}

EstimatorOptions with_optional_terms(EstimatorOptions options, const ImuDeclaration& imu, const Vector3d& accel_offset, const Vector3d& gyro_offset) {
  for (const CoefficientIndex index : select_each({"accel.quadratic", "accel.cubic", "gyro.quadratic", "gyro.cubic"})) options.terms.push_back(index);
  std::sort(options.terms.begin(), options.terms.end());
  options.optional = kernel::optional_priors(imu, accel_offset, gyro_offset);
  return options;
}

}  // namespace imulab::turntable
