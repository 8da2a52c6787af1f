#include "imulab/formats/recording/archive/archive.hpp"

#include "imulab/core/memory.hpp"
#include "imulab/core/text.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/recording/archive/zip.hpp"
#include "imulab/formats/recording/text/encoding.hpp"
#include "imulab/formats/text/several_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <zlib.h>

#ifdef IMULAB_WITH_ARCHIVE
#include <archive.h>
#include <archive_entry.h>
#include <dlfcn.h>
#endif

namespace imulab::recording_io {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t described_bytes = 1 << 18;  // of a text, to know what it is
constexpr std::size_t piece_bytes = 1 << 18;

struct PackedBegin {
  std::size_t place;
  std::string_view bytes;
};
constexpr std::array<PackedBegin, 9> packed_begins{{{0, "\x1F\x8B"},                 // gzip
                                                    {0, "\x28\xB5\x2F\xFD"},         // Zstandard
                                                    {0, {"\xFD\x37zXZ\x00", 6}},     // xz
                                                    {0, "BZh"},                      // bzip2
                                                    {0, "\x04\x22\x4D\x18"},         // LZ4
                                                    {0, "PK\3\4"},                   // zip
                                                    {0, "PK\5\6"},                   // an empty one
                                                    {0, {"7z\xBC\xAF\x27\x1C", 6}},  // 7-Zip
                                                    {257, "ustar"}}};                // tar

/// A file that is gunzipped while it is read; one that is not compressed so is given as it is.
class Gunzip {
 public:
  explicit Gunzip(const fs::path& path) : file_(gzopen(path.c_str(), "rb")) {
    if (file_ == nullptr) throw Error(path.string() + ": cannot be opened");
    gzbuffer(file_, piece_bytes);
  }
  ~Gunzip() { gzclose(file_); }
  Gunzip(const Gunzip&) = delete;
  Gunzip& operator=(const Gunzip&) = delete;

  /// 0 at the end. Where it is damaged: nothing, and why.
  std::optional<std::size_t> read(char* to, std::size_t size) {
    const int got = gzread(file_, to, static_cast<unsigned>(size));
    int code = Z_OK;
    const char* const text = gzerror(file_, &code);
    if (got > 0 || (got == 0 && code == Z_OK)) return static_cast<std::size_t>(got);
    why_ = code == Z_BUF_ERROR ? "it ends too early" : std::string(text).substr(std::string_view(text).rfind(": ") + 2);
    return std::nullopt;
  }
  const std::string& why() const { return why_; }
  bool gunzips() const { return gzdirect(file_) == 0; }

 private:
  gzFile file_;
  std::string why_;
};

[[noreturn]] void fail_packed(const std::string& place, const std::string& why) {
  throw Error(fmt::format("{}: cannot be unpacked: {}; expected a whole archive or compressed file, without a password", place, why));
}

struct PackedMember {
  std::string name;                    ///< empty where the whole file is one
  std::optional<std::uint64_t> bytes;  ///< when it is unpacked, where the archive says so
};

/// One pass over the members.
class Unpacking {
 public:
  Unpacking() = default;
  virtual ~Unpacking() = default;
  Unpacking(const Unpacking&) = delete;
  Unpacking& operator=(const Unpacking&) = delete;

  virtual std::optional<PackedMember> next() = 0;
  virtual bool is_file() const { return true; }
  virtual bool is_encrypted() const { return false; }
  /// Of the member; 0 at its end.
  virtual std::size_t read(char* to, std::size_t size, const std::string& place) = 0;
};

#ifdef IMULAB_WITH_ARCHIVE

/// The functions of libarchive. It is loaded with the first archive, if it is installed: the libraries that it needs take longer to load than many a
/// verb to run.
struct Libarchive {
#define IMULAB_OF_LIBARCHIVE(each)                                                                                                                  \
  each(archive_read_new) each(archive_read_free) each(archive_read_support_filter_bzip2) each(archive_read_support_filter_lz4)                      \
      each(archive_read_support_filter_xz) each(archive_read_support_filter_zstd) each(archive_read_support_format_7zip)                            \
          each(archive_read_support_format_raw) each(archive_read_support_format_tar) each(archive_read_support_format_zip) each(archive_read_open) \
              each(archive_read_open_filename) each(archive_read_next_header) each(archive_read_data) each(archive_format)                          \
                  each(archive_error_string) each(archive_set_error) each(archive_entry_pathname) each(archive_entry_size_is_set)                   \
                      each(archive_entry_size) each(archive_entry_filetype) each(archive_entry_is_encrypted)
#define IMULAB_DECLARE(name) decltype(&::name) name = nullptr;  // NOLINT(bugprone-macro-parentheses): it is a declarator
  IMULAB_OF_LIBARCHIVE(IMULAB_DECLARE)

