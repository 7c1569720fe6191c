# SPDX-License-Identifier: BSD-3-Clause
"""Where everything stands in the office, and its world file.

A placement is (name, mesh, x_m, y_m, theta_deg, z_m, textures). Desks stand in blocks of four, back to back, with the
same chairs and monitors everywhere: places look alike. Labels, papers, screens, books and posters tell them apart.
"""

import math
import random

from furniture import (CHAIR_DEPTH, DESK_DEPTH, DESK_HEIGHT, DESK_WIDTH, PLATES, SHEETS, SHELF_DEPTH, SHELF_WIDTH,
                       SHELVES, TABLE_LENGTH)
from room import LAMPS, WINDOW_OUT

CHAIR_OUT = 0.28      # how far a pushed-in chair stands out in front of its desk
GAP = 0.04            # between desks that stand back to back: the partition
SKIRTING = 0.02

CUPBOARD_FRONTS = {"tall": "bcad", "low": "ab", "end": "d"}   # doors of wood, of sheet, lockers, doors of glass
CUPBOARD_SIDES = {"a": "wood_shelf", "b": "laminate", "c": "plain_steel", "d": "wood_shelf"}


class Office:
    def __init__(self):
        self.rng = random.Random("office layout")
        self.objects = []
        self.desks = self.plates = self.sheets = self.screens = 0
        self.shelf_kind = 0

    def put(self, name, mesh, x, y, theta=0.0, z=0.0, **textures):
        self.objects.append((name, mesh, x, y, theta, z, textures))

    def beside(self, x, y, theta, forward, left):
        c, s = math.cos(math.radians(theta)), math.sin(math.radians(theta))
        return x + c * forward - s * left, y + s * forward + c * left

    def plate(self, x, y, theta, z):
        """The next number; no number is used twice."""
        self.plates += 1
        assert self.plates <= PLATES
        self.put(f"plate-{self.plates:02d}", f"plate_{self.plates:02d}", x, y, theta, z)

    def sheet(self, x, y, theta, z):
        self.sheets += 1
        self.put(f"sheet-{self.sheets:02d}", f"sheet_{(self.sheets * 5) % SHEETS + 1:02d}", x, y, theta, z)

    def desk(self, x, y, theta, ab):
        """A desk with all that belongs to it, its front towards theta; `ab` is beech or laminate."""
        rng = self.rng
        self.desks += 1
        k = self.desks
        self.put(f"desk-{k:02d}", "desk", x, y, theta, top=f"desk_top_{'ab'[(k // 2) % 2]}",
                 front=f"desk_front_{ab}", side=f"desk_side_{ab}")
        out = CHAIR_OUT - rng.choice((0.0, 0.0, 0.02, 0.04))
        cx, cy = self.beside(x, y, theta, DESK_DEPTH / 2 + out - CHAIR_DEPTH / 2, rng.uniform(-0.02, 0.02))
        self.put(f"chair-{k:02d}", "chair", cx, cy, theta + 180, fabric="chair_red" if k % 5 == 2 else "chair_blue")
        top = DESK_HEIGHT
        for which in range(2 if k % 4 == 1 else 1):
            self.screens += 1
            side = (rng.uniform(-0.1, 0.1), 0.0)[0] if k % 4 != 1 else (-0.32, 0.32)[which]
            mx, my = self.beside(x, y, theta, -0.17, side)
            self.put(f"monitor-{k:02d}{'ab'[which]}", "monitor", mx, my, theta + rng.uniform(-12, 12), top,
                     screen=f"screen_{(self.screens * 5) % 6 + 1}")
        self.put(f"keyboard-{k:02d}", "keyboard", *self.beside(x, y, theta, 0.18, rng.uniform(-0.06, 0.06)),
                 theta + rng.uniform(-5, 5), top)
        extras = rng.sample([("phone", -0.52), ("mug", 0.38), ("book_pile", 0.60)], rng.choice((1, 2, 2, 3)))
        for mesh, side in extras:
            ex, ey = self.beside(x, y, theta, rng.uniform(-0.12, 0.2), side + rng.uniform(-0.06, 0.06))
            books = {"books": "books_b"} if mesh == "book_pile" and k % 2 else {}
            self.put(f"{mesh.replace('_', '-')}-{k:02d}", mesh, ex, ey, theta + rng.uniform(-25, 25), top, **books)

    def block(self, x0, yc, columns, ab):
        """Desks back to back: a southern and a northern row of `columns` from x0 on, about the line y = yc."""
        for i in range(columns):
            x = x0 + DESK_WIDTH * (i + 0.5)
            for theta in (-90.0, 90.0):
                self.desk(*self.beside(x, yc, theta, GAP / 2 + DESK_DEPTH / 2, 0), theta, ab)
            self.put(f"partition-{len(self.objects):03d}", "partition", x, yc, 90.0,
                     fabric=f"partition_{'ab'[(i + self.desks // 4) % 2]}")
        # What tells the ends apart: numbers and papers on the end panels.
        inset = 0.02 - 0.0005
        for x, theta in ((x0 + inset, 180.0), (x0 + columns * DESK_WIDTH - inset, 0.0)):
            for side in (-1, 1):
                y = yc + side * (GAP / 2 + DESK_DEPTH / 2)
                self.plate(x, y + 0.22 * side, theta, 0.58)
                self.sheet(x, y - 0.16 * side, theta, 0.44)

    def shelf(self, x, y, theta, plate=True, wood="wood_shelf"):
        self.shelf_kind += 1
        k = self.shelf_kind
        self.put(f"shelf-{k:02d}", f"shelf_{k * 2 % SHELVES + 1}", x, y, theta,
                 books="books_a" if (k // 2) % 2 else "books_b", wood=wood)
        if plate:
            px, py = self.beside(x, y, theta, SHELF_DEPTH / 2 - 0.002, 0)
            self.plate(px, py, theta, 1.80)

    def cupboard(self, x, y, theta, kind, plate=True):
        k = sum(1 for o in self.objects if o[1].startswith("cupboard")) + 1
        front = CUPBOARD_FRONTS[kind][k % len(CUPBOARD_FRONTS[kind])]
        self.put(f"cupboard-{k:02d}", f"cupboard_{kind}", x, y, theta, front=f"cupboard_{front}", side=CUPBOARD_SIDES[front])
        if plate and kind != "low":
            self.plate(*self.beside(x, y, theta, 0.21 - 0.0005, 0.22), theta, 1.42)
            self.sheet(*self.beside(x, y, theta, 0.21 - 0.0005, -0.2), theta, 1.35 + 0.1 * (k % 3))


def place():
    o = Office()
    o.put("room", "room", 0, 0)
    back = SKIRTING + SHELF_DEPTH / 2
    cup = SKIRTING + 0.21

    # South wall: seven bookcases and cupboards, from the west corner eastwards.
    for k in range(7):
        x = 0.42 + SHELF_WIDTH * (k + 0.5)
        if k in (2, 5):
            o.cupboard(x, SKIRTING + 0.17, 90, "tall")
        else:
            o.shelf(x, back, 90)
    # West wall: bookcases on both sides of the whiteboard.
    for k in range(4):
        o.shelf(back, 0.03 + SHELF_WIDTH * (k + 0.5), 0, plate=k > 0, wood="laminate")
    for k in range(3):
        o.shelf(back, 6.55 + SHELF_WIDTH * (k + 0.5), 0, wood="laminate")
    # East wall: tall cupboards.
    for k in range(4):
        o.cupboard(10 - cup, 1.95 + 0.90 * (k + 0.5), 180, "tall")
    # North wall: sideboards under the windows, and what gathers in corners.
    for k, x in enumerate([0.86 + 0.90 * i for i in range(5)] + [5.95 + 0.90 * i for i in range(4)]):
        o.cupboard(x, 10 - 0.125 - 0.21, -90, "low")
    o.put("plant-1", "plant", 0.23, 9.66)
    o.put("boxes-1", "boxes", 0.24, 9.19, 0.0)
    o.put("printer", "printer", 9.66, 9.62, 180.0)
    o.put("plant-2", "plant", 9.72, 9.08)
    o.put("plant-4", "plant", 5.205, 9.63)
    o.put("plant-3", "plant", 6.93, 0.21)
    o.put("boxes-2", "boxes", 9.76, 0.30, 180.0)

    o.block(1.285, 2.385, 2, "b")
    o.block(5.405, 2.385, 2, "a")
    o.block(1.285, 7.425, 2, "a")
    o.block(5.80, 7.425, 2, "b")
    # Drawer units at the ends of desks and, drawn out, between the chairs; bins beside them.
    for k, (y, theta) in enumerate(((7.02, -90.0), (7.83, 90.0))):
        o.put(f"drawers-{k + 1}", "drawers", 4.485 + 0.215, y, theta, front=f"desk_front_{'ab'[k]}")
    for k, (x, yc) in enumerate(((2.885, 2.385), (7.005, 2.385), (2.885, 7.425), (7.40, 7.425))):
        for j, side in enumerate((-1, 1)):
            n = 2 * k + j
            turn = (1, -1, 1, -1, 1, 1, -1, -1)[n]
            front = yc + side * (GAP / 2 + DESK_DEPTH)
            o.put(f"drawers-{n + 3}", "drawers", x + 0.27 * turn, front + side * (0.24 - 0.02 * (n % 3) - 0.28), 90.0 * side,
                  front=f"desk_front_{'ab'[(n // 3) % 2]}", side=f"desk_side_{'ba'[n % 2]}")
            o.put(f"bin-{n + 1}", "bin", x - (0.12 + 0.02 * (n % 4)) * turn, front + side * 0.135, 20.0 * n)

    # The middle: a double row of bookcases with a cupboard across its end, and a table to meet at.
    for k in range(3):
        x = 1.58 + SHELF_WIDTH * (k + 0.5)
        o.shelf(x, 5.04 - SHELF_DEPTH / 2 - 0.005, -90, plate=k != 1, wood="wood_dark")
        o.shelf(x, 5.04 + SHELF_DEPTH / 2 + 0.005, 90, plate=k != 1, wood="wood_dark")
    o.cupboard(1.58 + 3 * SHELF_WIDTH + 0.215, 5.04, 0, "end")
    o.put("table", "table", 7.40, 4.93, 90)
    for k, (x, theta) in enumerate(((7.40 - TABLE_LENGTH / 2 - 0.02, 0.0), (7.40 + TABLE_LENGTH / 2 + 0.02, 180.0))):
        o.put(f"chair-t{k + 1}", "chair", x, 4.93, theta, fabric="chair_red")
    return o.objects


REACHES_OVER = {"desk": "desk_legs", "chair": "chair_star", "table": "table_legs"}


def with_overhangs(objects):
    """The same places with furniture that reaches over the floor. What hung on the desks' closed ends is left out."""
    ends = [o for o in objects if o[1].startswith(("plate_", "sheet_")) and o[5] in (0.58, 0.44)]
    return [(name, REACHES_OVER.get(mesh, mesh), *rest) for name, mesh, *rest in (o for o in objects if o not in ends)]


def world_yaml(name, what, objects, meshes):
    lines = [
        "# SPDX-License-Identifier: BSD-3-Clause",
        f"# {what}",
        "# Written by assets/generate.py from assets/layout.py: change it there and generate again.",
        "# The origin is the room's inner south-west corner on the floor; x east, y north, z up.",
        f"name: {name}",
        "ambient: 0.50                       # share of light that comes from everywhere",
        "lights:",
    ]
    for x, y in LAMPS:
        lines.append(f"  - {{at_m: [{x}, {y}, 2.675], size_m: [1.2, 0.6], normal: [0, 0, -1], power: 1.2, group: lamps}}")
    for k in range(4):   # windows
        x = 0.55 + 2.42 * k + 0.82
        lines.append(f"  - {{at_m: [{x:.2f}, {10 - WINDOW_OUT}, 1.64], size_m: [1.64, 1.44], normal: [0, -1, 0], power: 1.1, group: daylight}}")
    lines.append("objects:")

    def number(v):
        text = f"{v:.4f}".rstrip("0").rstrip(".")
        return "0" if text == "-0" else text

    for name, mesh, x, y, theta, z, textures in objects:
        item = f"name: {name}, mesh: ../../assets/office/{mesh}.gltf"
        if mesh != "room":
            theta = (theta + 180) % 360 - 180
            item += f", at: {{x_m: {number(x)}, y_m: {number(y)}, theta_deg: {number(theta)}}}"
        if z:
            item += f", z_m: {number(z)}"
        changed = {m: t for m, t in textures.items() if meshes[mesh].textures[m] != t + ".png"}
        if changed:
            item += ", textures: {" + ", ".join(f"{m}: ../../assets/office/{t}.png" for m, t in changed.items()) + "}"
        lines.append(f"  - {{{item}}}")
    return "\n".join(lines) + "\n"
