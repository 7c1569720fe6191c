# SPDX-License-Identifier: BSD-3-Clause
"""Figures in mid-stride, 1.75 m tall. The origin is on the floor below the hips; they walk along +x."""

import math

from furniture import part_of
from mesh import Mesh
from people_textures import CELLS
from textures import cell


def piece(name):
    return cell(4, CELLS.index(name), rows=2)


def ring(x, y, z, rx, ry, sides):
    """An ellipse, its first corner just right of straight ahead so that a side looks ahead."""
    return [(x + rx * math.cos(a), y + ry * math.sin(a), z)
            for a in (2 * math.pi * (i - 0.5) / sides for i in range(sides))]


def limb(m, points, radii, uv):
    """A leg or an arm: tapered pieces from point to point, downwards, each but the first begun inside the one above."""
    for i, ((a, ra), (b, rb)) in enumerate(zip(zip(points, radii), zip(points[1:], radii[1:]))):
        top = ring(a[0], a[1], a[2] + 0.015, 0.95 * ra, 0.95 * ra, 8) if i > 0 else ring(a[0], a[1], a[2], ra, ra, 8)
        m.loft(ring(b[0], b[1], b[2], rb, rb, 8), top, "cloth", uv=uv)


def figure(name, picture):
    m = Mesh(name)
    m.material("cloth", picture + ".png")
    front, back = piece("shirt"), piece("shirt_back")
    sides = 12

    def chest(v0, v1, ry):
        def of(i):
            a, b = (2 * math.pi * (k - 0.5) / sides for k in (i, i + 1))
            rect, sign = (front, 1) if math.cos((a + b) / 2) > 0 else (back, -1)
            ua, ub = (max(0.0, min(1.0, 0.5 + sign * math.sin(t) / 2)) for t in (a, b))
            return "cloth", part_of(rect, ua, v0, ub, v1)
        return of

    m.loft(ring(0, 0, 0.84, 0.115, 0.165, sides), ring(0, 0, 1.30, 0.125, 0.205, sides), "cloth",
           sides=chest(0.3, 1.0, 0.2))
    m.loft(ring(0, 0, 1.29, 0.122, 0.202, sides), ring(0.01, 0, 1.46, 0.065, 0.13, sides), "cloth",
           sides=chest(0.0, 0.3, 0.2), top=("cloth", piece("skin")))
    m.loft(ring(0.015, 0, 1.44, 0.05, 0.05, 8), ring(0.02, 0, 1.53, 0.05, 0.05, 8), "cloth", uv=piece("skin"))

    n, rect = 10, piece("face")

    def head(v0, v1):
        def of(i):
            return "cloth", part_of(rect, ((i - 0.5) / n + 0.5) % 1.0, v0, ((i - 0.5) / n + 0.5) % 1.0 + 1 / n, v1)
        return of
    m.loft(ring(0.025, 0, 1.50, 0.06, 0.05, n), ring(0.03, 0, 1.585, 0.098, 0.078, n), "cloth", sides=head(0.66, 1.0),
           bottom=("cloth", piece("skin")))
    m.loft(ring(0.03, 0, 1.575, 0.095, 0.075, n), ring(0.025, 0, 1.69, 0.095, 0.078, n), "cloth", sides=head(0.22, 0.66))
    m.loft(ring(0.025, 0, 1.68, 0.094, 0.077, n), ring(0.015, 0, 1.75, 0.045, 0.04, n), "cloth", uv=piece("hair"),
           top=("cloth", piece("hair")))

    trousers, sleeve = part_of(piece("trousers"), 0, 0.1, 1, 1), piece("sleeve")   # without the belt
    for side, knee, ankle in ((1, (0.17, 0.48), (0.27, 0.09)), (-1, (-0.04, 0.47), (-0.29, 0.12))):
        y = 0.092 * side
        limb(m, [(0.0, y, 0.86), (knee[0], y, knee[1]), (ankle[0], y, ankle[1])], [0.095, 0.066, 0.05], trousers)
        m.box(ankle[0] - 0.07, y - 0.05, ankle[1] - 0.09, ankle[0] + 0.19, y + 0.05, ankle[1] - 0.005, "cloth",
              uv=piece("shoe"), skip=())
    for side, elbow, wrist in ((1, (-0.10, 1.14), (-0.06, 0.90)), (-1, (0.05, 1.13), (0.20, 0.94))):
        y = 0.235 * side
        limb(m, [(0.0, y - 0.03 * side, 1.43), (elbow[0], y, elbow[1]), (wrist[0], y, wrist[1])], [0.06, 0.05, 0.038], sleeve)
        m.box(wrist[0] - 0.035, y - 0.03, wrist[1] - 0.13, wrist[0] + 0.035, y + 0.03, wrist[1] - 0.004, "cloth",
              uv=piece("skin"), skip=())
    return m


def all_meshes():
    return [figure("walker", "clothes_a"), figure("walker_b", "clothes_b"), figure("walker_c", "clothes_c")]
