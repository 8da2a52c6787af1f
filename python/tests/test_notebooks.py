"""Results in notebooks: arrays, tables, figures; sessions and recordings in other processes."""

import multiprocessing
import pickle
import warnings

import numpy as np
import pytest

import imulab

MISSION = """format = "imulab.mission/1"
rate_hz = 50.0

[start]
latitude_deg = 31.0
longitude_deg = 104.0
height_m = 500.0
heading_deg = 90.0
speed_mps = 60.0

[[segment]]
kind = "straight"
duration_s = 20.0
"""
HOSTILE = "<script>alert(1)</script>"


@pytest.fixture(scope="module")
def results(calibration, by_hand, hand_session, tmp_path_factory):
    """One of each kind."""
    folder = tmp_path_factory.mktemp("notebook")
    (folder / "mission.toml").write_text(MISSION)
    random = np.random.default_rng(1)
    n = 6000
    still = imulab.Recording.from_arrays(np.arange(1, n + 1) / 100, 1e-3 * random.standard_normal((n, 3)), [0, 0, 9.8] + 1e-2 * random.standard_normal((n, 3)))
    flight = imulab.trajectory(folder / "mission.toml")
    by_hand.session.save(folder / "p.toml")
    fleet = imulab.Fleet(folder / "fleet.db")
    for serial in range(4):
        text = imulab.procedure("handheld", poses=15, seed=3).text.replace("[imu]", f'[imu]\nserial = "0{serial}"', 1)
        (folder / "p.toml").write_text(text)
        imulab.simulate(imulab.read_session(folder / "p.toml"), seed=serial + 1, output=folder / f"unit{serial}")
        fleet.calibrate(folder / f"unit{serial}", method="handheld")
    return {
        "calibration": calibration,
        "comparison": imulab.compare(calibration, by_hand.truth),
        "comparison of three": imulab.compare(calibration, by_hand.truth, by_hand.truth),
        "prediction": imulab.predict(imulab.procedure("handheld", poses=12), method="handheld", require="gyro.offset <= 1 deg/h"),
        "plan": imulab.plan("gyro.offset <= 0.1 deg/h", within=120),
        "noise": imulab.noise(still),
        "navigation": imulab.navigate(None, flight),
        "budget": imulab.budget(folder / "mission.toml", grade="navigation", runs=5),
        "grades": imulab.budget(folder / "mission.toml", grade="navigation,tactical,mems", runs=0),
        "inspection": imulab.inspect(hand_session / "recording.csv", declare={"latitude_deg": "45"}),
        "fleet": fleet.statistics(),
        "recording": still,
        "units": fleet,
    }


KINDS = ["calibration", "comparison", "comparison of three", "prediction", "plan", "noise", "navigation", "budget", "grades", "inspection",
         "fleet"]


@pytest.mark.parametrize("kind", [*KINDS, "units"])
def test_tables(results, kind):
    page = results[kind]._repr_html_()
    assert page.count("<table>") >= 1 and page.count("<table>") == page.count("</table>") and page.count("<tr>") > 3
    assert "nan" not in page.lower()


@pytest.mark.parametrize("kind", [*KINDS, "recording"])
def test_figures(results, kind):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        figure = results[kind].plot()
        if kind in ("noise", "budget", "grades"):  # what only drawing shows: scales that have no place for their data
            figure.canvas.draw()
    shown = [axes for axes in figure.axes if axes.get_visible()]
    assert shown and all(axes.get_xlabel() or axes.get_ylabel() for axes in shown)
    assert all(axes.lines or axes.patches or axes.collections for axes in shown)
    matplotlib.pyplot.close(figure)


def test_noise_figure_names_terms_and_bounds(results):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    figure = results["noise"].plot()
    labels = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert any(label.startswith("N = ") for label in labels) and any(label.startswith("K < ") for label in labels) and "fit" in labels
    matplotlib.pyplot.close(figure)


def test_names_do_not_become_markup(calibration, by_hand):
    session = imulab.Session(imu={"name": HOSTILE}, site=imulab.Site(latitude_deg=45, height_m=0))
    hostile = pickle.loads(pickle.dumps(calibration))
    hostile.name = HOSTILE
    for shown in (session, imulab.compare(hostile, by_hand.truth)):
        page = shown._repr_html_()
        assert "<script" not in page and "&lt;script" in page
    made = imulab.simulate(imulab.Session(**{k: v for k, v in imulab.procedure("handheld", poses=12).tables.items() if k not in ("format", "imu")},
                                          imu={"name": HOSTILE, "grade": "mems"}))
    page = imulab.calibrate(made, method="handheld")._repr_html_()
    assert "<script" not in page and "&lt;script" in page


def test_figures_count_from_the_first_sample():
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    stamps = 1_774_958_400_000_000_000 + 10_000_000 * np.arange(100)  # 2026
    figure = imulab.Recording.from_arrays(stamps, np.zeros((100, 3)), np.zeros((100, 3)), time_unit="ns").plot()
    assert figure.axes[0].lines[0].get_xdata()[0] == 0 and figure.axes[1].get_xlabel() == "time from 2026-03-31 12:00:00 UTC, s"
    matplotlib.pyplot.close(figure)


