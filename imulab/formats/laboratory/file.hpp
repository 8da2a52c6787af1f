// A laboratory's file: what a certificate states that no recording shows, "imulab.laboratory/1" (docs/reference/calibration-file.md).
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace imulab {

/// All are text as it is declared; empty: not declared.
struct Laboratory {
  std::string name, address;
  std::string accreditation;  ///< by whom and under which number
  std::string traceability;   ///< the laboratory's own statement
  std::string issued;         ///< YYYY-MM-DD
  struct {
    std::string name, address, information;  ///< what the customer has stated about the item
  } customer;
  struct {
    std::string manufacturer, type, condition, received, adjustment;  ///< received: YYYY-MM-DD
  } item;
  struct {
    std::string place, temperature, humidity, pressure;
  } conditions;
  struct {
    std::string name, deviations;
  } procedure;
  struct {
    std::string name, function;
  } signatory;
};

/// Throws Error that names file, line and key: of a key that is not known with the nearest one.
Laboratory read_laboratory(const std::filesystem::path& path);
/// From text; `file` is its name in messages.
Laboratory parse_laboratory(std::string_view text, const std::string& file);

}  // namespace imulab
