# SPDX-License-Identifier: BSD-3-Clause
"""The room itself: two carpets, walls with everything that hangs on them, windows, the door, the ceiling.

Scene coordinates: the origin is the south-west inner corner, x east, y north, z up; the room is 10 m by 10 m by 2.7 m.
"""

from furniture import part_of, prop
from mesh import Mesh
from textures import SIGNS, cell

SIZE, HEIGHT, THICK = 10.0, 2.7, 0.12
SEAM_X, SEAM_Y = 5.0, 4.2        # the sand carpet lies in the south-east, east of x and south of y
CARPET_TILE = 2.0                # metres to one repetition of a carpet's picture
WINDOW_OUT = 0.004               # a pane before its wall; the frame stands out farther
LAMPS = [(x, y) for x in (1.8, 5.0, 8.2) for y in (1.2, 3.75, 6.2, 8.8)]


def sign(name):
    return cell(4, SIGNS.index(name))


class OnWall:
    """Places things on a wall by the distance s from its left end as seen from inside."""

    def __init__(self, mesh, side):
        self.mesh, self.side = mesh, side

    def box(self, s0, z0, s1, z1, out, mat, front, rim=None, base=0.0):
        """A box on the wall: s0..s1 along it, z0..z1, standing `out` into the room, the picture on its front."""
        a, b = base, out
        lay = {"south": (SIZE - s1, a, SIZE - s0, b, "+y"), "north": (s0, SIZE - b, s1, SIZE - a, "-y"),
               "west": (a, s0, b, s1, "+x"), "east": (SIZE - b, SIZE - s1, SIZE - a, SIZE - s0, "-x")}
        x0, y0, x1, y1, face = lay[self.side]
        back = {"+y": "-y", "-y": "+y", "+x": "-x", "-x": "+x"}[face]
        skip = [back] + (["-z"] if z0 < 0.01 else [])
        rim = rim or (mat, part_of(front, 0, 0.96, 1, 1))
        self.mesh.box(x0, y0, z0, x1, y1, z1, rim[0], uv=rim[1], faces={face: (mat, front)}, skip=tuple(skip))


