#include "imulab/formats/recording/bag/chunk.hpp"

#include "imulab/core/memory.hpp"
#include "imulab/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <memory>
#ifdef IMULAB_WITH_BZIP2
#include <bzlib.h>
#endif
#ifdef IMULAB_WITH_LZ4
#include <lz4frame.h>
#endif
#ifdef IMULAB_WITH_ZSTD
#include <zstd.h>
#endif

namespace imulab::bag {
namespace {

constexpr std::uint64_t largest_chunk = std::uint64_t{1} << 30;

/// Unpacks piece by piece: `step(in, out)` takes bytes off the front of `in`, gives the number it wrote to `out`, and says at the end that it is
/// done.
struct Piece {
  std::size_t written = 0;
  bool done = false;
};

template <class Step>
[[maybe_unused]] std::string_view unpack_pieces(std::string_view packed, std::uint64_t size, Buffer& buffer, const std::string& file, Step step) {
  if (size > largest_chunk) throw Damaged("a chunk of more than a gigabyte");
  const auto whole = static_cast<std::size_t>(size);
  std::size_t written = 0, room = std::min(whole, std::max({buffer.size(), 8 * packed.size(), std::size_t{1} << 16}));
  constexpr double copied = 1.5;  // while the buffer grows, what it holds is there twice
  while (true) {
    if (room > buffer.size()) expect_memory(copied * static_cast<double>(room), fmt::format("{}: unpacking a chunk of {} MB", file, whole >> 20));
    char* out = buffer.of(std::max<std::size_t>(room, 1), written);
    const std::size_t before = packed.size();
    const Piece piece = step(packed, out + written, room - written);
    written += piece.written;
    if (piece.done) break;
    if (written == room && room < whole) {
      room = std::min(whole, 2 * room);
      continue;
    }
    if (piece.written == 0 && packed.size() == before)
      throw Damaged(written == whole ? "a chunk longer than it says" : "a chunk that ends too early");
  }
  if (written != whole) throw Damaged("a chunk shorter than it says");
  return {buffer.data(), whole};
}

#ifdef IMULAB_WITH_LZ4
std::string_view unpack_lz4(std::string_view packed, std::uint64_t size, Buffer& buffer, const std::string& file) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) throw Error("LZ4 has no memory");
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> owner(context, LZ4F_freeDecompressionContext);
  return unpack_pieces(packed, size, buffer, file, [context](std::string_view& in, char* out, std::size_t room) {
    std::size_t taken = in.size(), written = room;
    const std::size_t left = LZ4F_decompress(context, out, &written, in.data(), &taken, nullptr);
    if (LZ4F_isError(left)) throw Damaged(std::string("LZ4: ") + LZ4F_getErrorName(left));
    in.remove_prefix(taken);
    return Piece{written, left == 0};
  });
}

std::string pack_lz4(std::string_view bytes) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.blockMode = LZ4F_blockIndependent;
  preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
  preferences.frameInfo.blockSizeID = LZ4F_max1MB;
  std::string packed(LZ4F_compressFrameBound(bytes.size(), &preferences), '\0');
  const std::size_t size = LZ4F_compressFrame(packed.data(), packed.size(), bytes.data(), bytes.size(), &preferences);
  if (LZ4F_isError(size)) throw Error(std::string("LZ4: ") + LZ4F_getErrorName(size));
  packed.resize(size);
  return packed;
}
#endif

#ifdef IMULAB_WITH_ZSTD
std::string_view unpack_zstd(std::string_view packed, std::uint64_t size, Buffer& buffer, const std::string& file) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), ZSTD_freeDCtx);
  return unpack_pieces(packed, size, buffer, file, [&](std::string_view& in, char* out, std::size_t room) {
    ZSTD_inBuffer from{in.data(), in.size(), 0};
    ZSTD_outBuffer to{out, room, 0};
    const std::size_t left = ZSTD_decompressStream(context.get(), &to, &from);
    if (ZSTD_isError(left)) throw Damaged(std::string("Zstandard: ") + ZSTD_getErrorName(left));
    in.remove_prefix(from.pos);
    return Piece{to.pos, left == 0};
  });
}

std::string pack_zstd(std::string_view bytes) {
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size = ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), ZSTD_CLEVEL_DEFAULT);
  if (ZSTD_isError(size)) throw Error(std::string("Zstandard: ") + ZSTD_getErrorName(size));
  packed.resize(size);
  return packed;
}
#endif

