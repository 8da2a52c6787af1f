// Exceptions of the library. Their text says where (file, line, field, sample), what is wrong, what was expected, and often what to do.
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
// Findings in the data are no exceptions but part of a result: `Quality::findings`, `unobservable`. The library never prints and never
// exits. Besides these only exceptions of the standard library leave it, as std::bad_alloc.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace imulab {

/// The input is wrong: a file, a line, a field. The command ends with exit code 2.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The terms to estimate do not fit the method or the data: an Error to which the caller adds the option that named them.
class TermsError : public Error {
 public:
  using Error::Error;
};

/// The work needs more memory than it may take: an Error to which the caller adds the option that sets the limit.
class MemoryError : public Error {
 public:
  using Error::Error;
};

/// The input is well formed, but the data do not support the request. The command ends with exit code 1.
class Unsupported : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The work was asked to stop (stop.hpp): neither the input nor the data are wrong, so it is no runtime_error.
class Stopped : public std::exception {
 public:
  const char* what() const noexcept override { return "stopped, as requested"; }
};

/// Throws Error with the problems, if there are any: "PLACE: PROBLEM", or a line each, of the first 20.
inline void throw_problems(std::string_view place, const std::vector<std::string>& problems) {
  if (problems.empty()) return;
  constexpr std::size_t most = 20;
  std::string all(place);
  for (std::size_t k = 0; k < problems.size() && k < most; ++k) all += (all.empty() ? "" : problems.size() > 1 ? "\n  " : ": ") + problems[k];
  if (problems.size() > most) all += "\n  and " + std::to_string(problems.size() - most) + " more";
  throw Error(all);
}

/// Calls `check`, and adds the message of an Error that it throws to the problems.
template <class F>
void collect_problem(std::vector<std::string>& problems, const F& check) {
  try {
    check();
  } catch (const Error& e) {
    problems.emplace_back(e.what());
  }
}

/// Returns the result of `f`. The message of an Error that it throws gets "PLACE: " in front: algorithms name values, their callers know the file,
/// key or flag.
template <class F>
decltype(auto) errors_at(const std::string& place, const F& f) {
  try {
    return f();
  } catch (const Error& e) {
    throw Error(place + ": " + e.what());
  }
}

}  // namespace imulab
