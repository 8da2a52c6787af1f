#include "imulab/io/budget_text.hpp"

#include "imulab/core/units.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <string_view>

namespace imulab {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::string_view, budget_quantities + 1> names{"pe", "pn", "pu", "ve", "vn", "vu", "ae", "an", "au", "ph"};

double unit_of(Eigen::Index quantity) { return quantity >= 6 && quantity < budget_quantities ? unit::arcsec : 1; }

std::string header(std::string start, Eigen::Index quantities, std::initializer_list<std::string_view> columns) {
  for (Eigen::Index q = 0; q < quantities; ++q)
    for (const std::string_view column : columns) start += fmt::format(",{}_{}", names[static_cast<std::size_t>(q)], column);
  return start + "\n";
}

void add_row(std::string& text, const BudgetRows& fixed, const BudgetRows& sigma, Eigen::Index at) {
  for (Eigen::Index q = 0; q < budget_quantities; ++q) text += fmt::format(",{:.8g},{:.8g}", fixed(q, at) / unit_of(q), sigma(q, at) / unit_of(q));
  text += '\n';
}

BudgetRows total_sigma(const ErrorBudget& b) {
  BudgetRows sigma(budget_quantities, static_cast<Eigen::Index>(b.time.size()));
  for (std::size_t i = 0; i < b.time.size(); ++i) sigma.col(static_cast<Eigen::Index>(i)) = b.covariance[i].diagonal().cwiseMax(0.0).cwiseSqrt();
  return sigma;
}

Json vector_of(const BudgetRows& rows, Eigen::Index first, Eigen::Index at) {
  Json list = Json::array();
  for (Eigen::Index q = first; q < first + 3; ++q) list.push_back(rows(q, at) / unit_of(q));
  return list;
}

Json contribution(const BudgetRows& fixed, const BudgetRows& sigma, Eigen::Index at) {
  const auto part = [&](Eigen::Index first) { return Json{{"fixed", vector_of(fixed, first, at)}, {"sigma", vector_of(sigma, first, at)}}; };
  return {{"position_m", part(0)}, {"velocity_mps", part(3)}, {"attitude_arcsec", part(6)}};
}

}  // namespace

std::string total_csv(const ErrorBudget& b) {
  const BudgetRows sigma = total_sigma(b);
  std::string text = header("t", budget_quantities, {"fixed", "sigma"});
  for (std::size_t i = 0; i < b.time.size(); ++i) {
    text += fmt::format("{:.10g}", b.time[i]);
    add_row(text, b.mean, sigma, static_cast<Eigen::Index>(i));
  }
  return text;
}

std::string sources_csv(const ErrorBudget& b) {
  std::string text = header("source,t", budget_quantities, {"fixed", "sigma", "share"});
  for (std::size_t i = 0; i < b.time.size(); ++i) {
    std::array<std::vector<double>, budget_quantities> shares;
    for (int q = 0; q < budget_quantities; ++q) shares[static_cast<std::size_t>(q)] = b.shares(q, i);
    for (std::size_t k = 0; k <= b.groups.size(); ++k) {  // the last: the correlation
      const bool group = k < b.groups.size();
      text += fmt::format("{},{:.10g}", group ? b.groups[k].name : "correlation between groups", b.time[i]);
      for (Eigen::Index q = 0; q < budget_quantities; ++q) {
        const auto at = static_cast<Eigen::Index>(i);
        const double unit = unit_of(q), fixed = group ? b.groups[k].fixed(q, at) / unit : 0, sigma = group ? b.groups[k].sigma(q, at) / unit : 0;
        text += fmt::format(",{:.8g},{:.8g},{:.6g}", fixed, sigma, shares[static_cast<std::size_t>(q)][k]);
      }
      text += '\n';
    }
  }
  return text;
}

std::string runs_csv(const ErrorDistribution& d) {
  std::string text = header("run", budget_quantities, {"end", "peak"});
  for (Eigen::Index k = 0; k < d.end.cols(); ++k) {
    text += fmt::format("{}", k);
    add_row(text, d.end, d.peak, k);
  }
  return text;
}

std::string distribution_csv(const ErrorDistribution& d) {
  std::string text = header("t", budget_quantities + 1, {"low", "median", "high"});
  for (std::size_t i = 0; i < d.time.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    text += fmt::format("{:.10g}", d.time[i]);
    for (Eigen::Index q = 0; q <= budget_quantities; ++q)
      text += fmt::format(",{:.8g},{:.8g},{:.8g}", d.low(q, at) / unit_of(q), d.median(q, at) / unit_of(q), d.high(q, at) / unit_of(q));
    text += '\n';
  }
  return text;
}

std::string budget_json(const ErrorBudget& b, const std::optional<ErrorDistribution>& monte_carlo) {
  const auto end = static_cast<Eigen::Index>(b.time.size()) - 1;
  Json out{{"time_s", b.time.back()}, {"vertical", to_string(b.vertical)}, {"total", contribution(b.mean, total_sigma(b), end)}};
  for (const auto* list : {&b.groups, &b.coefficients})
    for (const Contribution& c : *list) out[list == &b.groups ? "sources" : "coefficients"][c.name] = contribution(c.fixed, c.sigma, end);
  for (int q = 0; q < budget_quantities; ++q) {
    const std::vector<double> shares = b.shares(q, b.time.size() - 1);
    for (std::size_t k = 0; k < shares.size(); ++k)
      out["shares"][k < b.groups.size() ? b.groups[k].name : "correlation between groups"][std::string(names[static_cast<std::size_t>(q)])] = shares[k];
  }
  if (monte_carlo) {
    const ErrorDistribution& d = *monte_carlo;
    const double nmi_per_h = unit::nmi / unit::hour;
    Json& m = out["monte_carlo"];
    m["runs"] = d.drift.size();
    for (Eigen::Index q = 0; q <= budget_quantities; ++q)
      m[std::string(names[static_cast<std::size_t>(q)])] = {{"mean", d.mean(q, end) / unit_of(q)},     {"sigma", d.sigma(q, end) / unit_of(q)},
                                                            {"low", d.low(q, end) / unit_of(q)},       {"median", d.median(q, end) / unit_of(q)},
                                                            {"high", d.high(q, end) / unit_of(q)}};
    m["rate_nmi_per_h"] = {{"rms", d.drift_rms / nmi_per_h}, {"cep", d.drift_cep / nmi_per_h}, {"95_percent", d.drift_95 / nmi_per_h}};
  }
  return out.dump(2) + "\n";
}

}  // namespace imulab
