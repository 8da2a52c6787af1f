"""Laws that hold in C++ hold here: round trips, and errors as large as stated."""

import pickle

import numpy as np
import pytest

import imulab


def test_recording_gives_its_arrays_back():
    random = np.random.default_rng(2)
    t = np.arange(1, 501) / 200
    gyro, accel = random.standard_normal((500, 3)), random.standard_normal((500, 3))
    recording = imulab.Recording.from_arrays(t, gyro, accel, temperature=np.linspace(20, 30, 500))
    assert (recording.gyro == gyro).all() and (recording.accel == accel).all()
    assert np.abs(recording.t - t).max() <= 0.5e-9  # stamps are whole nanoseconds
    assert (recording.gyro_temperature[:, 0] == np.linspace(20, 30, 500)).all()
    assert recording.interval_s == pytest.approx(1 / 200, abs=1e-9)


@pytest.mark.parametrize("convert", [np.asfortranarray, lambda a: a[::-1][::-1], lambda a: np.repeat(a, 2, axis=0)[::2], lambda a: a.tolist(),
                                     lambda a: np.repeat(a, 2, axis=1)[:, ::2], lambda a: a.astype(">f8"), np.ma.asarray])
def test_any_layout_gives_the_same(calibration, convert):
    random = np.random.default_rng(3)
    gyro, accel = random.standard_normal((1500, 3)), random.standard_normal((1500, 3))
    expected = calibration.apply(gyro, accel)
    given = calibration.apply(convert(gyro), convert(accel))
    assert (given[0] == expected[0]).all() and (given[1] == expected[1]).all()


@pytest.mark.parametrize("kind", ["float32", "float16", "int16", "uint8", "int64"])
def test_other_numbers_are_converted(calibration, kind):
    gyro = np.arange(30).reshape(10, 3).astype(kind)
    expected = calibration.apply(gyro.astype(float), gyro.astype(float))
    assert (calibration.apply(gyro, gyro)[0] == expected[0]).all()


def test_calibration_written_by_hand(calibration, tmp_path):
    file = tmp_path / "hand.json"
    file.write_text("""{"format": "imulab.calibration/1", "model": {
        "accel": {"matrix": [[2, 0, 0], [0, 1, 0], [0, 0, 1]]}, "gyro": {"matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 3]]}}}""")
    c = imulab.read_calibration(file)
    assert set(c.sigma.values()) == {None} and c.covariance.shape == (0, 0) and c.estimated == []
    assert c.values["gyro.matrix.zz"] == 3 and c.values["gyro.offset.x"] == 0 and c.verdict == "" and c.imu == ""
    rate, force = c.apply([1, 1, 1], [1, 1, 1])
    assert rate.tolist() == [1, 1, 3] and force.tolist() == [2, 1, 1]
    c.save(tmp_path / "saved.json")
    assert imulab.read_calibration(tmp_path / "saved.json").values == c.values
    c.report(tmp_path / "page.html")
    assert "nothing to judge" in (tmp_path / "page.html").read_text() and str(c) and repr(c) and c.details
    assert pickle.loads(pickle.dumps(c)).values == c.values
    assert imulab.compare(calibration, c).data["coefficients"]["gyro.matrix.zz"]["b"] == 3
    assert c.to("csv").startswith("# Calibration of an unnamed IMU")


def test_headers_of_several_units(calibration):
    assert "left_compensate" in calibration.to("c-header", prefix="left")
    assert calibration.to("c-header", prefix="imulab") == calibration.to("c-header")


def test_compensation_is_that_of_recordings(calibration, by_hand):
    raw = by_hand.recordings[0]
    rate, force = calibration.apply(raw.gyro, raw.accel)
    out = imulab.compensate(calibration, raw)
    assert (out.gyro == rate).all() and (out.accel == force).all()


