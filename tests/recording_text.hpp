// For tests of recording files: a recording's text, read as the file that a session names.
#pragma once

#include "imulab/files.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/formats/recording/written/csv_writer.hpp"

#include "tests/temporary_folder.hpp"
#include <string>
#include <vector>

namespace imulab {

/// The text that write_recording writes, in counts.
inline RecordingSource plain_source() {
  RecordingSource source;
  source.file = "r.csv";
  source.time.column = "t";
  source.gyro.columns = {"gx", "gy", "gz"};
  source.accel.columns = {"ax", "ay", "az"};
  return source;
}

inline RecordingReading parse_recording(const std::string& text, const RecordingSource& source = plain_source(), const std::string& other = "") {
  const TemporaryFolder folder;
  Session session;
  session.file = (folder / "session.toml").string();
  folder.write("r.csv", text);
  if (!other.empty()) folder.write("a.csv", other);
  return read_recording(session, source);
}

inline const std::string header = "t,gx,gy,gz,ax,ay,az\n";
inline const std::string two_rows = "0.01,1,2,3,4,5,6\n0.02,7,8,9,10,11,12\n";

/// Rows `t,1,...,6` at the given times.
inline std::string rows_at(const std::vector<std::string>& times) {
  std::string text = header;
  for (const std::string& t : times) text += t + ",1,2,3,4,5,6\n";
  return text;
}

}  // namespace imulab
