// A bag that is several files: the folder of a ROS 2 bag, and the parts of one that its recorder split.
#pragma once

#include "imulab/formats/recording/bag/topics.hpp"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::bag {

/// Its topics are those of all files, its messages those of one file after the other. One file at a time is open.
class SplitBag : public Bag {
 public:
  /// Throws Error where there is no bag in it, where its files are several bags, and where they are compressed as a whole.
  explicit SplitBag(const std::filesystem::path& path);

  void each_message(const Topic& topic, const MessageSink& sink) override;
  void count_messages() override;

 private:
  std::vector<std::filesystem::path> parts_;
  std::vector<std::string> missing_;  // warnings about the files that there should be
};

/// True for a folder with the files of a bag, and for joined names of such files.
bool is_split_bag(const std::filesystem::path& path);

/// The only file of such a bag; the path itself where it is another one, or has several.
std::filesystem::path only_part(const std::filesystem::path& path);

/// The files that the metadata.yaml of a ROS 2 bag names, from its text.
std::vector<std::string> listed_parts(std::string_view metadata);

}  // namespace imulab::bag
