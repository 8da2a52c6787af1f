"""Rows as they come: the events of the command, the calibration of what came; and which files a calibration was made from."""

import json
import os
import subprocess

import numpy as np
import pytest

import imulab

SITE = imulab.Site(latitude_deg=45, height_m=0)


def live(**options):
    return imulab.Live(site=SITE, imu={"name": "handheld", "grade": "mems"}, interval_s=0.01, **options)


@pytest.fixture(scope="module")
def rows(by_hand):
    recording = by_hand.recordings[0]
    return recording.time_ns, recording.gyro, recording.accel


def feed(target, rows, size, until=None):
    events = []
    for begin in range(0, len(rows[0]) if until is None else until, size):
        t, gyro, accel = (column[begin : begin + size] for column in rows)
        events += target.add(t, gyro, accel, time_unit="ns")
        if target.done:
            break
    return events


@pytest.mark.parametrize("size", [25, 333])
def test_events_are_the_commands(size, rows, hand_session, environment):
    done = subprocess.run([os.environ["IMULAB_COMMAND"], "live", hand_session / "recording.csv", "--session", hand_session, "--json"],
                          capture_output=True, text=True, check=True, env=environment)
    printed = [json.loads(line) for line in done.stdout.splitlines()]
    target = live()
    assert "no rest" in target.missing
    events = feed(target, rows, size)
    assert events == printed
    assert target.done and target.missing == "" and len(events) >= 7
    assert "done" in str(target)
    assert all("next" in event for event in events[:-1]) and "next" not in events[-1]


def test_the_calibration_is_that_of_all_rows(rows, by_hand):
    target = live(require="gyro.matrix.diagonal <= 1 ppm")
    with pytest.raises(imulab.Unsupported, match="fewer than two rows"):
        target.calibration()
    feed(target, rows, 1000)
    assert len(target) == len(rows[0]) and not target.done and "not reached: gyro.matrix.diagonal" in target.missing
    own, whole = target.calibration(), imulab.calibrate(by_hand, method="handheld")
    assert own.values == whole.values
    assert (own.covariance == whole.covariance).all()
    assert "not reached: gyro.matrix.diagonal <= 1 ppm" in own.shortcomings
    with pytest.raises(imulab.Unsupported, match="not reached"):
        own.expect_supported()


def test_rest_and_motion_are_told(rows):
    target = live()
    assert target.resting_s is None
    feed(target, rows, 100, until=300)
    assert 2.5 < target.resting_s < 3.1
    t, gyro, accel = (column[:100] for column in rows)
    random = np.random.default_rng(1)
    target.add(t + 3 * 10**9, gyro + random.normal(size=(100, 3)), accel + random.normal(size=(100, 3)), time_unit="ns")
    assert target.resting_s is None
    assert repr(target) == "<imulab.Live: 400 rows, not done>"


def test_seconds_are_as_good_as_nanoseconds(rows):
    one, other = live(), live()
    t, gyro, accel = (column[:6000] for column in rows)
    assert one.add(1e-9 * t, gyro, accel) == other.add(t, gyro, accel, time_unit="ns") != []


def test_counts_have_a_first_advice_before_their_scale(rows):
    target = live(gyro_unit="count", accel_unit="count")
    events = feed(target, (rows[0], rows[1] * 1e4, rows[2] * 1e3), 500, until=1000)
    assert "problem" in events[0] and "turn by" in events[0]["next"]
    assert "what helps most" in target.missing


def test_bad_rows_are_refused_and_not_used(rows):
    t, gyro, accel = (column[:500] for column in rows)
    target = live()
    target.add(t, gyro, accel, time_unit="ns")
    bad = gyro.copy()
    bad[3, 1] = np.nan
    for arguments, says in [
        ((t, gyro, accel), "sample 0 is at 0.01 s, the one before at 5 s; expected stamps that increase"),
        ((t + 10**10, bad, accel), "gyro y: sample 3 at .* is nan; expected a finite number"),
        ((t + 10**10, gyro[1:], accel), "gyro: 499 samples; expected 500"),
        ((t[::-1] + 10**10, gyro, accel), "sample 1 is at .*; expected stamps that increase"),
    ]:
        with pytest.raises(imulab.Error, match=says):
            target.add(*arguments, time_unit="ns")
    assert len(target) == 500
    assert target.add([], np.empty((0, 3)), np.empty((0, 3))) == []
    target.add(t + 10**10, gyro, accel, time_unit="ns")
    assert len(target) == 1000


@pytest.mark.parametrize("options, error, says", [
    ({"require": "gyro.nothing <= 1 ppm"}, imulab.Error, "require: "),
    ({"require": "accel.matrix.diagonal <= 1 ppm"}, imulab.Unsupported, "cannot be better than gravity"),
    ({"rest": 0.5}, imulab.Error, "rest: 0.5; expected 1 to 600"),
    ({"gyro_unit": "rpm"}, imulab.Error, 'gyro: the unit is "rpm"; expected one of'),
    ({"gyro_unit": 3}, TypeError, "gyro_unit: expected a name"),
    ({"gyro_limits": (1, 2, 3)}, imulab.Error, "gyro_limits: expected two numbers"),
])
def test_bad_declarations(options, error, says):
    with pytest.raises(error, match=says):
        live(**options)


def test_increments_need_their_interval():
    with pytest.raises(imulab.Error, match="interval_s"):
        imulab.Live(site=SITE, gyro_increment=True)
    with pytest.raises(imulab.Error, match="latitude|gravity"):
        imulab.Live(site={})


def test_verify(hand_session, command, tmp_path):
    session = tmp_path / "session"
    session.mkdir()
    for name in ("session.toml", "recording.csv"):
        (session / name).write_bytes((hand_session / name).read_bytes())
    file = tmp_path / "c.json"
    imulab.calibrate(session, method="handheld").save(file)
    same = imulab.verify(file)
    assert same and same.shortcomings == "" and same.data == command("verify", file, "--json")
    assert [(os.path.basename(f.file), f.state) for f in same.files] == [("session.toml", "unchanged"), ("recording.csv", "unchanged")]

    with (session / "recording.csv").open("a") as out:
        out.write("1e9,0,0,0,0,0,0\n")
    changed = imulab.verify(file)
    assert not changed and [f.state for f in changed.files] == ["unchanged", "changed"]
    assert changed.data == command("verify", file, "--json", code=1)
    with pytest.raises(imulab.Unsupported, match="not what it was made from: .*recording.csv"):
        changed.expect_supported()

    session.rename(tmp_path / "elsewhere")
    missing = imulab.verify(file)
    assert not missing and "not found" in missing.shortcomings and {f.state for f in missing.files} == {"missing"}
    assert [f.state for f in imulab.verify(file, session_at=tmp_path / "elsewhere").files] == ["unchanged", "changed"]
    with pytest.raises(imulab.Error, match="no page"):
        missing.report(tmp_path / "page.html")


def test_verify_refuses_what_has_no_hashes(calibration, hand_session, tmp_path):
    calibration.save(tmp_path / "memory.json")
    with pytest.raises(imulab.Error, match="memory.json: has no hashes of recordings; expected a calibration that imulab made from files"):
        imulab.verify(tmp_path / "memory.json")
    with pytest.raises(imulab.Error, match="session.toml"):
        imulab.verify(hand_session / "session.toml")
    with pytest.raises(imulab.Error, match="nowhere.json"):
        imulab.verify(tmp_path / "nowhere.json")
    with pytest.raises(TypeError, match="calibration: expected a path"):
        imulab.verify(3)
