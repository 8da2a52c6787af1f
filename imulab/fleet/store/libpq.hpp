// PostgreSQL's client library, loaded when a store on a server is opened: no other program needs it. Its functions are declared here as its manual
// has them (PostgreSQL 15, chapter 34); libpq.so.5 has kept them since 9.2.
#pragma once

#include <cstddef>

struct pg_conn;
struct pg_result;

namespace imulab::fleet {

/// PQconninfoOption
struct LibpqOption {
  char *keyword, *envvar, *compiled, *val, *label, *dispchar;
  int dispsize;
};

struct Libpq {
  enum Status { connection_ok = 0 };
  enum Result { command_ok = 1, tuples_ok = 2, copy_in = 4, single_tuple = 9 };

  pg_conn* (*connect)(const char* const* keywords, const char* const* values, int expand_dbname);
  void (*finish)(pg_conn*);
  int (*status)(const pg_conn*);
  char* (*error_message)(const pg_conn*);
  void (*(*set_notice_processor)(pg_conn*, void (*)(void*, const char*), void*))(void*, const char*);
  LibpqOption* (*parse)(const char* address, char** error);
  void (*free_options)(LibpqOption*);
  void (*free_memory)(void*);
  pg_result* (*exec)(pg_conn*, const char* statements);
  int (*send_query)(pg_conn*, const char* statement, int count, const unsigned* types, const char* const* values, const int* lengths,
                    const int* formats, int result_format);
  int (*set_single_row_mode)(pg_conn*);
  pg_result* (*get_result)(pg_conn*);
  int (*put_copy_data)(pg_conn*, const char* data, int size);
  int (*put_copy_end)(pg_conn*, const char* error);
  int (*result_status)(const pg_result*);
  char* (*result_error_field)(const pg_result*, int field);
  char* (*command_tuples)(pg_result*);
  int (*rows)(const pg_result*);
  int (*columns)(const pg_result*);
  unsigned (*type)(const pg_result*, int column);
  char* (*value)(const pg_result*, int row, int column);
  int (*length)(const pg_result*, int row, int column);
  int (*is_null)(const pg_result*, int row, int column);
  void (*clear)(pg_result*);
};

/// Throws DatabaseError where there is no such library.
Libpq load_libpq(const char* file = "libpq.so.5");

}  // namespace imulab::fleet
