// What a picture needs of many rows in JSON: some of them.
#pragma once

#include "imulab/core/fields.hpp"
#include "imulab/formats/text/json.hpp"
#include "imulab/navigate.hpp"
#include "imulab/units.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace imulab::result_io {

inline constexpr std::size_t most_places = 800;
inline constexpr int stamp_digits = 16;  // of a clock that counts from 1970 to the microsecond

/// Indices of at most about `most` of `count` things, the last included.
inline std::vector<std::size_t> thinned(std::size_t count, std::size_t most) {
  const std::size_t step = std::max<std::size_t>(1, (count + most - 1) / most);
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < count; i += step) indices.push_back(i);
  if (count > 0 && indices.back() != count - 1) indices.push_back(count - 1);
  return indices;
}

template <class Row>
std::vector<Row> thinned_rows(const std::vector<Row>& rows, std::size_t most) {
  std::vector<Row> out;
  for (const std::size_t i : thinned(rows.size(), most)) out.push_back(rows[i]);
  return out;
}

/// Null where it is not known. Where it is written, it is thinned before.
template <class Fields>
void describe_track(Fields& f, std::vector<NavigationState>& states) {
  using S = NavigationState;
  if constexpr (Fields::reads) {
    if (!f.at().has("track") || f.at()["track"].is_null()) return;
  } else if (states.size() < 2) {
    return f("track", JsonValue());
  }
  f.table("track", [&](auto& t) {
    constexpr int place_digits = 10;
    const fields::How degrees{.size = unit::deg, .digits = place_digits};
    fields::column(t, "latitude_deg", states, true, degrees, [](S& s) -> double& { return s.latitude; });
    fields::column(t, "longitude_deg", states, false, degrees, [](S& s) -> double& { return s.longitude; });
    fields::column(t, "height_m", states, false, {.digits = place_digits}, [](S& s) -> double& { return s.height; });
  });
}

}  // namespace imulab::result_io