def room():
    m = Mesh("room")
    for mat, tex in (("carpet_blue", "carpet_blue"), ("carpet_sand", "carpet_sand"), ("wall", "wall"),
                     ("ceiling", "ceiling"), ("window_a", "window_a"), ("window_b", "window_b"), ("window_c", "window_c"),
                     ("window_d", "window_d"), ("frame", "plain_white"), ("door", "door"),
                     ("whiteboard", "whiteboard"), ("pinboard", "pinboard"), ("posters_a", "posters_a"),
                     ("posters_b", "posters_b"), ("posters_c", "posters_c"), ("posters_d", "posters_d"), ("signs", "signs"), ("fittings", "props"), ("pages", "sheets")):
        m.material(mat, tex + ".png")

    def flat(x0, y0, x1, y1, z, mat, tile, up=True):
        c = [(x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z)]
        uv = (x0 / tile, -y1 / tile, x1 / tile, -y0 / tile)
        if not up:
            c = [c[1], c[0], c[3], c[2]]
        return (c, uv, mat)

    m.wall_quads([flat(0, 0, SEAM_X, SEAM_Y, 0, "carpet_blue", CARPET_TILE),
                  flat(SEAM_X, 0, SIZE, SEAM_Y, 0, "carpet_sand", CARPET_TILE),
                  flat(0, SEAM_Y, SEAM_X, SIZE, 0, "carpet_blue", CARPET_TILE),
                  flat(SEAM_X, SEAM_Y, SIZE, SIZE, 0, "carpet_blue", CARPET_TILE)])
    m.wall_quads([flat(0, 0, SIZE, SIZE, HEIGHT, "ceiling", 1.2, up=False)])

    # Walls are boxes outside the room whose ends overlap, so that each is a part of its own.
    t, r = THICK, SIZE / HEIGHT
    ends = (0, 0, 0.1, 1)
    for box, face in (((-t, -t, 0, SIZE + t, 0, HEIGHT), "+y"), ((-t, SIZE, 0, SIZE + t, SIZE + t, HEIGHT), "-y"),
                      ((-t, -0.5 * t, 0, 0, SIZE + 0.5 * t, HEIGHT), "+x"),
                      ((SIZE, -0.5 * t, 0, SIZE + t, SIZE + 0.5 * t, HEIGHT), "-x")):
        m.box(*box, "wall", uv=ends, faces={face: ("wall", (0, 0, r, 1))}, skip=("-z", "+z"))

    south, north, west, east = (OnWall(m, side) for side in ("south", "north", "west", "east"))
    board = prop("skirting")

    def skirting(wall, s0, s1):
        k = s0
        while k < s1 - 1e-6:   # a metre at a time, so that the picture is not stretched
            e = min(k + 2.5, s1)
            wall.box(k, 0, e, 0.10, 0.018, "fittings", board)
            k = e

    skirting(south, 0.02, 0.75)
    skirting(south, 1.79, 9.98)
    for wall in (north, west, east):
        skirting(wall, 0.02, 9.98)

    # South wall, seen from inside: the door at the left, coats, then shelves (furniture) with pictures above.
    south.box(0.76, 0, 1.78, 2.12, 0.03, "door", (0, 0, 1, 1), rim=("fittings", prop("metal")))
    south.box(1.86, 1.04, 1.96, 1.14, 0.012, "signs", sign("switch"))
    south.box(0.40, 1.30, 0.66, 1.62, 0.01, "signs", sign("fire_plan"))
    south.box(0.36, 1.72, 0.68, 2.04, 0.012, "signs", sign("exit"))
    south.box(0.20, 0.25, 0.40, 0.35, 0.012, "signs", sign("socket"))
    south.box(0.30, 0.60, 0.60, 1.00, 0.008, "pages", cell(4, 3))
    south.box(1.0, 2.22, 1.5, 2.50, 0.01, "signs", part_of(sign("picture"), 0, 0.2, 1, 0.8))
    south.box(2.02, 1.66, 2.98, 1.74, 0.03, "fittings", prop("skirting"))
    for k, s in enumerate((2.06, 2.40, 2.72)):
        south.box(s, 0.84 + 0.06 * k, s + 0.26, 1.67, 0.13, "fittings", prop("coat"), base=0.03)
    south.box(2.2, 0.25, 2.4, 0.35, 0.012, "signs", sign("socket"))
    for k, s in enumerate((3.3, 4.7, 6.1, 7.5, 8.8)):
        south.box(s, 2.16, s + 0.8, 2.66, 0.012, f"posters_{'adcbd'[k]}", part_of(cell(2, (k * 3 + 1) % 4), 0, 0, 1, 0.62))
    south.box(2.15, 1.9, 2.75, 2.5, 0.012, "posters_a", cell(2, 2))

    # North wall: four windows with radiators below.
    for k in range(4):
        s = 0.55 + 2.42 * k
        north.box(s, 0.92, s + 1.64, 2.36, WINDOW_OUT, f"window_{'abcd'[k]}", (0, 0, 1, 1), rim=("frame", (0, 0, 1, 1)))
        for a, z0, b, z1 in ((0, 0.921, 0.05, 2.359), (1.59, 0.921, 1.64, 2.359), (0.051, 0.921, 1.589, 0.97),
                             (0.051, 2.31, 1.589, 2.359), (0.79, 0.971, 0.85, 2.309)):
            north.box(s + a, z0, s + b, z1, 0.06, "frame", (0, 0, 1, 1), base=WINDOW_OUT + 0.001)
        north.box(s + 0.86, 1.55, s + 0.88, 1.68, 0.08, "fittings", prop("metal"), base=0.06)
        north.box(s - 0.06, 0.87, s + 1.70, 0.915, 0.16, "fittings", part_of(prop("lamp"), 0, 0.6, 1, 1))
        for j in (0, 1):
            north.box(s + 0.83 * j, 0, s + 0.81 + 0.83 * j, 0.80, 0.12, "fittings", prop("radiator"))
    for k, name in enumerate(("thermostat", "calendar", "picture")):
        s = 2.31 + 2.42 * k
        north.box(s, 1.25, s + 0.54, 1.79, 0.012, "signs", sign(name))
        north.box(s + 0.15, 0.72, s + 0.40, 1.05, 0.008, "pages", cell(4, 4 + k))
        north.box(s + 0.07, 1.88, s + 0.53, 2.34, 0.012, f"posters_{'bcd'[k]}", cell(2, k))
    north.box(0.12, 1.1, 0.42, 1.5, 0.01, "pages", cell(4, 9))
    north.box(9.56, 1.1, 9.86, 1.5, 0.01, "pages", cell(4, 10))
    for k in range(5):
        north.box(0.4 + 1.9 * k, 2.44, 1.0 + 1.9 * k, 2.64, 0.05, "fittings", prop("duct"))

    # West wall, s from the south corner: shelves, the whiteboard, shelves.
    west.box(4.05, 0.86, 6.25, 2.16, 0.03, "whiteboard", (0, 0, 1, 1))
    for k in range(4):
        west.box(4.00 + 0.58 * k, 0.28, 4.57 + 0.58 * k, 0.44, 0.045, "fittings", prop("duct"))
    for k, (s, z) in enumerate(((4.15, 0.50), (4.7, 0.47), (5.25, 0.49), (5.85, 0.48))):
        west.box(s, z, s + 0.26, z + 0.35, 0.008, "pages", cell(4, (2 + 5 * k) % 16))
    for k, s in enumerate((4.3, 5.3)):
        west.box(s, 2.28, s + 0.7, 2.62, 0.012, "posters_b", part_of(cell(2, k), 0, 0, 1, 0.55))
    for k, s in enumerate((0.5, 1.6, 2.7, 7.0, 8.1, 9.1)):
        west.box(s, 2.18, s + 0.62, 2.64, 0.012, f"posters_{'badcbd'[k]}", part_of(cell(2, (k + 2) % 4), 0, 0, 1, 0.74))

    # East wall, s from the north corner.
    east.box(0.5, 1.0, 1.3, 1.8, 0.012, "posters_a", cell(2, 0))
    east.box(1.5, 0.92, 3.1, 2.02, 0.03, "pinboard", (0, 0, 1, 1))
    east.box(3.3, 1.0, 4.1, 1.8, 0.012, "posters_d", cell(2, 1))
    east.box(1.7, 2.15, 2.06, 2.51, 0.04, "signs", sign("clock"))
    east.box(2.5, 2.15, 2.95, 2.6, 0.012, "signs", sign("certificate"))
    east.box(0.6, 2.0, 1.1, 2.5, 0.012, "signs", sign("first_aid"))
    east.box(3.4, 2.0, 3.9, 2.5, 0.012, "signs", sign("rota"))
    for k in range(6):
        east.box(0.3 + 0.66 * k, 0.30, 0.94 + 0.66 * k, 0.46, 0.045, "fittings", prop("duct"))
    for k, (s, z) in enumerate(((0.45, 0.56), (1.25, 0.50), (1.75, 0.56), (2.35, 0.52), (3.05, 0.58), (3.7, 0.52))):
        east.box(s, z, s + 0.27, z + 0.36, 0.008, "pages", cell(4, (11 + 3 * k) % 16))
    for k, s in enumerate((4.4, 5.5, 6.6, 7.5)):
        east.box(s, 2.10, s + 0.62, 2.62, 0.012, f"posters_{'cdab'[k]}", part_of(cell(2, (k + 1) % 4), 0, 0, 1, 0.84))
    east.box(8.55, 1.0, 9.35, 1.8, 0.012, "posters_c", cell(2, 3))
    east.box(8.65, 1.95, 9.15, 2.45, 0.012, "signs", sign("recycling"))
    east.box(8.50, 0.28, 8.70, 0.38, 0.012, "signs", sign("socket"))
    east.box(9.45, 1.2, 9.75, 1.5, 0.012, "signs", sign("extinguisher"))
    east.box(9.45, 0.45, 9.75, 0.85, 0.008, "pages", cell(4, 14))
    east.box(8.80, 0.50, 9.25, 0.85, 0.008, "pages", cell(4, 13))

    # What was bare between all that: pipes and cables high up, a thermometer, hooks, a ring of keys.
    for wall, pieces in ((south, ((0.1, 0.9), (1.6, 3.2))), (west, ((3.75, 4.25), (6.3, 6.95))), (east, ((4.95, 5.45), (8.2, 8.6)))):
        for s0, s1 in pieces:
            wall.box(s0, 2.575, s1, 2.655, 0.05, "fittings", prop("duct"))
    west.box(3.70, 1.10, 4.00, 1.50, 0.01, "pages", cell(4, 12))
    west.box(3.70, 1.60, 4.00, 1.90, 0.012, "signs", sign("notice"))
    west.box(3.72, 2.05, 3.98, 2.31, 0.012, "signs", sign("no_smoking"))
    west.box(6.30, 1.10, 6.50, 1.40, 0.01, "pages", cell(4, 15))
    west.box(6.30, 1.52, 6.50, 1.72, 0.012, "signs", sign("arrow"))
    east.box(0.1, 1.35, 0.4, 1.65, 0.012, "signs", sign("fire_plan"))
    east.box(0.12, 1.05, 0.22, 1.15, 0.012, "signs", sign("switch"))
    east.box(8.25, 1.15, 8.45, 1.42, 0.01, "pages", cell(4, 8))
    east.box(8.25, 1.52, 8.45, 1.72, 0.012, "signs", sign("thermostat"))
    south.box(8.35, 1.05, 9.15, 1.85, 0.012, "posters_d", cell(2, 0))
    south.box(7.55, 1.20, 7.95, 1.60, 0.012, "signs", sign("calendar"))
    south.box(7.60, 0.35, 7.80, 0.45, 0.012, "signs", sign("socket"))
    south.box(7.50, 0.60, 7.80, 1.00, 0.008, "pages", cell(4, 7))

    for x, y in LAMPS:
        m.box(x - 0.6, y - 0.3, HEIGHT - 0.025, x + 0.6, y + 0.3, HEIGHT - 0.001, "fittings",
              uv=part_of(prop("metal"), 0, 0.4, 1, 0.5), faces={"-z": ("fittings", prop("lamp"))}, skip=("+z",))
    return m
