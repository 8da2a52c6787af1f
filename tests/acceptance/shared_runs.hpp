// The runs of an acceptance test on all cores; in parts, which are joined; or again from where it ended (docs/reference/fleet-store.md).
#pragma once

#include "imulab/core/part_file.hpp"
#include "imulab/core/shared_work.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/text/file.hpp"

#include <Eigen/Core>

#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace imulab::acceptance {

/// How this program does its runs.
inline Sharing& shared_runs() {
  static Sharing sharing;
  return sharing;
}

/// True where whole results come out, and not a part of them.
inline bool tells() { return !shared_runs().part; }

/// Of one test. Runs of another build of this program, or of another number, are another work.
inline Sharing sharing_of(const std::string& test, std::size_t count) {
  static const std::string program = file_sum("/proc/self/exe").sha256;
  Sharing out = shared_runs();
  out.identity = work_identity("acceptance", {{"test", test}, {"runs", std::to_string(count)}, {"program", program}});
  if (!out.checkpoint.empty()) out.checkpoint /= test;
  return out;
}

/// What follows from one work of a test; nothing where a part of that is done.
inline void by_part(const std::function<void()>& work) {
  try {
    work();
  } catch (const PartIsDone&) {
  }
}

/// A structure lists its members: `void fields(auto&& visit) { visit(error, covariance); }`. Its bytes would have holes, which differ from run to
/// run.
template <class T>
concept HasFields = requires(T value) {
  value.fields([](auto&...) {});
};

template <class T>
concept IsMatrix = requires(T value) {
  value.rows();
  value.resize(1, 1);
  value.data();
};

/// The result of a run, as bytes.
template <class T>
void write_run(std::string& out, T& value) {
  if constexpr (HasFields<T>) {
    value.fields([&](auto&... members) { (write_run(out, members), ...); });
  } else if constexpr (IsMatrix<T>) {
    Eigen::Index rows = value.rows(), columns = value.cols();
    write_run(out, rows), write_run(out, columns);
    out.append(reinterpret_cast<const char*>(value.data()), static_cast<std::size_t>(value.size()) * sizeof(double));
  } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
    out.append(reinterpret_cast<const char*>(&value), sizeof value);
  } else {
    std::size_t count = value.size();
    write_run(out, count);
    for (auto& element : value) write_run(out, element);
  }
}

/// And back, from the front of the bytes.
template <class T>
void read_run(std::string_view& bytes, T& value) {
  const auto take = [&](void* to, std::size_t size) {
    if (bytes.size() < size) throw Error("a run that was kept is cut short; expected one of the same program");
    if (size > 0) std::memcpy(to, bytes.data(), size);
    bytes.remove_prefix(size);
  };
  if constexpr (HasFields<T>) {
    value.fields([&](auto&... members) { (read_run(bytes, members), ...); });
  } else if constexpr (IsMatrix<T>) {
    Eigen::Index rows = 0, columns = 0;
    read_run(bytes, rows), read_run(bytes, columns);
    value.resize(rows, columns);
    take(value.data(), static_cast<std::size_t>(value.size()) * sizeof(double));
  } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
    take(&value, sizeof value);
  } else {
    std::size_t count = 0;
    read_run(bytes, count);
    if constexpr (requires { value.resize(count); })
      value.resize(count);
    else if (count != value.size())
      throw Error("a run that was kept has another shape; expected one of the same program");
    for (auto& element : value) read_run(bytes, element);
  }
}

/// The results of `run` for 0 ... count - 1, in this order. `test`: the name of its folder.
template <class T>
std::vector<T> runs_of(const std::string& test, int count, const std::function<T(std::size_t)>& run) {
  std::vector<T> runs(static_cast<std::size_t>(count));
  SharedWork work{.count = runs.size(), .work = {}, .take = {}};
  work.work = [&](std::size_t i) {
    T one = run(i);
    std::string bytes;
    write_run(bytes, one);
    return bytes;
  };
  work.take = [&](std::size_t i, const std::string& bytes) {
    std::string_view rest = bytes;
    read_run(rest, runs[i]);
  };
  const Sharing sharing = sharing_of(test, runs.size());
  for_each(work, &sharing);
  return runs;
}

}  // namespace imulab::acceptance
