# SPDX-License-Identifier: BSD-3-Clause
"""The furniture. Every piece stands with the middle of its footprint on the origin and its front towards +x.

What is lower than the robot (0.80 m) reaches the floor within 5 cm of its outline: a camera that sees the foot of a
piece of furniture has seen how far it reaches. So desks have closed sides and fronts, chairs are tubs with a skirt, and
shelves stand on a plinth.
"""

import math
import random

from mesh import FULL, Mesh
from textures import PROPS, SIGNS, cell

DESK_WIDTH, DESK_DEPTH, DESK_HEIGHT = 1.60, 0.80, 0.74
CHAIR_DEPTH, CHAIR_WIDTH = 0.52, 0.50
SHELF_WIDTH, SHELF_DEPTH = 0.90, 0.36
TABLE_LENGTH, TABLE_DEPTH = 1.80, 1.00


def prop(name):
    return cell(4, PROPS.index(name))


def part_of(rect, u0, v0, u1, v1):
    a, b, c, d = rect
    return (a + (c - a) * u0, b + (d - b) * v0, a + (c - a) * u1, b + (d - b) * v1)


def desk():
    m = Mesh("desk")
    m.material("top", "desk_top_a.png")
    m.material("front", "desk_front_a.png")
    m.material("side", "desk_side_a.png")
    x, y = DESK_DEPTH / 2, DESK_WIDTH / 2
    # The carcass stands 2 cm inside the top's outline.
    m.box(-x + 0.02, -y + 0.02, 0, x - 0.02, y - 0.02, 0.705, "side",
          faces={"+x": ("front", None), "-x": ("side", (0.1, 0.1, 0.9, 0.9))}, skip=("-z", "+z"))
    edge = (0.02, 0.955, 0.98, 0.99)
    m.box(-x, -y, 0.705, x, y, DESK_HEIGHT, "top", faces={s: ("top", edge) for s in ("+x", "-x", "+y", "-y", "-z")},
          skip=())
    return m


def chair():
    m = Mesh("chair")
    m.material("fabric", "chair_blue.png")
    m.material("skirt", "chair_base.png")
    x, y = CHAIR_DEPTH / 2, CHAIR_WIDTH / 2
    d, cut = 0.01, 0.04     # the skirt: a rectangle with its corners cut, hardly smaller than the seat
    p, q = x - d, y - d
    m.pillar([(p, -q + cut), (p, q - cut), (p - cut, q), (-p + cut, q), (-p, q - cut), (-p, -q + cut), (-p + cut, -q),
              (p - cut, -q)], 0, 0.39, "skirt", wraps=4)
    m.box(-x + 0.005, -y, 0.385, x, y, 0.50, "fabric", uv=(0, 0.1, 1, 0.4), faces={"+z": ("fabric", None)}, skip=())
    m.box(-x, -y + 0.02, 0.46, -x + 0.09, y - 0.02, 0.98, "fabric", skip=())
    for s in (-1, 1):
        a, b = sorted((s * (y - 0.06), s * y))
        m.box(-x + 0.095, a, 0.502, x - 0.08, b, 0.67, "fabric", uv=(0.1, 0.3, 0.9, 0.6))
    return m


def monitor():
    m = Mesh("monitor")
    m.material("screen", "screen_1.png")
    m.material("case", "plastic.png")
    m.material("back", "monitor_back.png")
    m.box(-0.10, -0.12, 0, 0.10, 0.12, 0.015, "case", uv=(0.05, 0.8, 0.3, 0.95))
    m.box(-0.09, -0.03, 0.015, -0.06, 0.03, 0.26, "case", uv=(0.4, 0.5, 0.6, 0.7), skip=("-z",))
    m.box(-0.025, -0.27, 0.10, 0.01, 0.27, 0.44, "case", uv=(0.02, 0.02, 0.2, 0.08),
          faces={"+x": ("screen", None), "-x": ("back", None)}, skip=())
    # What stands out behind: the picture on its back goes on over it.
    m.box(-0.06, -0.14, 0.18, -0.026, 0.14, 0.35, "back", uv=(0.04, 0.4, 0.16, 0.6),
          faces={"-x": ("back", (0.24, 0.26, 0.76, 0.76))}, skip=("+x",))
    return m


