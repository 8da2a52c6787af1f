"""Do the stated uncertainties hold, and are causes named, for units, rigs and hands with effects that a sensor model lacks?

accept.py COMMAND [--seeds N] [--method NAME] [--quick]

Every case is a method, a grade, and what the session has. Clean: no false alarm. All effects at once, drawn from their priors: a result that is called
good has e'P^-1 e / m below 1.3 on average, and no error beyond the 99.9 % quantile of the largest of all. One effect of ten times its prior, in sessions
whose residuals can show it: doubtful in 95 %, or covered as above; four of five causes are the true one. One effect that they cannot show, of its prior:
covered, and the result names it as assumed.
"""

from __future__ import annotations

import argparse
import concurrent.futures
import os
import sys
from dataclasses import dataclass, field
from statistics import NormalDist

import numpy as np

import simulate
import study


@dataclass
class Case:
    method: str
    grade: str
    name: str
    effects: dict[str, float] = field(default_factory=dict)
    special: dict[str, float] = field(default_factory=dict)
    cause: str | None = None  # what a doubt should name
    assumed: str | None = None  # what a result should list among what it considers
    clean: bool = False
    quick: bool = False  # among those of one session each

    def title(self) -> str:
        return f"{self.method}, {self.grade}: {self.name}"


GRADES = {"static": ("navigation", "mems"), "handheld": ("navigation", "mems"), "turntable": ("navigation", "mems"),
          "hybrid": ("navigation", "mems"), "whole-unit": ("tactical", "mems")}
# Effects that the residuals of a method's session can show.
SHOWN = {
    "static": ("accel.asymmetry", "accel.cross_terms", "accel.drift"),
    "handheld": ("accel.asymmetry", "accel.cross_terms", "accel.drift", "gyro.drift", "gyro.asymmetry", "gyro.scale_force"),
    "turntable": ("accel.hysteresis", "accel.cross_terms", "accel.drift", "gyro.drift", "gyro.asymmetry", "mount.elastic"),
    "hybrid": ("accel.cross_terms", "accel.drift", "gyro.drift", "gyro.asymmetry", "gyro.scale_drift", "gyro.scale_force"),
    "whole-unit": ("accel.turn_on", "gyro.turn_on", "gyro.g_squared", "gyro.drift", "centrifuge.arm"),
}
BOTH = ("navigation", "mems")
# Sessions that show an effect: without these turns cross terms within their prior look like the bend.
BETTER = {("turntable", "mount.elastic"): ("with turns on each face", {"all_faces": 1})}
# Effects that shift a coefficient and do not show, whatever their size: a bend, or a scale that follows the force, with turns on one face, a scale over
# temperature in one mount.
ASSUMED = {"turntable": ("mount.elastic", "gyro.scale_force"), "whole-unit": ("accel.scale_temperature",)}
SPECIAL = {
    "static": (("the latitude 0.2 deg off", {"latitude_off": 0.2}, "site.latitude", ("navigation",)),
               ("the latitude with the wrong sign", {"wrong_sign": 1}, "site.latitude", ("navigation",)),
               ("offsets that follow the heading by 100 ug", {"heading_ug": 100}, "accel.heading", ("navigation",))),
    # A hand that wanders is no rest to a good gyro: that log is refused.
    "handheld": (("a tremor of 0.05 deg", {"tremor": 0.05}, None, BOTH), ("a hand that wanders by 0.3 deg", {"wander": 0.3}, None, ("mems",)),
                 ("a clock 1 % off", {"clock": 0.01}, None, BOTH)),
    "turntable": (("the latitude 0.2 deg off", {"latitude_off": 0.2}, "site.latitude", ("navigation",)),),
    "hybrid": (("a clock 20 ppm off", {"clock": 2e-5}, None, BOTH), ("a gyro that sticks for a second", {"sticks": 1}, None, BOTH)),
    "whole-unit": (("the latitude with the wrong sign", {"wrong_sign": 1}, "site.latitude", ("tactical", "mems")),),
}


def cases() -> list[Case]:
    out = []
    for method, grades in GRADES.items():
        sizes = study.SIMULATORS.get(method, study.simulate).SIZES
        for grade in grades:
            out.append(Case(method, grade, "nothing", clean=True, quick=True))
            out.append(Case(method, grade, "all effects at their priors", {e: 1 for e in sizes}, quick=True))
            for number, effect in enumerate(SHOWN[method]):
                if effect in sizes:
                    words, special = BETTER.get((method, effect), ("", {}))
                    name = f"{effect} of ten times its prior" + (words and ", " + words)
                    out.append(Case(method, grade, name, {effect: 10}, special, effect, quick=grade == grades[0] and number < 2))
            for effect in ASSUMED.get(method, ()):
                out.append(Case(method, grade, f"{effect} of its prior, assumed", {effect: 1}, assumed=effect, quick=(method, grade) == ("turntable", "navigation")))
            for name, special, cause, of_grades in SPECIAL.get(method, ()):
                if grade in of_grades:
                    out.append(Case(method, grade, name, special=special, cause=cause))
    return out


