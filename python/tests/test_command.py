"""The module's answers are the command's, to the last digit."""


import json
import os
import subprocess
import warnings

import imulab
import pytest


def test_calibrate(hand_session, command, tmp_path):
    printed = command("calibrate", hand_session, "--method", "handheld", "--json")
    own = imulab.calibrate(hand_session, method="handheld")
    for data in (printed, made := dict(own.data)):
        data.pop("created")
    assert made == printed
    own.save(tmp_path / "c.json")
    assert imulab.read_calibration(tmp_path / "c.json").values == own.values


def test_calibrate_with_terms_and_requirements(hand_session, command):
    terms, require = "accel.offset,accel.matrix", "accel.offset <= 1 ug"
    printed = command("calibrate", hand_session, "--method", "static", "--terms", terms, "--require", require, "--json", code=1)
    own = imulab.calibrate(hand_session, method="static", terms=terms.split(","), require=require)
    for data in (printed, made := dict(own.data)):
        data.pop("created")
    assert made == printed
    assert "not reached: accel.offset <= 1 ug" in own.shortcomings
    with pytest.raises(imulab.Unsupported, match="not reached"):
        own.expect_supported()


def test_compare(hand_session, command, tmp_path):
    imulab.calibrate(hand_session, method="handheld").save(tmp_path / "c.json")
    printed = command("compare", tmp_path / "c.json", hand_session / "truth.json", "--json")
    own = imulab.compare(imulab.read_calibration(tmp_path / "c.json"), imulab.read_calibration(hand_session / "truth.json"))
    assert own.data == printed


@pytest.mark.parametrize("method, name", [("turntable", "zhang-24"), ("hybrid", "cheng-path"), ("handheld", "handheld")])
def test_predict(method, name, command, tmp_path):
    procedure = imulab.procedure(name)
    procedure.save(tmp_path / "p.toml")
    own = imulab.predict(tmp_path / "p.toml", method=method, runs=100)
    printed = command("predict", tmp_path / "p.toml", "--method", method, *(["--runs", "100"] if method == "turntable" else []), "--json",
                      code=1 if own.shortcomings else 0)
    assert own.data == printed


def test_plan(command):
    require = "gyro.offset <= 0.1 deg/h"
    assert imulab.plan(require, within=120, rest=20).data == command("plan", "--require", require, "--within", "120", "--rest", "20", "--json")


def test_noise(rest_log, command, tmp_path):
    rest_log.save(tmp_path / "rest.csv")
    units = {"gyro.unit": "rad/s", "accel.unit": "m/s^2"}  # a log at rest does not show them
    own = imulab.noise(imulab.inspect(tmp_path / "rest.csv", declare=units).session)
    assert own.data == command("noise", tmp_path / "rest.csv", *(a for k, v in units.items() for a in ("--set", f"{k}={v}")), "--json")


def test_noise_in_motion(rest_log):
    axes = imulab.noise(rest_log, moving=[rest_log])["moving"]["axes"]
    assert [axis["name"] for axis in axes] == ["gyro.x", "gyro.y", "gyro.z", "accel.x", "accel.y", "accel.z"]
    assert all(0.95 < axis["N"]["factor"] < 1.05 for axis in axes)  # the log itself, whose N is known to 0.4 %
    with pytest.raises(TypeError):
        imulab.noise(rest_log, moving=5)


def test_inspect(hand_session, command):
    file = hand_session / "recording.csv"
    own = imulab.inspect(file, declare={"latitude_deg": "45"})
    assert own.data == command("inspect", file, "--set", "latitude_deg=45", "--json")
    assert len(own.recording) == len(imulab.read_recording(hand_session))


def test_simulate(hand_session, by_hand):
    read = imulab.read_recording(hand_session)
    assert (read.gyro == by_hand.recordings[0].gyro).all()
    assert (read.time_ns == by_hand.recordings[0].time_ns).all()
    assert imulab.read_calibration(hand_session / "truth.json").values == by_hand.truth.values


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
duration_s = 60.0
"""


def mission(folder):
    file = folder / "mission.toml"
    file.write_text(MISSION)
    return file


def test_trajectory_navigate_and_budget(command, tmp_path):
    flight = imulab.trajectory(mission(tmp_path), output=tmp_path / "flight")
    read = imulab.read_recording(tmp_path / "flight")
    assert abs(read.gyro - flight.recording.gyro).max() <= 1e-15  # an increment in the file may differ by one unit in the last place
    own = imulab.navigate(None, tmp_path / "flight")
    printed = command("navigate", "none", tmp_path / "flight", "--json")
    for data in (printed, made := dict(own.data)):
        data.pop("session")
    assert made == printed
    budget = imulab.budget(tmp_path / "mission.toml", grade="navigation", runs=10)
    assert budget.data == command("budget", tmp_path / "mission.toml", "--grade", "navigation", "--runs", "10", "--json")
    grades = imulab.budget(tmp_path / "mission.toml", grade=["navigation", "tactical"], runs=0)
    assert grades.data == command("budget", tmp_path / "mission.toml", "--grade", "navigation,tactical", "--runs", "0", "--json")
    assert list(grades.budgets) == ["navigation", "tactical"] and str(grades).startswith("horizontal RMS: navigation ")
    assert budget.budgets == {"navigation": budget.data}
    with pytest.raises(TypeError, match="grade: expected a name or a list of names, got 3"):
        imulab.budget(tmp_path / "mission.toml", grade=3)


def test_requirements(rest_log, tmp_path):
    imulab.trajectory(mission(tmp_path), output=tmp_path / "flight")
    navigated = imulab.navigate(None, tmp_path / "flight", require="horizontal <= 1 km at 30 s")
    assert list(navigated.data)[:3] == ["verdict", "headline", "warnings"]
    assert navigated["verdict"] == "met" and not navigated.shortcomings and str(navigated).startswith("met: horizontal ")
    budget = imulab.budget(tmp_path / "mission.toml", grade="navigation", runs=10, require="CEP <= 0.001 m")
    assert budget["verdict"] == "not met" and budget.shortcomings == "not met: CEP <= 0.001 m"
    rest_log.save(tmp_path / "rest.csv")
    units = {"gyro.unit": "rad/s", "accel.unit": "m/s^2"}
    noise = imulab.noise(imulab.inspect(tmp_path / "rest.csv", declare=units).session, require="gyro.N <= 1000 deg/sqrt(h)")
    assert noise["verdict"] == "met" and noise["requirements"][0]["met"]
    with pytest.raises(imulab.Error, match="require: CPE: .*did you mean CEP"):
        imulab.budget(tmp_path / "mission.toml", grade="navigation", runs=10, require="CPE <= 1 m")


def test_export(calibration, environment, tmp_path):
    calibration.save(tmp_path / "c.json")
    for target in ("csv", "json-matrix", "vectornav"):
        done = subprocess.run([os.environ["IMULAB_COMMAND"], "export", tmp_path / "c.json", "--to", target], capture_output=True, check=True,
                              env=environment)
        with warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always")
            assert calibration.to(target) == done.stdout.decode()
        assert bool(warned) == bool(done.stderr)
        assert not any("--" in str(w.message) for w in warned)  # an option is the command's


def test_json_is_the_text(calibration):
    assert json.loads(calibration.json) == calibration.data
