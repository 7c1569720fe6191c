# SPDX-License-Identifier: BSD-3-Clause
"""Racks, pallets, barrels, a forklift. Origins as in home.py."""

import random

from furniture import part_of
from home import made_of, on_wall
from textures import cell
from warehouse_textures import CARTONS, THINGS

BAY_M, DEPTH_M, LEVELS_M = 2.70, 1.05, (0.0, 1.65, 3.15)


def thing(name):
    return cell(4, THINGS.index(name))


def goods(m, rng, x, y, z, depth, width, height, yaw_deg=0.0):
    """What stands on a pallet: cartons in layers, or one load under film."""
    kind = rng.random()
    if kind < 0.35:
        u = rng.random()
        m.box(x - depth / 2, y - width / 2, z, x + depth / 2, y + width / 2, z + height * rng.uniform(0.7, 1.0), "wrapped",
              uv=(u, 0, u + 1, 1), yaw_deg=yaw_deg)
        return
    rows = rng.choice((2, 2, 3))
    columns = rng.choice((2, 3))
    h, w = height / rows, width / columns
    for j in range(rows):
        for i in range(columns):
            if j == rows - 1 and rng.random() < 0.35:
                continue
            face = cell(4, rng.randrange(CARTONS))
            a = y - width / 2 + i * w
            m.box(x - depth / 2, a + 0.005, z + j * h + 0.001, x + depth / 2 - rng.uniform(0, 0.05), a + w - 0.005, z + (j + 1) * h - 0.004,
                  "cartons", uv=face, skip=("-z",))


def pallet(m, x, y, z, yaw_deg=0.0):
    """A euro pallet, 0.8 m deep and 1.2 m wide; its openings are painted."""
    m.box(x - 0.40, y - 0.60, z, x + 0.40, y + 0.60, z + 0.144, "timber", uv=(0, 0.1, 1, 0.35), faces={"+z": ("timber", None)}, yaw_deg=yaw_deg)


def with_materials(name):
    return made_of(name, timber="timber", cartons="cartons", wrapped="wrapped", things="things", barrel="barrel")


def rack(k):
    """A bay of a pallet rack, 2.7 m wide and 4.4 m high, two pallets on each of three levels."""
    m = with_materials(f"rack_{k}")
    rng = random.Random(f"rack {k}")
    x, y = DEPTH_M / 2, BAY_M / 2
    for s in (-1, 1):
        for t in (-1, 1):
            m.box(s * (x - 0.05) - 0.05, t * (y - 0.05) - 0.05, 0, s * (x - 0.05) + 0.05, t * (y - 0.05) + 0.05, 4.4, "things",
                  uv=part_of(thing("upright"), 0, 0, 1, 1))
    for z in LEVELS_M[1:]:
        for s in (-1, 1):
            m.box(s * (x - 0.04) - 0.035, -y + 0.101, z - 0.14, s * (x - 0.04) + 0.035, y - 0.101, z - 0.001, "things", uv=thing("beam"),
                  skip=("+y", "-y"))
    for level, z in enumerate(LEVELS_M):
        for t in (-1, 1):
            if level and rng.random() < 0.12:
                continue
            a = t * 0.63 + rng.uniform(-0.015, 0.015)
            pallet_x = 0.08 + rng.uniform(-0.02, 0.02)
            m.box(-x + 0.10, a - 0.59, z, x - 0.02, a + 0.59, z + 0.144, "timber", uv=(0, 0.1, 1, 0.35), faces={"+z": ("timber", None)},
                  skip=("-z",) if level == 0 else ())
            goods(m, rng, pallet_x - 0.02, a, z + 0.145, 0.82, 1.10, rng.uniform(0.85, 1.15))
    m.box(x - 0.004, -0.22, 1.66 - 0.14, x + 0.012, 0.0, 1.66 - 0.02, "things", uv=part_of(thing("number"), 0, 0, 1, 0.1),
          faces={"+x": ("things", part_of(thing("number"), 0, 0.2, 1, 0.8))}, skip=("-x",))
    return m


def loaded(k):
    m = with_materials(f"loaded_{k}")
    rng = random.Random(f"loaded {k}")
    pallet(m, 0, 0, 0)
    goods(m, rng, 0, 0, 0.145, 0.78, 1.16, rng.uniform(0.7, 1.2))
    return m


