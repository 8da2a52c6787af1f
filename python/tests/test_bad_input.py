"""Bad input as Python sees it: Error, Unsupported or TypeError with a text that says what; never a crash, never another exception."""

import datetime
import decimal
import pathlib
import re

import numpy as np
import pytest

import imulab

CLEAR = (imulab.Error, imulab.Unsupported, TypeError)
N = 50
T = np.arange(1, N + 1) / 100
GOOD = np.full((N, 3), 1.0)


class Strange:
    def __array__(self, *_):
        return "not an array"


class Raising:
    def __len__(self):
        return 3

    def __getitem__(self, _):
        raise TypeError("no items")


def read_only(a):
    a = np.array(a)
    a.flags.writeable = False
    return a


WITH_NAN = GOOD.copy()
WITH_NAN[7, 1] = np.nan
WITH_INFINITY = GOOD.copy()
WITH_INFINITY[7, 1] = -np.inf

NOT_NUMBERS = {
    "none": None,
    "text": "1 2 3",
    "bytes": b"123",
    "dict": {"x": 1},
    "set": {1, 2, 3},
    "function": len,
    "object": object(),
    "strange": Strange(),
    "raising": Raising(),
    "texts": [["1", "2", "3"]] * N,
    "ragged": [[1, 2, 3], [1, 2]],
    "complex": GOOD * 1j,
    "booleans": GOOD > 0,
    "objects": np.array([[object()] * 3] * N),
    "decimals": [[decimal.Decimal(1)] * 3] * N,
    "dates": [[datetime.date(2026, 1, 1)] * 3] * N,
    "structured": np.zeros(N, dtype=[("x", float), ("y", float), ("z", float)]),
    "void": np.zeros((N, 3), dtype="V8"),
    "timedelta": np.zeros((N, 3), dtype="m8[s]"),
    "generator": (row for row in GOOD),
    "module": np,
    "big integers": [[10**400] * 3] * N,
}
WRONG_SHAPES = {
    "scalar": 1.0,
    "vector": np.ones(N),
    "two columns": np.ones((N, 2)),
    "four columns": np.ones((N, 4)),
    "transposed": GOOD.T,
    "three dimensions": np.ones((N, 3, 1)),
    "one row too few": GOOD[1:],
    "one row too many": np.ones((N + 1, 3)),
    "empty": [],
    "no rows": np.empty((0, 3)),
    "no columns": np.empty((N, 0)),
    "no dimensions": np.array(5),
}
BAD_ROWS = NOT_NUMBERS | WRONG_SHAPES
BAD_READINGS = {"nan": WITH_NAN, "infinity": WITH_INFINITY, "too large": GOOD * 1e30, "masked": np.ma.masked_greater(GOOD, 0.5)}
BAD_STAMPS = {
    "none": None,
    "text": "now",
    "texts": ["1"] * N,
    "backwards": T[::-1],
    "repeated": np.zeros(N),
    "nan": np.where(T > 0.2, np.nan, T),
    "infinite": np.where(T > 0.4, np.inf, T),
    "two dimensions": GOOD,
    "short": T[1:],
    "empty": [],
    "complex": T * 1j,
    "booleans": T > 0,
    "huge": T * 1e300,
    "beyond 64 bits": T + 1e12,
    "integers beyond 64 bits": (np.arange(N) + 2**62),
    "unsigned beyond 64 bits": np.full(N, 2**64 - 1, dtype=np.uint64),
    "not a time": np.full(N, np.datetime64("NaT")),
    "objects": [object()] * N,
    "scalar": 1.0,
}


def cases(table):
    return [pytest.param(value, id=name) for name, value in table.items()]


def expect_clear(call):
    with pytest.raises(CLEAR) as raised:
        call()
    assert type(raised.value) in CLEAR and str(raised.value), repr(raised.value)
    assert not re.search(r"(^|[^\w-])--[a-z]", str(raised.value)), f"an option of the shell: {raised.value}"


@pytest.mark.parametrize("place", ["gyro", "accel"])
@pytest.mark.parametrize("bad", cases(BAD_ROWS | BAD_READINGS))
def test_readings(place, bad):
    arrays = {"gyro": GOOD, "accel": GOOD} | {place: bad}
    expect_clear(lambda: imulab.Recording.from_arrays(T, **arrays))


