// Exceptions of the library. Each message states the place (file, line, field, sample), the fault, what was expected, and often the remedy.
//
// Example:
//   try {
//     parse_requirements("gyro.offset <= 5");
//   } catch (const Error& e) {        // the input is wrong
//     std::puts(e.what());
//   } catch (const Unsupported& e) {  // well formed, but the data do not support the request
//     std::puts(e.what());
//   }
//
// Findings in the data are not exceptions but part of a result: `Quality::findings`, `unobservable`. The library never prints or exits. Apart from
// these exceptions it throws only those of the standard library, such as std::bad_alloc.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace imulab {

/// The input is wrong: a file, line or field. The command then ends with exit code 2.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The requested terms do not fit the method or the data. The caller adds the option that named them.
class TermsError : public Error {
 public:
  using Error::Error;
};

/// The work needs more memory than allowed. The caller adds the option that sets the limit.
class MemoryError : public Error {
 public:
  using Error::Error;
};

/// The input is well formed, but the data do not support the request. The command then ends with exit code 1.
class Unsupported : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The work was stopped on request (stop.hpp). Neither input nor data are wrong, so this is not a runtime_error.
class Stopped : public std::exception {
 public:
  const char* what() const noexcept override { return "stopped, as requested"; }
};

/// Throws Error with the first 20 `problems`, if there are any: "PLACE: PROBLEM" for one, a line each for several.
inline void throw_problems(std::string_view place, const std::vector<std::string>& problems) {
  if (problems.empty()) return;
  constexpr std::size_t most = 20;
  std::string all(place);
  for (std::size_t k = 0; k < problems.size() && k < most; ++k) all += (all.empty() ? "" : problems.size() > 1 ? "\n  " : ": ") + problems[k];
  if (problems.size() > most) all += "\n  and " + std::to_string(problems.size() - most) + " more";
  throw Error(all);
}

/// Calls `check` and appends the message of an Error that it throws to `problems`.
template <class F>
void collect_problem(std::vector<std::string>& problems, const F& check) {
  try {
    check();
  } catch (const Error& e) {
    problems.emplace_back(e.what());
  }
}

/// Returns the result of `f`. An Error that `f` throws gets the prefix "PLACE: ": algorithms name values, their callers the file, key or flag.
template <class F>
decltype(auto) errors_at(const std::string& place, const F& f) {
  try {
    return f();
  } catch (const Error& e) {
    throw Error(place + ": " + e.what());
  }
}

}  // namespace imulab
