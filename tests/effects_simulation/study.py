"""Calibrates simulated sessions and tells how well the stated uncertainties hold: study.py COMMAND METHOD GRADE SEEDS [EFFECT[=SIZE]...] [+SPECIAL[=SIZE]...]"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import hybrid
import simulate
import turntable
import whole_unit

SIMULATORS = {"hybrid": hybrid, "turntable": turntable, "whole-unit": whole_unit}  # others: a unit turned by hand


def studied(command: str, method: str, grade: str, seed: int, effects: dict[str, float], special: dict[str, float], extra: list[str],
            declared: str | None = None) -> dict:
    """`declared`: a grade in place of the simulated one; empty: none."""
    with tempfile.TemporaryDirectory() as folder:
        session = Path(folder)
        unit = SIMULATORS.get(method, simulate).write_session(session, seed, grade, effects, **special)
        if declared is not None:
            line = f'grade = "{declared}"' if declared else ""
            file = session / "session.toml"
            file.write_text(re.sub('(?m)^grade = ".*"$', line, file.read_text()))
        run = subprocess.run([command, "calibrate", "session.toml", "--method", method, "-o", "c.json", *extra], cwd=folder, capture_output=True, text=True)
        if not (session / "c.json").exists():
            return {"verdict": f"exit {run.returncode}: {run.stderr.strip()[:200]}"}
        c = json.loads((session / "c.json").read_text())
    names = c["covariance"]["coefficients"]
    P = np.array(c["covariance"]["matrix"])
    triads = {t: c["model"][t] for t in ("accel", "gyro") if t in c["model"]}

    def value(name: str) -> float:
        triad, term, place = name.split(".")
        at = ["xyz".index(a) if a in "xyz" else int(a) for a in place]
        v = triads[triad][term]
        return v[at[0]][at[1]] if len(at) == 2 else v[at[0]]

    truth = unit.values()
    e = np.array([value(n) - truth.get(n, 0) for n in names])
    z = np.abs(e) / np.sqrt(np.diag(P))
    chi2 = float(e @ np.linalg.lstsq(P, e, rcond=1e-14)[0]) / len(e)
    return {"verdict": c["quality"]["verdict"], "because": c["quality"].get("because", []), "worst": float(z.max()), "name": names[int(z.argmax())],
            "chi2": chi2, "count": len(e), "u": dict(zip(names, np.sqrt(np.diag(P)))),
            "cause": c["quality"].get("cause", ""), "considered": c["quality"].get("considered", [])}


def main() -> None:
    command, method, grade, seeds, *rest = sys.argv[1:]
    extra = [r for r in rest if r.startswith("--")]
    effects, special = {}, {}  # special: what a writer has arguments for, as +clock=2e-5
    for r in rest:
        name, _, size = r.partition("=")
        if r.startswith("+"):
            special[name[1:]] = float(size or 1)
        elif not r.startswith("--"):
            for each in SIMULATORS.get(method, simulate).SIZES if name == "all" else [name]:
                effects[each] = float(size or 1)
    results = [studied(command, method, grade, seed, effects, special, extra) for seed in range(1, int(seeds) + 1)]
    good = [r for r in results if r["verdict"] == "good"]
    print(f"{method} {grade} {effects | special}: {len(good)} of {len(results)} good")
    if good:
        print(f"  of the good: mean chi2/m {np.mean([r['chi2'] for r in good]):.2f}, worst error {max(r['worst'] for r in good):.1f} sigma "
              f"({max(good, key=lambda r: r['worst'])['name']}), median worst {np.median([r['worst'] for r in good]):.1f}")
    for r in results:
        if r["verdict"] != "good":
            print("  ", r["verdict"], r.get("because"), r.get("cause"), f"{r.get('worst', 0):.1f} {r.get('chi2', 0):.2f}")


if __name__ == "__main__":
    main()
