// A store in the schema "imulab" of a PostgreSQL database.
//
// Rows come one by one as the server sends them (libpq's single-row mode), so that a query takes no memory. A connection sends the rows of one query
// at a time: when another one begins, the rest of the rows of the one before is taken into memory. Whoever writes holds one lock of the database from
// the begin of a transaction to its end. So transactions come one after the other, as in SQLite, and each sees all that the ones before it wrote. A
// connection that is lost is an error: the server undoes what was not committed.
#include "imulab/fleet/store/engine.hpp"
#include "imulab/fleet/store/libpq.hpp"
#include "imulab/fleet/store/postgres_text.hpp"
#include "imulab/fleet/store/server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <deque>
#include <new>
#include <utility>

namespace imulab::fleet {

namespace {

constexpr std::int64_t lock_of_writers = 0x494D4C46;  // "IMLF": an advisory lock of the database

const Libpq& libpq() {
  static const Libpq library = load_libpq();
  return library;
}

struct ClearResult {
  void operator()(pg_result* result) const { libpq().clear(result); }
};
using ResultRow = std::unique_ptr<pg_result, ClearResult>;

/// The first line, with single spaces: libpq explains at length.
std::string first_line(const char* message) {
  std::string out;
  for (const char* c = message != nullptr ? message : ""; *c != '\0' && *c != '\n'; ++c)
    if (*c != ' ' || (!out.empty() && out.back() != ' ')) out += *c;
  return out.empty() ? "no reason given" : out;
}

/// What an error's code begins with (appendix A of PostgreSQL's manual), and what was expected.
constexpr std::array<std::pair<std::string_view, std::string_view>, 6> advice{{
    {"55P03", "expected it within a minute from the other program that writes"},
    {"25006", "expected a store that can be written"},
    {"42501", "expected a user with the right to do this"},
    {"53", "expected room on the server; the store is as it was before"},
    {"57P", "expected a server that stays; each calibration is in the store as a whole or not at all, and the same command goes on"},
    {"", "expected a whole fleet store"},
}};

class PostgresQuery;

class Postgres final : public Engine {
 public:
  Postgres(const std::string& address, Access access);
  ~Postgres() override { libpq().finish(connection_); }

  void run(const std::string& statements) override { run_as_it_is(postgres_sql(statements)); }
  std::unique_ptr<Query> query(const std::string& text) override;
  std::int64_t changes() const override { return changes_; }

  void begin(Access access) override;
  void commit() override { run_as_it_is("COMMIT"); }
  void rollback() noexcept override;

  bool is_new() override { return names().empty(); }
  std::vector<std::string> names() override;
  std::int64_t version() override;
  void mark(std::int64_t version) override {
    run_as_it_is(fmt::format("CREATE TABLE store (version BIGINT NOT NULL); INSERT INTO store VALUES ({})", version));
  }
  std::vector<std::string> damages() override { return {}; }  // the server keeps its references; all is read besides
  bool attach(const std::string&) override { return false; }
  void detach() noexcept override {}
  void fill(const std::string& table, Query& rows) override;

  // For a query.
  void send(PostgresQuery& query, const std::string& statement, const std::vector<Value>& values);
  ResultRow next_result() { return ResultRow(libpq().get_result(connection_)); }
  void end_of(const PostgresQuery& query, std::int64_t changes) {
    if (active_ == &query) active_ = nullptr;
    changes_ = changes;
  }
  [[noreturn]] void fail(const pg_result* result);

 private:
  void connect(const std::string& address);
  void expect_address(const std::string& address);
  void run_as_it_is(const std::string& statements);
  void make_way();

  std::string name_;  // without a password
  pg_conn* connection_ = nullptr;
  PostgresQuery* active_ = nullptr;  // whose rows the connection sends
  std::int64_t changes_ = 0;
};

class PostgresQuery : public Query {
 public:
  PostgresQuery(Postgres& engine, const std::string& text) : engine_(engine), statement_(postgres_sql(text)) {}
  ~PostgresQuery() override { leave(); }

  bool next() override {
    if (state_ == State::bound) {
      engine_.send(*this, statement_, values_);
      state_ = State::running;
    }
    row_.reset();
    if (waiting_.empty()) fetch();
    if (waiting_.empty()) return false;
    row_ = std::move(waiting_.front());
    waiting_.pop_front();
    return true;
  }
  void reset() override {
    leave();
    state_ = State::bound;
  }
  void bind(int parameter, const Value& value) override {
    const auto count = static_cast<std::size_t>(parameter);
    if (values_.size() < count) values_.resize(count), texts_.resize(count);
    Value& kept = values_[count - 1] = value;
    if (auto* const text = std::get_if<std::string_view>(&kept)) *text = texts_[count - 1] = std::string(*text);
    if (auto* const blob = std::get_if<Blob>(&kept)) blob->bytes = texts_[count - 1] = std::string(blob->bytes);
  }
  int columns() const override { return row_ ? libpq().columns(row_.get()) : 0; }
  Value value(int column) const override {
    if (!row_ || libpq().is_null(row_.get(), 0, column) != 0) return {};
    const auto size = static_cast<std::size_t>(libpq().length(row_.get(), 0, column));
    return postgres_value(libpq().type(row_.get(), column), {libpq().value(row_.get(), 0, column), size});
  }

