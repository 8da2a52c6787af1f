// Files that the build embeds (cmake/report_assets.cmake).
#pragma once

#include <string_view>

namespace imulab::report::assets {

extern const std::string_view page_css, certificate_css, page_js, dygraph_css, dygraph_js;

}  // namespace imulab::report::assets