def keyboard():
    m = Mesh("keyboard")
    m.material("keys", "props.png")
    m.box(-0.08, -0.22, 0, 0.08, 0.22, 0.02, "keys", uv=part_of(prop("keyboard"), 0, 0, 1, 0.04),
          faces={"+z": ("keys", prop("keyboard"))})
    return m


def phone():
    m = Mesh("phone")
    m.material("phone", "props.png")
    m.box(-0.10, -0.09, 0, 0.10, 0.09, 0.06, "phone", uv=part_of(prop("phone"), 0, 0.9, 1, 1),
          faces={"+z": ("phone", prop("phone"))})
    return m


def mug():
    m = Mesh("mug")
    m.material("mug", "props.png")
    m.prism(0, 0, 0, 0.10, 0.04, 0.042, 8, "mug", uv=prop("mug"), top=("mug", part_of(prop("soil"), 0, 0, 1, 1)), wraps=2)
    return m


def book_pile():
    m = Mesh("book_pile")
    m.material("books", "books_a.png")
    rng = random.Random("book pile")
    z = 0.0
    for k in range(5):
        w, d, h = rng.uniform(0.20, 0.26), rng.uniform(0.14, 0.19), rng.uniform(0.02, 0.05)
        u = rng.uniform(0, 0.9)
        rect = (u, 0.02, u + 0.03, 0.22)
        m.box(-d / 2, -w / 2, z, d / 2, w / 2, z + h - 0.0005, "books", uv=rect, yaw_deg=rng.uniform(-20, 20))
        z += h
    return m


def drawers():
    """A drawer unit, 0.42 m wide and 0.56 m deep."""
    m = Mesh("drawers")
    m.material("front", "desk_front_a.png")
    m.material("side", "desk_side_b.png")
    m.box(-0.28, -0.21, 0, 0.28, 0.21, 0.58, "side", uv=(0.02, 0.02, 0.5, 0.5),
          faces={"+x": ("front", (0.012, 0.02, 0.30, 0.99)), "+z": ("side", (0.55, 0.15, 0.95, 0.8))})
    m.box(-0.16, -0.13, 0.58, 0.05, 0.02, 0.585, "side", faces={"+z": ("side", (0.12, 0.12, 0.34, 0.44))}, yaw_deg=14)
    return m


def partition():
    """A screen between two desks that stand back to back, 1.56 m long."""
    m = Mesh("partition")
    m.material("fabric", "partition_a.png")
    m.box(-0.02, -0.78, 0, 0.02, 0.78, 1.18, "fabric", uv=(0, 0, 1, 0.015),
          faces={"+x": ("fabric", None), "-x": ("fabric", (0.5, 0, 1.5, 1))})
    return m


def shelf(variant):
    """A bookcase 0.90 m wide, 0.36 m deep, 1.90 m high, filled differently in each variant."""
    m = Mesh(f"shelf_{variant}")
    m.material("wood", "wood_shelf.png")
    m.material("books", "books_a.png")
    m.material("boxes", "props.png")
    rng = random.Random(f"shelf {variant}")
    x, y, t = SHELF_DEPTH / 2, SHELF_WIDTH / 2, 0.022
    m.box(-x, -y, 0, x, -y + t, 1.90, "wood", tile=0.8)
    m.box(-x, y - t, 0, x, y, 1.90, "wood", tile=0.8, shift=(0.3, 0.2))
    m.box(-x, -y + t, 0, -x + 0.012, y - t, 1.895, "wood", tile=0.8, shift=(0.5, 0.1), skip=("-z", "+z", "+y", "-y"))
    m.box(-x + 0.012, -y + t, 0, x - 0.01, y - t, 0.08, "wood", tile=0.5, skip=("-z", "+y", "-y", "-x"))
    levels = [0.08, 0.44, 0.80, 1.16, 1.52, 1.876]
    for z in levels[1:]:
        m.box(-x + 0.012, -y + t, z, x - 0.004, y - t, z + t, "wood", tile=0.8, shift=(rng.random(), rng.random()),
              skip=("+y", "-y", "-x"))
    for z in levels[:-1]:
        z += t if z > 0.08 else 0.0
        at = -y + t + 0.004
        end = y - t - 0.004
        while end - at > 0.10:
            w = min(rng.uniform(0.16, 0.55), end - at)
            what = rng.random()
            if what < 0.14:
                at += w * 0.45   # a gap
                continue
            if what < 0.26 and w > 0.2:
                h = rng.uniform(0.20, 0.28)
                m.box(-x + 0.05, at, z, x - rng.uniform(0.03, 0.07), at + w, z + h, "boxes", uv=prop("cardboard"),
                      skip=("-z", "-x"))
            else:
                h, row, u = rng.uniform(0.23, 0.29), rng.randrange(4), rng.randrange(8) / 8
                rect = (u, row / 4 + 0.25 - h / 0.30 / 4 + 0.004, u + w / 0.9, row / 4 + 0.25 - 0.004)
                m.box(-x + 0.05, at, z, x - rng.uniform(0.05, 0.12), at + w, z + h, "books",
                      faces={"+x": ("books", rect), "+z": ("boxes", part_of(prop("skirting"), 0, 0.2, 1, 0.8))},
                      uv=(u, rect[1], u + 0.02, rect[3]), skip=("-z", "-x"))
            at += w + rng.choice((0.002, 0.002, 0.05))
    if variant % 2 == 0:
        m.box(-x + 0.03, -0.30, 1.90, x - 0.04, 0.06, 2.12, "boxes", uv=prop("cardboard"))
    else:
        m.box(-x + 0.05, 0.05, 1.90, x - 0.06, 0.36, 2.06, "boxes", uv=prop("cardboard"), yaw_deg=8)
    return m


