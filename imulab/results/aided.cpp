#include "imulab/results/aided.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab {

namespace {

const AidedConstant* find_constant(const AidedNavigation& n, const std::string& name) {
  const auto at = std::ranges::find(n.constants, name, &AidedConstant::name);
  return at == n.constants.end() ? nullptr : &*at;
}

}  // namespace

std::vector<AidedAid> aided_aids(const AidedNavigation& n) {
  std::vector<AidedAid> out;
  for (const std::string& name : n.aids) {
    AidedAid aid{.name = name, .kind = name.substr(0, name.find_last_not_of("0123456789") + 1)};
    const auto take = [&](const std::string& group, std::initializer_list<const char*> elements, std::vector<double>& value,
                          std::vector<double>& sigma) {
      for (const char* element : elements)
        if (const AidedConstant* c = find_constant(n, fmt::format("{}.{}.{}", name, group, element)))
          value.push_back(c->value), sigma.push_back(c->sigma);
    };
    take("lever_arm", {"right", "forward", "up"}, aid.lever_arm, aid.lever_arm_sigma);
    take("mounting", {"pitch", "yaw"}, aid.mounting, aid.mounting_sigma);
    if (const AidedConstant* c = find_constant(n, name + ".delay")) aid.delay = c->value, aid.delay_sigma = c->sigma;
    if (const AidedConstant* c = find_constant(n, name + ".delay.drift")) aid.drift = c->value;
    const auto factor = std::ranges::find_if(n.factors, [&](const AidedFactor& f) { return f.name == name || f.name.starts_with(name + "."); });
    if (factor != n.factors.end()) aid.sigma_factor = std::sqrt(factor->factor);
    out.push_back(std::move(aid));
  }
  return out;
}

OutageSummary outage_summary(const std::vector<OutageResult>& outages, OutageErrors OutageResult::*part) {
  OutageSummary out;
  std::vector<double> largest;
  for (const OutageResult& o : outages) {
    const OutageErrors& e = o.*part;
    largest.push_back(e.horizontal);
    out.ratio += e.ratio * e.ratio / static_cast<double>(outages.size());
    out.worst = std::max(out.worst, e.horizontal);
  }
  out.ratio = std::sqrt(out.ratio);
  out.median = outages.empty() ? 0 : median(std::move(largest));
  return out;
}

double largest_sigma(const AidedNavigation& n) {
  double most = 0;
  for (const AidedCovariance& c : n.covariance) most = std::max(most, std::sqrt(c.value(6, 6) + c.value(7, 7)));
  return most;
}

std::string aided_headline(const AidedNavigation& n) {
  std::string text = fmt::format("{:.4g} km in {:.4g} s, {}; position known to {:.2g} m or better (one sigma, horizontal)", n.distance / 1000,
                                 n.solution.time.back() - n.solution.time.front(), n.causal ? "filtered" : "smoothed", largest_sigma(n));
  if (n.outages.empty()) return text;
  const OutageSummary s = outage_summary(n.outages, n.causal ? &OutageResult::predicted : &OutageResult::smoothed);
  return text + fmt::format("; in {} off by at most {:.2g} m{}; errors over their sigmas {:.2g} RMS", text::plural(n.outages.size(), "withheld time"),
                            s.median, n.outages.size() > 1 ? " (median)" : "", s.ratio);
}

namespace {

std::string constant_row(const AidedConstant& c) {
  const UserUnit& unit = quantity_of_constant(c.name).unit;
  return fmt::format("  {:<26} {:>11.4g} {:>9.2g} {:<8}\n", c.name, c.value / unit.size, c.sigma / unit.size, unit.name);
}

std::string not_shown(const AidedNavigation& n) {
  std::vector<std::string> undetermined;
  for (const AidedConstant& c : n.constants)
    if (c.undetermined()) undetermined.push_back(c.name);
  std::string text;
  for (const auto& [manoeuvre, names] : by_manoeuvre(undetermined))
    text += text::wrapped("  ", fmt::format("{}", fmt::join(names, ", "))) +
            text::wrapped("    ", fmt::format("would show: {}", manoeuvre.empty() ? "no motion" : manoeuvre));
  return text.empty() ? "" : "\nnot determined by this motion\n" + text;
}

}  // namespace

std::string aided_table(const std::string& session, const AidedNavigation& n) {
  std::string text =
      fmt::format("{}: {} from {:.3f} s to {:.3f} s, {} passes, {} tried at the start\n", one_line(session), n.causal ? "filtered" : "smoothed",
                  n.solution.time.front(), n.solution.time.back(), n.passes, text::plural(static_cast<std::size_t>(n.headings), "heading"));
  text += fmt::format("innovations {:.2f} times their stated size; {:.1f} % of the rows are suspects\n", n.innovation_rms, 100 * n.suspects);
  if (!n.outages.empty()) {
    text +=
        fmt::format("\n{:>21} {:>12} {:>6} {:>6} {:>13} {:>6} {:>6}\n", "withheld, s", "predicted, m", "sigma", "RMS", "smoothed, m", "sigma", "RMS");
    for (const OutageResult& o : n.outages)
      text += fmt::format("  {:>8.2f} to {:>7.2f} {:>12.3g} {:>6.2g} {:>6.2f} {:>13.3g} {:>6.2g} {:>6.2f}\n", o.begin, o.end, o.predicted.horizontal,
                          o.predicted.sigma, o.predicted.ratio, o.smoothed.horizontal, o.smoothed.sigma, o.smoothed.ratio);
    const OutageSummary p = outage_summary(n.outages, &OutageResult::predicted), s = outage_summary(n.outages, &OutageResult::smoothed);
    text += fmt::format("  {:>19} {:>12.3g} {:>6} {:>6.2f} {:>13.3g} {:>6} {:>6.2f}\n", "median, RMS", p.median, "", p.ratio, s.median, "", s.ratio);
    text += "  largest error, its sigma; RMS of all errors over their sigmas\n";
  }
  text += fmt::format("\n  {:<26} {:>11} {:>9}\n", "determined", "value", "u");
  for (const AidedConstant& c : n.constants)
    if (!c.undetermined()) text += constant_row(c);
  text += fmt::format("\n  {:<26} {:>11}\n", "noise", "sigma / stated");
  for (const AidedFactor& f : n.factors)
    text += fmt::format("  {:<26} {:>11.3g}{}\n", f.name, std::sqrt(f.factor),
                        f.lasting > 1 ? fmt::format(", lasting: {:.2g} times that", f.lasting) : "");
  return text + not_shown(n);
}

}  // namespace imulab
