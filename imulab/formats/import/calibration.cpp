#include "imulab/core/decomposition.hpp"
#include "imulab/error.hpp"
#include "imulab/exchange.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/import/format.hpp"
#include "imulab/formats/import/numbers.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/model/finding_table.hpp"
#include "imulab/recording/origin.hpp"

#include <fmt/format.h>

#include <cmath>

namespace imulab {

namespace import_io {

const std::vector<ImportFormat>& import_formats() {
  // The first that recognizes a text reads it: those of narrow content before those of wide.
  static const std::vector<ImportFormat> formats{
      {"json-matrix", "matrices of `imulab export --to json-matrix`", is_json_matrix, read_json_matrix},
      {"csv", "the table of `imulab export --to csv`", is_csv_table, read_csv_table},
      {"imucal", "imucal's JSON", is_imucal, read_imucal},
      {"OpenVINS", "kalibr_imu_chain.yaml", is_openvins, read_openvins},
      {"Kalibr", "its result form", is_kalibr, read_kalibr},
      {"VectorNav", "registers 25 and 84", is_vectornav, read_vectornav},
      {"PX4", "parameters", is_px4, read_px4},
      {"ArduPilot", "parameters", is_ardupilot, read_ardupilot},
      {"PSINS", "text of clbtfile", is_psins, read_psins},
      {"imu_tk", ".calib, one triad a file", is_imu_tk, read_imu_tk},
      {"matrix and bias", "12 numbers a triad", is_plain_matrix, read_plain_matrix},
  };
  return formats;
}

void fail_at(const Source& source, int line, const std::string& text) {
  throw Error(line > 0 ? fmt::format("{}:{}: {}", source.file, line, text) : fmt::format("{}: {}", source.file, text));
}

Matrix3d inverse_at(const Source& source, int line, const std::string& what, const Matrix3d& matrix) {
  const auto inverse = regular_inverse(matrix);
  if (!inverse) fail_at(source, line, what + ": is singular; expected a matrix with an inverse");
  return *inverse;
}

namespace {

constexpr std::size_t largest_import = std::size_t{1} << 20;

const ImportFormat& format_of(const Source& s) {
  if (s.text.find_first_not_of(" \t\r\n") == std::string_view::npos) fail_at(s, 0, "is empty; expected a calibration");
  if (s.text.size() > largest_import) fail_at(s, 0, "is longer than a MiB; expected a calibration");
  if (s.text.find("\"imulab.calibration/") != std::string_view::npos)
    fail_at(s, 0, "is a calibration of imulab already; expected one of another program");
  for (const ImportFormat& format : import_formats())
    if (format.recognizes(s.text)) return format;
  std::string names;
  for (const ImportFormat& format : import_formats()) names += fmt::format("{}{} ({})", names.empty() ? "" : ", ", format.name, format.summary);
  fail_at(s, 0, "is in no format that import knows; expected one of " + names);
}

void check_triad(const Source& s, const TriadModel& m, const char* name) {
  if (!m.all_finite()) fail_at(s, 0, fmt::format("the {}' numbers are too large; expected finite ones", name));
  inverse_at(s, 0, fmt::format("the {}' matrix", name), m.matrix);
}

/// Where the file does not tell: a mean scale between half and two is one of SI units, else counts.
void set_raw_unit(const Source& s, Imported& out, TriadModel& m, const char* name, const char* si, const std::string& asked, bool known) {
  if (known && !asked.empty() && (asked == "count") != (m.raw_unit == "count"))
    fail_at(s, 0,
            fmt::format("raw {}: the {}' readings are in {} in this format; expected no raw", asked, name, m.raw_unit == "count" ? "counts" : si));
  if (!asked.empty()) {
    m.raw_unit = asked == "count" ? "count" : si;
  } else if (!known) {
    const double scale = std::cbrt(std::abs(m.matrix.determinant()));
    m.raw_unit = scale >= 0.5 && scale <= 2 ? si : "count";
    out.warnings.push_back(fmt::format(
        "the file does not tell the unit of the {}' readings: taken as {}, because their scale is {:.3g}; raw (si or count) says otherwise", name,
        m.raw_unit == "count" ? "counts" : si, scale));
  }
}

/// Without the byte order mark that editors put in front.
std::string_view without_mark(std::string_view text) {
  constexpr std::string_view mark = "\xEF\xBB\xBF";
  return text.starts_with(mark) ? text.substr(mark.size()) : text;
}

ImportedModel read_model(const Source& source, const ImportOptions& options, const ImportFormat& format) {
  ImportedModel model = format.read(source);
  check_triad(source, model.model.accel, "accelerometers");
  if (!model.one_triad) {
    check_triad(source, model.model.gyro, "gyros");
    if (options.gyro_file) fail_at(source, 0, "has both triads; expected no second file, of gyros");
    return model;
  }
  if (!options.gyro_file) {
    model.warnings.push_back("the file has one triad, taken as the accelerometers': the gyros stay as they are; a second file (gyro) may have them");
    return model;
  }
  const MappedFile file(*options.gyro_file, Content::settings);
  const Source gyros{without_mark(file.text()), input_name(*options.gyro_file), options.instance};
  const ImportFormat& gyro_format = format_of(gyros);
  const ImportedModel gyro = gyro_format.read(gyros);
  if (!gyro.one_triad) fail_at(gyros, 0, "has both triads; expected one with the gyros alone");
  check_triad(gyros, gyro.model.accel, "gyros");
  model.model.gyro = gyro.model.accel;
  model.one_triad = false;
  return model;
}

/// Lower triangular with a positive diagonal: the body frame is the accelerometers'.
bool is_accelerometers_frame(const Matrix3d& m) { return m(0, 1) == 0 && m(0, 2) == 0 && m(1, 2) == 0 && m.diagonal().minCoeff() > 0; }

}  // namespace

}  // namespace import_io

Imported import_calibration_text(std::string_view text, const std::string& name, const ImportOptions& options) {
  using namespace import_io;
  const Source source{without_mark(text), name, options.instance};
  const ImportFormat& format = format_of(source);
  const ImportedModel model = read_model(source, options, format);
  Imported out{format.name, {}, model.warnings};
  Calibration& c = out.calibration;
  c.model = model.model;
  set_raw_unit(source, out, c.model.accel, "accelerometers", "m/s^2", options.raw, model.raw_known);
  if (model.one_triad)
    c.model.gyro.raw_unit = "rad/s";
  else
    set_raw_unit(source, out, c.model.gyro, "gyros", "rad/s", options.raw, model.raw_known);
  c.imu = std::string(format.name) + " import";
  c.method = "import";
  c.software = software();
  c.options = {{"file", printable(name)}, {"format", std::string(format.name)}, {"sha256", sha256(text)}};
  c.frame = is_accelerometers_frame(c.model.accel.matrix) ? BodyFrame::accelerometers : BodyFrame::rig;
  c.covariance.resize(0, 0);
  c.recorded_accel = model.recorded_accel;
  c.recorded_gyro = model.recorded_gyro;
  c.quality.unobservable = model.not_determined;
  c.quality.verdict = Verdict::doubtful;
  c.quality.findings.add<Code::imported>();
  if (!model.not_determined.empty()) c.quality.findings.add<Code::import_undetermined>(model.not_determined.size());
  c.quality.findings.append(Severity::warning, out.warnings);
  return out;
}

Imported import_calibration(const std::filesystem::path& file, const ImportOptions& options) {
  const MappedFile mapped(file, Content::settings);
  return import_calibration_text(mapped.text(), input_name(file), options);
}

}  // namespace imulab
