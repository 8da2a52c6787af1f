"""Several IMUs on one body, moved by hand. It shares no code with imulab: motion, mounting and errors are written down here once more.

Body axes are those of the first IMU. Its origin moves on sums of sines, its attitude follows rates that are sums of sines."""

import numpy as np

GRAVITY = np.array([0, 0, -9.81])
STEP = 1 / 2000


def cross(w):
    return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def rotation(vector):
    angle = np.linalg.norm(vector)
    if angle < 1e-12:
        return np.eye(3) + cross(vector)
    k = cross(vector / angle)
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


class Sines:
    """A vector of sums of sines, with its derivatives."""

    def __init__(self, random, size, low_hz, high_hz, terms=5):
        self.frequency = 2 * np.pi * random.uniform(low_hz, high_hz, (3, terms))
        self.phase = random.uniform(0, 2 * np.pi, (3, terms))
        self.amplitude = size * random.uniform(0.3, 1, (3, terms)) / np.sqrt(terms / 2)

    def at(self, t, derivative=0):
        angle = self.frequency[:, :, None] * t + self.phase[:, :, None] + derivative * np.pi / 2
        return (self.amplitude[:, :, None] * self.frequency[:, :, None] ** derivative * np.sin(angle)).sum(1).T


class Motion:
    """Rates and forces at the first IMU's origin, at equal steps."""

    def __init__(self, random, seconds, rate=1.5, way=0.15, axis=None, drive=False, plane=False):
        self.t = np.arange(-1, seconds + 1, STEP)
        rates, path = Sines(random, rate, 0.2, 3), Sines(random, way, 0.2, 2)
        if drive:  # turns about the vertical, a road that tilts the vehicle, and speed
            rates, path = Sines(random, 0.3, 0.02, 0.1), Sines(random, 5, 0.02, 0.15)
            rates.amplitude[:2] *= 0.1
        if plane:  # a robot on a floor
            rates.amplitude[:2] = path.amplitude[2] = 0
        self.place, self.attitude = path.at(self.t), np.empty((len(self.t), 3, 3))
        self.rate, self.rate_slope, acceleration = rates.at(self.t), rates.at(self.t, 1), path.at(self.t, 2)
        if axis is not None:  # turns about one axis alone
            axis = np.array(axis) / np.linalg.norm(axis)
            self.rate, self.rate_slope = self.rate @ np.outer(axis, axis), self.rate_slope @ np.outer(axis, axis)
        attitude, self.force = rotation(random.normal(size=3) * (not plane)), np.empty_like(self.rate)  # attitude: from body to level axes
        for i in range(len(self.t)):
            self.attitude[i] = attitude
            self.force[i] = attitude.T @ (acceleration[i] - GRAVITY)
            middle = self.rate[i] + 0.5 * STEP * self.rate_slope[i]
            attitude = attitude @ rotation(STEP * middle)

    def at_place(self, arm):
        w, slope = self.rate, self.rate_slope
        return self.force + np.cross(slope, arm) + np.cross(w, np.cross(w, arm))


class Integral:
    """Means over intervals of a quantity given at equal steps: the integral between steps is a cubic."""

    def __init__(self, t, values):
        slope = np.gradient(values, STEP, axis=0)
        parts = STEP * (values[1:] + values[:-1]) / 2 - STEP**2 / 12 * (slope[1:] - slope[:-1])
        self.t, self.values = t, values
        self.sum = np.vstack([np.zeros(3), np.cumsum(parts, axis=0)])

    def at(self, times):
        i = np.clip(((times - self.t[0]) / STEP).astype(int), 0, len(self.t) - 2)
        u = ((times - self.t[i]) / STEP)[:, None]
        p0, p1, m0, m1 = self.sum[i], self.sum[i + 1], STEP * self.values[i], STEP * self.values[i + 1]
        return p0 * (2 * u**3 - 3 * u**2 + 1) + m0 * (u**3 - 2 * u**2 + u) + p1 * (3 * u**2 - 2 * u**3) + m1 * (u**3 - u**2)

    def means(self, begin, end):
        return (self.at(end) - self.at(begin)) / (end - begin)[:, None]


class Grade:
    """One sigma of what an IMU departs by, as docs/reference/grades.md has it; noise densities of better ones."""

    def __init__(self, scale, misalignment, gyro_bias, accel_bias, g_sensitivity, gyro_noise, accel_noise):
        self.scale, self.misalignment, self.gyro_bias, self.accel_bias = scale, misalignment, gyro_bias, accel_bias
        self.g_sensitivity, self.gyro_noise, self.accel_noise = g_sensitivity, gyro_noise, accel_noise


DEG = np.pi / 180
GRADES = {
    "mems": Grade(0.01, 0.01, 1 * DEG, 0.3, 0.05 * DEG / 9.8, 0.005 * DEG, 1e-3),
    "tactical": Grade(1.5e-4, 60 / 206265, 3 / 3600 * DEG, 3e-3, 0.3 / 3600 * DEG / 9.8, 0.05 / 60 * DEG, 3e-4),
}


