"""Data and calibrations that are well formed and do not fit what is asked of them: said, or refused."""

import json
import shutil

import numpy as np
import pytest

import imulab

GOOD = np.full((50, 3), 1.0)


def test_unusable_calibration(by_hand):
    """One that the data do not determine is not applied unless that is said."""
    poor = imulab.calibrate(by_hand, method="handheld", terms="accel.offset")
    if not poor.shortcomings:
        tables = by_hand.session.tables
        raw = by_hand.recordings[0]
        few = imulab.Recording.from_arrays(raw.t[:3500], raw.gyro[:3500], raw.accel[:3500])
        poor = imulab.calibrate(few, method="handheld", site=tables["site"], imu=tables["imu"])
    assert poor.shortcomings
    with pytest.raises(imulab.Unsupported, match="did not determine"):
        poor.apply(GOOD, GOOD)
    with pytest.warns(imulab.DataWarning):
        poor.apply(GOOD, GOOD, allow_undetermined=True)


def test_temperatures_in_another_unit(tmp_path):
    """Kelvin are not taken for degrees Celsius."""
    unit = imulab.simulate(imulab.procedure("dai-unit"), seed=2)
    warm = unit.recordings[0]
    other = imulab.Recording(warm._recording, ("K", "degC"))
    imulab.compensate(unit.truth, warm)
    with pytest.raises(imulab.Error, match="gyro temperature is in K; expected degC"):
        imulab.compensate(unit.truth, other)


def test_calibrations_of_two_imus(calibration, tmp_path):
    data = dict(calibration.data)
    for serial in ("1", "2"):
        (tmp_path / serial).write_text(json.dumps(data | {"serial": serial}))
    a, b = (imulab.read_calibration(tmp_path / serial) for serial in ("1", "2"))
    with pytest.raises(imulab.Error, match="expected calibrations of one IMU"):
        imulab.compare(a, b)
    assert imulab.compare(a, b, different_imus=True)["consistency"]["chi2"] == 0


def test_assumed_gravity_is_said(hand_session, tmp_path):
    inspected = imulab.inspect(hand_session / "recording.csv", declare={"grade": "mems"}).session
    shutil.copy(hand_session / "recording.csv", tmp_path)
    inspected.save(tmp_path / "session.toml")
    for data in (hand_session / "recording.csv", inspected, imulab.read_session(tmp_path / "session.toml")):
        with pytest.warns(imulab.DataWarning, match="assumed: gravity"):
            imulab.calibrate(data, method="handheld")


def test_budget_of_an_undetermined_calibration(by_hand, tmp_path):
    raw = by_hand.recordings[0]
    few = imulab.Recording.from_arrays(raw.t[:3500], raw.gyro[:3500], raw.accel[:3500])
    tables = by_hand.session.tables
    with pytest.warns(imulab.DataWarning):
        imulab.calibrate(few, method="handheld", site=tables["site"], imu=tables["imu"]).save(tmp_path / "c.json")
    mission = tmp_path / "m.toml"
    mission.write_text(
        'format = "imulab.mission/1"\nrate_hz = 10\n[start]\nlatitude_deg = 45\nlongitude_deg = 0\nheight_m = 0\n'
        'heading_deg = 0\n[[segment]]\nkind = "rest"\nduration_s = 20\n'
    )
    with pytest.raises(imulab.Unsupported, match="did not determine"):
        imulab.budget(mission, calibration=tmp_path / "c.json", runs=0)
    with pytest.warns(imulab.DataWarning, match="did not determine"):
        imulab.budget(mission, calibration=tmp_path / "c.json", runs=0, allow_undetermined=True)
