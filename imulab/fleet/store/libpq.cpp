#include "imulab/fleet/store/libpq.hpp"

#include "imulab/fleet/store/engine.hpp"

#include <fmt/format.h>

#include <dlfcn.h>
#include <type_traits>

namespace imulab::fleet {

Libpq load_libpq(const char* file) {
  void* const library = dlopen(file, RTLD_NOW | RTLD_LOCAL);  // until the program ends
  const auto fail = [] {
    const char* const why = dlerror();
    throw DatabaseError(
        fmt::format("a store on a PostgreSQL server needs its library libpq: {}; expected it to be installed (Debian and Ubuntu: "
                    "apt-get install libpq5; Fedora: libpq)",
                    why != nullptr ? why : "cannot be loaded"));
  };
  if (library == nullptr) fail();
  Libpq out{};
  const auto take = [&](const char* name, auto& function) {
    void* const found = dlsym(library, name);
    if (found == nullptr) fail();
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(found);
  };
  take("PQconnectdbParams", out.connect), take("PQfinish", out.finish), take("PQstatus", out.status);
  take("PQerrorMessage", out.error_message), take("PQsetNoticeProcessor", out.set_notice_processor);
  take("PQconninfoParse", out.parse), take("PQconninfoFree", out.free_options), take("PQfreemem", out.free_memory);
  take("PQexec", out.exec), take("PQsendQueryParams", out.send_query), take("PQsetSingleRowMode", out.set_single_row_mode);
  take("PQgetResult", out.get_result), take("PQputCopyData", out.put_copy_data), take("PQputCopyEnd", out.put_copy_end);
  take("PQresultStatus", out.result_status), take("PQresultErrorField", out.result_error_field), take("PQcmdTuples", out.command_tuples);
  take("PQntuples", out.rows), take("PQnfields", out.columns), take("PQftype", out.type), take("PQgetvalue", out.value);
  take("PQgetlength", out.length), take("PQgetisnull", out.is_null), take("PQclear", out.clear);
  return out;
}

}  // namespace imulab::fleet