def cupboard(width, height, name):
    m = Mesh(name)
    m.material("front", "cupboard_a.png")
    m.material("side", "wood_shelf.png")
    x, y = 0.21, width / 2
    m.box(-x, -y, 0, x, y, height, "side", tile=0.8, faces={"+x": ("front", None)})
    m.box(-x - 0.0, -y - 0.0, height, x + 0.012, y, height + 0.022, "side", tile=0.6, skip=())
    return m


def printer():
    """A copying machine, 0.60 m wide and deep."""
    m = Mesh("printer")
    m.material("body", "props.png")
    side = part_of(prop("printer"), 0.02, 0.42, 0.98, 0.56)
    m.box(-0.28, -0.30, 0, 0.28, 0.30, 0.92, "body", uv=side, faces={"+x": ("body", prop("printer"))})
    m.box(-0.28, -0.27, 0.92, 0.24, 0.27, 1.08, "body", uv=part_of(prop("printer"), 0, 0, 1, 0.2),
          faces={"+z": ("body", prop("printer_top"))})
    return m


def plant():
    m = Mesh("plant")
    m.material("plant", "props.png")
    m.prism(0, 0, 0, 0.36, 0.17, 0.20, 10, "plant", uv=prop("pot"), top=("plant", prop("soil")), wraps=2)
    m.prism(0, 0, 0.355, 0.85, 0.025, 0.02, 5, "plant", uv=prop("skirting"), skip_top=True)
    rng = random.Random("plant")
    for k in range(5):   # clumps of leaves
        r = (0.22, 0.27, 0.24, 0.20, 0.14)[k]
        x, y, z = rng.uniform(-0.07, 0.07), rng.uniform(-0.07, 0.07), 0.82 + 0.17 * k
        turn = rng.uniform(0, 50)
        m.prism(x, y, z, z + 0.12, r * 0.5, r, 8, "plant", uv=prop("leaves"), turn_deg=turn, skip_top=True, wraps=2)
        m.prism(x, y, z + 0.12, z + 0.25, r, r * 0.3, 8, "plant", uv=prop("leaves"), turn_deg=turn, wraps=2)
    return m


def bin_():
    m = Mesh("bin")
    m.material("bin", "props.png")
    m.prism(0, 0, 0, 0.34, 0.13, 0.15, 10, "bin", uv=prop("bin"), top=("bin", part_of(prop("soil"), 0, 0, 1, 1)), wraps=2)
    return m


def boxes():
    """Cartons, piled."""
    m = Mesh("boxes")
    m.material("card", "props.png")
    m.box(-0.20, -0.28, 0, 0.20, 0.28, 0.34, "card", uv=prop("cardboard"))
    m.box(-0.18, -0.24, 0.34, 0.15, 0.20, 0.62, "card", uv=prop("cardboard"), yaw_deg=9)
    m.box(-0.12, -0.14, 0.62, 0.12, 0.16, 0.80, "card", uv=prop("cardboard"), yaw_deg=-16)
    return m