class Imu:
    """Where an IMU is, how its clock runs, and what is wrong with it."""

    def __init__(self, random, grade, rate_hz, first=False, arm=0.3, clock=0.05, drift=100e-6, delay=0):
        g = GRADES[grade]
        self.grade, self.rate_hz = grade, rate_hz
        self.rotation = np.eye(3) if first else rotation(random.normal(size=3) * 1.5)
        self.arm = np.zeros(3) if first else random.uniform(-arm, arm, 3)
        self.offset = 0 if first else random.uniform(-clock, clock)
        self.drift = 0 if first else random.uniform(-drift, drift)
        self.delay = 0 if first else delay
        draw = lambda sigma: np.diag(random.normal(size=3) * sigma.scale) + (1 - np.eye(3)) * random.normal(size=(3, 3)) * sigma.misalignment
        self.gyro, self.accel = np.eye(3) + draw(g), np.eye(3) + np.tril(draw(g))
        self.sensitivity = random.normal(size=(3, 3)) * g.g_sensitivity
        self.gyro_bias, self.accel_bias = random.normal(size=3) * g.gyro_bias, random.normal(size=3) * g.accel_bias

    def read(self, random, motion, seconds, bend=None):
        """Stamps on its clock (s), rates and forces. bend: what an elastic mount adds to the rates."""
        g = GRADES[self.grade]
        h = 1 / self.rate_hz
        stamps = np.arange(random.uniform(0, h), seconds, h)
        on_first = lambda stamp: (stamp - self.offset) - self.drift * (stamp - self.offset - seconds / 2)
        begin, end = on_first(stamps - h), on_first(stamps)
        true_rate = motion.rate if bend is None else motion.rate + bend(motion)
        rate = Integral(motion.t, true_rate).means(begin, end) @ self.rotation.T
        place = Integral(motion.t, motion.at_place(self.arm))
        force = place.means(begin - self.delay, end - self.delay) @ self.rotation.T
        root = np.sqrt(self.rate_hz)
        return (stamps, rate @ self.gyro.T + force @ self.sensitivity.T + self.gyro_bias + random.normal(size=rate.shape) * g.gyro_noise * root,
                force @ self.accel.T + self.accel_bias + random.normal(size=force.shape) * g.accel_noise * root)


class Tracker:
    """Poses of markers on the body in a frame of their own, on their own clock."""

    def __init__(self, random, rate_hz=100, way=1e-3, angle=0.05 * DEG, frame="free", arm=0.2, clock=0.05, drift=50e-6):
        self.rate_hz, self.way, self.angle = rate_hz, way, angle
        yaw = rotation(np.array([0, 0, random.uniform(-np.pi, np.pi)]))
        self.frame = rotation(random.normal(size=3)) if frame == "free" else yaw  # from level axes to the frame
        self.body = rotation(random.normal(size=3) * 1.5)  # from the axes of the markers to those of the IMU
        self.arm = random.uniform(-arm, arm, 3)
        self.offset, self.drift = random.uniform(-clock, clock), random.uniform(-drift, drift)

    def read(self, random, motion, seconds):
        """Stamps, positions and quaternions x, y, z, w."""
        stamps = np.arange(random.uniform(0, 1 / self.rate_hz), seconds, 1 / self.rate_hz)
        times = (stamps - self.offset) - self.drift * (stamps - self.offset - seconds / 2)
        at = ((times - motion.t[0]) / STEP).astype(int)
        rest = times - motion.t[at]
        places, quaternions = [], []
        speed = np.gradient(motion.place, STEP, axis=0)
        for i, dt in zip(at, rest):
            attitude = motion.attitude[i] @ rotation(dt * (motion.rate[i] + dt / 2 * motion.rate_slope[i]))
            place = motion.place[i] + dt * speed[i] + attitude @ self.arm
            places.append(self.frame @ place + random.normal(size=3) * self.way)
            quaternions.append(quaternion(self.frame @ attitude @ self.body @ rotation(random.normal(size=3) * self.angle)))
        return stamps, np.array(places), np.array(quaternions)


def quaternion(c):
    """x, y, z, w of a rotation matrix (Shepperd 1978)."""
    four = np.array([c[0, 0] - c[1, 1] - c[2, 2], c[1, 1] - c[0, 0] - c[2, 2], c[2, 2] - c[0, 0] - c[1, 1], np.trace(c)]) + 1
    k = int(np.argmax(four))
    s = c + c.T
    rows = [
        [four[0], s[0, 1], s[0, 2], c[2, 1] - c[1, 2]],
        [s[0, 1], four[1], s[1, 2], c[0, 2] - c[2, 0]],
        [s[0, 2], s[1, 2], four[2], c[1, 0] - c[0, 1]],
        [c[2, 1] - c[1, 2], c[0, 2] - c[2, 0], c[1, 0] - c[0, 1], four[3]],
    ]
    return np.array(rows[k]) / (2 * np.sqrt(four[k]))


def write_poses(path, stamps, places, quaternions):
    with open(path, "w") as file:
        file.write("# timestamp tx ty tz qx qy qz qw\n")
        for row in np.column_stack([stamps, places, quaternions]):
            file.write(f"{row[0]:.9f} " + " ".join(f"{v:.7f}" for v in row[1:]) + "\n")


def write(path, stamps, rate, force):
    with open(path, "w") as file:
        file.write("time_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,accel_x_m_s2,accel_y_m_s2,accel_z_m_s2\n")
        for row in np.column_stack([stamps, rate, force]):
            file.write(f"{row[0]:.9f}," + ",".join(f"{v:.8f}" for v in row[1:]) + "\n")


def session(path, names, grade):
    with open(path, "w") as file:
        file.write('format = "imulab.session/1"\n[imu]\nname = "body"\n' + f'grade = "{grade}"\n')
        for name, rate_hz in names:
            file.write(f'[[recording]]\nfile = "{name}.csv"\nimu = "{name}"\nrate_hz = {rate_hz}\n')
            file.write('time = { column = "time_s", unit = "s" }\n')
            for triad, unit, columns in (("gyro", "rad/s", "gyro_{}_rad_s"), ("accel", "m/s^2", "accel_{}_m_s2")):
                file.write(f"[recording.{triad}]\noutput = \"rate\"\nunit = \"{unit}\"\ncolumns = [" + ", ".join(f'"{columns.format(a)}"' for a in "xyz") + "]\n")
