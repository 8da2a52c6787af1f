#include "imulab/fleet/store/server.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace imulab::fleet {

namespace {

constexpr std::array<std::string_view, 2> schemes{"postgresql://", "postgres://"};
constexpr std::string_view hidden = "***";

/// Where the address has its user: behind the scheme; 0: it is none.
std::size_t user_at(std::string_view address) {
  const auto* const found = std::ranges::find_if(schemes, [&](std::string_view scheme) { return address.starts_with(scheme); });
  return found == schemes.end() ? 0 : found->size();
}

/// What stands between the first ":" and the last "@" is the password, with too much of the rest if it was not written as it should be.
std::string hide(std::string address) {
  const std::size_t user = user_at(address), at = address.rfind('@'), colon = address.find(':', user);
  if (at != std::string::npos && colon < at) address.replace(colon + 1, at - colon - 1, hidden);
  constexpr std::string_view key = "password=";  // and sslpassword
  for (std::size_t k = address.find(key, user); k != std::string::npos; k = address.find(key, k)) {
    k += key.size();
    address.replace(k, std::min(address.find('&', k), address.size()) - k, hidden);
  }
  return address;
}

}  // namespace

bool is_server(const std::filesystem::path& store) { return user_at(store.native()) > 0; }

std::string shown_store(const std::filesystem::path& store) { return is_server(store) ? hide(store.string()) : store.string(); }

std::string without_passwords(const std::string& text) {
  constexpr std::string_view ends(" \t\n\"'\0", 6);
  std::string out;
  for (std::size_t k = 0; k < text.size();) {
    if (user_at(std::string_view(text).substr(k)) == 0) {
      out += text[k++];
      continue;
    }
    const std::size_t end = std::min(text.find_first_of(ends, k), text.size());
    out += hide(text.substr(k, end - k));
    k = end;
  }
  return out;
}

}  // namespace imulab::fleet