#ifdef IMULAB_WITH_BZIP2
std::string_view unpack_bzip2(std::string_view packed, std::uint64_t size, Buffer& buffer, const std::string& file) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) throw Error("bzip2 has no memory");
  const std::unique_ptr<bz_stream, decltype(&BZ2_bzDecompressEnd)> owner(&stream, BZ2_bzDecompressEnd);
  return unpack_pieces(packed, size, buffer, file, [&stream](std::string_view& in, char* out, std::size_t room) {
    stream.next_in = const_cast<char*>(in.data());
    stream.avail_in = static_cast<unsigned>(in.size());
    stream.next_out = out;
    stream.avail_out = static_cast<unsigned>(room);
    const int result = BZ2_bzDecompress(&stream);
    if (result != BZ_OK && result != BZ_STREAM_END) throw Damaged("bzip2: its data are damaged");
    in.remove_prefix(in.size() - stream.avail_in);
    return Piece{room - stream.avail_out, result == BZ_STREAM_END};
  });
}

std::string pack_bzip2(std::string_view bytes) {
  std::string packed(bytes.size() + bytes.size() / 100 + 600, '\0');  // as much as bzip2 can need
  auto size = static_cast<unsigned>(packed.size());
  if (BZ2_bzBuffToBuffCompress(packed.data(), &size, const_cast<char*>(bytes.data()), static_cast<unsigned>(bytes.size()), 9, 0, 30) != BZ_OK)
    throw Error("bzip2 cannot compress a chunk");
  packed.resize(size);
  return packed;
}
#endif

struct Codec {
  std::string_view name, words, package;
  std::string_view (*unpack)(std::string_view packed, std::uint64_t size, Buffer& buffer, const std::string& file) = nullptr;
  std::string (*pack)(std::string_view bytes) = nullptr;  ///< null, as unpack, in a build without its library
};

/// In the order of Compression, after none.
constexpr std::array<Codec, 3> codecs{{
    {"lz4", "LZ4", "liblz4"
#ifdef IMULAB_WITH_LZ4
     ,
     unpack_lz4, pack_lz4
#endif
    },
    {"zstd", "Zstandard", "libzstd"
#ifdef IMULAB_WITH_ZSTD
     ,
     unpack_zstd, pack_zstd
#endif
    },
    {"bz2", "bzip2", "libbz2"
#ifdef IMULAB_WITH_BZIP2
     ,
     unpack_bzip2, pack_bzip2
#endif
    },
}};

const Codec& codec_of(Compression compression) { return codecs[static_cast<std::size_t>(compression) - 1]; }

}  // namespace

Compression compression_of(std::string_view name) {
  if (name.empty() || name == "none") return Compression::none;
  const auto codec = std::ranges::find(codecs, name, &Codec::name);
  if (codec == codecs.end()) throw Damaged("unknown compression \"" + std::string(name.substr(0, 20)) + "\"");
  if (codec->unpack == nullptr)
    throw Error(
        fmt::format("chunks are compressed with {}, which this imulab was built without; expected a build with {}, or a bag that is not compressed",
                    codec->words, codec->package));
  return static_cast<Compression>(codec - codecs.begin() + 1);
}

std::string_view unpack(Compression compression, std::string_view packed, std::uint64_t size, Buffer& buffer, const std::string& file) {
  if (compression != Compression::none) return codec_of(compression).unpack(packed, size, buffer, file);
  if (packed.size() != size) throw Damaged("a chunk that is not as long as it says");
  return packed;
}

std::string_view compression_of_new_bags() {
  const Codec& zstd = codec_of(Compression::zstd);
  return zstd.pack != nullptr ? zstd.name : "";
}

std::string pack(Compression compression, std::string_view bytes) {
  return compression != Compression::none ? codec_of(compression).pack(bytes) : std::string(bytes);
}

std::string Damage::place(std::uint64_t at) const { return fmt::format("{}: chunk at byte {}", file_, at); }

std::vector<std::string> Damage::warnings() const {
  std::vector<std::string> warnings;
  if (!index_.empty()) warnings.push_back(fmt::format("{}: {}: read from its beginning", file_, index_));
  if (!chunks_.empty())
    warnings.push_back(fmt::format("{}: {}: {}: the messages in it are missing", place(chunks_.begin()->first), chunks_.begin()->second,
                                   chunks_.size() == 1 ? "left out" : fmt::format("left out with {} more", chunks_.size() - 1)));
  if (!ends_.empty())
    warnings.push_back(
        fmt::format("{}: damaged from byte {} on: {}: only what stands before was read", file_, ends_.begin()->first, ends_.begin()->second));
  return warnings;
}

Compression Damage::compression(std::string_view name, std::uint64_t at) const {
  try {
    return compression_of(name);
  } catch (const Damaged& e) {
    throw Error(fmt::format("{}: {}; expected none, lz4, zstd or bz2", place(at), e.what()));
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", file_, e.what()));
  }
}

}  // namespace imulab::bag
