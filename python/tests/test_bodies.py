"""Several IMUs on one body: where they are, and their calibrations together."""

import numpy as np
import pytest

import imulab

ARM = np.array([0.1, -0.2, 0.05])
TURN = np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])  # by 90 deg about z, from the axes of the first to those of the second


@pytest.fixture(scope="module")
def body():
    """Two recordings of one motion."""
    random = np.random.default_rng(1)
    t = np.arange(1, 4001) / 100
    sines = [(1.2, 3.1, 0), (1.0, 5.3, 1), (1.4, 4.3, 2), (0.6, 9.4, 3), (0.5, 8.6, 4), (0.7, 7.9, 5)]
    rate = np.column_stack([sum(a * np.sin(f * (t - 0.005) + p) for a, f, p in sines[i::3]) for i in range(3)])
    slope = np.column_stack([sum(a * f * np.cos(f * (t - 0.005) + p) for a, f, p in sines[i::3]) for i in range(3)])
    force = np.column_stack([3 * np.sin(2.3 * t), 5 * np.cos(3.7 * t), 9.8 + np.sin(4.9 * t)])
    there = force + np.cross(slope, ARM) + np.cross(rate, np.cross(rate, ARM))
    noise = lambda size: size * random.standard_normal(rate.shape)
    return [imulab.Recording.from_arrays(t, w + noise(1e-3), f + noise(1e-2)) for w, f in ((rate, force), (rate @ TURN.T, there @ TURN.T))]


def test_mounting(body):
    found = imulab.extrinsics(*body, names=["left", "right"])
    assert (found.data["verdict"], found["imus"]) == ("good", ["left", "right"])
    [m] = found.mountings
    u = np.sqrt(np.diag(m.covariance))
    assert np.all(np.abs(m.lever_arm - ARM) < 4 * u[3:6]) and np.all(u[3:6] < 0.005)
    np.testing.assert_allclose(m.matrix[:3, :3], TURN, atol=4 * u[:3].max())
    np.testing.assert_allclose(m.matrix @ [*m.lever_arm, 1], [0, 0, 0, 1], atol=1e-12)
    assert m.not_shown == [] and abs(m.clock_offset) < 1e-4
    assert "right relative to left" in str(found)
    with pytest.raises(ValueError):
        m.matrix[0, 0] = 1


def test_wrong_arguments(body, calibration):
    with pytest.raises(TypeError, match="two or more recordings"):
        imulab.extrinsics(body[0])
    with pytest.raises(TypeError, match="calibrations: expected 2"):
        imulab.extrinsics(*body, calibrations=[calibration])
    with pytest.raises(TypeError, match="names: expected a list of 2"):
        imulab.extrinsics(*body, names="ab")
    with pytest.raises(imulab.Error, match="one: two IMUs have this name"):
        imulab.extrinsics(*body, names=["one", "one"])
    with pytest.raises(TypeError, match="two or more calibrations"):
        imulab.calibrate_jointly(calibration)


def test_calibrations_together(by_hand, calibration, tmp_path):
    random = np.random.default_rng(2)
    r = by_hand.recordings[0]
    noise = lambda size: size * random.standard_normal(r.gyro.shape)
    turned = imulab.Recording.from_arrays(r.t, (r.gyro + noise(1e-4)) @ TURN.T, (r.accel + noise(1e-3)) @ TURN.T)
    other = imulab.calibrate(turned, site=imulab.Site(gravity_mps2=9.80665), imu={"name": "right", "grade": "mems"}, method="handheld")
    found = imulab.calibrate_jointly(calibration, other, names=["left", "right"])
    for before, after in zip((calibration, other), found):
        assert any(f["code"] in ("joint-estimate", "imus-contradict", "not-joint") for f in after.findings)
        assert all(after.sigma[name] <= u * (1 + 1e-9) for name, u in before.sigma.items() if u)
    calibration.save(tmp_path / "c.json")
    with pytest.raises(imulab.Error, match="left: has no recordings"):
        imulab.calibrate_jointly(imulab.read_calibration(tmp_path / "c.json"), other, names=["left", "right"])
