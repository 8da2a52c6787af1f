// imulab import FILE -o calibration.json
#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "imulab/exchange.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/text/json.hpp"

#include <fmt/format.h>

#include <memory>
#include <string>

namespace imulab::command {

namespace {

struct Options {
  std::string file, output, gyro, raw;
  int instance = 0;
  bool json = false;
};

void run(const Options& o) {
  ImportOptions options;
  if (!o.gyro.empty()) options.gyro_file = o.gyro;
  options.raw = o.raw;
  options.instance = o.instance;
  const Imported imported = import_calibration(o.file, options);
  for (const std::string& warning : imported.warnings) warn(fmt::format("{}: {}", o.file, warning));
  write_calibration(o.output, imported.calibration);
  if (o.output == "-") return;
  if (o.json)
    print_json({{{"format", std::string(imported.format)}, {"file", o.output}}}, {Verdict::none, "written: " + o.output}, imported.warnings);
  else
    print(fmt::format("{}: calibration of {}, without uncertainties\n", o.output, imported.format));
}

}  // namespace

void add_import(Verb& app) {
  const auto o = std::make_shared<Options>();
  Verb& verb = app.verb("import", "Read a calibration of another program");
  verb.option("FILE", o->file,
              "a file of Kalibr, OpenVINS, imu_tk, imucal, PSINS, PX4, ArduPilot or VectorNav, or a matrix and a bias; its content decides")
      .required()
      .reads();
  verb.option("-o,--output FILE", o->output, "the calibration to write; - for standard output").required().writes().keeps_existing();
  verb.option("--gyro FILE", o->gyro, "the gyros' file, if a file has one triad: imu_tk, a matrix and a bias").reads();
  verb.option("--raw UNIT", o->raw, "unit of the readings, if the file does not state it").one_of({"si", "count"});
  verb.option("--instance N", o->instance, "number of the IMU in the file, from 0").in_range(0, 9).show_default();
  verb.option("--json", o->json, "print what was read as JSON");
  verb.example("imulab import results-imucam-imu.yaml -o kalibr.json");
  verb.example("imulab import acc.calib --gyro gyro.calib -o imu_tk.json");
  verb.does = [o] { run(*o); };
}

}  // namespace imulab::command
