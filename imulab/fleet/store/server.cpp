#include "imulab/fleet/store/server.hpp"

#include "imulab/core/text.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace imulab::fleet {

namespace {

constexpr std::array<std::string_view, 2> schemes{"postgresql://", "postgres://"};
constexpr std::string_view hidden = "***";

/// Where the address has its user: behind the scheme, in capitals or not; 0: it is none.
std::size_t user_at(std::string_view address) {
  const std::string begin = lowered(address.substr(0, schemes[0].size()));
  const auto* const found = std::ranges::find_if(schemes, [&](std::string_view scheme) { return begin.starts_with(scheme); });
  return found == schemes.end() ? 0 : found->size();
}

/// True for a text of letters, digits and the characters of `also`: no part of it stands for another character.
bool is_plain(std::string_view text, std::string_view also) {
  return std::ranges::all_of(text, [&](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || also.find(c) != std::string_view::npos;
  });
}

/// "host:5432,[::1]/database": a text behind a colon is a port, not what stands there for want of an "@".
bool is_place(std::string_view text) {
  const std::string_view hosts = text.substr(0, text.find('/')), database = text.substr(std::min(hosts.size() + 1, text.size()));
  if (!is_plain(hosts, "-._,:[]") || !is_plain(database, "-._")) return false;
  bool in_brackets = false;
  for (std::size_t k = 0; k < hosts.size(); ++k) {
    if (hosts[k] == '[' || hosts[k] == ']') in_brackets = hosts[k] == '[';
    if (hosts[k] != ':' || in_brackets) continue;
    const std::string_view port = hosts.substr(k + 1, hosts.find(',', k) - k - 1);
    if (port.empty() || port.size() > 5 || port.find_first_not_of("0123456789") != std::string_view::npos) return false;
  }
  return true;
}

/// A parameter that is known to be no secret, as it is; a known secret by its key.
std::string shown_parameter(std::string_view parameter) {
  constexpr std::array<std::string_view, 10> open{
      "host", "hostaddr", "port", "user", "dbname", "sslmode", "connect_timeout", "channel_binding", "application_name", "target_session_attrs"};
  constexpr std::array<std::string_view, 2> secret{"password", "sslpassword"};
  const std::string_view key = parameter.substr(0, parameter.find('=')), value = parameter.substr(std::min(key.size() + 1, parameter.size()));
  if (std::ranges::find(open, key) != open.end() && is_plain(value, "-._,/")) return std::string(parameter);
  if (std::ranges::find(secret, key) != secret.end()) return std::string(key) + "=" + std::string(hidden);
  return std::string(hidden);
}

/// An address with the parts of it that are understood; all else may be a password, or a part of one, and is not repeated.
std::string hide(std::string_view address) {
  const std::size_t user = user_at(address);
  const std::string scheme(address.substr(0, user));
  const std::string_view rest = address.substr(user), head = rest.substr(0, rest.find('?'));
  const std::size_t at = head.rfind('@');
  const std::string_view named = at == std::string_view::npos ? std::string_view() : head.substr(0, at), name = named.substr(0, named.find(':'));
  const std::string_view place = head.substr(at == std::string_view::npos ? 0 : at + 1);
  const bool later = rest.find('@', head.size()) != std::string_view::npos;  // of a password with "?"
  if (!is_place(place) || later) return scheme + std::string(hidden);
  std::string out = scheme;
  if (at != std::string_view::npos)
    out += std::string(is_plain(name, "-._") ? name : hidden) + (name == named ? "@" : ":" + std::string(hidden) + "@");
  out += place;
  for (std::size_t k = head.size(); k < rest.size();) {
    const std::size_t end = std::min(rest.find('&', k + 1), rest.size());
    out += rest[k] + shown_parameter(rest.substr(k + 1, end - k - 1));
    k = end;
  }
  return out;
}

/// A file's name, up to what would be a password if it were something else that libpq reads.
std::string hide_in_name(const std::string& name) {
  const std::string lower = lowered(name);
  const std::size_t key = lower.find("password"), is = lower.find_first_not_of(" \t", std::min(key + 8, lower.size()));
  if (key != std::string::npos && is != std::string::npos && lower[is] == '=') return name.substr(0, is + 1) + std::string(hidden);
  const bool mistyped = lower.starts_with("postgres") && lower.find('@') != std::string::npos && lower.find(':') != std::string::npos;
  return mistyped ? name.substr(0, name.find_first_of(":/@")) + ":" + std::string(hidden) : name;
}

}  // namespace

bool is_server(const std::filesystem::path& store) { return user_at(store.native()) > 0; }

std::string shown_store(const std::filesystem::path& store) { return is_server(store) ? hide(store.native()) : hide_in_name(store.string()); }

std::string without_passwords(const std::string& text) {
  constexpr std::string_view ends(" \t\n\"'\0", 6), punctuation = ":;,.)";
  std::string out;
  for (std::size_t k = 0; k < text.size();) {
    if (user_at(std::string_view(text).substr(k)) == 0) {
      out += text[k++];
      continue;
    }
    std::size_t end = std::min(text.find_first_of(ends, k), text.size());
    end = text.find_last_not_of(punctuation, end - 1) + 1;
    const std::string_view address = std::string_view(text).substr(k, end - k);
    out += hide(address);
    const std::size_t at = text.rfind('@');
    if (out.ends_with("://***") && !address.ends_with(hidden) && at != std::string::npos && at > end)  // a password with a space or a quote in it
      end = std::min(text.find_first_of(ends, at), text.size());
    k = end;
  }
  return out;
}

}  // namespace imulab::fleet