def table():
    """A counter for meetings, closed all round."""
    m = Mesh("table")
    m.material("top", "desk_top_b.png")
    m.material("side", "wood_shelf.png")
    x, y = TABLE_DEPTH / 2, TABLE_LENGTH / 2
    m.box(-x + 0.02, -y + 0.02, 0, x - 0.02, y - 0.02, 0.70, "side", tile=0.9, skip=("-z", "+z"))
    edge = (0.02, 0.955, 0.98, 0.99)
    m.box(-x, -y, 0.70, x, y, 0.74, "top", faces={s: ("top", edge) for s in ("+x", "-x", "+y", "-y", "-z")}, skip=())
    return m


# --- what reaches over the floor

def desk_legs():
    """The same desk on four legs: under its top and beside its drawers the floor is seen."""
    m = Mesh("desk_legs")
    m.material("top", "desk_top_a.png")
    m.material("front", "desk_front_a.png")
    m.material("side", "desk_side_a.png")
    m.material("metal", "props.png")
    x, y = DESK_DEPTH / 2, DESK_WIDTH / 2
    edge = (0.02, 0.955, 0.98, 0.99)
    m.box(-x, -y, 0.705, x, y, DESK_HEIGHT, "top", faces={s: ("top", edge) for s in ("+x", "-x", "+y", "-y")},
          skip=("-z",))
    m.box(-x + 0.001, -y + 0.001, 0.69, x - 0.001, y - 0.001, 0.704, "side", uv=(0.1, 0.1, 0.9, 0.9),
          skip=("+z", "+x", "-x", "+y", "-y"), faces={"-z": ("side", (0.05, 0.1, 0.7, 0.35))})
    for i, a in enumerate((-x + 0.04, x - 0.08)):
        for j, b in enumerate((-y + 0.04, y - 0.08)):
            m.box(a, b, 0, a + 0.04, b + 0.04, 0.705, "metal", uv=prop("metal"), skip=("-z", "+z"))
    for b in (-y + 0.045, y - 0.075):       # rails between the legs, and the board that hides the knees
        m.box(-x + 0.085, b, 0.62, x - 0.085, b + 0.03, 0.66, "metal", uv=prop("metal"), skip=("+x", "-x"))
    m.box(-x + 0.05, -y + 0.085, 0.34, -x + 0.07, y - 0.085, 0.70, "side", uv=(0.05, 0.2, 0.8, 0.6), skip=("+z",))
    m.box(-x + 0.12, -y + 0.10, 0.30, x - 0.06, -y + 0.52, 0.69, "side", uv=(0.02, 0.1, 0.5, 0.5),
          faces={"+x": ("front", (0.012, 0.02, 0.30, 0.62))}, skip=("+z",))
    return m


def chair_star():
    """A swivel chair whose seat reaches over the floor: a column on a foot of five beams."""
    m = Mesh("chair_star")
    m.material("fabric", "chair_blue.png")
    m.material("metal", "props.png")
    x, y = CHAIR_DEPTH / 2, CHAIR_WIDTH / 2
    for k in range(5):
        turn = 90 + 72 * k
        c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
        m.box(0.125 * c - 0.105, 0.125 * s - 0.02, 0.05 + 0.0001 * k, 0.125 * c + 0.105, 0.125 * s + 0.02, 0.085, "metal",
              uv=part_of(prop("bin"), 0, 0, 1, 0.1), yaw_deg=turn, skip=())
        m.prism(0.215 * c, 0.215 * s, 0, 0.06, 0.025, 0.025, 6, "metal", uv=part_of(prop("phone"), 0, 0.1, 0.2, 0.9),
                turn_deg=turn)
    m.prism(0, 0, 0.06, 0.40, 0.04, 0.03, 8, "metal", uv=prop("metal"), skip_top=True)
    m.box(-x + 0.08, -0.10, 0.36, x - 0.14, 0.10, 0.40, "metal", uv=part_of(prop("bin"), 0, 0, 1, 0.1), skip=("+z",))
    m.box(-x + 0.005, -y, 0.40, x, y, 0.50, "fabric", uv=(0, 0.1, 1, 0.4), faces={"+z": ("fabric", None)}, skip=())
    m.box(-x + 0.02, -0.035, 0.38, -x + 0.05, 0.035, 0.62, "metal", uv=prop("metal"), skip=("-z", "+z"))
    m.box(-x, -y + 0.02, 0.56, -x + 0.07, y - 0.02, 0.98, "fabric", skip=())
    for s in (-1, 1):
        a, b = sorted((s * (y - 0.05), s * y))
        m.box(-x + 0.12, a, 0.64, x - 0.12, b, 0.68, "metal", uv=part_of(prop("bin"), 0, 0, 1, 0.1), skip=())
        m.box(-x + 0.20, a + 0.01, 0.502, -x + 0.25, b - 0.01, 0.64, "metal", uv=prop("metal"), skip=("-z", "+z"))
    return m


