"""Long work: the interpreter's lock, interrupts, progress."""

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest

import imulab


def test_import_is_quick():
    """The median of five new interpreters, in seconds of the processor, less what numpy takes alone."""

    def seconds(code):
        times = [subprocess.run([sys.executable, "-c", f"{code}, time; print(time.process_time())"], check=True, capture_output=True, text=True)
                 for _ in range(5)]
        return sorted(float(run.stdout) for run in times)[2]

    assert seconds("import imulab") - seconds("import numpy") < 0.3 * (5 if "LD_PRELOAD" in os.environ else 1)


def test_import_loads_neither_pandas_nor_matplotlib():
    code = "import imulab, sys; assert not {'pandas', 'matplotlib', 'scipy'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_other_threads_run_meanwhile(by_hand):
    counted = 0
    done = threading.Event()

    def count():
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    imulab.predict(imulab.procedure("zhang-24"), runs=3000)
    done.set()
    thread.join()
    assert counted > 20


def test_progress_rises_to_one():
    told = []
    imulab.predict(imulab.procedure("zhang-24"), runs=3000, progress=told.append)
    assert told and told == sorted(told) and told[-1] == 1 and told[0] >= 0


def test_a_failing_callback_ends_the_work():
    def fail(part):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        imulab.predict(imulab.procedure("zhang-24"), runs=10**6, progress=fail)


def test_interrupt_is_raised_at_once():
    threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    begin = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        imulab.predict(imulab.procedure("zhang-24"), runs=10**8)
    assert time.perf_counter() - begin < 5


def test_interrupted_program_ends():
    """Also where the work knows of no progress: it goes on to its end behind the interpreter's."""
    code = """
import imulab, os, signal, threading
s = imulab.simulate(imulab.procedure("handheld", poses=60), seed=1)
threading.Timer(0.1, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
try:
    while True:
        imulab.calibrate(s, method="handheld")
except KeyboardInterrupt:
    print("interrupted")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0 and done.stdout == "interrupted\n", done.stderr


def test_interrupted_work_stops():
    """The interpreter waits for it at its end: a calibration of an hour, begun anew without end in a thread, and ten million runs."""
    code = """
import imulab, os, signal, sys, threading, time
work = {
    "calibrate": lambda: imulab.calibrate(s, method="hybrid"),
    "predict": lambda: imulab.predict(imulab.procedure("zhang-24"), runs=10**7),
}[sys.argv[1]]
s = imulab.simulate(imulab.procedure("cheng-path", rest=120), seed=1) if sys.argv[1] == "calibrate" else None
threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
try:
    while True:
        work()
except KeyboardInterrupt:
    print(time.time())
"""
    for verb in ("calibrate", "predict"):
        done = subprocess.run([sys.executable, "-c", code, verb], capture_output=True, text=True, timeout=300, check=False)
        assert done.returncode == 0, done.stderr
        assert time.time() - float(done.stdout) < 5, "a second, on a machine that does other things, too"


def test_threads_calibrate_at_the_same_time(by_hand):
    expected = imulab.calibrate(by_hand, method="handheld").values
    found = [None] * 4

    def work(k):
        found[k] = imulab.calibrate(by_hand, method="handheld").values

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(values == expected for values in found)


def test_arrays_may_go_away():
    def made():
        gyro = np.zeros((100, 3))
        return imulab.Recording.from_arrays(np.arange(1, 101) / 10, gyro, gyro + 9.8)

    recording = made()
    assert (recording.accel == 9.8).all()
    view = recording.accel
    del recording
    assert (view == 9.8).all()


def test_an_executors_workers_give_the_same_bits(tmp_path):
    procedure = imulab.procedure("zhang-24")
    mission = tmp_path / "mission.toml"
    mission.write_text(
        'format = "imulab.mission/1"\nrate_hz = 10\n[start]\nlatitude_deg = 45\nlongitude_deg = 8\nheight_m = 400\nspeed_mps = 100\n'
        '[[segment]]\nkind = "straight"\nduration_s = 60\n[errors]\ngrade = "navigation"\n'
    )
    told = []
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as executor:  # a fork beside threads may wait forever
        assert imulab.predict(procedure, runs=1000, executor=executor, parts=3, progress=told.append).json == imulab.predict(procedure, runs=1000).json
        assert imulab.budget(mission, runs=20, executor=executor).json == imulab.budget(mission, runs=20).json
        for wrong, options in {
            "parts: 0": {"parts": 0},
            "divides a Monte Carlo": {"runs": 0, "parts": 2},
            "belongs to method turntable": {"method": "handheld", "parts": 2},
        }.items():
            with pytest.raises(imulab.Error, match=wrong):
                imulab.predict(procedure, executor=executor, **options)
        with pytest.raises(imulab.Error, match="belongs to the budget of one grade"):
            imulab.budget(mission, grade=["tactical", "navigation"], executor=executor, parts=2)
    assert told == [1 / 3, 2 / 3, 1]
    for options in ({"executor": 2}, {"parts": 2}, {"executor": executor, "parts": True}):
        with pytest.raises(TypeError, match="executor|parts"):
            imulab.predict(procedure, **options)
