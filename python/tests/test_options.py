"""The keywords of a function are the options of the command's verb: one table has both."""

import inspect
import math
import os
import re
import subprocess

import imulab
import pytest
from imulab import _imulab

VERBS = ["calibrate", "compare", "verify", "simulate", "predict", "plan", "noise", "trajectory", "navigate", "budget", "extrinsics"]


@pytest.mark.parametrize("verb", VERBS)
def test_keywords_are_those_of_the_table(verb):
    function = getattr(imulab, verb)
    code = function.__code__
    special = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]  # of a type of its own in Python
    signature = inspect.signature(function)
    rows = _imulab.keywords()[verb]
    assert rows
    for name, kind, default, meaning in rows:
        parameter = signature.parameters[name]
        if name not in special:
            assert (parameter.annotation, parameter.default) == (kind, default)
            assert f"{name}: {_imulab.in_keywords(meaning)}" in function.__doc__


@pytest.mark.parametrize("verb", VERBS)
def test_keywords_are_options_of_the_command(verb, environment):
    """Help of the command names each of them, with the same words."""
    done = subprocess.run([os.environ["IMULAB_COMMAND"], verb, "--help"], capture_output=True, text=True, check=True, env=environment)
    flat = re.sub(r"\s+", " ", done.stdout)
    for name, _, _, meaning in _imulab.keywords()[verb]:
        option = "--" + name.removesuffix("_deg").replace("_", "-")
        assert option in flat and meaning in flat


def test_an_export_has_the_options_of_its_target(calibration):
    assert "q15" in calibration.to("c-header", q15=True, input_accel="g")
    with pytest.raises(imulab.Error, match="^to csv: has none of the options of c-header"):
        calibration.to("csv", fixed_point=True)
    with pytest.raises(imulab.Error, match="^target: nowhere; expected .*kalibr"):
        calibration.to("nowhere")
    with pytest.raises(TypeError, match="unexpected keyword argument 'force'"):
        calibration.to("csv", force=True)


def test_wrong_keywords(by_hand):
    with pytest.raises(TypeError, match="unexpected keyword argument 'colour'"):
        imulab.calibrate(by_hand, method="handheld", colour="red")
    with pytest.raises(TypeError, match="seed: expected int, got float"):
        imulab.predict(imulab.procedure("zhang-24"), seed=1.5)
    with pytest.raises(imulab.Error, match="latitude_deg: 100; expected -90 to 90"):
        imulab.plan("gyro.offset <= 1 deg/h", latitude_deg=100)


def test_a_wrong_value_is_named_with_its_keyword(by_hand):
    procedure = imulab.procedure("handheld")
    with pytest.raises(imulab.Error, match="^terms full: only the method whole-unit takes it"):
        imulab.calibrate(by_hand, method="static", terms="full")
    with pytest.raises(imulab.Error, match="^axes: bogus; expected"):
        imulab.plan("gyro.offset <= 5 deg/h", axes=["bogus"])
    with pytest.raises(imulab.Error, match="^heading_sigma: belongs to"):
        imulab.navigate(None, by_hand, heading_sigma_deg=1)
    with pytest.raises(imulab.Error, match="^classical: belongs to"):
        imulab.predict(procedure, method="static", classical=True)
    with pytest.raises(imulab.Error, match='^grade: grade = "nosuch": unknown'):
        imulab.simulate(procedure, grade="nosuch")
    with pytest.raises(TypeError, match="method: expected str, got int"):
        imulab.calibrate(by_hand, method=5)
    with pytest.raises(TypeError, match="refuse_gaps: expected a bool"):
        imulab.navigate(None, by_hand, refuse_gaps="x")
    with pytest.raises(imulab.Error, match="contradict each other"):
        imulab.navigate(None, by_hand, gaps="integrate", refuse_gaps=True)
    imulab.predict(procedure, method="static", require="")  # the same as none


def test_noise_of_a_data_sheet_needs_no_recording():
    noise = imulab.noise(datasheet="gyro.N = 0.0038 deg/s/sqrt(Hz), gyro.stability = 10 deg/h")
    N = noise.axis("gyro.z")["coefficients"]["N"]
    assert N["value"] == pytest.approx(0.0038 * math.pi / 180, rel=1e-12)
    assert noise["source"] == "data sheet" and "gyro N 0.228 deg/sqrt(h)" in str(noise)
    with pytest.raises(TypeError, match="expected a recording or a session; without them datasheet="):
        imulab.noise()
    with pytest.raises(imulab.Error, match="require: judges a log"):
        imulab.noise(datasheet="gyro.N = 1 deg/sqrt(h)", require="gyro.N <= 1 deg/sqrt(h)")
