#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Camera faults in the middle of a drive, at random moments: is the robot at rest in time, without a
contact, and does the map hold no more that is no floor than that of the same drive ended then?

  tests/system/camera_faults.py build/ci/apps/panoptes --out runs/faults [--seeds 100-119]
      [--worlds office,home] [--faults freeze,cover,black,unplug] [--camera floor]

Every seed has a moment of its own, 15 to 90 s after the start; a drive that ended before it is told
and not counted. Prints a row a run as it ends and keeps
it in OUT/faults.csv; runs that are there are not run again. Status 1 where a row breaks a limit.
"""
import argparse
import csv
import json
import math
import pathlib
import random
import subprocess
import sys

REST_S = 1.0
LEAKED_SHARE = 0.001
AFTER_S = 4.0


def poses(run):
    rows = [line.split() for line in (run / "ground_truth.tum").read_text().splitlines()
            if line and not line.startswith("#")]
    return [(float(r[0]), float(r[1]), float(r[2]), 2 * math.atan2(float(r[6]), float(r[7])))
            for r in rows]


def rest_after_s(run, at_s):
    """From the fault to the first frame set from which on the body stays where it is."""
    path = poses(run)
    x, y, theta = path[-1][1:]
    still = path[-1][0]
    for stamp, px, py, ptheta in reversed(path):
        turn = math.remainder(ptheta - theta, 2 * math.pi)
        if math.hypot(px - x, py - y) > 0.001 or abs(turn) > math.radians(0.1):
            break
        still = stamp
    return max(0.0, still - at_s)


def explore(program, mission, out, seed, duration_s, extra):
    if not (out / "metrics.json").exists():
        subprocess.run([program, "explore", mission, "--seed", str(seed), "--quiet", "--out", str(out),
                        "--set", f"until.duration_s={duration_s:.3f}", "--set", "require=[]"] + extra,
                       stdout=subprocess.DEVNULL, check=False)
    return json.loads((out / "metrics.json").read_text())


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--out", required=True)
    parser.add_argument("--seeds", default="100-119")
    parser.add_argument("--worlds", default="office,home")
    parser.add_argument("--faults", default="freeze,cover,black,unplug")
    parser.add_argument("--camera", default="floor")
    arguments = parser.parse_args()
    first, last = (arguments.seeds.split("-") * 2)[:2]
    missions = pathlib.Path(__file__).resolve().parents[2] / "scenes" / "missions"
    out = pathlib.Path(arguments.out)
    out.mkdir(parents=True, exist_ok=True)
    broken = 0
    with open(out / "faults.csv", "w", newline="") as table:
        rows = csv.writer(table)
        rows.writerow(["world", "seed", "at_s", "fault", "outcome", "rest_s", "contacts",
                       "leaked_share", "leaked_share_without", "told", "verdict"])
        for seed in range(int(first), int(last) + 1):
            for world in arguments.worlds.split(","):
                at_s = random.Random(f"{world}-{seed}").uniform(15, 90)
                mission = str(missions / f"explore-{world}.yaml")
                whole = explore(arguments.program, mission, out / f"{world}-{seed}", seed, at_s, [])
                if whole["run_s"] < at_s - 1:
                    print(f"{world} {seed} {at_s:.2f}: the drive ended after {whole['run_s']:.1f} s "
                          f"({whole['outcome']}); no moment of it", flush=True)
                    continue
                for fault in arguments.faults.split(","):
                    run = out / f"{world}-{seed}-{fault}"
                    which = f"camera: {arguments.camera}, " if arguments.camera != "all" else ""
                    m = explore(arguments.program, mission, run, seed, at_s + AFTER_S, [
                        "--set", f"platform.faults=[{{{which}fault: {fault}, at_s: {at_s:.3f}}}]",
                        "--set", f"navigator.camera_patience_s={AFTER_S - 1}"])
                    rest_s = rest_after_s(run, at_s)
                    contacts = m["collisions"] - whole["collisions"]
                    leaked = m["map"].get("leaked_share", math.nan)
                    without = whole["map"].get("leaked_share", math.nan)
                    told = {k: v for c in m["cameras"].values() for k, v in c.items()
                            if v and k not in ("lost_s",)}
                    good = (rest_s <= REST_S and contacts == 0 and told and
                            m["outcome"] in ("device_lost", "collision") and
                            not leaked > without + LEAKED_SHARE)
                    broken += not good
                    row = [world, seed, f"{at_s:.2f}", fault, m["outcome"], f"{rest_s:.2f}", contacts,
                           f"{leaked:.4f}", f"{without:.4f}",
                           " ".join(f"{k}={v}" for k, v in told.items()), "good" if good else "BROKEN"]
                    rows.writerow(row)
                    table.flush()
                    print(*row, flush=True)
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