@pytest.mark.parametrize("bad", cases(BAD_STAMPS))
def test_stamps(bad):
    expect_clear(lambda: imulab.Recording.from_arrays(bad, GOOD, GOOD))


@pytest.mark.parametrize("bad", cases({k: v for k, v in BAD_ROWS.items() if k not in ("none", "vector")} | {"nan": WITH_NAN[:, 1]}))
def test_temperatures(bad):
    expect_clear(lambda: imulab.Recording.from_arrays(T, GOOD, GOOD, temperature=bad))


@pytest.mark.parametrize("place", ["gyro", "accel"])
@pytest.mark.parametrize("bad", cases({k: v for k, v in BAD_ROWS.items() if k != "vector"}))
def test_apply(calibration, place, bad):
    arrays = {"gyro": GOOD, "accel": GOOD} | {place: bad}
    expect_clear(lambda: calibration.apply(**arrays))


@pytest.mark.parametrize("bad", cases({k: v for k, v in BAD_ROWS.items() if k not in ("none", "vector", "scalar", "no dimensions")}))
def test_apply_temperature(calibration, bad):
    expect_clear(lambda: calibration.apply(GOOD, GOOD, bad))


@pytest.mark.parametrize(
    "out",
    cases(
        {
            "one": (np.empty((N, 3)),),
            "array": np.empty((2, N, 3)),
            "list": [GOOD.copy(), GOOD.copy()],
            "float32": (np.empty((N, 3), np.float32), np.empty((N, 3))),
            "short": (np.empty((N - 1, 3)), np.empty((N, 3))),
            "columns": (np.asfortranarray(GOOD), np.empty((N, 3))),
            "read only": (read_only(GOOD), np.empty((N, 3))),
            "shared": (GOOD[:], GOOD[:]),
            "big endian": (np.empty((N, 3), ">f8"), np.empty((N, 3))),
            "numbers": (1, 2),
        }
    ),
)
def test_apply_out(calibration, out):
    expect_clear(lambda: calibration.apply(GOOD, GOOD, out=out))


def test_apply_to_a_part_of_its_input(calibration):
    """In place is fine; shifted, a block would be read after it was written."""
    memory = np.ones((N + 1, 3))
    expect_clear(lambda: calibration.apply(memory[:-1], GOOD, out=(memory[1:], np.empty((N, 3)))))
    expect_clear(lambda: calibration.apply(GOOD, memory[::-1][1:], out=(np.empty((N, 3)), memory[1:])))
    swapped = [GOOD.copy(), 2 * GOOD]
    expected = calibration.apply(*(a.copy() for a in swapped))
    calibration.apply(*swapped, out=(swapped[1], swapped[0]))
    assert (swapped[1] == expected[0]).all() and (swapped[0] == expected[1]).all()


@pytest.mark.parametrize("bad", cases(NOT_NUMBERS | {"rows": GOOD, "short": [1.0], "nan": [1.0, np.nan, 2.0, 3.0], "empty": []}))
def test_deviation(bad):
    expect_clear(lambda: imulab.allan_deviation(bad, 0.01))


@pytest.mark.parametrize(
    "options",
    cases(
        {
            "interval nan": {"interval_s": float("nan")},
            "interval negative": {"interval_s": -1.0},
            "interval text": {"interval_s": "fast"},
            "interval contradicts": {"interval_s": 5.0},
            "unit": {"gyro_unit": "furlong"},
            "unit of the other": {"accel_unit": "deg/s"},
            "unit none": {"gyro_unit": None},
            "counts zero": {"gyro_counts_per_unit": 0},
            "counts nan": {"accel_counts_per_unit": float("nan")},
            "limits": {"gyro_limits": (1, -1)},
            "limits three": {"gyro_limits": (1, 2, 3)},
            "limits text": {"accel_limits": "ab"},
            "time unit": {"time_unit": "weeks"},
            "name": {"name": 5},
            "temperature short": {"gyro_temperature": T[1:]},
            "unknown": {"colour": "red"},
        }
    ),
)
def test_options_of_recordings(options):
    expect_clear(lambda: imulab.Recording.from_arrays(T, GOOD, GOOD, **options))


