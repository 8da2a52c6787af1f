#include "imulab/io/recording/format.hpp"

#include "imulab/io/recording/csv.hpp"

namespace imulab {

const std::vector<RecordingFormat>& recording_formats() {
  using namespace recording_io;
  static const std::vector<RecordingFormat> formats{
      {"CSV or plain columns of numbers", is_text,
       [](const std::filesystem::path& file, const RecordingSource& source, const std::vector<Column>& columns) {
         return read_csv(file, source.time, columns);
       }},
  };
  return formats;
}

}  // namespace imulab
