"""What the fixtures of bags hold: the same messages in every format, from integers alone, so that every program makes the same numbers."""

RATE = 200                 # Hz
FIRST_NS = 1_700_000_000_123_456_789
INTERVAL_NS = 5_000_000
SAMPLES = 60
IMAGE_EVERY = 20           # a camera image comes with every twentieth sample
TEMPERATURE_EVERY = 10
SPARSE_SAMPLES = 4         # of a bag with one large picture among them, in a chunk of its own size
SPARSE_IMAGE = 40_000


def stamp_ns(i):
    return FIRST_NS + i * INTERVAL_NS


def log_ns(i):
    """When it was logged: 1 ms after its stamp, and i microseconds."""
    return stamp_ns(i) + 1_000_000 + 1000 * i


def gyro(i):
    return [(i - 30) / 1024, (7 * i % 16) / 512, -i / 256]


def accel(i):
    return [i / 64, -(i % 5) / 32, 9.8125]


def orientation(i):
    return [0, 0, 0, 1]


def covariance(first):
    return [first, 0, 0, 0, first, 0, 0, 0, first]


def temperature(i):
    return 20 + i / 16


def image(i, size=768):
    """A fake picture: not all compressible."""
    state, out = i + 1, bytearray()
    for _ in range(size):
        state = (1103515245 * state + 12345) % 2**31
        out.append(state >> 16 & 255 if _ % 2 else 7)
    return bytes(out)