def judged(case: Case, results: list[dict]) -> tuple[str, list[str]]:
    """A line, and what is wrong."""
    good = [r for r in results if r["verdict"] == "good"]
    doubted = [r for r in results if r["verdict"] == "doubtful"]
    wrong = [r["verdict"] for r in results if r["verdict"] not in ("good", "doubtful")]
    line = f"{case.title():<70} good {len(good)}/{len(results)}"
    if good:
        count = sum(r["count"] for r in good)
        chi2, worst, most = np.mean([r["chi2"] for r in good]), max(r["worst"] for r in good), NormalDist().inv_cdf(1 - 0.0005 / count)
        line += f"  chi2/m {chi2:.2f}  worst {worst:.1f} of {most:.1f} sigma"
        # A mean of few sessions scatters: m of some 25 each.
        if chi2 > 1.3 + 3 * np.sqrt(2 / count):
            wrong.append(f"chi2/m of good results is {chi2:.2f}")
        if worst > most:
            wrong.append(f"an error of {worst:.1f} sigma was called good")
    if case.clean and len(doubted) > max(1, 0.05 * len(results)):
        wrong.append(f"{len(doubted)} false alarms")
    if case.assumed and (silent := sum(case.assumed not in r["considered"] for r in good)):
        wrong.append(f"{silent} do not name what they assume")
    if case.cause and doubted:
        named = sum(case.cause in (r["cause"] or "") for r in doubted)
        line += f"  cause {named}/{len(doubted)}"
        if len(doubted) >= 5 and named < 0.8 * len(doubted):
            wrong.append(f"the cause was named in {named} of {len(doubted)}")
    return line, wrong


def priced(title: str, results: list[dict], without: list[dict]) -> tuple[str, list[str]]:
    """Of clean sessions: what the effects cost, and what is wrong. `without`: the same sessions with the effects declared absent."""
    kinds: dict[str, list[float]] = {}
    for r, w in zip(results, without):
        for name, u in r.get("u", {}).items():
            triad, term, place = name.split(".")
            kind = f"{triad}.{term}" + (" diagonal" if term == "matrix" and place[0] == place[-1] else "")
            if name in w.get("u", {}):
                kinds.setdefault(kind, []).append(u / w["u"][name])
    doubted = sum(r["verdict"] != "good" for r in results)
    cost = {k: float(np.median(v)) for k, v in kinds.items()}
    known = [r for r in results if "chi2" in r]
    line = (f"{title:<70} good {len(results) - doubted}/{len(results)}  chi2/m {np.mean([r['chi2'] for r in known]):.2f}  "
            f"u over that without effects: most {max(cost.values()):.2g} ({max(cost, key=cost.get)}), median {np.median(list(cost.values())):.2g}")
    return line, [f"{doubted} false alarms"] if doubted > max(1, 0.05 * len(results)) else []


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("command", type=os.path.abspath)  # sessions are calibrated in their folders
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--method")
    parser.add_argument("--quick", action="store_true")
    o = parser.parse_args()
    failed = 0
    with concurrent.futures.ProcessPoolExecutor() as pool:
        chosen = [c for c in cases() if (not o.method or c.method == o.method) and (not o.quick or c.quick)]
        seeds = {c.title(): 1 if o.quick else 5 * o.seeds // 2 if c.clean else o.seeds for c in chosen}  # a false alarm is rare
        work = [[pool.submit(study.studied, o.command, c.method, c.grade, seed, c.effects, c.special, ["--effects", "table"])
                 for seed in range(1, seeds[c.title()] + 1)] for c in chosen]
        prices = []  # title, with effects, without
        for method, grades in {} if o.quick else GRADES.items():
            for grade in grades if o.method in (None, method) else ():
                def clean(declared: str, effects: str) -> list:
                    return [pool.submit(study.studied, o.command, method, grade, seed, {}, {}, ["--effects", effects], declared)
                            for seed in range(1, o.seeds + 1)]

                place = simulate.GRADES.index(grade)
                better, worse = simulate.GRADES[max(place - 1, 0)], simulate.GRADES[min(place + 1, 3)]
                without = clean(grade, "none")
                for words, declared in {"right": grade, "one better": better, "one worse": worse, "none": ""}.items():
                    if declared != grade or words == "right":
                        prices.append((f"{method}, {grade}: clean, declared {words}", clean(declared, "table"), without))
        for case, futures in zip(chosen, work):
            line, wrong = judged(case, [f.result() for f in futures])
            print(line + "".join(f"\n    WRONG: {w}" for w in wrong), flush=True)
            failed += bool(wrong)
        for title, with_effects, without in prices:
            line, wrong = priced(title, [f.result() for f in with_effects], [f.result() for f in without])
            print(line + "".join(f"\n    WRONG: {w}" for w in wrong), flush=True)
            failed += bool(wrong)
    print(f"{failed} of {len(work) + len(prices)} cases failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