def table_legs():
    """The table on two columns, its edge far out over the floor."""
    m = Mesh("table_legs")
    m.material("top", "desk_top_b.png")
    m.material("side", "wood_shelf.png")
    m.material("metal", "props.png")
    x, y = TABLE_DEPTH / 2, TABLE_LENGTH / 2
    edge = (0.02, 0.955, 0.98, 0.99)
    m.box(-x, -y, 0.70, x, y, 0.74, "top", faces={s: ("top", edge) for s in ("+x", "-x", "+y", "-y")}, skip=("-z",))
    m.box(-x + 0.001, -y + 0.001, 0.69, x - 0.001, y - 0.001, 0.699, "side", tile=0.9,
          skip=("+z", "+x", "-x", "+y", "-y"))
    for b in (-y + 0.45, y - 0.45):
        m.prism(0, b, 0.041, 0.70, 0.06, 0.06, 8, "metal", uv=prop("metal"), skip_top=True)
        m.box(-0.30, b - 0.05, 0, 0.30, b + 0.05, 0.04, "metal", uv=part_of(prop("metal"), 0, 0.2, 1, 0.5))
    return m


# --- on walls and the ceiling: the origin is in the middle, on the face they hang on

def flat(name, texture, width, height, picture, out=0.012, rim=None):
    m = Mesh(name)
    m.material("picture", texture + ".png")
    m.box(0, -width / 2, -height / 2, out, width / 2, height / 2, "picture", uv=rim or part_of(picture, 0, 0.96, 1, 1),
          faces={"+x": ("picture", picture)}, skip=("-x",))
    return m


def poster(number):
    return flat(f"poster_{number:02d}", f"posters_{'abcd'[(number - 1) // 4]}", 0.70, 0.70, cell(2, (number - 1) % 4))


def banner(number):
    """The upper part of every other poster, for over a door or a bookcase."""
    k = 2 * number - 1
    return flat(f"banner_{number:02d}", f"posters_{'abcd'[k // 4]}", 0.80, 0.44, part_of(cell(2, k % 4), 0, 0, 1, 0.55))


def sign(name):
    picture = cell(4, SIGNS.index(name))
    small = {"socket": ("socket", 0.20, 0.10, part_of(picture, 0, 0.16, 1, 0.84)), "switch": ("switch", 0.10, 0.10, picture),
             "thermostat": ("thermostat", 0.12, 0.12, picture)}
    mesh, width, height, part = small.get(name, (f"sign_{name}", 0.40, 0.40, picture))
    return flat(mesh, "signs", width, height, part)


def duct():
    return flat("duct", "props", 0.64, 0.16, prop("duct"), out=0.018)


def radiator():
    """On the wall, its underside 10 cm over the floor when its middle hangs 45 cm high."""
    m = flat("radiator", "props", 0.81, 0.70, prop("radiator"), out=0.12)
    return m


def window():
    """A pane that shines, 1.64 m by 1.44 m, and its frame, 6 cm deep."""
    m = Mesh("window")
    m.material("view", "window_a.png")
    m.material("frame", "plain_white.png")
    w, h = 0.82, 0.72
    m.box(0, -w, -h, 0.004, w, h, "view", faces={"+x": ("view", None)}, skip=("-x", "+y", "-y", "+z", "-z"))
    for k, (y0, z0, y1, z1) in enumerate(((-w, -h, -w + 0.05, h), (w - 0.05, -h, w, h), (-w + 0.051, -h, w - 0.051, -h + 0.05),
                                          (-w + 0.051, h - 0.05, w - 0.051, h), (-0.03, -h + 0.051, 0.03, h - 0.051))):
        m.box(0.005, y0, z0, 0.06, y1, z1, "frame", skip=("-x",))
    m.box(0.0605, 0.034, -0.06, 0.075, 0.05, 0.06, "frame", skip=("-x",))
    return m


