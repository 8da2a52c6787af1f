#include "imulab/formats/recording/bag/damage.hpp"

#include "imulab/core/error.hpp"

#include <fmt/core.h>

namespace imulab::bag {

std::string Damage::place(std::uint64_t at) const { return fmt::format("{}: chunk at byte {}", file_, at); }

std::vector<std::string> Damage::warnings() const {
  std::vector<std::string> warnings;
  if (!index_.empty()) warnings.push_back(fmt::format("{}: {}: read from its beginning", file_, index_));
  if (!chunks_.empty())
    warnings.push_back(fmt::format("{}: {}: {}: the messages in it are missing", place(chunks_.begin()->first), chunks_.begin()->second,
                                   chunks_.size() == 1 ? "left out" : fmt::format("left out with {} more", chunks_.size() - 1)));
  if (!ends_.empty())
    warnings.push_back(
        fmt::format("{}: damaged from byte {} on: {}: only what stands before was read", file_, ends_.begin()->first, ends_.begin()->second));
  return warnings;
}

Compression Damage::compression(std::string_view name, std::uint64_t at) const {
  try {
    return compression_of(name);
  } catch (const Damaged& e) {
    throw Error(fmt::format("{}: {}; expected none, lz4, zstd or bz2", place(at), e.what()));
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", file_, e.what()));
  }
}

}  // namespace imulab::bag
