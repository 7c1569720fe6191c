# SPDX-License-Identifier: BSD-3-Clause
"""The furniture of the home. As in the office: a piece of furniture has its origin on the floor in the middle of its
footprint and its front towards +x, and reaches the floor within 5 cm of its outline (covers hang to the floor, legs are
hidden behind plinths); what hangs on walls has its origin in its middle, on the face it hangs on."""

import random

from furniture import part_of
from home_textures import KITCHEN, PAINTINGS, THINGS, TOPS
from mesh import Mesh
from textures import PROPS, cell


def thing(name):
    return cell(4, THINGS.index(name))


def unit_front(name):
    return cell(4, KITCHEN.index(name), rows=2)


def top(name):
    return cell(2, TOPS.index(name))


PLAIN = part_of(thing("drawers"), 0.36, 0.06, 0.64, 0.26)   # wood between the handles


def office_prop(name):
    return cell(4, PROPS.index(name))


def made_of(name, **materials):
    m = Mesh(name)
    for mat, texture in materials.items():
        m.material(mat, texture + ".png")
    return m


def seat(name, width):
    """A sofa or an armchair."""
    m = made_of(name, cloth="sofa", things="things")
    y = width / 2
    m.box(-0.43, -y + 0.02, 0, 0.43, y - 0.02, 0.30, "cloth", tile=0.8)
    m.box(-0.45, -y + 0.18, 0.30, -0.20, y - 0.18, 0.86, "cloth", tile=0.7, skip=("-z", "+y", "-y"))
    for s in (-1, 1):
        a, b = sorted((s * (y - 0.18), s * y))
        m.box(-0.45, a, 0.003, 0.45, b, 0.60, "cloth", tile=0.6, shift=(0.2, 0.1 + 0.2 * s))
    n = max(1, round((width - 0.4) / 0.7))
    w = (width - 0.38) / n
    for k in range(n):
        a = -y + 0.19 + k * w
        m.box(-0.20, a + 0.01, 0.301, 0.46, a + w - 0.01, 0.46, "cloth", tile=0.5, shift=(0.1 * k, 0.3))
        m.box(-0.20, a + w / 2 - 0.2, 0.47, -0.06, a + w / 2 + 0.2, 0.82, "things",
              uv=thing("cushion_a" if k % 2 == 0 else "cushion_b"), yaw_deg=6 * (k % 3) - 5)
    return m


def coffee_table():
    m = made_of("coffee_table", things="things", tops="tops")
    wood = PLAIN
    m.box(-0.28, -0.48, 0, 0.28, 0.48, 0.40, "things", uv=thing("basket"),
          faces={"+x": ("things", thing("drawers")), "-x": ("things", thing("drawers"))}, skip=("-z", "+z"))
    m.box(-0.31, -0.51, 0.40, 0.31, 0.51, 0.44, "things", uv=wood, faces={"+z": ("tops", part_of(top("breakfast"), 0, 0, 1, 0.5))},
          skip=())
    return m


def tv_bench():
    m = made_of("tv_bench", things="things", tv="television", case="../office/plastic")
    m.box(-0.21, -0.85, 0, 0.21, 0.85, 0.44, "things", uv=PLAIN,
          faces={"+x": ("things", thing("drawers"))})
    m.box(-0.10, -0.22, 0.441, 0.08, 0.22, 0.47, "case", uv=(0.05, 0.8, 0.3, 0.95))
    m.box(-0.03, -0.62, 0.47, 0.03, 0.62, 1.20, "case", uv=(0.02, 0.02, 0.2, 0.08),
          faces={"+x": ("tv", (0, 0, 1, 0.8)), "-x": ("case", None)}, skip=())
    m.box(-0.05, 0.28, 0.442, 0.17, 0.80, 0.52, "case", uv=(0.02, 0.02, 0.2, 0.08), faces={"+x": ("tv", (0, 0.81, 1, 1))})
    return m


def bed():
    m = made_of("bed", quilt="quilt", things="things")
    m.box(-1.00, -0.80, 0, 1.00, 0.80, 0.48, "quilt", faces={
        "+z": ("quilt", (0, 0, 0.8, 1)), "+x": ("quilt", (0, 0.1, 0.8, 0.34)), "+y": ("quilt", (0, 0.3, 1, 0.54)),
        "-y": ("quilt", (0, 0.6, 1, 0.84)), "-x": ("quilt", (0, 0.1, 0.8, 0.34))})
    m.box(-1.06, -0.84, 0, -1.001, 0.84, 1.05, "things", uv=PLAIN)
    m.box(-0.98, -0.76, 0.481, -0.48, 0.76, 0.52, "things", uv=thing("linen"))
    for s in (-1, 1):
        m.box(-0.95, s * 0.4 - 0.32, 0.521, -0.55, s * 0.4 + 0.32, 0.64, "things", uv=thing("linen"), yaw_deg=4 * s)
        m.box(-0.66, s * 0.38 - 0.2, 0.525, -0.50, s * 0.38 + 0.2, 0.80, "things", uv=thing("cushion_a" if s > 0 else "cushion_b"))
    return m


