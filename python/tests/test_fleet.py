"""Fleets, as the command has them."""

import multiprocessing
from concurrent.futures import ProcessPoolExecutor

import imulab
import pytest


@pytest.fixture(scope="module")
def week(tmp_path_factory):
    """A folder with sessions of 28 units."""
    folder = tmp_path_factory.mktemp("fleet") / "week"
    folder.mkdir()
    procedure = imulab.procedure("handheld", poses=15, seed=3)
    for unit in range(28):
        procedure.save(folder / "p.toml")
        text = (folder / "p.toml").read_text().replace("[imu]", f'[imu]\nserial = "{unit}"', 1)
        (folder / "p.toml").write_text(text)
        imulab.simulate(imulab.read_session(folder / "p.toml"), seed=unit + 1, output=folder / f"unit{unit}")
    (folder / "p.toml").unlink()
    return folder


@pytest.fixture(scope="module")
def fleet(week):
    fleet = imulab.Fleet(week / "fleet.db")
    counts = fleet.calibrate(week, method="handheld", station="A")
    assert counts == {"sessions": 28, "calibrated": 28, "skipped": 0, "failed": 0, "failed_before": 0, "failures": []}
    return fleet


def test_it_is_the_commands_store(fleet, week, command):
    assert fleet.calibrate(week, method="handheld")["skipped"] == 28
    assert len(fleet.units) == 28
    assert {u["station"] for u in fleet.units} == {"A"}
    assert fleet.statistics(require="accel.offset <= 100 mg").data == command(
        "fleet", "stats", "--store", fleet.store, "--require", "accel.offset <= 100 mg", "--json"
    )
    assert fleet.check() == ([], [])


def test_an_executors_workers_make_the_same_store(fleet, week, tmp_path):
    again = imulab.Fleet(tmp_path / "again.db")
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as executor:
        counts = again.calibrate(week, method="handheld", station="A", executor=executor, parts=3)
        assert (counts["sessions"], counts["calibrated"], counts["skipped"]) == (28, 28, 0)
    # One more time in this process: nothing is left to do.
    assert again.calibrate(week, method="handheld", station="A")["skipped"] == 28
    assert again.to_frame().drop(columns="added", errors="ignore").equals(fleet.to_frame().drop(columns="added", errors="ignore"))


def test_it_is_a_prior(fleet, week, command):
    plain = imulab.calibrate(week / "unit3", method="handheld")
    own = imulab.calibrate(week / "unit3", method="handheld", prior=fleet)
    printed = command("calibrate", week / "unit3", "--method", "handheld", "--prior", fleet.store, "--json")
    for data in (printed, made := dict(own.data)):
        data.pop("created")
    assert made == printed
    name = "accel.offset.x"
    assert own.sigma[name] <= plain.sigma[name]
    require = "gyro.matrix.diagonal <= 2000 ppm"
    planned = imulab.plan(require, grade="mems", by_hand=True, prior=fleet.store)
    assert planned.data == command("plan", "--require", require, "--grade", "mems", "--axes", "hand", "--prior", fleet.store, "--json")
    alone, with_prior = (imulab.predict(imulab.procedure("handheld", poses=15), method="handheld", prior=p) for p in (None, fleet))
    assert with_prior.sigma["gyro.matrix.xx"] < alone.sigma["gyro.matrix.xx"]
    own.save(week / "with-prior.json")
    with pytest.raises(imulab.Error, match="was calibrated with a fleet's prior"):
        fleet.add(week / "with-prior.json")


def test_bad_input(fleet, tmp_path):
    with pytest.raises(imulab.Error, match="none.db"):
        imulab.Fleet(tmp_path / "none.db").units
    with pytest.raises(imulab.Error, match="false_alarm"):
        fleet.statistics(false_alarm=2)
    with pytest.raises(imulab.Error, match="apples"):
        fleet.statistics(require="accel.offset <= 10 apples")
    with pytest.raises(TypeError):
        imulab.Fleet(3)
    with pytest.raises(TypeError):
        fleet.calibrate(method="handheld")
    with pytest.raises(TypeError):
        fleet.add()
    with pytest.raises(imulab.Error, match="no session"):
        fleet.calibrate(tmp_path, method="handheld")
    (tmp_path / "text.db").write_text("no store at all, but some text that is long enough")
    with pytest.raises(imulab.Error):
        imulab.calibrate(tmp_path, method="handheld", prior=tmp_path / "text.db")


def test_a_servers_password_is_not_shown():
    fleet = imulab.Fleet("postgresql://ada:secret@/fleet?host=/nowhere")
    assert repr(fleet) == "<imulab.Fleet: postgresql://ada:***@/fleet?host=/nowhere>"
    with pytest.raises(imulab.Error) as error:  # no such server, or no libpq
        fleet.check()
    assert "secret" not in str(error.value)
