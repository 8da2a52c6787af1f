#include "imulab/core/part_file.hpp"

#include "imulab/core/shared_work.hpp"
#include "imulab/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

namespace imulab {

namespace {

constexpr const char* part_format = "imulab.part/1";

std::optional<std::size_t> whole_number(std::string_view text) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

/// A number that the environment has.
std::optional<std::size_t> from_environment(const char* name) {
  const char* const text = std::getenv(name);
  return text == nullptr ? std::nullopt : whole_number(text);
}

/// The task of a Slurm array: where the number of parts is stated, its index is the part, as of an array that repeats lost tasks; otherwise it is
/// numbered from 1 on.
std::optional<PartNumber> of_array(std::optional<std::size_t> stated) {
  const auto id = from_environment("SLURM_ARRAY_TASK_ID"), count = from_environment("SLURM_ARRAY_TASK_COUNT"),
             least = from_environment("SLURM_ARRAY_TASK_MIN"), most = from_environment("SLURM_ARRAY_TASK_MAX");
  if (!id) return std::nullopt;
  if (stated && (*id < 1 || *id > *stated))
    throw Error(fmt::format("auto: {} is the index of the Slurm array, and no part; expected --array with indices from 1 to {}", *id, *stated));
  if (stated) return PartNumber{*id, *stated};
  const std::size_t step = std::max<std::size_t>(1, from_environment("SLURM_ARRAY_TASK_STEP").value_or(1));
  if (!count || !least || !most || *id < *least || *most < *least || (*id - *least) % step != 0 || (*most - *least) / step + 1 != *count)
    throw Error("auto: the indices of the Slurm array are not evenly spaced; expected --array=1-N, or auto/N, where each index is a part");
  return PartNumber{(*id - *least) / step + 1, *count};
}

/// The process of mpirun, which may have been started in a step of Slurm, or of such a step.
std::optional<PartNumber> of_tasks() {
  constexpr std::array<std::pair<const char*, const char*>, 3> names{
      {{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"}, {"PMI_RANK", "PMI_SIZE"}, {"SLURM_PROCID", "SLURM_STEP_NUM_TASKS"}}};
  for (const auto& [rank, size] : names)
    if (const auto k = from_environment(rank), n = from_environment(size); k && n && *k < *n) return PartNumber{*k + 1, *n};
  return std::nullopt;
}

PartNumber by_environment(std::optional<std::size_t> of) {
  const std::optional<PartNumber> tasks = of_tasks();
  const std::optional<PartNumber> array = of_array(of ? std::optional(*of / (tasks ? tasks->of : 1)) : std::nullopt);
  const auto index = from_environment("JOB_COMPLETION_INDEX");
  PartNumber part;
  if (array || tasks) {
    const PartNumber a = array.value_or(PartNumber{}), t = tasks.value_or(PartNumber{});
    part = {(a.number - 1) * t.of + t.number, a.of * t.of};
  } else if (index) {
    if (!of) throw Error("auto: Kubernetes does not say how many parts there are; expected auto/N with the job's completions");
    if (*index >= *of) throw Error(fmt::format("auto/{}: this is the index {} of the job; expected N as its completions", *of, *index));
    part = {*index + 1, *of};
  } else {
    throw Error("auto: no Slurm array or step, no mpirun, no indexed job of Kubernetes started this process; expected K/N");
  }
  if (of && part.of != *of) throw Error(fmt::format("auto/{}: the environment has {} parts", *of, part.of));
  return part;
}

/// The works of a part are sealed together with what its file says of it before.
std::uint64_t sum_of(std::uint64_t number, std::uint64_t of, const std::string& command) {
  return checksum(fmt::format("{}/{} {}", number, of, command));
}

/// The words of a command as a line.
std::string readable(std::string command) {
  std::replace_if(
      command.begin(), command.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
  return command.substr(0, command.find_last_not_of(' ') + 1);
}

}  // namespace

PartNumber part_named(const std::string& text) {
  const std::size_t slash = std::min(text.find('/'), text.size());
  const std::optional<std::size_t> of = slash < text.size() ? whole_number(text.substr(slash + 1)) : std::nullopt;
  const bool automatic = text.substr(0, slash) == "auto";
  if (automatic && (of || slash == text.size())) {
    const PartNumber part = by_environment(of);
    if (part.number >= 1 && part.number <= part.of && part.of <= most_parts) return part;
  }
  const std::optional<std::size_t> number = whole_number(text.substr(0, slash));
  if (!number || !of || *number < 1 || *number > *of || *of > most_parts) throw Error(text + "; expected K/N with K from 1 to N, as in 3/8, or auto");
  return {*number, *of};
}

BlockRange blocks_of(PartNumber part, std::size_t count) {
  const auto before = [&](std::size_t parts) { return count / part.of * parts + count % part.of * parts / part.of; };
  return {before(part.number - 1), before(part.number)};
}

std::string missing_parts(std::size_t of, const std::function<bool(std::size_t part)>& is_there) {
  constexpr std::size_t most_named = 10;
  std::string names;
  std::size_t missing = 0;
  for (std::size_t k = 1; k <= of; ++k)
    if (!is_there(k) && ++missing <= most_named) names += fmt::format("{}{}", missing > 1 ? ", " : "", k);
  if (missing == 0) return "";
  return fmt::format("of {} parts these are missing: {}{}", of, names, missing > most_named ? fmt::format(" and {} more", missing - most_named) : "");
}

PartWriter::PartWriter(PartNumber part, std::string command)
    : part_(part), command_(std::move(command)), works_(sum_of(part.number, part.of, command_)) {}

std::string PartWriter::name() const { return fmt::format("part-{}-of-{}", part_.number, part_.of); }

BlockRange PartWriter::begin_work(const std::string& identity, std::size_t count) {
  works_.text(identity), works_.number(count);
  blocks_ = count;
  return range_ = blocks_of(part_, count);
}

void PartWriter::end_work() {
  works_.seal();
  ++count_;
}

std::string PartWriter::bytes() const {
  SealedWriter out;
  out.text(part_format), out.text(command_), out.number(part_.number), out.number(part_.of), out.number(count_), out.seal();
  return out.bytes() + works_.bytes();
}

std::string PartWriter::summary() const {
  const std::string blocks = range_.size() == 0 ? "no block" : fmt::format("blocks {} to {}", range_.begin + 1, range_.end);
  return fmt::format("part {} of {}: {} of {}", part_.number, part_.of, blocks, blocks_);
}

PartReader::Source PartReader::file(const std::filesystem::path& path) {
  return {path.string(), [path](std::uint64_t& size) -> std::unique_ptr<std::istream> {
            std::error_code none;
            size = is_regular_file(path, none) ? file_size(path, none) : 0;
            auto in = std::make_unique<std::ifstream>();
            if (size > 0 && !none) in->open(path, std::ios::binary);
            if (!in->is_open()) throw Error(path.string() + ": cannot be read; expected a part of a work");
            return in;
          }};
}

PartReader::Source PartReader::memory(std::string name, std::string bytes) {
  return {std::move(name), [bytes = std::move(bytes)](std::uint64_t& size) -> std::unique_ptr<std::istream> {
            size = bytes.size();
            return std::make_unique<std::istringstream>(bytes);
          }};
}

PartReader::PartReader(std::vector<Source> sources) {
  std::uint64_t of = 0;
  for (Source& source : sources) {
    Part part{.source = std::move(source)};
    const std::string& name = part.source.name;
    std::uint64_t size = 0, n = 0, works = 0;
    const auto in = part.source.open(size);
    SealedReader reader(*in, size);
    std::string format, command;
    if (!reader.text(format) || format != part_format) throw Error(name + ": is no part of a work; expected a file of --part");
    if (!reader.text(command) || !reader.number(part.number) || !reader.number(n) || !reader.number(works) || !reader.seal() || n > most_parts ||
        works == 0)
      throw Error(name + ": is damaged; expected the part as it was written");
    part.left = reader.left(), part.sum = sum_of(part.number, n, command);
    if (parts_.empty()) command_ = command, of = n, works_ = works;
    const std::string& first = parts_.empty() ? name : parts_.front().source.name;
    if (n != of) throw Error(fmt::format("{}: is one of {} parts, {} one of {}; expected parts of one work", name, n, first, of));
    if (command != command_ || works != works_)
      throw Error(fmt::format("{}: is a part of another command than {}: {} in place of {}", name, first, readable(command), readable(command_)));
    parts_.push_back(std::move(part));
  }
  std::sort(parts_.begin(), parts_.end(), [](const Part& a, const Part& b) { return a.number < b.number; });
  for (std::size_t k = 1; k < parts_.size(); ++k)
    if (parts_[k].number == parts_[k - 1].number)
      throw Error(fmt::format("{}, {}: both are part {}", parts_[k - 1].source.name, parts_[k].source.name, parts_[k].number));
  std::size_t at = 0;
  const std::string missing = missing_parts(of, [&](std::size_t k) {
    const bool is_there = at < parts_.size() && parts_[at].number == k;
    at += is_there ? 1 : 0;
    return is_there;
  });
  if (!missing.empty() || parts_.size() != of) throw Error(missing.empty() ? "expected the parts of a work" : missing);
}

void PartReader::read(const std::string& identity, std::size_t count, const std::function<void(std::size_t, const std::string&)>& take) {
  ++read_;
  for (Part& part : parts_) {
    std::uint64_t size = 0, blocks = 0;
    const auto in = part.source.open(size);
    const auto damaged = [&] { return Error(part.source.name + ": is damaged; expected the part as it was written"); };
    if (size < part.left || !in->seekg(static_cast<std::streamoff>(size - part.left))) throw damaged();
    SealedReader reader(*in, part.left, part.sum);
    std::string there, result;
    if (!reader.text(there) || !reader.number(blocks)) throw damaged();
    if (there != identity)
      throw Error(fmt::format("{}: is a part of another run (its \"{}\" differs); expected the inputs and the version of imulab of the parts",
                              part.source.name, differing_field(identity, there)));
    if (blocks != count) throw damaged();
    const BlockRange range = blocks_of({part.number, parts_.size()}, count);
    for (std::size_t block = range.begin; block < range.end; ++block) {
      if (!reader.text(result)) throw damaged();
      take(block, result);
    }
    if (!reader.seal() || (read_ == works_ && reader.left() > 0)) throw damaged();
    part.left = reader.left(), part.sum = reader.sum();
  }
}

}  // namespace imulab
