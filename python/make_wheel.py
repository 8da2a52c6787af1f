"""A wheel from a built module: python3 make_wheel.py BUILD/python OUTPUT-FOLDER

The wheel has the package and the shared libraries that the extension needs beyond those of any Linux, so `pip install --no-index FILE` is all. It
fits the Python and the processor that built it, and a glibc at least as new.
"""

import base64
import hashlib
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

SYSTEM = re.compile(r"(linux-vdso|ld-linux.*|lib(c|m|dl|rt|pthread|resolv|util|gcc_s|stdc\+\+))\.so")  # of glibc and the compiler: on every machine


def libraries(module: pathlib.Path) -> list[pathlib.Path]:
    """What the dynamic linker loads with the module."""
    lines = subprocess.run(["ldd", module], capture_output=True, text=True, check=True).stdout.splitlines()
    missing = [line.strip() for line in lines if "not found" in line]
    if missing:
        sys.exit(f"{module}: {', '.join(missing)}")
    found = [pathlib.Path(match[1]) for line in lines if (match := re.search(r"=> (/\S+)", line))]
    return [library for library in found if not SYSTEM.match(library.name)]


def bundle(package: pathlib.Path) -> None:
    """Puts the libraries into imulab.libs beside the package; all find each other there."""
    folder = package.parent / "imulab.libs"
    folder.mkdir()
    module = next(package.glob("_imulab*.so"))
    for library in libraries(module):
        copy = folder / library.name
        shutil.copy(library, copy)
        copy.chmod(0o755)
        subprocess.run(["patchelf", "--set-rpath", "$ORIGIN", copy], check=True)
        for notice in pathlib.Path("/usr/share/doc").glob(f"{owner(library)}/copyright"):
            shutil.copy(notice, folder / f"{library.name}.copyright")
    subprocess.run(["patchelf", "--set-rpath", "$ORIGIN/../imulab.libs", module], check=True)
    subprocess.run(["strip", "--strip-unneeded", module], check=True)


def owner(library: pathlib.Path) -> str:
    """The Debian package of a file."""
    answer = subprocess.run(["dpkg", "-S", library.resolve()], capture_output=True, text=True, check=False).stdout
    return answer.split(":")[0] or "none"


def write(root: pathlib.Path, version: str, output: pathlib.Path) -> pathlib.Path:
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"
    information = root / f"imulab-{version}.dist-info"
    information.mkdir()
    (information / "WHEEL").write_text(f"Wheel-Version: 1.0\nGenerator: imulab\nRoot-Is-Purelib: false\nTag: {tag}\n")
    (information / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: imulab\nVersion: {version}\nSummary: The laboratory for inertial measurement units\nLicense: MIT\n"
        "Requires-Python: >=3.11\nRequires-Dist: numpy\n"
    )
    shutil.copy(pathlib.Path(__file__).parents[1] / "LICENSE", information)
    record = information / "RECORD"
    files = sorted(f for f in root.rglob("*") if f.is_file())
    lines = []
    for file in files:
        data = file.read_bytes()
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        lines.append(f"{file.relative_to(root)},sha256={digest},{len(data)}\n")
    record.write_text("".join(lines) + f"{record.relative_to(root)},,\n")
    output.mkdir(parents=True, exist_ok=True)
    wheel = output / f"imulab-{version}-{tag}.whl"
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in [*files, record]:
            archive.write(file, file.relative_to(root))
    return wheel


def main() -> None:
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    built = pathlib.Path(sys.argv[1])
    code = "import imulab; print(imulab.__version__)"
    version = subprocess.run([sys.executable, "-c", code], cwd=built, capture_output=True, text=True, check=True).stdout.strip()
    with tempfile.TemporaryDirectory() as temporary:
        root = pathlib.Path(temporary)
        shutil.copytree(built / "imulab", root / "imulab", ignore=shutil.ignore_patterns("__pycache__", ".mypy_cache"))
        bundle(root / "imulab")
        print(write(root, version, pathlib.Path(sys.argv[2])))


if __name__ == "__main__":
    main()
