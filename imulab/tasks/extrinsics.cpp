#include "imulab/tasks/extrinsics.hpp"

#include "imulab/report/extrinsics_page.hpp"
#include "imulab/results/extrinsics.hpp"

#include <fmt/format.h>

#include <memory>
#include <utility>

namespace imulab {

Verb& declare(Verb& command, ExtrinsicsOptions& o) {
  Verb& verb = command.verb("extrinsics", "Find rotation, lever arm and clock offset between the IMUs of one body");
  verb.option(
          "RECORDING", o.recordings,
          "a log with several IMUs, a log each, or a session with a recording each; all of one motion. Of one IMU: predicts what its motion shows")
      .takes_several(1)
      .required()
      .reads()
      .of_command();
  verb.option("--calibration FILE", o.calibrations, "a calibration an IMU, in their order; none: as its grade (repeat)")
      .repeats()
      .reads()
      .of_command();
  verb.option("--grade NAME", o.grade, "grade of the IMUs without a calibration (default: the session's, else mems)");
  verb.option("--set KEY=VALUE", o.declarations, "what a recording does not say, as inspect asks for it (repeat)").repeats().of_command();
  verb.option("-o,--output FILE", o.output, "extrinsics.json to write; - for standard output").writes().of_command();
  report_option(verb, o.report);
  json_option(verb, o.json);
  verb.option("-v,--verbose", o.verbose, "also print residuals, notes and why a recording is read as it is").of_command();
  verb.example("imulab extrinsics a.csv b.csv -o extrinsics.json");
  verb.example("imulab extrinsics flight.ulg --calibration a.json --calibration b.json --calibration none");
  return verb;
}

AnswerOf<Extrinsics> extrinsics_answer(const std::vector<BodyImu>& imus, const std::function<void(double)>& progress) {
  const auto found = std::make_shared<const Extrinsics>(imus.size() == 1 ? predict_extrinsics(imus.front()) : estimate_extrinsics(imus, progress));
  std::vector<std::string> missing;
  for (const Mounting& m : found->from_first)
    if (!m.not_shown.empty()) missing.push_back(fmt::format("{}: {}", m.to, fmt::join(m.not_shown, ", ")));
  const Conclusion conclusion = conclusion_of(*found);
  return {{.json = [found] { return extrinsics_json(*found); },
           .table = [found](bool details) { return extrinsics_text(*found, details); },
           .page = [found, conclusion] { return extrinsics_page(*found, conclusion); },
           .warnings = found->findings.warnings(),
           .shortcomings = missing.empty() ? "" : fmt::format("not shown by this motion: {}", fmt::join(missing, "; ")),
           .conclusion = conclusion},
          found};
}

}  // namespace imulab
