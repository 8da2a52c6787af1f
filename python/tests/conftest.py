"""Common to the tests: a session by hand, simulated once, and the command."""

import json
import os
import subprocess

import numpy as np
import pytest

import imulab


@pytest.fixture(scope="session")
def hand_session(tmp_path_factory):
    """A folder with a session by hand: 24 rests, its truth beside it."""
    folder = tmp_path_factory.mktemp("sessions") / "by-hand"
    imulab.simulate(imulab.procedure("handheld", poses=24, seed=3), seed=5, output=folder)
    return folder


@pytest.fixture(scope="session")
def by_hand():
    """That session in memory."""
    return imulab.simulate(imulab.procedure("handheld", poses=24, seed=3), seed=5)


@pytest.fixture(scope="session")
def calibration(by_hand):
    return imulab.calibrate(by_hand, method="handheld")


@pytest.fixture(scope="session")
def rest_log():
    """Ten minutes at rest: 100 Hz, white noise alone."""
    random = np.random.default_rng(1)
    n = 60_000
    return imulab.Recording.from_arrays(
        np.arange(1, n + 1) / 100, 1e-3 * random.standard_normal((n, 3)), [0, 0, 9.8] + 1e-2 * random.standard_normal((n, 3))
    )


@pytest.fixture
def environment():
    """For programs that a test starts, without the libraries that the interpreter itself has to load first."""
    return {k: v for k, v in os.environ.items() if k != "LD_PRELOAD"}


@pytest.fixture
def command(environment):
    """Runs the command; its JSON."""

    def run(*arguments, code=0):
        done = subprocess.run([os.environ["IMULAB_COMMAND"], *map(str, arguments)], capture_output=True, text=True, check=False, env=environment)
        assert done.returncode == code, done.stderr
        return json.loads(done.stdout)

    return run