def nightstand():
    m = made_of("nightstand", things="things")
    m.box(-0.20, -0.22, 0, 0.20, 0.22, 0.52, "things", uv=PLAIN,
          faces={"+x": ("things", thing("drawers"))})
    m.prism(-0.02, 0.03, 0.52, 0.70, 0.05, 0.03, 8, "things", uv=thing("basket"), skip_top=True)
    m.prism(-0.02, 0.03, 0.70, 0.92, 0.15, 0.09, 10, "things", uv=thing("shade"), wraps=2)
    m.box(0.05, -0.17, 0.521, 0.17, 0.0, 0.56, "things", uv=thing("towel"), yaw_deg=14)
    return m


def wardrobe():
    m = made_of("wardrobe", front="wardrobe", side="../office/wood_dark", things="things")
    m.box(-0.30, -0.80, 0, 0.30, 0.80, 2.06, "side", tile=0.8, faces={"+x": ("front", None)})
    m.box(-0.31, -0.82, 2.06, 0.33, 0.82, 2.11, "side", tile=0.6, skip=())
    m.box(-0.2, -0.6, 2.111, 0.2, 0.05, 2.36, "things", uv=thing("basket"))
    return m


def dresser():
    m = made_of("dresser", things="things")
    m.box(-0.23, -0.50, 0, 0.23, 0.50, 0.86, "things", uv=PLAIN,
          faces={"+x": ("things", thing("drawers"))})
    m.box(-0.22, -0.36, 0.861, -0.18, 0.36, 1.66, "things", uv=PLAIN,
          faces={"+x": ("things", thing("mirror"))})
    m.prism(0.02, 0.34, 0.86, 1.02, 0.06, 0.09, 8, "things", uv=thing("cushion_b"), wraps=2)
    m.box(-0.05, -0.44, 0.861, 0.12, -0.2, 0.98, "things", uv=thing("cushion_a"), yaw_deg=9)
    return m


def table():
    """A table for four, its cloth down to the floor."""
    m = made_of("table", cloth="cloth", tops="tops", things="things", leaves="../office/props")
    x, y = 0.45, 0.72
    m.loft([(x, -y, 0), (x, y, 0), (-x, y, 0), (-x, -y, 0)],
           [(x - 0.03, -y + 0.03, 0.75), (x - 0.03, y - 0.03, 0.75), (-x + 0.03, y - 0.03, 0.75), (-x + 0.03, -y + 0.03, 0.75)],
           "cloth", sides=lambda i: ("cloth", (0.1 * i, 0, 0.1 * i + (1.8 if i % 2 == 0 else 1.1), 0.94)),
           top=("cloth", (0, 0, 1.8, 1.1)))
    m.box(-0.36, -0.62, 0.751, 0.36, 0.62, 0.757, "tops", uv=part_of(top("breakfast"), 0, 0, 1, 0.02),
          faces={"+z": ("tops", top("breakfast"))})
    m.prism(0, 0, 0.757, 0.90, 0.06, 0.09, 8, "things", uv=thing("towel"), wraps=2)
    m.prism(0, 0, 0.901, 1.12, 0.07, 0.16, 8, "leaves", uv=office_prop("leaves"), top=("leaves", office_prop("leaves")), wraps=2)
    return m


def chair():
    """A chair under a loose cover."""
    m = made_of("chair", cloth="cloth", things="things")
    m.box(-0.23, -0.23, 0, 0.23, 0.23, 0.46, "cloth", tile=0.6)
    m.box(-0.23, -0.215, 0.461, -0.16, 0.215, 0.94, "cloth", tile=0.6, shift=(0.2, 0.1))
    m.box(-0.155, -0.20, 0.461, 0.20, 0.20, 0.52, "things", uv=thing("cushion_a"))
    return m


