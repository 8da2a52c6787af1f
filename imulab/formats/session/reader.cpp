#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/session/fields.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/session/step_layout.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/formats/text/toml_fields.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace imulab {
namespace {

using namespace session_io;

void read_rig(TomlFields& f, Session& session) {
  RigDeclaration rig;
  transfer(f, rig, !session.rigs.empty());
  f.check(std::none_of(session.rigs.begin(), session.rigs.end(), [&](const RigDeclaration& r) { return r.name == rig.name; }), "name",
          "repeats the name of an earlier rig; expected different names");
  session.rigs.push_back(rig);
}

void read_reference(TomlFields& f, Session& session) {
  Reference reference;
  transfer(f, reference);
  f.check(std::none_of(session.references.begin(), session.references.end(), [&](const Reference& r) { return r.quantity == reference.quantity; }),
          "quantity", "repeats the quantity of an earlier reference; expected each once");
  session.references.push_back(reference);
}

void read_recording_source(TomlFields& f, Session& session) {
  RecordingSource recording;
  transfer(f, recording);
  std::vector<std::string_view> rigs;
  for (const RigDeclaration& rig : session.rigs) rigs.push_back(rig.name);
  f.check(rigs.size() < 2 || !recording.rig.empty(), "rig", "is missing; expected one of " + listed(rigs));
  f.check(recording.rig.empty() || std::find(rigs.begin(), rigs.end(), recording.rig) != rigs.end(), "rig",
          fmt::format("\"{}\" is not a rig of this session; expected {}", recording.rig, rigs.empty() ? "[[rig]] of that name" : listed(rigs)));
  f.check(std::none_of(session.recordings.begin(), session.recordings.end(), [&](const RecordingSource& r) { return r.file == recording.file; }),
          "file", "repeats the file of an earlier recording; expected each file once");
  session.recordings.push_back(recording);
}

void read_step(TomlFields& f, Session& session, StepLayout& layout) {
  StepText text;
  transfer(f, text);
  std::vector<std::string_view> files;
  for (const RecordingSource& recording : session.recordings) files.push_back(recording.file);
  f.check(files.size() < 2 || text.recording, "recording", "is missing; expected one of " + listed(files));
  std::string recording = text.recording.value_or(files.size() == 1 ? std::string(files[0]) : "");
  f.check(files.empty() || std::find(files.begin(), files.end(), recording) != files.end(), "recording",
          fmt::format("\"{}\" is not a recording of this session; expected {}", recording, listed(files)));
  Step step;
  if (const auto problem = layout.place(text, recording, step)) f.check(false, problem->key, problem->message);
  session.steps.push_back(step);
}

void read_aid(TomlFields& f, Session& session) {
  Aid& aid = session.aids.emplace_back();
  transfer(f, aid);
  std::vector<std::string_view> files;
  for (const RecordingSource& recording : session.recordings) files.push_back(recording.file);
  f.check(aid.recording.empty() || std::find(files.begin(), files.end(), aid.recording) != files.end(), "recording",
          fmt::format("\"{}\" is not a recording of this session; expected {}", aid.recording, listed(files)));
}

}  // namespace

void take_noise(ImuDeclaration& imu, const std::string& file) {
  const ImuNoise noise = read_noise(file);
  NoiseModels sizes = errors_at(file, [&] { return noise_sizes(noise); });
  if (!imu.gyro_noise_density) imu.gyro_noise_density = sizes.gyro.N;
  if (!imu.accel_noise_density) imu.accel_noise_density = sizes.accel.N;
  sizes.gyro.N = sizes.accel.N = 0;  // which have keys of their own
  if (!imu.gyro_noise) imu.gyro_noise = sizes.gyro;
  if (!imu.accel_noise) imu.accel_noise = sizes.accel;
  imu.noise_file.reset();
}

Session read_session(const std::filesystem::path& path) {
  const std::filesystem::path file = std::filesystem::is_directory(path) ? path / "session.toml" : path;
  const MappedFile mapped(file, Content::settings);
  return parse_session(mapped.text(), input_name(file));
}

Session parse_session(std::string_view text, const std::string& file) {
  Session session;
  session.file = file;
  session.sha256 = sha256(text);
  TomlFields f(session.file, text);
  StepLayout layout;
  f.format(session_format);
  transfer(f, session);
  f.table("imu", Presence::optional, [&](TomlFields& t) { transfer(t, session.imu); });
  f.table("site", Presence::optional, [&](TomlFields& t) { transfer(t, session.site); });
  f.tables("reference", [&](TomlFields& t) { read_reference(t, session); });
  f.tables("rig", [&](TomlFields& t) { read_rig(t, session); });
  f.tables("recording", [&](TomlFields& t) { read_recording_source(t, session); });
  f.consecutive_tables("step", [&](TomlFields& t) { read_step(t, session, layout); });
  f.table_of<InitialState>("initial", session.initial, [](TomlFields& t, InitialState& initial) { transfer(t, initial); });
  f.table("truth", Presence::optional, [&](TomlFields& t) { t.text("file", session.truth_file.emplace()); });
  f.table("navigation", Presence::optional, [&](TomlFields& t) { transfer_navigation(t, session); });
  f.tables("aid", [&](TomlFields& t) { read_aid(t, session); });
  f.done();
  session.noise_taken = session.imu.noise_file;
  if (session.imu.noise_file) take_noise(session.imu, session_path(session, *session.imu.noise_file).string());
  return session;
}

std::filesystem::path session_path(const Session& session, const std::string& file) {
  return std::filesystem::path(session.file).parent_path() / file;
}

}  // namespace imulab
