#include "apps/imulab/inspected.hpp"

#include "apps/imulab/files.hpp"
#include "imulab/core/error.hpp"
#include "imulab/inspection/declared.hpp"
#include "imulab/io/session/file.hpp"
#include "imulab/io/text/file.hpp"
#include "imulab/io/text/terminal.hpp"
#include "imulab/tasks/inspect.hpp"

#include <fmt/format.h>

namespace imulab::command {
namespace {

/// A session says so in its first lines; a folder has one.
bool is_session(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path) || path.extension() == ".toml" || !std::filesystem::is_regular_file(path)) return true;
  const MappedFile mapped(path);
  const std::string_view head = mapped.text().substr(0, 4096);
  return head.find("\"imulab.session/") != std::string_view::npos;
}

}  // namespace

void add_declarations(Verb& verb, std::vector<std::string>& declarations) {
  verb.option("--set KEY=VALUE", declarations,
              fmt::format("declare of a recording what its data leave open, as often as needed: {}", fmt::join(declaration_keys(), ", ")))
      .repeats();
}

Declarations parse_declarations(const std::vector<std::string>& texts) {
  Declarations declared;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) throw Error(fmt::format("--set {}: has no value; expected KEY=VALUE", text));
    declared[text.substr(0, equals)] = text.substr(equals + 1);
  }
  errors_at("--set", [&] {
    inspection::check_declarations(declared);
    declared_site(declared);
  });
  return declared;
}

Session open_session(const std::filesystem::path& path, const std::vector<std::string>& texts, std::size_t most_numbers) {
  if (is_session(path)) {
    if (!texts.empty()) throw Error("--set: declares a recording; expected it without a session, which declares all itself");
    if (path != "-") return session_at(path);
    try {
      return session_at(path);
    } catch (const Error& e) {
      throw Error(fmt::format("{} (- is a session here; a recording has to be a file, or is looked at by imulab inspect -)", e.what()));
    }
  }
  const InspectionTask task{.files = {path.string()}, .declared = parse_declarations(texts), .most_numbers = most_numbers};
  const Inspection inspection = [&] {
    const Progress progress("inspecting");
    return inspect_files(task);
  }();
  Session session = session_for(inspection, task, "declare with --set KEY=VALUE, or write a session");
  for (const std::string& line : inspection.evidence) note("assumed: " + line);
  if (const std::string gravity = assumed_gravity(session); !gravity.empty())
    note(fmt::format("assumed: {}; declare the place: --set latitude_deg=47.4", gravity));
  return session;
}

}  // namespace imulab::command
