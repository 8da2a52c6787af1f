#include "imulab/formats/aid/format.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/text/file.hpp"

#include <fmt/core.h>

namespace imulab::aid_io {

const std::vector<AidFormat>& aid_formats() {
  static const std::vector<AidFormat> formats{bag_aid_format(), ulog_aid_format(), dataflash_aid_format(), rtklib_format(), novatel_solution_format(),
                                              nmea_format(),    tum_format(),      euroc_format(),         aid_csv_format()};
  return formats;
}

void expect_gnss(const AidRequest& request, std::string_view what) {
  if (request.kind != AidKind::gnss)
    throw Error(
        fmt::format("{}: is {}, and the aid's kind is {}; expected kind = \"gnss\"", input_name(request.file), what, to_string(request.kind)));
}

}  // namespace imulab::aid_io
