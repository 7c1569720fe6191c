# SPDX-License-Identifier: BSD-3-Clause
"""What makes a street: windows, doors and shops for the fronts of houses, roofs, cars, trees, lamp posts. Origins as in
home.py."""

import math
import random

from furniture import part_of
from home import made_of, on_wall
from people import ring
from street_textures import CAR, THINGS
from textures import cell


def thing(name):
    return cell(4, THINGS.index(name))


def car_cell(name):
    x, y, w, h = CAR[name]
    d = 1.5
    return ((x + d) / 512, (y + d) / 512, (x + w - d) / 512, (y + h - d) / 512)


def car():
    """4.2 m long, 1.74 m wide, with a skirt down to the road."""
    m = made_of("car", paint="car_red")
    under, side, body = car_cell("under"), car_cell("side"), car_cell("body")

    def plan(front, back, half, z):
        return [(front, -half, z), (front, half, z), (back, half, z), (back, -half, z)]
    around = (("front", 1, 0), ("side", 0, 1), ("back", 0, 1), ("side", 1, 0))

    def skin(v0, v1):
        def of(i):
            name, u0, u1 = around[i]
            rect = part_of(car_cell(name), 0, v0, 1, v1)
            if u0 > u1 and name == "side":   # the other side: front of the car still to its front
                rect = (rect[2], rect[1], rect[0], rect[3])
            return "paint", rect
        return of
    m.loft(plan(2.02, -2.02, 0.82, 0), plan(2.05, -2.06, 0.85, 0.40), "paint", sides=skin(0.55, 1.0))
    m.loft(plan(2.08, -2.09, 0.87, 0.401), plan(2.00, -2.05, 0.84, 0.86), "paint", sides=skin(0.0, 0.55), top=("paint", car_cell("bonnet")))
    glass, wind = car_cell("glass_side"), car_cell("glass_front")
    m.loft(plan(1.00, -1.86, 0.80, 0.861), plan(0.42, -1.45, 0.64, 1.40), "paint",
           sides=lambda i: ("paint", glass if i % 2 else wind), top=("paint", body))
    for s in (-1, 1):
        m.box(0.80, s * 0.90 - 0.07, 0.90, 0.95, s * 0.90 + 0.07, 1.02, "paint", uv=part_of(body, 0, 0, 0.5, 0.5), skip=())
    m.box(1.2, -0.25, 0.862, 1.45, 0.0, 0.866, "paint", uv=part_of(car_cell("front"), 0.27, 0.42, 0.73, 0.55), yaw_deg=9)
    return m


def tree(k):
    m = made_of(f"tree_{k}", bark="bark", crown="crown")
    rng = random.Random(f"tree {k}")
    m.prism(0, 0, 0, 2.4, 0.19, 0.14, 9, "bark", uv=(0, 0, 1, 2.2), skip_top=True)
    for j in range(5):
        r = (1.0, 1.5, 1.35, 1.2, 0.8)[j] * rng.uniform(0.85, 1.15)
        x, y, z = rng.uniform(-0.45, 0.45), rng.uniform(-0.45, 0.45), 1.95 + 0.55 * j
        turn = rng.uniform(0, 50)
        m.prism(x, y, z, z + 0.6, r * 0.6, r, 8, "crown", uv=(0, 0, 4, 0.9), turn_deg=turn, skip_top=True)
        m.loft(ring(x, y, z, r * 0.62, r * 0.62, 8), ring(x, y, z + 0.002, r * 0.63, r * 0.63, 8), "crown",
               bottom=("crown", (0, 0, 1.4, 1.4)))
        m.prism(x, y, z + 0.6, z + 1.1, r, r * 0.4, 8, "crown", uv=(0, 0, 4, 0.8), turn_deg=turn, top=("crown", (0, 0, 1, 1)))
    return m


def lamp_post():
    m = made_of("lamp_post", things="things")
    post = thing("post")
    m.prism(0, 0, 0, 0.9, 0.13, 0.09, 8, "things", uv=post, top=("things", part_of(post, 0, 0, 1, 0.1)))
    m.prism(0, 0, 0.901, 3.4, 0.055, 0.045, 8, "things", uv=(post[0], post[1], post[2], post[3]), skip_top=True)
    m.prism(0, 0, 3.401, 3.95, 0.12, 0.24, 6, "things", uv=thing("lamp"), skip_top=True)
    m.prism(0, 0, 3.951, 4.25, 0.27, 0.06, 6, "things", uv=post, top=("things", part_of(post, 0, 0, 1, 0.1)))
    m.box(0.056, -0.2, 2.35, 0.07, 0.2, 2.75, "things", uv=part_of(thing("sign_park"), 0, 0, 1, 0.05),
          faces={"+x": ("things", thing("sign_park")), "-x": ("things", thing("gutter"))}, skip=())
    return m


def sign(name, what):
    m = made_of(name, things="things")
    m.prism(0, 0, 0, 2.7, 0.04, 0.04, 6, "things", uv=thing("gutter"), top=("things", thing("gutter")))
    m.box(0.041, -0.3, 2.05, 0.055, 0.3, 2.65, "things", uv=part_of(thing(what), 0, 0, 1, 0.04),
          faces={"+x": ("things", thing(what)), "-x": ("things", thing("gutter"))}, skip=())
    m.prism(0, 0, 0.0, 0.3, 0.10, 0.07, 6, "things", uv=thing("post"), top=("things", thing("gutter")))
    return m