BAD_PATHS = {"none": None, "number": 5, "bytes": b"x", "list": ["x"], "missing": "no/such/file", "empty": "", "nul": "a\0b", "device": "/dev/null",
             "folder": pathlib.Path("/"), "program": "/bin/true", "long": "x" * 5000}


@pytest.mark.parametrize("read", [imulab.read_session, imulab.read_calibration, imulab.read_recording, imulab.inspect, imulab.import_calibration,
                                  imulab.trajectory, imulab.budget, imulab.simulate, imulab.predict, imulab.noise],
                         ids=lambda f: f.__name__)
@pytest.mark.parametrize("bad", cases(BAD_PATHS))
def test_paths(read, bad):
    expect_clear(lambda: read(bad))


@pytest.mark.parametrize(
    "options",
    cases(
        {
            "no method": {},
            "method": {"method": "guess"},
            "method none": {"method": None},
            "terms": {"method": "handheld", "terms": "gyro.colour"},
            "terms number": {"method": "handheld", "terms": 5},
            "terms of numbers": {"method": "handheld", "terms": [1]},
            "full": {"method": "handheld", "terms": "full"},
            "require": {"method": "handheld", "require": "everything"},
            "require nan": {"method": "handheld", "require": "accel.offset <= nan ug"},
            "stepwise": {"method": "handheld", "stepwise": True},
            "progress": {"method": "handheld", "progress": 5},
            "site of a session": {"method": "handheld", "site": imulab.Site(latitude_deg=1)},
            "turntable by hand": {"method": "turntable"},
        }
    ),
)
def test_calibrate(by_hand, options):
    expect_clear(lambda: imulab.calibrate(by_hand, **options))


@pytest.mark.parametrize("data", cases({"none": None, "number": 5, "no recordings": [], "numbers": [1, 2], "array": GOOD, "dict": {}}))
def test_calibrate_what_is_no_data(data):
    expect_clear(lambda: imulab.calibrate(data, method="handheld"))


@pytest.mark.parametrize(
    "site",
    cases({"none": None, "nothing": {}, "latitude": {"latitude_deg": 100}, "nan": {"latitude_deg": float("nan")}, "text": {"latitude_deg": "north"},
           "key": {"altitude": 5}, "gravity": {"gravity_mps2": -1}, "tuple": (47.4,), "list in it": {"latitude_deg": [1]}, "object": object()}),
)
def test_sites(by_hand, site):
    expect_clear(lambda: imulab.calibrate(by_hand.recordings[0], method="handheld", site=site))


@pytest.mark.filterwarnings("ignore::imulab.DataWarning")
def test_recordings_without_information():
    still = imulab.Recording.from_arrays(np.arange(1, 3001) / 100, np.zeros((3000, 3)), np.tile([0, 0, 9.8], (3000, 1)))
    for method in imulab.methods():
        expect_clear(lambda method=method: imulab.calibrate(still, method=method, site=imulab.Site(latitude_deg=45)).expect_supported())
    expect_clear(lambda: imulab.noise(still).expect_supported())


@pytest.mark.parametrize(
    "tables",
    cases({"imu": {"imu": 5}, "rig": {"rig": "turntable"}, "rig kind": {"rig": {"kind": "swing"}}, "step": {"step": [{"kind": "jump"}]},
           "step text": {"step": "hold"}, "value": {"imu": {"name": object()}}, "key": {"imu": {5: 1}}, "unknown": {"imu": {"colour": "red"}},
           "infinite": {"step": [{"kind": "hold", "duration_s": float("inf")}]}, "recording": {"recording": {"file": ""}}}),
)
def test_sessions(tables):
    expect_clear(lambda: imulab.Session(**tables).recordings.index("none of them"))


