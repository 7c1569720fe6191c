# SPDX-License-Identifier: BSD-3-Clause
"""The furniture. Every piece stands with the middle of its footprint on the origin and its front towards +x.

What is lower than the robot (0.80 m) reaches the floor within 5 cm of its outline: a camera that sees the foot of a
piece of furniture has seen how far it reaches. So desks have closed sides and fronts, chairs are tubs with a skirt, and
shelves stand on a plinth.
"""

import random

from mesh import Mesh
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
    m.box(-0.10, -0.12, 0, 0.10, 0.12, 0.015, "case", uv=(0.05, 0.8, 0.3, 0.95))
    m.box(-0.06, -0.03, 0.015, -0.03, 0.03, 0.20, "case", uv=(0.4, 0.5, 0.6, 0.7), skip=("-z", "+z"))
    m.box(-0.03, -0.27, 0.10, 0.01, 0.27, 0.44, "case", uv=(0.02, 0.02, 0.2, 0.08),
          faces={"+x": ("screen", None), "-x": ("case", None)}, skip=())
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
        m.prism(x, y, z, z + 0.12, r * 0.5, r, 7, "plant", uv=prop("leaves"), turn_deg=turn, skip_top=True, wraps=2)
        m.prism(x, y, z + 0.12, z + 0.25, r, r * 0.3, 7, "plant", uv=prop("leaves"), turn_deg=turn, wraps=2)
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


SHELVES, PLATES, SHEETS = 5, 40, 16


def all_meshes():
    out = [desk(), chair(), monitor(), keyboard(), phone(), mug(), book_pile(), drawers(), partition(),
           cupboard(0.90, 1.80, "cupboard_tall"), cupboard(0.90, 0.80, "cupboard_low"), cupboard(0.73, 1.90, "cupboard_end"), printer(), plant(), bin_(),
           boxes(), table()]
    out += [shelf(k) for k in range(1, SHELVES + 1)]
    out += [plate(k) for k in range(1, PLATES + 1)]
    out += [sheet(k) for k in range(1, SHEETS + 1)]
    return out