def column():
    """A column of posters."""
    m = made_of("column", things="things")
    posters = thing("column")
    m.prism(0, 0, 0, 0.35, 0.66, 0.62, 16, "things", uv=thing("post"), wraps=6, skip_top=True)
    for k in range(4):
        m.prism(0, 0, 0.351 + 0.55 * k, 0.90 + 0.55 * k, 0.58, 0.58, 16, "things", uv=posters, turn_deg=37 * k, wraps=4, skip_top=True)
    m.prism(0, 0, 2.56, 2.95, 0.68, 0.20, 16, "things", uv=thing("post"), wraps=6, top=("things", thing("gutter")))
    return m


def pillar_box(name, what, depth, width, height):
    m = made_of(name, things="things")
    m.box(-depth / 2, -width / 2, 0, depth / 2, width / 2, height, "things", uv=thing(what))
    return m


def bin_():
    m = made_of("bin", things="things")
    m.prism(0, 0, 0, 0.82, 0.21, 0.23, 10, "things", uv=thing("bin"), wraps=2, top=("things", thing("grate")))
    return m


def bench():
    m = made_of("bench", things="things")
    m.box(-0.24, -0.80, 0, 0.22, 0.80, 0.42, "things", uv=thing("bench"), faces={"+z": ("things", thing("bench"))})
    m.box(-0.26, -0.80, 0.421, -0.18, 0.80, 0.86, "things", uv=thing("bench"), skip=())
    return m


def a_board():
    m = made_of("a_board", things="things")
    m.loft([(0.28, -0.31, 0), (0.28, 0.31, 0), (-0.28, 0.31, 0), (-0.28, -0.31, 0)],
           [(0.05, -0.30, 1.0), (0.05, 0.30, 1.0), (-0.05, 0.30, 1.0), (-0.05, -0.30, 1.0)], "things",
           sides=lambda i: ("things", thing("board") if i % 2 == 0 else part_of(thing("bench"), 0, 0, 1, 0.5)),
           top=("things", thing("bench")))
    return m


def planter():
    m = made_of("planter", things="things", leaves="hedge")
    m.box(-0.30, -0.60, 0, 0.30, 0.60, 0.50, "things", uv=thing("pot"))
    m.box(-0.26, -0.56, 0.501, 0.26, 0.56, 0.92, "leaves", tile=1.2)
    return m


def manhole():
    m = made_of("manhole", things="things")
    m.box(-0.35, -0.35, 0, 0.35, 0.35, 0.006, "things", uv=thing("manhole"), skip=("-z", "+x", "-x", "+y", "-y"))
    return m


def roof(width):
    """Over a front of that width; its origin is under its middle, on the front, at the height of the eaves."""
    m = made_of(f"roof_{width}", tiles="roof", side="brick_red")
    y = width / 2
    m.loft([(0.35, -y, 0), (0.35, y, 0), (-5.0, y, 0), (-5.0, -y, 0)],
           [(-2.5, -y + 0.4, 2.2), (-2.5, y - 0.4, 2.2), (-2.6, y - 0.4, 2.2), (-2.6, -y + 0.4, 2.2)], "tiles",
           sides=lambda i: ("tiles", (0, 0, width / 1.6 if i % 2 == 0 else 3.3, 2.2)), bottom=("side", (0, 0, 3, width / 1.8)))
    m.box(-1.6, y - 1.6, 0.4, -1.0, y - 1.0, 3.0, "side", tile=1.8)
    return m


def front(name, width, height, depth, picture, face=(0, 0, 1, 1)):
    m = made_of(name, picture=picture, things="things")
    m.box(0, -width / 2, -height / 2, depth, width / 2, height / 2, "things", uv=part_of(thing("gutter"), 0, 0, 1, 0.3),
          faces={"+x": ("picture", face)}, skip=("-x",))
    return m


def downpipe():
    m = made_of("downpipe", things="things")
    m.box(0, -0.06, -3.0, 0.12, 0.06, 3.0, "things", uv=thing("gutter"), skip=("-x",))
    return m


FRONTS_M = (6, 8, 10)


def all_meshes():
    out = [car(), tree(1), tree(2), lamp_post(), sign("sign_stop", "sign_stop"), sign("sign_name", "sign_name"), column(),
           pillar_box("meter", "meter", 0.26, 0.32, 1.35), pillar_box("letterbox", "letterbox", 0.36, 0.48, 1.25), bin_(), bench(), a_board(),
           planter(), manhole(), downpipe()]
    out += [roof(width) for width in FRONTS_M]
    out += [front(f"window_{k + 1}", 1.5 if k in (1, 2) else 1.3, 1.6, 0.06, "windows", cell(2, k)) for k in range(4)]
    out += [front(f"door_{k + 1}", 1.25, 2.35, 0.08, "doors", cell(2, k)) for k in range(4)]
    out += [front("shop", 3.6, 3.0, 0.12, "shop_a"), front("garage", 2.6, 2.3, 0.06, "garage")]
    out += [on_wall("dish", 0.6, 0.6, 0.1, "things", "things", thing("dish"), part_of(thing("dish"), 0, 0, 1, 0.1)),
            on_wall("house_sign", 0.5, 0.5, 0.02, "things", "things", thing("sign_name"), part_of(thing("sign_name"), 0, 0, 1, 0.05)),
            on_wall("house_letterbox", 0.35, 0.4, 0.12, "things", "things", thing("letterbox"), part_of(thing("letterbox"), 0, 0, 1, 0.05))]
    return out