def unit(name, what, top_name):
    """A kitchen unit, 0.6 m wide and deep, 0.9 m high."""
    m = made_of(name, front="kitchen", tops="tops")
    side = part_of(unit_front("cupboard"), 0.05, 0.3, 0.9, 0.8)
    m.box(-0.29, -0.299, 0, 0.28, 0.299, 0.86, "front", uv=side, faces={"+x": ("front", unit_front(what))}, skip=("-z", "+z"))
    m.box(-0.29, -0.2995, 0.86, 0.31, 0.2995, 0.90, "tops", uv=part_of(top("granite"), 0, 0, 1, 0.12),
          faces={"+z": ("tops", top(top_name))}, skip=("-x",))
    if top_name == "basin":
        m.box(-0.22, -0.02, 0.901, -0.18, 0.02, 1.16, "front", uv=part_of(unit_front("oven"), 0.1, 0.0, 0.9, 0.1))
        m.box(-0.18, -0.02, 1.12, 0.0, 0.02, 1.159, "front", uv=part_of(unit_front("oven"), 0.1, 0.0, 0.9, 0.1), skip=())
    return m


def fridge():
    m = made_of("fridge", front="kitchen", things="things")
    m.box(-0.29, -0.299, 0, 0.31, 0.299, 1.86, "front", uv=part_of(unit_front("fridge"), 0.1, 0.45, 0.9, 0.9),
          faces={"+x": ("front", unit_front("fridge"))})
    m.box(-0.18, -0.25, 1.861, 0.2, 0.22, 2.10, "things", uv=thing("basket"))
    return m


def wall_unit(name, what):
    """A cupboard or a shelf over the kitchen units: it hangs at its middle."""
    m = made_of(name, front="kitchen")
    m.box(0, -0.299, -0.35, 0.34, 0.299, 0.35, "front", uv=part_of(unit_front("cupboard"), 0.05, 0.3, 0.9, 0.8),
          faces={"+x": ("front", part_of(unit_front(what), 0, 0.02, 1, 0.92))}, skip=("-x",))
    return m


def tub():
    m = made_of("tub", things="things")
    m.box(-0.38, -0.84, 0, 0.38, 0.84, 0.56, "things", uv=thing("tub"), faces={"+z": ("things", part_of(thing("toilet"), 0, 0.3, 1, 1))})
    m.box(-0.12, 0.70, 0.561, 0.12, 0.80, 0.78, "things", uv=part_of(thing("lamp"), 0, 0, 1, 0.1))
    m.box(0.30, -0.5, 0.30, 0.395, 0.1, 0.60, "things", uv=thing("towel"), skip=("-x",))
    return m


def toilet():
    m = made_of("toilet", things="things")
    m.box(-0.10, -0.18, 0, 0.33, 0.18, 0.42, "things", uv=thing("toilet"), faces={"+z": ("things", part_of(thing("mirror"), 0.1, 0.1, 0.9, 0.9))})
    m.box(-0.33, -0.21, 0, -0.101, 0.21, 0.84, "things", uv=thing("toilet"))
    return m


def basin():
    m = made_of("basin", things="things", tops="tops")
    m.box(-0.23, -0.40, 0, 0.22, 0.40, 0.82, "things", uv=PLAIN,
          faces={"+x": ("things", thing("drawers"))}, skip=("-z", "+z"))
    m.box(-0.24, -0.42, 0.82, 0.25, 0.42, 0.88, "things", uv=part_of(thing("toilet"), 0, 0.4, 1, 1),
          faces={"+z": ("tops", part_of(top("basin"), 0.05, 0.15, 0.6, 0.9))}, skip=())
    return m


def basket():
    m = made_of("basket", things="things")
    m.prism(0, 0, 0, 0.55, 0.20, 0.23, 10, "things", uv=thing("basket"), top=("things", thing("towel")), wraps=3)
    return m


def shoe_rack():
    m = made_of("shoe_rack", things="things")
    m.box(-0.15, -0.45, 0, 0.15, 0.45, 0.80, "things", uv=PLAIN,
          faces={"+x": ("things", thing("shoes"))})
    m.box(-0.10, -0.38, 0.801, 0.12, 0.02, 0.95, "things", uv=thing("basket"), yaw_deg=5)
    return m


def on_wall(name, width, height, depth, mat, texture, face, rim):
    m = made_of(name, **{mat: texture})
    m.box(0, -width / 2, -height / 2, depth, width / 2, height / 2, mat, uv=rim, faces={"+x": (mat, face)}, skip=("-x",))
    return m


def painting(k):
    face = cell(4, k - 1)
    return on_wall(f"painting_{k:02d}", 0.6, 0.6, 0.03, "picture", "paintings", face, part_of(face, 0, 0, 1, 0.04))


