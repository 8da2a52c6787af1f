"""walk.csv.*: one text in each form of compression, by Python's gzip, bz2 and lzma and by the programs zstd and lz4; walk.tar.xz: two. Python 3."""

import bz2
import gzip
import io
import lzma
import subprocess
import tarfile

import imu

text = "\n".join(["t,gx,gy,gz,ax,ay,az", *(",".join(map(repr, row)) for row in imu.rows()), ""]).encode()
packed = {
    "gz": gzip.compress(text, mtime=0),
    "bz2": bz2.compress(text),
    "xz": lzma.compress(text),
    "zst": subprocess.run(["zstd", "-19", "--check"], input=text, stdout=subprocess.PIPE, check=True).stdout,
    "lz4": subprocess.run(["lz4", "-9"], input=text, stdout=subprocess.PIPE, check=True).stdout,
}
for ending, content in packed.items():
    with open(f"walk.csv.{ending}", "wb") as file:
        file.write(content)
with tarfile.open("walk.tar.xz", "w:xz") as archive:
    for name in ("morning.csv", "evening.csv"):
        member = tarfile.TarInfo(f"logs/{name}")
        member.size = len(text)
        archive.addfile(member, io.BytesIO(text))
