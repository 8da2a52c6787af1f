// Numbers as they stand in files: of any alignment and byte order.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string>
#include <type_traits>

namespace imulab::recording_io {

/// The number at `p`: least significant byte first, or last where `big_endian`.
template <class T>
T load(const char* p, bool big_endian = false) {
  std::array<char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), p, sizeof(T));
  if (big_endian != (std::endian::native == std::endian::big)) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

template <class T>
void store(char* p, std::type_identity_t<T> value, bool big_endian = false) {
  const T stored = load<T>(reinterpret_cast<const char*>(&value), big_endian);
  std::memcpy(p, &stored, sizeof stored);
}

/// At the end of a text, least significant byte first.
template <class T>
void append(std::string& out, std::type_identity_t<T> value) {
  char bytes[sizeof(T)];
  store<T>(bytes, value);
  out.append(bytes, sizeof bytes);
}

}  // namespace imulab::recording_io