def door():
    m = Mesh("door")
    m.material("door", "door.png")
    m.material("frame", "props.png")
    m.box(0, -0.51, -1.06, 0.03, 0.51, 1.06, "frame", uv=prop("metal"), faces={"+x": ("door", None)}, skip=("-x", "-z"))
    m.box(0.031, 0.28, -0.05, 0.07, 0.42, -0.02, "frame", uv=prop("metal"), skip=("-x",))
    return m


def lamp():
    """A ceiling lamp, 1.2 m along x by 0.6 m; the origin is on the ceiling."""
    m = Mesh("lamp")
    m.material("lamp", "props.png")
    m.box(-0.6, -0.3, -0.025, 0.6, 0.3, -0.001, "lamp", uv=part_of(prop("metal"), 0, 0.4, 1, 0.5),
          faces={"-z": ("lamp", prop("lamp"))}, skip=("+z",))
    return m


def extinguisher():
    """A fire extinguisher in its bracket."""
    m = Mesh("extinguisher")
    m.material("red", "extinguisher.png")
    m.material("black", "props.png")
    dark = part_of(prop("bin"), 0, 0, 1, 0.1)
    m.prism(0.09, 0, -0.25, 0.17, 0.07, 0.07, 10, "red", wraps=2, top=("black", prop("metal")))
    m.prism(0.09, 0, 0.1705, 0.25, 0.03, 0.02, 6, "black", uv=dark, turn_deg=8)
    m.box(0.02, -0.02, 0.19, 0.17, 0.02, 0.22, "black", uv=dark, skip=())
    m.box(0, -0.05, -0.28, 0.15, 0.05, -0.252, "black", uv=prop("metal"), skip=("-x",))
    return m


def plate(number):
    """A numbered plate for a vertical face: it hangs at its origin and looks along +x."""
    m = Mesh(f"plate_{number:02d}")
    m.material("plate", "plates.png")
    face = cell(8, number - 1)
    m.box(0, -0.08, -0.08, 0.004, 0.08, 0.08, "plate", uv=part_of(face, 0, 0.95, 1, 1),
          faces={"+x": ("plate", face)}, skip=("-x", "-z"))
    return m


def sheet(number):
    """A page on a vertical face, like a plate."""
    m = Mesh(f"sheet_{number:02d}")
    m.material("page", "sheets.png")
    face = cell(4, number - 1)
    m.box(0, -0.13, -0.17, 0.003, 0.13, 0.17, "page", uv=part_of(face, 0, 0.97, 1, 1),
          faces={"+x": ("page", face)}, skip=("-x", "-z"))
    return m


SHELVES, PLATES, SHEETS, POSTERS, BANNERS = 5, 40, 16, 16, 8


def all_meshes():
    out = [desk(), chair(), monitor(), keyboard(), phone(), mug(), book_pile(), drawers(), partition(),
           cupboard(0.90, 1.80, "cupboard_tall"), cupboard(0.90, 0.80, "cupboard_low"), cupboard(0.73, 1.90, "cupboard_end"), printer(), plant(), bin_(),
           boxes(), table()]
    out += [desk_legs(), chair_star(), table_legs(), duct(), radiator(), window(), door(), lamp(), extinguisher(),
            flat("whiteboard", "whiteboard", 2.20, 1.30, FULL, out=0.03),
            flat("pinboard", "pinboard", 1.60, 1.10, FULL, out=0.03)]
    out += [sign(name) for name in SIGNS]
    out += [poster(k) for k in range(1, POSTERS + 1)]
    out += [banner(k) for k in range(1, BANNERS + 1)]
    out += [shelf(k) for k in range(1, SHELVES + 1)]
    out += [plate(k) for k in range(1, PLATES + 1)]
    out += [sheet(k) for k in range(1, SHEETS + 1)]
    return out