def test_coefficients_as_arrays(calibration):
    for triad, own in (("gyro", calibration.gyro), ("accel", calibration.accel)):
        assert own.offset.shape == own.quadratic.shape == own.cubic.shape == (3,)
        assert own.matrix.shape == (3, 3) and own.thermal.shape == (3, 3)
        assert own.matrix_thermal1.shape == own.matrix_thermal2.shape == (3, 3)
        assert own.matrix[0, 1] == calibration[f"{triad}.matrix.xy"] == calibration.values[f"{triad}.matrix.xy"]
        assert own.offset[2] == calibration[f"{triad}.offset.z"]
        assert own.sigma.offset[1] == calibration.sigma[f"{triad}.offset.y"]
    assert calibration.gyro.g_sensitivity.shape == (3, 3) and calibration.gyro.lever_arm is None
    assert calibration.accel.lever_arm.shape == (3, 3) and calibration.accel.g_sensitivity is None
    assert np.isnan(calibration.accel.sigma.matrix[0, 1])  # fixed by the frame
    with pytest.raises(KeyError):
        calibration["gyro.matrix"]
    raw = np.array([0.1, -0.2, 0.3])
    model = calibration.gyro.offset + calibration.gyro.matrix @ raw  # g-sensitivity apart
    assert np.abs(calibration.apply(raw, np.zeros(3))[0] - model).max() < 0.01


def _of_another_process(session_and_recording):
    session, recording = session_and_recording
    return session, recording, recording.gyro.sum()


def test_sessions_and_recordings_go_to_other_processes(by_hand):
    temperature = np.linspace(20, 30, 500)
    random = np.random.default_rng(2)
    own = imulab.Recording.from_arrays(np.arange(1, 501) / 200, random.standard_normal((500, 3)), random.standard_normal((500, 3)),
                                       temperature=temperature, gyro_increment=True, gyro_limits=(-500, 500))
    procedures = [imulab.procedure(name) for name in ("handheld", "zhang-24", "dai-unit", "two-axis")]
    for session in [by_hand.session, *procedures]:
        assert pickle.loads(pickle.dumps(session)) == session
    for recording in (by_hand.recordings[0], own):
        same(pickle.loads(pickle.dumps(recording)), recording)
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        session, recording, total = pool.map(_of_another_process, [(by_hand.session, own)])[0]
    assert session == by_hand.session and total == own.gyro.sum()
    same(recording, own)
    again = imulab.calibrate(pickle.loads(pickle.dumps(by_hand)), method="handheld")
    assert (again.covariance == imulab.calibrate(by_hand, method="handheld").covariance).all()


def same(a, b):
    """To the last bit."""
    assert (a.name, a.interval_s, a.gyro_unit, a.accel_unit, a.temperature_units) == (b.name, b.interval_s, b.gyro_unit, b.accel_unit, b.temperature_units)
    for name in ("time_ns", "gyro", "accel", "gyro_temperature", "accel_temperature", "gaps", "saturated"):
        left, right = getattr(a, name), getattr(b, name)
        assert (left is None) == (right is None) and (left is None or left.tobytes() == right.tobytes()), name


def test_pickles_that_are_none():
    for kind in (imulab._imulab.Recording, imulab._imulab.Session):
        with pytest.raises(imulab.Error, match="another version"):
            kind.__new__(kind).__setstate__((1, 2))


def test_reading_a_log_needs_no_gravity(hand_session):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(imulab.read_recording(hand_session / "recording.csv")) > 1000


def test_fleet_as_a_table(results):
    pandas = pytest.importorskip("pandas")
    frame = results["units"].to_frame()
    assert isinstance(frame, pandas.DataFrame) and len(frame) == 4
    assert list(frame["serial"]) == ["00", "01", "02", "03"]
    assert frame["accel.offset.x"].notna().all()


def test_exports_without_a_noise_log(calibration):
    with pytest.warns(imulab.DataWarning, match="the random walk is not measured"):
        text = calibration.to("kalibr")
    assert "NOT MEASURED" in text and "gyroscope_random_walk" in text


def test_inspection_of_several_topics(by_hand, tmp_path):
    """A folder of texts has a topic for each, as a bag has."""
    recording = by_hand.recordings[0]
    for name, values in (("Gyroscope", recording.gyro), ("Accelerometer", recording.accel)):
        np.savetxt(tmp_path / f"{name}.csv", np.column_stack([recording.t, values]), delimiter=",", header="seconds,x,y,z", comments="")
    declared = {"latitude_deg": "45", "gyro.unit": "rad/s", "accel.unit": "m/s^2"}
    found = imulab.inspect(tmp_path, declare=declared)
    assert found.complete and {"Gyroscope.x", "Accelerometer.z"} <= {c["name"] for c in found["columns"]}
    assert "Gyroscope.x" in found._repr_html_() and len(found.recording) == len(recording)
    assert pickle.loads(pickle.dumps(found.session)) == found.session
    only = imulab.inspect(tmp_path, topics=["Accelerometer"], declare=declared | {"latitude_deg": "45"})
    assert "Gyroscope.x" not in only._repr_html_()
