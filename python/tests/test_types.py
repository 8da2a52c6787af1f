"""Type hints: complete and true."""

import os
import pathlib
import subprocess
import sys

import imulab
import pytest

pytest.importorskip("mypy")
package = pathlib.Path(os.environ["IMULAB_SOURCE"]) / "python"


def run(*arguments, folder):
    environment = {k: v for k, v in os.environ.items() if k != "LD_PRELOAD"}
    return subprocess.run([sys.executable, "-m", *arguments], capture_output=True, text=True, check=False, cwd=folder, env=environment)


def test_hints_are_complete(tmp_path):
    done = run("mypy", "--strict", "--cache-dir", str(tmp_path), "imulab", folder=package)
    assert done.returncode == 0, done.stdout


@pytest.mark.skipif("LD_PRELOAD" in os.environ, reason="loads the extension in an interpreter of its own")
def test_hints_are_those_of_the_extension(tmp_path):
    done = run("mypy.stubtest", "imulab._imulab", "--allowlist", str(pathlib.Path(__file__).parent / "stubtest_allowlist.txt"), folder=tmp_path)
    assert done.returncode == 0, done.stdout


@pytest.mark.skipif("LD_PRELOAD" in os.environ, reason="the hints are beside the extension without sanitizers")
def test_a_program_is_checked(tmp_path):
    """Wrong types are found by a checker, right ones are not."""
    program = tmp_path / "program.py"
    program.write_text(
        "import imulab\n"
        "c = imulab.read_calibration('c.json')\n"
        "x: float = c.values['accel.offset.x']\n"
        "y: str = c.verdict\n"
        "imulab.calibrate('log.csv', method=3)\n"
        "z: int = c.covariance\n"
        "imulab.predict('p.toml', runs=200, seed='x')\n"
        "imulab.predict('p.toml', colour=3)\n"
        "imulab.navigate(None, 'x', vertical=3)\n"
        "imulab.plan('gyro.offset <= 1 deg/h', latitude_deg=47.4).report('plan.html')\n"
        "imulab.budget('m.toml', grade=['navigation', 'tactical']).budgets['tactical']\n"
        "imulab.budget('m.toml', grade=3)\n"
        "sigma: float = c.gyro.sigma.offset[0]\n"
    )
    environment = dict(os.environ, MYPYPATH=str(pathlib.Path(imulab.__file__).parent.parent))  # as it is built: the hints of options are written then
    environment.pop("LD_PRELOAD", None)
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--cache-dir", str(tmp_path / "cache"), str(program)], capture_output=True, text=True, check=False, env=environment
    )
    wrong = sorted(int(line.split(":")[1]) for line in done.stdout.splitlines() if "error" in line and "program.py" in line)
    assert wrong == [5, 6, 7, 8, 9, 12], done.stdout


def test_everything_public_says_what_it_is():
    for name in imulab.__all__:
        thing = getattr(imulab, name)
        assert thing.__doc__, name
        for member, value in vars(thing).items() if isinstance(thing, type) else []:
            if not member.startswith("_") and callable(value):
                assert value.__doc__, f"{name}.{member}"
