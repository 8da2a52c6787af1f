"""A ULog written byte by byte from the specification (https://docs.px4.io/main/en/dev_log/ulog_file_format.html). pyulog 1.2 reads the same values from
it: ulog2csv gives sensor_accel of instances 0 and 1, sensor_combined, nested; ulog_info gives 1 dropout of 0.030 s."""
import struct
from imu import *

SYNC = bytes([0x2F, 0x73, 0x13, 0x20, 0x25, 0x0C, 0xBB, 0x12])


def message(kind, payload):
    return struct.pack("<HB", len(payload), ord(kind)) + payload


def us(i):
    return 8000 * (i + 1)


def definitions():
    out = b""
    for text in [
        "sensor_accel:uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;float temperature;uint8_t[4] clip;",
        "sensor_combined:uint64_t timestamp;float[3] gyro_rad;int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;uint8_t[4] _padding0;",
        "part:int16_t raw;char[3] name;uint8_t[1] _padding0;",
        "nested:uint64_t timestamp;part[2] parts;double rate;",
        "never_logged:uint64_t timestamp;float x;",
    ]:
        out += message("F", text.encode())
    key = b"char[3] sys_name"
    out += message("I", bytes([len(key)]) + key + b"PX4")
    return out + subscriptions()


def subscriptions():
    out = b""
    for i, (multi, name) in enumerate([(0, "sensor_accel"), (1, "sensor_accel"), (0, "sensor_combined"), (0, "nested"), (0, "never_logged")]):
        out += message("A", struct.pack("<BH", multi, i) + name.encode())
    return out


def samples(first, last):
    out = b""
    for i in range(first, last):
        for instance in range(2):
            a = [x + instance for x in accel(i)]
            out += message("D", struct.pack("<HQQIffff4B", instance, us(i), us(i) - 500, 1310988, *a, 25.5, 1, 2, 3, 4))
        out += message("D", struct.pack("<HQfffifff", 2, us(i), *gyro(i), -300, *accel(i)))  # without the padding at the end
        if i % 4 == 0:
            c = counts(i)
            out += message("D", struct.pack("<HQh3sBh3sBd", 3, us(i), c[0], b"one", 0, c[1], b"two", 0, 125.0))
        if i == 10:
            out += message("O", struct.pack("<H", 30)) + message("S", SYNC) + message("L", struct.pack("<BQ", ord("6"), us(i)) + b"hello")
    return out


head = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 112500000)
plain = head + message("B", bytes(40)) + definitions() + samples(0, SAMPLES)
open("px4.ulg", "wb").write(plain)

# The same, where the logger died inside a message after 30 samples and the others were appended.
cut = (message("D", bytes(40)))[:25]
body = definitions() + samples(0, 30) + cut
offset = len(head) + 43 + len(body)
flags = message("B", bytes(8) + b"\x01" + bytes(7) + struct.pack("<QQQ", offset, 0, 0))
open("px4_appended.ulg", "wb").write(head + flags + body + subscriptions() + samples(30, SAMPLES))