def test_compensation_is_the_model(calibration):
    """omega = W0 + W1 V + W2 V^2 + W3 V^3 + C a (Dai 2011 eqs 1-4), with numpy alone."""
    v = calibration.values
    gyro, accel = np.random.default_rng(4).standard_normal((2, 100, 3))

    def term(name):
        return np.array([[v[f"{name}.{r}{c}"] for c in "xyz"] for r in "xyz"])

    def diagonal(name):
        return np.array([v[f"{name}.{r}"] for r in "xyz"])

    def polynomial(triad, u):
        return diagonal(f"{triad}.offset") + u @ term(f"{triad}.matrix").T + diagonal(f"{triad}.quadratic") * u**2 + diagonal(f"{triad}.cubic") * u**3

    force = polynomial("accel", accel)
    rate = polynomial("gyro", gyro) + force @ term("gyro.g_sensitivity").T
    got = calibration.apply(gyro, accel)
    assert np.allclose(got[0], rate, rtol=1e-13, atol=1e-15) and np.allclose(got[1], force, rtol=1e-13, atol=1e-15)


def test_one_sample_and_in_place(calibration):
    gyro, accel = np.ones((5, 3)), np.ones((5, 3))
    rate, force = calibration.apply(gyro, accel)
    one = calibration.apply([1, 1, 1], [1, 1, 1])
    assert one[0].shape == (3,) and (one[0] == rate[0]).all() and (one[1] == force[0]).all()
    calibration.apply(gyro, accel, out=(gyro, accel))
    assert (gyro == rate).all() and (accel == force).all()


def test_no_samples(calibration):
    rate, force = calibration.apply(np.empty((0, 3)), np.empty((0, 3)))
    assert rate.shape == force.shape == (0, 3)


def test_nan_gives_nan(calibration):
    gyro = np.ones((4, 3))
    gyro[2, 1] = np.nan
    rate, _ = calibration.apply(gyro, np.ones((4, 3)))
    assert np.isnan(rate[2]).any() and not np.isnan(rate[[0, 1, 3]]).any()


def test_stated_uncertainties_hold():
    """Handheld calibrations of 12 seeds: errors against the truth in their sigmas. The mean square of 12 x 18 such errors, about six of which are
    independent a session, lies in 0.5 to 1.7 with a probability of more than 0.999 (chi-square of 72)."""
    squares = []
    for seed in range(12):
        simulation = imulab.simulate(imulab.procedure("handheld", poses=24, seed=seed), seed=100 + seed)
        compared = imulab.compare(imulab.calibrate(simulation, method="handheld", effects="none"), simulation.truth)  # none are drawn
        squares += [sigmas**2 for sigmas in compared.sigmas.values()]
    assert 0.5 < np.mean(squares) < 1.7


def test_session_as_tables():
    session = imulab.procedure("zhang-24")
    tables = session.tables
    tables.pop("format")
    assert imulab.Session(**tables).tables == session.tables
    by_hand = imulab.Session(imu={"name": 'a "name"\n'}, site=imulab.Site(latitude_deg=47.4))
    assert by_hand.imu == 'a "name"\n'
    assert by_hand.gravity == pytest.approx(9.80837, abs=1e-4)  # normal gravity 9.780325 (1 + 0.00193185 s^2)/sqrt(1 - 0.00669438 s^2), s = sin 47.4 deg


def test_recording_in_memory_equals_the_file(by_hand):
    raw = by_hand.recordings[0]
    recording = imulab.Recording.from_arrays(raw.time_ns, raw.gyro, raw.accel, name=raw.name, time_unit="ns")
    tables = by_hand.session.tables
    site = imulab.Site(**tables["site"])
    own = imulab.calibrate(recording, site=site, imu=tables["imu"], method="handheld")
    assert own.values == pytest.approx(imulab.calibrate(by_hand, method="handheld").values, rel=1e-9)


def test_units():
    t, ones = np.arange(1, 11) / 10, np.ones((10, 3))
    recording = imulab.Recording.from_arrays(t, ones, ones, gyro_unit="deg/s", accel_unit="g")
    assert recording.gyro[0, 0] == pytest.approx(np.pi / 180, rel=1e-15) and recording.accel[0, 0] == pytest.approx(9.80665, rel=1e-15)
    counts = imulab.Recording.from_arrays(t, ones, ones, gyro_unit="count", accel_unit="count")
    assert counts.gyro_unit == "count" and counts.gyro[0, 0] == 1


