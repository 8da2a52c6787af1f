"""The samples of all files here, exact in single precision: 40 samples at 125 Hz."""

SAMPLES = 40
FIRST_NS = 1_700_000_000_000_000_000


def stamp_ns(i):
    return FIRST_NS + 8_000_000 * (i + 1)


def t(i):
    return 8 * (i + 1) / 1000


def gyro(i):  # rad/s
    return [(64 * (k + 1) + i) / 1024 for k in range(3)]


def accel(i):  # m/s^2
    return [(9.75 if k == 2 else 0) + (i - 8 * k) / 256 for k in range(3)]


def counts(i):  # an integer for each gyro
    return [1000 * (k + 1) - 7 * i for k in range(3)]


def rows():
    return [[t(i), *gyro(i), *accel(i)] for i in range(SAMPLES)]
