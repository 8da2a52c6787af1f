// The parts of a certificate, each as HTML.
#pragma once

#include "imulab/report/certificate.hpp"

#include <string>
#include <string_view>

namespace imulab::report {

/// Rows of a name and what is declared or measured of it.
class Statements {
 public:
  /// `value` is text; where it is empty there is a line to fill in.
  void add(std::string_view name, const std::string& value);
  /// Left out where it is empty.
  void add_known(std::string_view name, const std::string& value);
  void add_html(std::string_view name, const std::string& html);
  std::string html() const { return "<table><tbody>\n" + rows_ + "</tbody></table>\n"; }

 private:
  std::string rows_;
};

/// Text, or a line to fill in.
std::string or_line(const std::string& text);

// certificate_results.cpp
std::string results_part(const Certificate& certificate);
std::string conformity_part(const Calibration& calibration);
std::string traceability_part(const Certificate& certificate);
std::string signature_part(const Laboratory& laboratory);

// certificate_appendix.cpp
std::string appendix_part(const Certificate& certificate);

}  // namespace imulab::report