def test_exact_stamps():
    first = np.datetime64("2026-01-01T00:00:00.000000001")
    t = first + np.arange(10) * np.timedelta64(10_000_000, "ns")
    recording = imulab.Recording.from_arrays(t, np.zeros((10, 3)), np.ones((10, 3)))
    assert (np.diff(recording.time_ns) == 10_000_000).all() and recording.time_ns[0] % 10 == 1


def test_stamps_of_pandas():
    pandas = pytest.importorskip("pandas")
    forces = np.ones((10, 3))
    utc = pandas.date_range("2026-01-01", periods=10, freq="10ms", tz="UTC")
    for t in (utc, utc.tz_convert("Asia/Kolkata"), utc.to_series(), utc.tz_localize(None)):
        recording = imulab.Recording.from_arrays(t, np.zeros((10, 3)), forces)
        assert recording.time_ns[0] == 1_767_225_600_000_000_000 and (np.diff(recording.time_ns) == 10_000_000).all()
    since = imulab.Recording.from_arrays(utc - utc[0], np.zeros((10, 3)), forces)
    assert (since.time_ns == np.arange(10) * 10_000_000).all()


def test_stamps_since_a_start():
    t = np.arange(10) * np.timedelta64(10, "ms")
    assert imulab.Recording.from_arrays(t, np.zeros((10, 3)), np.ones((10, 3))).time_ns[9] == 90_000_000


def test_arrays_of_results_are_views(by_hand, calibration):
    recording = by_hand.recordings[0]
    assert recording.gyro is recording.gyro and recording.time_ns is recording.time_ns
    for array in (recording.gyro, recording.t, calibration.gyro.matrix, calibration.gyro.sigma.offset, calibration.covariance):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 5
    again = pickle.loads(pickle.dumps(recording))
    assert (again.gyro == recording.gyro).all() and again.temperature_units == recording.temperature_units


def test_pickle(calibration):
    again = pickle.loads(pickle.dumps(calibration))
    assert again.values == calibration.values and (again.covariance == calibration.covariance).all()


def test_covariance_has_the_sigmas(calibration):
    for k, name in enumerate(calibration.estimated):
        sigma = calibration.sigma[name]
        if sigma is not None:
            assert np.sqrt(calibration.covariance[k, k]) == pytest.approx(sigma, rel=1e-12)


def test_white_noise_is_found():
    n = 200_000
    rate = 0.02 * np.random.default_rng(7).standard_normal(n)  # rad/s at 100 Hz: N = 0.02 * sqrt(0.01) = 0.002
    found = imulab.allan_deviation(rate, 0.01)
    expected = 0.002 / np.sqrt(found["tau"])
    inside = (found["lower_95"] < expected) & (expected < found["upper_95"])
    assert inside.mean() > 0.7  # points of a curve are correlated: 95 % of all curves, not of one


def test_frames_and_figures(by_hand, calibration, rest_log):
    pytest.importorskip("pandas")
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    frame = calibration.to_frame()
    assert frame.loc["accel.offset.x", "value"] == calibration.values["accel.offset.x"]
    assert len(by_hand.recordings[0].to_frame()) == len(by_hand.recordings[0])
    assert by_hand.recordings[0].plot() is not None and imulab.noise(rest_log).plot() is not None


def test_reports(calibration, by_hand, tmp_path, rest_log):
    calibration.report(tmp_path / "c.html")
    imulab.compare(calibration, by_hand.truth).report(tmp_path / "d.html")
    imulab.noise(rest_log).report(tmp_path / "n.html")
    imulab.predict(imulab.procedure("cheng-path"), method="hybrid").report(tmp_path / "p.html")
    for page in tmp_path.glob("*.html"):
        text = page.read_text()
        assert text.startswith("<!DOCTYPE html>") and "</html>" in text


def test_representations(calibration, by_hand, rest_log):
    assert "handheld" in repr(calibration) and str(calibration).count("\n") > 5
    assert "<table>" in calibration._repr_html_() and "6000" in repr(rest_log)
    for thing in (by_hand.session, by_hand.recordings[0], imulab.noise(rest_log)):
        assert repr(thing).startswith("<imulab.")