  /// Another query begins.
  void take_all() {
    while (state_ == State::running) fetch();
  }

 private:
  enum class State { bound, running, done };

  /// The next row to those that wait, or the end.
  void fetch() {
    if (state_ != State::running) return;
    ResultRow result = engine_.next_result();
    if (result && libpq().result_status(result.get()) == Libpq::single_tuple) {
      waiting_.push_back(std::move(result));
      return;
    }
    state_ = State::done;
    const int status = result ? libpq().result_status(result.get()) : Libpq::command_ok;
    const bool good = status == Libpq::tuples_ok || status == Libpq::command_ok;
    while (engine_.next_result()) {
    }
    engine_.end_of(*this, good && result ? std::strtoll(libpq().command_tuples(result.get()), nullptr, 10) : 0);
    if (!good) engine_.fail(result.get());
  }
  void leave() noexcept {
    try {
      for (; state_ == State::running; waiting_.clear()) fetch();
    } catch (const std::exception&) {
      state_ = State::done;  // whoever uses the connection next says so
    }
    waiting_.clear(), row_.reset();
  }

  Postgres& engine_;
  std::string statement_;
  std::vector<Value> values_;
  std::deque<std::string> texts_;  // of the values; a deque leaves them where they are
  State state_ = State::bound;
  std::deque<ResultRow> waiting_;
  ResultRow row_;
};

Postgres::Postgres(const std::string& address, Access access) : name_(shown_store(address)) {
  expect_address(address);
  connect(address);
  try {
    run_as_it_is(
        "SET search_path = imulab, pg_temp; SET client_encoding = 'UTF8'; SET client_min_messages = 'error'; SET lock_timeout = '60s'; SET "
        "extra_float_digits = 1");
    if (access == Access::read) run_as_it_is("SET default_transaction_read_only = on");
    if (access == Access::read || PostgresQuery(*this, "SELECT 1 FROM pg_catalog.pg_namespace WHERE nspname = 'imulab'").next()) return;
    begin(Access::write);
    run_as_it_is("CREATE SCHEMA IF NOT EXISTS imulab");
    commit();
  } catch (...) {
    libpq().finish(connection_);
    throw;
  }
}

/// libpq quotes an address that it cannot read, or a part of it that it takes for something else. Neither may be shown where it has a password.
void Postgres::expect_address(const std::string& address) {
  char* error = nullptr;
  LibpqOption* const options = libpq().parse(address.c_str(), &error);
  const std::string why = error != nullptr && name_ == address ? ": " + first_line(error) : "";
  libpq().free_memory(error);
  bool good = options != nullptr;
  for (const LibpqOption* o = options; good && o->keyword != nullptr; ++o) {
    const std::string_view key = o->keyword, value = o->val != nullptr ? o->val : "";
    if (key == "port") good = value.find_first_not_of("0123456789,") == std::string_view::npos;
    if (key == "host" || key == "dbname") good = value.find('@') == std::string_view::npos;
  }
  libpq().free_options(options);
  if (!good)
    throw DatabaseError(
        fmt::format("{}: is no address of a PostgreSQL server{}; expected postgresql://USER@HOST:5432/DATABASE, with %40 for @, %3A "
                    "for :, %2F for / within a name or a password",
                    name_, why));
}

void Postgres::connect(const std::string& address) {
  // What stands ahead of "dbname" gives way to what the address says.
  const std::array<const char*, 8> keys{"connect_timeout",
                                        "keepalives_idle",
                                        "keepalives_interval",
                                        "keepalives_count",
                                        "tcp_user_timeout",
                                        "fallback_application_name",
                                        "dbname",
                                        nullptr};
  const std::array<const char*, 8> values{"10", "30", "10", "3", "60000", "imulab", address.c_str(), nullptr};  // s, s, s, 1, ms
  connection_ = libpq().connect(keys.data(), values.data(), 1);
  if (connection_ == nullptr) throw std::bad_alloc();
  libpq().set_notice_processor(
      connection_, [](void*, const char*) {}, nullptr);
  if (libpq().status(connection_) == Libpq::connection_ok) return;
  const std::string why = without_passwords(first_line(libpq().error_message(connection_)));
  libpq().finish(connection_);
  throw DatabaseError(
      fmt::format("{}: PostgreSQL: {}; expected a server that answers, and a user, a password and a database that it has", name_, why));
}

void Postgres::fail(const pg_result* result) {
  const char* const state = result != nullptr ? libpq().result_error_field(result, 'C') : nullptr;
  const char* const message = result != nullptr ? libpq().result_error_field(result, 'M') : nullptr;
  const bool lost = libpq().status(connection_) != Libpq::connection_ok;
  const std::string why = first_line(message != nullptr ? message : libpq().error_message(connection_));
  const std::string_view code = state != nullptr ? state : lost ? "57P" : "";
  const auto* const found = std::ranges::find_if(advice, [&](const auto& a) { return code.starts_with(a.first); });  // the last one fits all
  throw DatabaseError(fmt::format("{}: PostgreSQL: {}; {}", name_, why, found->second));
}

void Postgres::make_way() {
  if (PostgresQuery* const before = std::exchange(active_, nullptr)) before->take_all();
}

void Postgres::run_as_it_is(const std::string& statements) {
  make_way();
  const ResultRow result(libpq().exec(connection_, statements.c_str()));
  const int status = result ? libpq().result_status(result.get()) : -1;
  if (status != Libpq::command_ok && status != Libpq::tuples_ok) fail(result.get());
}

void Postgres::send(PostgresQuery& query, const std::string& statement, const std::vector<Value>& values) {
  make_way();
  std::vector<std::string> bytes;
  std::vector<unsigned> types;
  std::vector<const char*> data;
  std::vector<int> lengths;
  bytes.reserve(values.size());
  for (const Value& value : values) {
    types.push_back(postgres_type(value));
    bytes.push_back(postgres_binary(value));
    data.push_back(value.index() == 0 ? nullptr : bytes.back().data());
    lengths.push_back(static_cast<int>(bytes.back().size()));
  }
  const std::vector<int> binary(values.size(), 1);
  if (libpq().send_query(connection_, statement.c_str(), static_cast<int>(values.size()), types.data(), data.data(), lengths.data(), binary.data(),
                         1) == 0 ||
      libpq().set_single_row_mode(connection_) == 0)
    fail(nullptr);
  active_ = &query;
}

std::unique_ptr<Query> Postgres::query(const std::string& text) { return std::make_unique<PostgresQuery>(*this, text); }

void Postgres::begin(Access access) {
  if (access == Access::read) return run_as_it_is("BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY");
  run_as_it_is("BEGIN ISOLATION LEVEL READ COMMITTED READ WRITE");  // each statement sees what was committed before the lock was had
  try {
    run_as_it_is(fmt::format("SELECT pg_advisory_xact_lock({})", lock_of_writers));
  } catch (const Error&) {
    rollback();
    throw;
  }
}

void Postgres::rollback() noexcept {
  try {
    run_as_it_is("ROLLBACK");
  } catch (const std::exception&) {  // a server that is lost has rolled back
    active_ = nullptr;
  }
}

std::vector<std::string> Postgres::names() {
  std::vector<std::string> out;
  for (PostgresQuery rows(*this, "SELECT tablename FROM pg_catalog.pg_tables WHERE schemaname = 'imulab'"); rows.next();)
    out.emplace_back(std::get<std::string_view>(rows.value(0)));
  return out;
}

std::int64_t Postgres::version() {
  const std::vector<std::string> its = names();
  if (its.empty()) throw DatabaseError(name_ + ": has no fleet store; expected one (imulab fleet calibrate, add and merge make it)");
  if (std::find(its.begin(), its.end(), "store") == its.end())
    throw DatabaseError(name_ + ": its schema \"imulab\" is something else; expected a fleet store");
  PostgresQuery row(*this, "SELECT version FROM store");
  return row.next() ? std::get<std::int64_t>(row.value(0)) : 0;
}

void Postgres::fill(const std::string& table, Query& rows) {
  make_way();
  {
    const ResultRow begun(libpq().exec(connection_, postgres_sql(fmt::format("COPY {} FROM STDIN (FORMAT binary)", table)).c_str()));
    if (!begun || libpq().result_status(begun.get()) != Libpq::copy_in) fail(begun.get());
  }
  const auto put = [&](const std::string& bytes) {
    if (libpq().put_copy_data(connection_, bytes.data(), static_cast<int>(bytes.size())) != 1) fail(nullptr);
  };
  try {
    put(postgres_copy_head());
    while (rows.next()) put(postgres_copy_row(rows));
    put(postgres_copy_tail());
  } catch (const Error& e) {
    libpq().put_copy_end(connection_, e.what());
    while (next_result()) {
    }
    throw;
  }
  const int ended = libpq().put_copy_end(connection_, nullptr);
  const ResultRow result = next_result();
  while (next_result()) {
  }
  if (ended != 1 || !result || libpq().result_status(result.get()) != Libpq::command_ok) fail(result.get());
}

}  // namespace

std::unique_ptr<Engine> open_postgres(const std::string& address, Access access) { return std::make_unique<Postgres>(address, access); }

}  // namespace imulab::fleet
