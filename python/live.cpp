// live: rows of arrays as they come.
#include "imulab/tasks/live.hpp"

#include "imulab/core/stamp_text.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/clock.hpp"
#include "imulab/recording/origin.hpp"
#include "imulab/recording/readings.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/session.hpp"

#include <fmt/core.h>

#include "python/module.hpp"
#include <mutex>
#include <optional>
#include <pybind11/stl.h>
#include <utility>

namespace imulab::python {
namespace {

/// A calibration by hand of rows as they come. Several threads may ask: one after the other.
class LiveObject {
 public:
  LiveObject(Session session, RecordingOptions options, std::vector<Requirement> required, double rest_s)
      : session_(std::move(session)), options_(std::move(options)), progress_(session_, options_, std::move(required), rest_s) {}

  /// The events of these rows: the command's lines of JSON.
  std::vector<std::string> add(Recording piece) {
    const std::lock_guard lock(mutex_);
    if (last_ns_ && piece.time_ns.front() <= *last_ns_)
      throw Error(fmt::format("{}: time: sample 0 is at {} s, the one before at {} s; expected stamps that increase", piece.name,
                              stamp_text(piece.time_ns.front()), stamp_text(*last_ns_)));
    last_ns_ = piece.time_ns.back();
    std::vector<std::string> events;
    for (std::optional<Range> left = Range{0, piece.size()}; left;)
      if ((left = progress_.add(piece, *left))) events.push_back(live_json(progress_.view()));
    return events;
  }

  /// The calibration of all rows so far.
  CalibrationObject calibration() {
    const std::lock_guard lock(mutex_);
    if (progress_.view().samples < 2) throw Unsupported("fewer than two rows arrived; expected a stream of them");
    progress_.estimate();
    if (!progress_.result()) throw Unsupported(shortcomings(progress_));
    auto result = std::make_shared<CalibrationResult>(*progress_.result());
    const auto data = std::make_shared<SessionRecordings>(SessionRecordings{session_, {progress_.recording()}, {}});
    add_declared_origin(result->calibration, session_, data->recordings);
    result->calibration.options = {{"live", "true"}};
    return {std::move(result), data};
  }

  LiveView view() {
    const std::lock_guard lock(mutex_);
    return progress_.view();
  }
  std::string missing() {
    const std::lock_guard lock(mutex_);
    return shortcomings(progress_);
  }
  const RecordingOptions& options() const { return options_; }

 private:
  std::mutex mutex_;
  Session session_;
  RecordingOptions options_;
  LiveProgress progress_;
  std::optional<std::int64_t> last_ns_;
};

/// Reports wrong declarations before any row comes.
std::unique_ptr<LiveObject> begin(const Session& session, const std::optional<std::string>& require, double rest_s, std::optional<double> interval_s,
                                  const py::dict& gyro_options, const py::dict& accel_options) {
  RecordingOptions options{
      .name = "rows", .interval_s = interval_s, .gyro = reading_options(gyro_options, "gyro"), .accel = reading_options(accel_options, "accel")};
  if ((options.gyro.increment || options.accel.increment) && !interval_s)
    throw Error("increments need interval_s; expected it, since the median interval is known only at the end");
  const std::vector<double> zeros(2);
  const double step_s = interval_s.value_or(1);
  Recording none = make_recording(std::vector{0.0, step_s}, {zeros, zeros, zeros}, {zeros, zeros, zeros}, options);
  const std::string accel_unit = none.accel_unit;
  Session declared = given_recordings(session, {std::move(none)}).session;
  std::vector<Requirement> required = errors_at("require", [&] { return live_requirements(require, accel_unit, declared.site); });
  return std::make_unique<LiveObject>(std::move(declared), std::move(options), std::move(required), rest_s);
}

std::vector<std::string> add(LiveObject& live, const py::array& t, const Array& gyro, const Array& accel) {
  std::vector<std::int64_t> time_ns = exact_stamps(t, "rows");
  Columns3 rates = columns_of("gyro", gyro), forces = columns_of("accel", accel);
  const py::gil_scoped_release unlocked;
  if (time_ns.empty()) return {};
  Recording piece = convert_readings(std::move(rates), std::move(forces), live.options());
  piece.time_ns = std::move(time_ns);
  piece.interval_s = piece.size() > 1 ? stamp_intervals(piece.time_ns).median : 1;  // the nominal one is that of all rows
  validate(piece);
  return live.add(std::move(piece));
}

}  // namespace

void bind_live(py::module_& module) {
  py::class_<LiveObject>(module, "Live")
      .def(py::init(&begin))
      .def("add", &add)
      .def("calibration",
           [](LiveObject& live) {
             const py::gil_scoped_release unlocked;
             return std::make_shared<CalibrationObject>(live.calibration());
           })
      .def_property_readonly("picture", [](LiveObject& live) { return live_picture(live.view(), false); })
      .def_property_readonly("missing", &LiveObject::missing)
      .def_property_readonly("done", [](LiveObject& live) { return live.view().done; })
      .def_property_readonly("samples", [](LiveObject& live) { return live.view().samples; })
      .def_property_readonly("resting_s", [](LiveObject& live) { return live.view().resting_s; });
}

}  // namespace imulab::python