def stack():
    """Empty pallets, nine high."""
    m = with_materials("stack")
    rng = random.Random("stack")
    for k in range(9):
        pallet(m, rng.uniform(-0.015, 0.015), rng.uniform(-0.02, 0.02), 0.146 * k, rng.uniform(-2, 2))
    return m


def barrels():
    """Four barrels on a pallet."""
    m = with_materials("barrels")
    pallet(m, 0, 0, 0)
    for k, (x, y) in enumerate(((-0.19, -0.30), (0.19, -0.29), (-0.19, 0.30), (0.19, 0.31))):
        m.prism(x, y, 0.145, 1.02, 0.19, 0.19, 12, "barrel", top=("things", thing("lid")), turn_deg=20 * k, wraps=1)
    return m


def barrel():
    m = with_materials("barrel")
    m.prism(0, 0, 0, 0.88, 0.29, 0.29, 14, "barrel", top=("things", thing("lid")), wraps=2)
    return m


def forklift():
    """Parked, a loaded pallet on its forks."""
    m = with_materials("forklift")
    pallet(m, 0.86, 0, 0)
    goods(m, random.Random("forklift"), 0.86, 0, 0.145, 0.78, 1.16, 0.9)
    cab, dark = thing("cab"), part_of(thing("fork"), 0, 0, 1, 0.5)

    def part(x0, y0, z0, x1, y1, z1, uv, **more):
        m.box(x0 - 0.39, y0, z0, x1 - 0.39, y1, z1, "things", uv=uv, **more)

    part(-1.05, -0.55, 0, 0.62, 0.55, 0.62, cab, faces={"-x": ("things", thing("stripes"))})
    part(-1.05, -0.50, 0.62, -0.45, 0.50, 1.05, cab)
    for s in (-1, 1):
        for x in (-0.70, 0.34):
            a, b = sorted((s * 0.551, s * 0.60))
            part(x - 0.26, a, 0, x + 0.26, b, 0.5, dark, faces={"+y" if s > 0 else "-y": ("things", thing("wheel"))})
        for x in (-0.42, 0.50):
            part(x - 0.04, s * 0.46 - 0.04, 0.625 if x > 0 else 1.055, x + 0.04, s * 0.46 + 0.04, 2.05, dark)
        part(0.66, s * 0.28 - 0.06, 0, 0.78, s * 0.28 + 0.06, 2.20, thing("steel"))
    part(0.781, -0.50, 0, 0.83, 0.50, 0.62, thing("fence"))
    part(-0.50, -0.53, 2.055, 0.58, 0.53, 2.11, dark, skip=())
    part(-0.38, -0.25, 0.621, 0.10, 0.25, 0.80, dark)
    part(-0.42, -0.24, 0.801, -0.30, 0.24, 1.30, dark)
    return m


def pillar():
    """5 m of steel, striped as far up as forklifts hit it."""
    m = made_of("pillar", things="things")
    for k, (z0, z1) in enumerate(((0, 0.6), (0.601, 1.2))):
        m.box(-0.19, -0.19, z0, 0.19, 0.19, z1, "things", uv=thing("stripes"), skip=("-z",) if k == 0 else ("-z", "+z"))
    for k in range(5):
        m.box(-0.17, -0.17, 1.201 + 0.76 * k, 0.17, 0.17, 1.96 + 0.76 * k, "things", uv=thing("steel"), skip=("-z", "+z"))
    return m


def lamp():
    """A lamp under the roof, 1.4 m by 0.5 m; its origin is on its upper side."""
    m = made_of("lamp", things="things")
    m.box(-0.7, -0.25, -0.08, 0.7, 0.25, -0.001, "things", uv=part_of(thing("steel"), 0, 0, 1, 0.3), faces={"-z": ("things", thing("lamp"))},
          skip=())
    return m


def all_meshes():
    out = [rack(k) for k in range(1, 6)] + [loaded(k) for k in range(1, 6)]
    out += [stack(), barrels(), barrel(), forklift(), pillar(), lamp(), on_wall("gate", 3.0, 3.0, 0.06, "gate", "gate", (0, 0, 1, 1), (0, 0, 0.06, 1))]
    out += [on_wall("plate_" + k, 0.6, 0.6, 0.01, "things", "things", thing("plate_" + k), part_of(thing("plate_" + k), 0, 0, 1, 0.04))
            for k in "abcd"]
    return out
