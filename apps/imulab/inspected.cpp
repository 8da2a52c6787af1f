#include "apps/imulab/inspected.hpp"

#include "apps/imulab/files.hpp"
#include "imulab/core/error.hpp"
#include "imulab/inspection/declared.hpp"
#include "imulab/inspection/join.hpp"
#include "imulab/io/recording/signals.hpp"
#include "imulab/io/session/file.hpp"
#include "imulab/io/text/file.hpp"

#include <fmt/format.h>

#include <utility>

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

Inspection inspect_files(const std::vector<std::string>& files, const std::vector<std::string>& topics, const Declarations& declared,
                         double longest_s, std::size_t most_numbers) {
  std::vector<SignalTable> tables;
  for (const std::string& file : files)
    for (const std::string& topic : topics.empty() ? std::vector<std::string>{""} : topics)
      tables.push_back(read_signals(file, topic, recording_formats(), longest_s, most_numbers));
  return inspect(inspection::joined(std::move(tables), declared), declared);
}

Session open_session(const std::filesystem::path& path, const std::vector<std::string>& texts, std::size_t most_numbers) {
  if (is_session(path)) {
    if (!texts.empty()) throw Error("--set: declares a recording; expected it without a session, which declares all itself");
    return session_at(path);
  }
  const Declarations declared = parse_declarations(texts);
  const Inspection inspection = inspect_files({path.string()}, {}, declared, stream_s, most_numbers);
  if (!inspection.problems.empty()) throw Error(fmt::format("{}: {}", path.string(), inspection.problems.front()));
  if (!inspection.complete()) {
    std::string questions;
    for (const std::string& question : inspection.ambiguous) questions += "\n  " + question;
    throw Unsupported(
        fmt::format("{}: its data leave open what it holds; declare with --set KEY=VALUE, or write a session:{}", path.string(), questions));
  }
  for (const std::string& line : inspection.evidence) note("assumed: " + line);
  Session session = inspected_session(inspection, declared_site(declared));
  if (!session.site.latitude && session.site.given_gravity_sigma)
    note(fmt::format("assumed: gravity {} +/- {} m/s^2, as anywhere on Earth; declare the place: --set latitude_deg=47.4",
                     *session.site.given_gravity, *session.site.given_gravity_sigma));
  session.file = path.string();
  session.sha256 = file_sum(path).sha256;
  return session;
}

}  // namespace imulab::command
