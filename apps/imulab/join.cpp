// imulab join PART...
#include "apps/imulab/command.hpp"
#include "imulab/error.hpp"

#include <memory>
#include <utility>

namespace imulab::command {

namespace {

struct Options : ShowOptions {
  std::vector<std::string> parts;
};

/// The command that was divided, with its own options of the answer.
void join(const Options& o) {
  std::vector<PartReader::Source> sources;
  for (const std::string& file : o.parts) sources.push_back(PartReader::file(file));
  const PartReader parts(std::move(sources));
  std::vector<std::string> words;
  std::string word;
  for (const char c : parts.command())
    if (c == 0)
      words.push_back(std::exchange(word, {}));
    else
      word += c;
  if (words.empty()) throw Error(o.parts.front() + ": is a part of another program's work; expected one of imulab --part");
  std::vector<std::string> own;
  if (!o.output.empty()) own.insert(own.end(), {"-o", o.output});
  if (!o.report.empty()) own.insert(own.end(), {"--report", o.report});
  if (o.json) own.emplace_back("--json");
  if (o.verbose) own.emplace_back("--verbose");
  join_parts(std::move(words), own, o.parts);
}

}  // namespace

void add_join(Verb& app) {
  const auto o = std::make_shared<Options>();
  Verb& verb = app.verb("join", "Join the parts of a work: the answer of the whole, to the last bit");
  verb.option("PART", o->parts, "the files of all parts, made by --part; the inputs must be at their original paths")
      .required()
      .takes_several(1)
      .reads();
  verb.option("-o,--output FILE", o->output, "the file or folder that the command would write").of_command();
  report_option(verb, o->report);
  json_option(verb, o->json);
  verb.option("-v,--verbose", o->verbose, "as for the command").of_command();
  verb.example("imulab join part-*");
  verb.does = [o] { join(*o); };
}

}  // namespace imulab::command
