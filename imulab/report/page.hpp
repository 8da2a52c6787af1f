// The skeleton of every page: one file with its style and scripts inside, which asks nobody for anything. A policy in its head admits its own scripts
// by their hashes and no others, so text can never run.
#pragma once

#include "imulab/coefficient.hpp"
#include "imulab/model/conclusion.hpp"

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace imulab::report {

enum class Tone { good, doubtful, neutral };

/// All are text.
struct PageVerdict {
  Tone tone = Tone::neutral;
  std::string word;                  ///< "good"
  std::string meaning;               ///< one sentence
  std::vector<std::string> because;  ///< why
  std::vector<std::string> actions;  ///< what to do
};

/// The verdict of the answer in place of the page's own: its word, its tone (green: met and good), its headline, and the requirements as reasons. A
/// conclusion that judged nothing changes nothing.
void take_conclusion(PageVerdict& verdict, const Conclusion& conclusion);

struct KeyFigure {
  std::string value, name;
};

struct Page {
  std::string kind;   ///< "Calibration"
  std::string title;  ///< of what: an IMU's name
  std::string subtitle;
  PageVerdict verdict;
  std::vector<KeyFigure> figures;
  std::string body;  ///< HTML: sections
};

std::string page_text(const Page& page);

/// The worst standard uncertainty of scales, misalignments and offsets of each triad, where one is known. `sigma` gives a coefficient's [SI]; not
/// finite where it is not known.
std::vector<KeyFigure> key_figures(const std::function<double(CoefficientIndex)>& sigma);

/// A paragraph that explains these figures; empty where there are none.
std::string worst_axis_note(const std::vector<KeyFigure>& figures);

}  // namespace imulab::report
