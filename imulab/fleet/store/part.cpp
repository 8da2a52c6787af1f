#include "imulab/fleet/store/part.hpp"

#include "imulab/core/shared_work.hpp"
#include "imulab/error.hpp"
#include "imulab/fleet/store/database.hpp"
#include "imulab/fleet/store/server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

namespace imulab::fleet {

namespace {

struct Marked {
  PartNumber part;
  std::string task;
  bool finished = false;
};

std::optional<Marked> mark_of(FleetStore& store) {
  Database& db = store.database();
  const std::vector<std::string> names = db.engine().names();
  if (std::find(names.begin(), names.end(), "part") == names.end()) return std::nullopt;
  Statement row(db, "SELECT number, of, task, finished FROM part");
  if (!row.next()) return std::nullopt;
  const std::int64_t number = row.integer(0), of = row.integer(1);
  if (number < 1 || number > of || of > static_cast<std::int64_t>(most_parts)) throw Error(db.file() + ": is damaged: it is a part that cannot be");
  return Marked{{static_cast<std::size_t>(number), static_cast<std::size_t>(of)}, row.text(2), row.integer(3) != 0};
}

}  // namespace

void begin_part(FleetStore& store, PartNumber part, const std::string& task) {
  Database& db = store.database();
  const std::optional<Marked> before = mark_of(store);
  if (!before && db.number("SELECT COUNT(*) FROM units") > 0) throw Error(db.file() + ": is a store already; expected a new one for the part");
  if (before && (before->part.number != part.number || before->part.of != part.of))
    throw Error(fmt::format("{}: is part {} of {}; expected a store of its own for each part", db.file(), before->part.number, before->part.of));
  if (before && before->task != task)
    throw Error(
        fmt::format("{}: is a part of another run (its \"{}\" differs); expected a new store", db.file(), differing_field(task, before->task)));
  Transaction transaction(db);
  db.run(
      "CREATE TABLE IF NOT EXISTS part (number INTEGER NOT NULL, of INTEGER NOT NULL, task TEXT NOT NULL, finished INTEGER NOT NULL); DELETE FROM "
      "part");
  Statement(db, "INSERT INTO part (number, of, task, finished) VALUES (?, ?, ?, 0)")
      .with(static_cast<std::int64_t>(part.number), static_cast<std::int64_t>(part.of), task)
      .run();
  transaction.commit();
}

void end_part(FleetStore& store) { store.database().run("UPDATE part SET finished = 1"); }

void expect_no_part(FleetStore& store) {
  if (const auto mark = mark_of(store))
    throw Error(fmt::format("{}: is part {} of {} of a fleet's sessions; expected another store (imulab fleet merge joins the parts in one)",
                            store.database().file(), mark->part.number, mark->part.of));
}

std::vector<std::filesystem::path> all_parts(std::vector<std::filesystem::path> stores) {
  std::map<std::size_t, std::filesystem::path> parts;
  std::optional<Marked> first;
  for (const std::filesystem::path& file : stores) {
    FleetStore store(file);
    const std::optional<Marked> mark = mark_of(store);
    if (!mark && !first) continue;
    if (!mark || (!first && file != stores.front()))
      throw Error(shown_store(file) + ": of these stores some are parts, and some are not; expected one kind");
    if (!first) first = mark;
    const auto fail = [&](const std::string& what) { throw Error(fmt::format("{}: {}", shown_store(file), what)); };
    if (mark->task != first->task)
      fail(fmt::format("is a part of another run than {} (its \"{}\" differs)", shown_store(stores.front()),
                       differing_field(first->task, mark->task)));
    if (mark->part.of != first->part.of)
      fail(fmt::format("is one of {} parts, {} one of {}", mark->part.of, shown_store(stores.front()), first->part.of));
    if (!mark->finished) fail(fmt::format("part {} is not finished; the same command goes on with it", mark->part.number));
    if (!parts.emplace(mark->part.number, file).second)
      fail(fmt::format("part {} is also {}", mark->part.number, shown_store(parts.at(mark->part.number))));
  }
  if (!first) return stores;
  const std::string missing = missing_parts(first->part.of, [&](std::size_t k) { return parts.contains(k); });
  if (!missing.empty()) throw Error(missing);
  stores.clear();
  for (auto& [number, file] : parts) stores.push_back(file);
  return stores;
}

}  // namespace imulab::fleet