@pytest.mark.parametrize(
    "call",
    [
        lambda c: imulab.compare(c),
        lambda c: imulab.compare(),
        lambda c: imulab.compare(c, "truth.json"),
        lambda c: imulab.compensate(c, GOOD),
        lambda c: imulab.compensate("c.json", imulab.Recording.from_arrays(T, GOOD, GOOD)),
        lambda c: imulab.compensate(c, imulab.Recording.from_arrays(T, GOOD, GOOD, gyro_unit="count", accel_unit="count")),
        lambda c: c.to("nowhere"),
        lambda c: c.to("kalibr", noise=5),
        lambda c: c.to("csv", three_axes="all"),
        lambda c: c.to("csv", prefix="imu1"),
        lambda c: c.to("c-header", prefix="1imu"),
        lambda c: c.to("c-header", prefix=5),
        lambda c: c.to(5),
        lambda c: c.save("/no/such/folder/c.json"),
        lambda c: c.save(5),
        lambda c: c.report("/"),
        lambda c: c.export("csv", 5),
        lambda c: imulab.Calibration("c.json"),
        lambda c: imulab.Recording("log.csv"),
        lambda c: imulab.Recording(),
        lambda c: imulab.procedure("dance"),
        lambda c: imulab.procedure("zhang-24", speed=5),
        lambda c: imulab.procedure("handheld", poses="many"),
        lambda c: imulab.procedure("handheld", poses=float("nan")),
        lambda c: imulab.procedure("handheld", poses=1e18),
        lambda c: imulab.procedure("handheld", seed=-1),
        lambda c: imulab.simulate(imulab.procedure("handheld"), seed=-1),
        lambda c: imulab.simulate(imulab.procedure("handheld"), seed=2**64),
        lambda c: imulab.simulate(imulab.procedure("handheld"), seed=1.5),
        lambda c: imulab.simulate(imulab.procedure("handheld"), grade="best"),
        lambda c: imulab.simulate(imulab.procedure("handheld"), unit="truth.json"),
        lambda c: imulab.predict(imulab.procedure("zhang-24"), method="guess"),
        lambda c: imulab.predict(imulab.procedure("zhang-24"), runs=-1),
        lambda c: imulab.predict(imulab.procedure("zhang-24"), runs=10**12),
        lambda c: imulab.plan("everything"),
        lambda c: imulab.plan("gyro.offset <= 1 deg/h", latitude_deg=100),
        lambda c: imulab.plan("gyro.offset <= 1 deg/h", latitude_deg=float("nan")),
        lambda c: imulab.plan("gyro.offset <= 1 deg/h", axes="outer"),
        lambda c: c.to("csv", noise="none.json"),
        lambda c: imulab.plan("gyro.offset <= 1 deg/h", axes=["diagonal"]),
        lambda c: imulab.plan("gyro.offset <= 1 deg/h", within=1),
        lambda c: imulab.plan("gyro.offset <= 1 deg/h", grade="best"),
        lambda c: imulab.inspect(),
        lambda c: imulab.inspect("x.csv", topics="imu"),
        lambda c: imulab.inspect("x.csv", declare={"colour": "red"}),
        lambda c: imulab.inspect("x.csv", declare={"gyro.unit": 5}),
        lambda c: imulab.navigate(c, imulab.procedure("handheld")),
        lambda c: imulab.navigate("c.json", imulab.procedure("handheld")),
        lambda c: imulab.allan_deviation(np.arange(100.0), -1),
        lambda c: imulab.allan_deviation(np.arange(100.0), float("nan")),
        lambda c: imulab.allan_deviation(np.arange(100.0), 1, kind="total eclipse"),
        lambda c: imulab.allan_deviation(np.arange(100.0), 1, factors=[0]),
        lambda c: imulab.allan_deviation(np.arange(100.0), 1, factors=[1.5]),
        lambda c: imulab.allan_deviation(np.arange(100.0), 1, factors=["a"]),
        lambda c: imulab.trajectory("m.toml", errors=True, unit=c),
        lambda c: imulab.budget("m.toml", grade="navigation", system="LTN-72"),
        lambda c: imulab.budget("m.toml", runs=-1),
        lambda c: imulab.Site(1, 2, 3, 4, 5, 6),
    ],
)
def test_calls(calibration, call):
    expect_clear(lambda: call(calibration))


def test_errors_are_those_of_python():
    assert issubclass(imulab.Error, ValueError) and issubclass(imulab.Unsupported, RuntimeError)
    assert imulab.Error.__module__ == imulab.Unsupported.__module__ == "imulab"


def test_read_only_input_is_fine(calibration):
    rate, _ = calibration.apply(read_only(GOOD), read_only(GOOD))
    assert rate.shape == (N, 3)