def window():
    """1.4 m by 1.3 m with curtains beside it: 2.1 m by 1.6 m in all."""
    m = made_of("window", view="window", curtain="curtain", things="things")
    m.box(0, -0.70, -0.65, 0.03, 0.70, 0.65, "things", uv=part_of(thing("skirting"), 0, 0.3, 1, 0.8), faces={"+x": ("view", None)},
          skip=("-x",))
    m.box(0, -0.78, -0.72, 0.13, 0.78, -0.655, "things", uv=part_of(thing("skirting"), 0, 0.3, 1, 0.8), skip=("-x",))
    for s in (-1, 1):
        m.box(0.03, s * 0.88 - 0.17, -0.64, 0.09, s * 0.88 + 0.17, 0.76, "curtain", uv=(0, 0, 0.05, 1),
              faces={"+x": ("curtain", (0, 0, 0.6, 1.8))}, skip=("-x",))
    m.box(0.02, -1.05, 0.765, 0.10, 1.05, 0.80, "things", uv=PLAIN, skip=("-x",))
    return m


def radiator():
    m = made_of("radiator", props="../office/props")
    m.box(0, -0.55, -0.36, 0.10, 0.55, 0.36, "props", uv=part_of(office_prop("radiator"), 0, 0, 1, 0.05),
          faces={"+x": ("props", office_prop("radiator"))}, skip=("-x", "-z"))
    return m


def wall_shelf():
    m = made_of("wall_shelf", books="../office/books_a", things="things")
    wood = PLAIN
    m.box(0, -0.50, -0.17, 0.22, 0.50, -0.14, "things", uv=wood, skip=("-x",))
    rng = random.Random("wall shelf")
    y = -0.47
    while y < 0.38:
        w = rng.uniform(0.14, 0.30)
        row = rng.randrange(4)
        u = rng.random()
        m.box(0.01, y, -0.139, 0.19, min(0.47, y + w), 0.09 + rng.uniform(0, 0.06), "books", uv=(u, 0.02, u + 0.02, 0.2),
              faces={"+x": ("books", (u, row / 4 + 0.06, u + w / 0.9, row / 4 + 0.246))}, skip=("-x", "-z"))
        y += w + 0.03
    return m


def coats():
    m = made_of("coats", props="../office/props", things="things")
    m.box(0, -0.55, 0.42, 0.03, 0.55, 0.52, "things", uv=PLAIN, skip=("-x",))
    for k in range(3):
        y = -0.36 + 0.36 * k
        m.box(0.031, y - 0.14, -0.5 + 0.08 * k, 0.15, y + 0.14, 0.44, "props", uv=office_prop("coat"), skip=("-x",))
    return m


def towels():
    return on_wall("towels", 0.7, 0.6, 0.05, "things", "things", thing("towel"), part_of(thing("towel"), 0, 0, 1, 0.08))


def lamp():
    """A lamp under the ceiling, 0.5 m square; its origin is on the ceiling."""
    m = made_of("lamp", things="things")
    m.box(-0.25, -0.25, -0.06, 0.25, 0.25, -0.001, "things", uv=part_of(thing("lamp"), 0, 0, 1, 0.05),
          faces={"-z": ("things", thing("lamp"))}, skip=("+z",))
    return m


def door():
    """A leaf of 1.04 m by 2.04 m; it turns about its origin and reaches to +x from there."""
    m = made_of("door", leaf="door", things="things")
    edge = (0.0, 0.0, 0.02, 1.0)
    m.box(0.01, -0.02, 0.004, 1.05, 0.02, 2.04, "leaf", uv=edge,
          faces={"-y": ("leaf", None), "+y": ("leaf", (1, 0, 0, 1))}, skip=("-z",))
    return m


def all_meshes():
    out = [seat("sofa", 2.1), seat("armchair", 0.95), coffee_table(), tv_bench(), bed(), nightstand(), wardrobe(), dresser(), table(),
           chair(), fridge(), tub(), toilet(), basin(), basket(), shoe_rack(), window(), radiator(), wall_shelf(), coats(), towels(),
           lamp(), door()]
    out += [unit(f"unit_{what}", what, on_top) for what, on_top in (
        ("cupboard", "granite"), ("drawers", "granite"), ("oven", "hob"), ("washer", "granite"), ("sink", "basin"))]
    out += [wall_unit("wall_unit_glass", "glass"), wall_unit("wall_unit_jars", "jars"), wall_unit("wall_unit_cupboard", "cupboard")]
    out += [painting(k) for k in range(1, PAINTINGS + 1)]
    out += [on_wall("mirror", 0.6, 0.8, 0.03, "things", "things", thing("mirror"), part_of(thing("mirror"), 0, 0, 1, 0.05)),
            on_wall("clock", 0.36, 0.36, 0.05, "things", "things", thing("clock"), part_of(thing("clock"), 0, 0, 1, 0.05)),
            on_wall("cat", 0.5, 0.5, 0.03, "things", "things", thing("cat"), part_of(thing("cat"), 0, 0, 1, 0.05))]
    return out
