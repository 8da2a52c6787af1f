// A recording that is several files: a folder, or the parts of one that its recorder split, named as "run_0.bag+run_1.bag".
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// True for a folder, and for a name that joins files of one folder by "+".
bool is_several_files(const std::filesystem::path& recording);

/// The files of a recording in the order of their names, in which numbers count by their value: a file itself; the parts of a split one; of a folder
/// all files below it that may hold readings or describe them, without pictures. Throws Error for a folder with far more files than a recording has.
std::vector<std::filesystem::path> files_of(const std::filesystem::path& recording);

/// The bytes of all of them; 0 where they are not known.
std::uintmax_t bytes_of(const std::filesystem::path& recording);

/// "run_2.bag" before "run_10.bag".
bool in_natural_order(std::string_view a, std::string_view b);

/// The name without the number that a recorder gives the parts of a bag: "run_2.bag" is part of "run". Empty where it is no bag, or has none.
std::string series_of(const std::filesystem::path& file);

/// Files as they were named, with neighbors that are all parts of one split bag, numbered from 0, joined to one name: recordings of two nights may be
/// called night_1.bag and night_2.bag.
std::vector<std::string> with_series_joined(const std::vector<std::string>& files);

/// A folder without a slash at its end, which would be an empty name.
std::filesystem::path without_slash(const std::filesystem::path& path);

}  // namespace imulab