  /// Null if it is not installed.
  static const Libarchive* installed() {
    static const std::optional<Libarchive> found = load();
    return found ? &*found : nullptr;
  }

 private:
  static std::optional<Libarchive> load() {
    Libarchive out;
#ifdef __EMSCRIPTEN__
#define IMULAB_FIND(name) out.name = &::name;
#else
    void* const library = dlopen("libarchive.so.13", RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) return std::nullopt;
#define IMULAB_FIND(name)                                                \
  out.name = reinterpret_cast<decltype(&::name)>(dlsym(library, #name)); \
  if (out.name == nullptr) return std::nullopt;
#endif
    IMULAB_OF_LIBARCHIVE(IMULAB_FIND)
    return out;
  }
};

class ByLibarchive : public Unpacking {
 public:
  ByLibarchive(const Libarchive& library, const fs::path& path)
      : library_(library), path_(path.string()), gunzip_(path), archive_(library.archive_read_new(), library.archive_read_free) {
    using Support = int (*)(struct archive*);
    // No filter or format that starts a program.
    for (const Support support :
         {library_.archive_read_support_filter_bzip2, library_.archive_read_support_filter_lz4, library_.archive_read_support_filter_xz,
          library_.archive_read_support_filter_zstd, library_.archive_read_support_format_7zip, library_.archive_read_support_format_raw,
          library_.archive_read_support_format_tar, library_.archive_read_support_format_zip})
      support(archive_.get());
    const int opened = gunzip_.gunzips() ? library_.archive_read_open(archive_.get(), this, nullptr, next_piece, nullptr)
                                         : library_.archive_read_open_filename(archive_.get(), path.c_str(), piece_bytes);
    if (opened != ARCHIVE_OK) fail_packed(path_, why());
  }

  std::optional<PackedMember> next() override {
    const int found = library_.archive_read_next_header(archive_.get(), &entry_);
    if (found == ARCHIVE_EOF) return std::nullopt;
    if (found != ARCHIVE_OK && found != ARCHIVE_WARN) fail_packed(path_, why());  // a warning is about names and owners
    PackedMember member;
    if (library_.archive_format(archive_.get()) == ARCHIVE_FORMAT_RAW) return member;
    if (const char* const name = library_.archive_entry_pathname(entry_)) member.name = name;
    if (library_.archive_entry_size_is_set(entry_) != 0)
      member.bytes = static_cast<std::uint64_t>(std::max<la_int64_t>(0, library_.archive_entry_size(entry_)));
    return member;
  }
  bool is_file() const override { return library_.archive_entry_filetype(entry_) == AE_IFREG; }
  bool is_encrypted() const override { return library_.archive_entry_is_encrypted(entry_) != 0; }

  std::size_t read(char* to, std::size_t size, const std::string& place) override {
    const la_ssize_t got = library_.archive_read_data(archive_.get(), to, size);
    if (got < 0) fail_packed(place, why());
    return static_cast<std::size_t>(got);
  }

 private:
  std::string why() const {
    if (!gunzip_.why().empty()) return gunzip_.why();
    const char* const text = library_.archive_error_string(archive_.get());
    return text != nullptr ? text : "its format is not known";
  }

  static la_ssize_t next_piece(struct archive* archive, void* self, const void** piece) {
    auto& own = *static_cast<ByLibarchive*>(self);
    const auto got = own.gunzip_.read(own.piece_.data(), own.piece_.size());
    *piece = own.piece_.data();
    if (got) return static_cast<la_ssize_t>(*got);
    own.library_.archive_set_error(archive, EINVAL, "%s", own.gunzip_.why().c_str());
    return -1;
  }

  const Libarchive& library_;
  std::string path_, piece_ = std::string(piece_bytes, '\0');
  Gunzip gunzip_;
  std::unique_ptr<struct archive, int (*)(struct archive*)> archive_;
  struct archive_entry* entry_ = nullptr;
};

#endif

class GzipOrZip : public Unpacking {
 public:
  explicit GzipOrZip(const fs::path& path) : path_(path.string()), gunzip_(path), file_(path) {
    if (gunzip_.gunzips()) return;
    if (!file_.text().starts_with("PK"))
      throw Error(path_ +
                  ": is compressed or an archive, for which libarchive is missing (Debian: libarchive13); expected .gz, .zip, or it unpacked");
    members_ = zip_members(file_.text(), path_);
  }
  std::optional<PackedMember> next() override {
    if (gunzip_.gunzips()) return std::exchange(at_, 1) == 0 ? std::optional(PackedMember{}) : std::nullopt;
    if (at_ == members_.size()) return std::nullopt;
    const ZipMember& member = members_[at_++];
    zipped_ = std::make_unique<ZipReader>(member, path_ + "/" + member.name);
    left_ = member.bytes;
    return PackedMember{member.name, member.bytes};
  }
  std::size_t read(char* to, std::size_t size, const std::string& place) override {
    if (!zipped_) {
      const auto got = gunzip_.read(to, size);
      if (!got) fail_packed(place, gunzip_.why());
      return *got;
    }
    const std::size_t part = std::min(size, left_);
    zipped_->read(to, part);
    left_ -= part;
    if (left_ == 0) zipped_->expect_intact();
    return part;
  }

 private:
  std::string path_;
  Gunzip gunzip_;
  MappedFile file_;
  std::vector<ZipMember> members_;
  std::size_t at_ = 0, left_ = 0;
  std::unique_ptr<ZipReader> zipped_;
};

std::unique_ptr<Unpacking> unpacking(const fs::path& path) {
#ifdef IMULAB_WITH_ARCHIVE
  if (const Libarchive* const library = Libarchive::installed()) return std::make_unique<ByLibarchive>(*library, path);
#endif
  return std::make_unique<GzipOrZip>(path);
}

struct UnpackedText {
  std::string text;
  bool whole = true;
};

/// The member's text, or the lines of its first bytes. Memory grows with what is found, not with what an archive claims.
UnpackedText unpacked_text(Unpacking& from, const std::string& place, std::uint64_t most) {
  UnpackedText out;
  std::string piece(piece_bytes, '\0');
  while (true) {
    expect_memory(2.0 * static_cast<double>(out.text.size() + piece.size()), place + ": unpacking it");
    const std::size_t got = from.read(piece.data(), piece.size(), place);
    if (got == 0) return out;
    if (out.text.size() + got > std::min<std::uint64_t>(most, longest_stream)) break;
    out.text.append(piece, 0, got);
  }
  if (most > longest_stream)
    throw Error(fmt::format("{}: is longer than {} MiB; expected it unpacked, as a file on disk or in a folder", place, longest_stream >> 20));
  out.text.resize(out.text.rfind('\n') + 1);  // npos + 1 is 0
  out.whole = false;
  return out;
}

/// The file's name without the ending that says how it is compressed: log.csv of log.csv.gz.
std::string name_of(const PackedMember& member, const fs::path& path) { return member.name.empty() ? path.stem().string() : member.name; }

bool is_wanted(const Unpacking& from, const PackedMember& member) {
  return member.name.empty() || (from.is_file() && is_text_name(member.name) && !member.name.starts_with("__MACOSX/"));
}

/// A member's text as a table: from another pass, or `head` where it is enough.
TextTable open_packed(const fs::path& path, const std::string& name, const fs::path& place, const UnpackedText& head, std::uint64_t most) {
  if (head.whole || most <= described_bytes) return TextTable(head.whole ? place : fs::path(place.string() + " (its beginning)"), head.text);
  const std::unique_ptr<Unpacking> from = unpacking(path);
  while (const auto member = from->next())
    if (is_wanted(*from, *member) && name_of(*member, path) == name) return TextTable(place, unpacked_text(*from, place.string(), most).text);
  fail_packed(place.string(), "it is no longer there");
}

}  // namespace

bool is_packed(std::string_view head) {
  return std::any_of(packed_begins.begin(), packed_begins.end(),
                     [&](const PackedBegin& begin) { return head.size() > begin.place && head.substr(begin.place).starts_with(begin.bytes); });
}

std::vector<TextMember> texts_of_archive(const fs::path& path) {
  constexpr std::uint64_t usual_ratio = 5;  // of numbers as text, for an estimate of the rows
  std::vector<TextMember> members;
  const std::unique_ptr<Unpacking> from = unpacking(path);
  while (const auto packed = from->next()) {
    if (!is_wanted(*from, *packed)) continue;
    const std::string name = name_of(*packed, path);
    const fs::path place = path / fs::path(name).relative_path();
    if (from->is_encrypted()) throw Error(place.string() + ": is encrypted; expected an archive without a password");
    const auto head = std::make_shared<const UnpackedText>(unpacked_text(*from, place.string(), described_bytes));
    if (packed->name.empty() && !may_be_text(head->text))
      throw Error(
          fmt::format("{}: is compressed, and what is in it is no text; expected a text in it, or the file unpacked, since bags and other "
                      "logs are read where they stand on disk",
                      path.string()));
    std::error_code none;
    const std::uint64_t bytes = head->whole ? head->text.size() : packed->bytes.value_or(usual_ratio * fs::file_size(path, none));
    members.push_back({name, bytes, [path, name, place, head](std::uint64_t most) { return open_packed(path, name, place, *head, most); }});
    expect_few(members, path);
  }
  std::sort(members.begin(), members.end(), [](const TextMember& a, const TextMember& b) { return in_natural_order(a.name, b.name); });
  if (members.empty())
    throw Error(
        fmt::format("{}: is an archive without texts; expected {} files in it, or the archive unpacked: bags and other logs "
                    "are read as files",
                    path.string(), text_endings_listed()));
  return members;
}

}  // namespace imulab::recording_io
