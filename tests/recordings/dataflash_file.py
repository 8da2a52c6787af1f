"""A DataFlash log written byte by byte as ArduPilot's libraries/AP_Logger/LogStructure.h lays messages out. pymavlink's DFReader reads the same values
from it (it leaves TimeUS in microseconds and the multipliers of FMTU to the reader)."""
import struct
from imu import *

ID = {"FMT": 128, "UNIT": 129, "MULT": 130, "FMTU": 131, "IMU": 10, "ATT": 11, "OLD": 12}
STRUCT = {"b": "b", "B": "B", "h": "h", "H": "H", "i": "i", "I": "I", "f": "f", "d": "d", "Q": "Q", "q": "q", "n": "4s", "N": "16s", "Z": "64s",
          "c": "h", "C": "H", "e": "i", "E": "I", "L": "i", "M": "B", "a": "64s"}


def message(name, *values):
    return b"\xA3\x95" + bytes([ID[name]]) + struct.pack("<" + "".join(STRUCT[c] for c in FORMAT[name][0]), *values)


FORMAT = {
    "FMT": ("BBnNZ", "Type,Length,Name,Format,Columns"),
    "UNIT": ("QbZ", "TimeUS,Id,Label"),
    "MULT": ("Qbd", "TimeUS,Id,Mult"),
    "FMTU": ("QBNN", "TimeUS,FmtType,UnitIds,MultIds"),
    "IMU": ("QBffffffIhQ", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,T,SampleUS"),
    "ATT": ("QccCeLna", "TimeUS,DesRoll,Roll,Yaw,Far,Lat,Mode,Raw"),
    "OLD": ("IhhM", "TimeMS,GX,GY,Mode"),
}
UNITS = {"s": "s", "#": "instance", "E": "rad/s", "o": "m/s/s", "O": "degC", "d": "deg", "D": "deglatitude", "-": ""}
MULTS = {"-": 0, "0": 1, "F": 1e-6, "B": 1e-2, "C": 1e-3, "G": 1e-7}

out = b""
for name, (fmt, labels) in FORMAT.items():
    length = 3 + struct.calcsize("<" + "".join(STRUCT[c] for c in fmt))
    out += message("FMT", ID[name], length, name.encode(), fmt.encode(), labels.encode())
for key, label in UNITS.items():
    out += message("UNIT", 100, ord(key), label.encode())
for key, factor in MULTS.items():
    out += message("MULT", 100, ord(key), factor)
out += message("FMTU", 100, ID["IMU"], b"s#EEEooo-Os", b"F-000000-CF")  # T: thousandths of a degree
out += message("FMTU", 100, ID["ATT"], b"sdddmD--", b"FBBBBG--")
for i in range(SAMPLES):
    us = 8000 * (i + 1)
    for sensor in range(2):
        g = gyro(i)
        a = [x + sensor for x in accel(i)]
        out += message("IMU", us, sensor, *g, *a, 0, 25000 + i, us - 500)
    if i % 4 == 0:
        out += message("ATT", us, 100 * i, -50 * i, 35999, 123456 + i, 473000000 + i, b"HOLD", struct.pack("<32h", *range(i, i + 32)))
        out += message("OLD", us // 1000, counts(i)[0], counts(i)[1], 3)
open("ardupilot.bin", "wb").write(out)
