// The fields of `navigate --aided --json`.
#include "imulab/formats/text/json_fields.hpp"
#include "imulab/model/calibration_fields.hpp"
#include "imulab/results/aided.hpp"
#include "imulab/results/conclusion.hpp"
#include "imulab/results/thinned.hpp"
#include "imulab/units.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

namespace imulab {

using json_io::Field, result_io::stamp_digits;

template <class Fields>
void describe(Fields& f, OutageErrors& e) {
  f("horizontal_error_m", e.horizontal), f("sigma_m", e.sigma), f("vertical_error_m", e.vertical), f("error_over_sigma", e.ratio);
}

template <class Fields>
void describe(Fields& f, AidedConstant& c) {
  f("value", c.value), f("standard_uncertainty", c.sigma), f("prior", c.prior);
  fields::derived(f, "determined", !c.undetermined());
}

template <class Fields>
void describe(Fields& f, AidedFactor& a) {
  f("variance_factor", a.factor), f("resolved", a.resolved), f("lasting", a.lasting, fields::optional);
}

template <class Fields>
void describe(Fields& f, AidedResiduals& r) {
  f("rms", r.rms), f("resolved", r.resolved);
}

template <class Fields>
void describe(Fields& f, AidedMotion& m) {
  f("kind", m.kind), f("innovations", m.innovations), f("rms", m.rms), f("gyro", m.gyro, fields::if_any), f("accel", m.accel, fields::if_any);
}

template <class Fields>
void describe(Fields& f, AidedAid& a) {
  f("name", a.name), f("kind", a.kind);
  if (!a.lever_arm.empty()) f("lever_arm_m", a.lever_arm), f("lever_arm_sigma_m", a.lever_arm_sigma);
  if (!a.mounting.empty()) f("mounting_deg", a.mounting, fields::in(unit::deg)), f("mounting_sigma_deg", a.mounting_sigma, fields::in(unit::deg));
  f("delay_s", a.delay, fields::if_any), f("delay_sigma_s", a.delay_sigma, fields::if_any),
      f("drift_ppm", a.drift, fields::How{fields::Presence::optional, fields::Null::none, true, 1e-6});
  f("sigma_factor", a.sigma_factor);
}

namespace {

constexpr std::size_t most_epochs = 400, most_innovations = 1000;
constexpr int picture_digits = 6;

JsonValue outage_json(const OutageResult& o, bool causal) {
  JsonValue shown = written(causal ? o.predicted : o.smoothed);
  JsonFields out{{{"begin_s", o.begin}, {"end_s", o.end}, {"fixes", o.fixes}}};
  for (auto& field : std::get<JsonFields>(shown.is).fields) out.fields.push_back(std::move(field));
  out.fields.emplace_back("predicted", written(o.predicted)), out.fields.emplace_back("smoothed", written(o.smoothed));
  return out;
}

OutageResult outage_of(const Field& at) {
  OutageResult o;
  JsonReader f(at);
  f("begin_s", o.begin), f("end_s", o.end), f("fixes", o.fixes), f("predicted", o.predicted), f("smoothed", o.smoothed);
  return o;
}

/// One sigma of position and attitude.
template <class Fields>
void describe_sigmas(Fields& f, std::vector<AidedCovariance>& epochs) {
  fields::column(f, "time_s", epochs, true, {.digits = stamp_digits}, [](AidedCovariance& c) -> double& { return c.time; });
  for (const auto& [key, first, size] : {std::tuple{"position_m", Eigen::Index{6}, 1.}, {"attitude_deg", Eigen::Index{0}, unit::deg}}) {
    std::array<std::vector<double>, 3> lists;
    for (std::size_t k = 0; k < 3 && !Fields::reads; ++k)
      for (const AidedCovariance& c : epochs) lists[k].push_back(std::sqrt(std::max(0., c.value.diagonal()[first + static_cast<Eigen::Index>(k)])));
    f(key, lists, {.size = size, .things = "lists of numbers", .digits = picture_digits});
    for (std::size_t k = 0; k < 3 && Fields::reads; ++k) {
      fields::check(f, lists[k].size() == epochs.size(), key, "expected lists of " + std::to_string(epochs.size()) + " numbers");
      for (std::size_t i = 0; i < epochs.size(); ++i) epochs[i].value.diagonal()[first + static_cast<Eigen::Index>(k)] = lists[k][i] * lists[k][i];
    }
  }
}

template <class Fields>
void describe_innovations(Fields& f, std::vector<AidedInnovation>& innovations) {
  fields::column(f, "time_s", innovations, true, {.digits = stamp_digits}, [](AidedInnovation& i) -> double& { return i.time; });
  fields::column(f, "sigmas", innovations, false, {.digits = picture_digits}, [](AidedInnovation& i) -> double& { return i.sigmas; });
}

template <class Fields>
void describe_outages(Fields& f, AidedNavigation& n) {
  if constexpr (Fields::reads) {
    n.outages = f.at()["outages"].list(outage_of);
  } else {
    std::vector<JsonValue> outages;
    for (const OutageResult& o : n.outages) outages.push_back(outage_json(o, n.causal));
    f("outages", JsonValue(std::move(outages)));
  }
}

}  // namespace

template <class Fields>
void describe(Fields& f, AidedSummary& s) {
  AidedNavigation& n = s.navigation;
  f("session", s.session);
  fields::via(
      f, "kind", [&] { return std::string(n.causal ? "filtered" : "smoothed"); },
      [&](const std::string& kind) {
        fields::expect(f, kind == "filtered" || kind == "smoothed", "kind", "filtered or smoothed");
        n.causal = kind == "filtered";
      });
  std::array<double, 2> time{};
  if constexpr (!Fields::reads) time = {n.solution.time.front(), n.solution.time.back()};
  f("begin_s", time[0]), f("end_s", time[1]);
  if constexpr (Fields::reads)
    n.solution.time = {time[0], time[1]}, n.aids = f.at()["aids"].list([](const Field& aid) { return aid["name"].text(); });
  f("largest_sigma_m", s.largest_sigma);
  describe_outages(f, n);
  if constexpr (!Fields::reads) f("aids", aided_aids(n));
  describe_by_name(f, "constants", n.constants), describe_by_name(f, "noise", n.factors);
  f("innovation_rms", n.innovation_rms), f("innovations_by_motion", s.motion, fields::optional), f("suspects", n.suspects), f("passes", n.passes),
      f("converged", n.converged);
  f("findings", n.findings, fields::if_any);
  result_io::describe_track(f, n.track);
  f.table("sigmas_over_time", [&](auto& inner) { describe_sigmas(inner, n.covariance); });
  f.table("innovations_over_time", [&](auto& inner) { describe_innovations(inner, n.innovations); });
}

std::string aided_json(const std::string& session, const AidedNavigation& n) {
  using result_io::thinned_rows;
  AidedSummary s{session, {}, largest_sigma(n), innovations_by_motion(n)};
  AidedNavigation& shown = s.navigation;
  shown.solution.time = {n.solution.time.front(), n.solution.time.back()}, shown.track = thinned_rows(n.track, result_io::most_places);
  shown.covariance = thinned_rows(n.covariance, most_epochs), shown.innovations = thinned_rows(n.innovations, most_innovations);
  shown.aids = n.aids, shown.constants = n.constants, shown.factors = n.factors, shown.outages = n.outages;
  shown.findings = n.findings, shown.innovation_rms = n.innovation_rms, shown.suspects = n.suspects, shown.passes = n.passes;
  shown.converged = n.converged, shown.causal = n.causal;
  JsonWriter writer;
  describe(writer, s);
  return result_text("aided", writer.out, JsonLayout::long_lists);
}

AidedSummary result_io::aided_of(const Field& root) {
  AidedSummary out;
  JsonReader reader(root);
  describe(reader, out);
  return out;
}

}  // namespace imulab
