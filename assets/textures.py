# SPDX-License-Identifier: BSD-3-Clause
"""The pictures of the office: carpets, wood, fabric, papers, screens, books, posters.

Each is a function of its own seeded generator, so changing one does not change the others. Sheets of several small
pictures are grids; `cell` gives the texture rectangle of one of them.
"""

import math
import random

from canvas import Canvas, add, mix, shade, smooth_noise

INK = (45, 48, 58)
BLUE, RED, GREEN, ORANGE, TEAL, PURPLE, YELLOW = ((52, 96, 168), (186, 58, 52), (70, 140, 84), (226, 140, 52),
                                                   (48, 142, 150), (124, 84, 150), (238, 204, 90))
COLOURS = [BLUE, RED, GREEN, ORANGE, TEAL, PURPLE, YELLOW]
WORDS = ("ROBOT VISION SLAM MAP POSE GRAPH LOOP CAMERA FLOW GRID PLAN WHEEL LENS ANGLE MODEL FILTER STEREO TRACK "
         "FLOOR SCENE IMAGE DEPTH MOTION PLACE PATH INDEX DATA NOTES REPORT TEST BUDGET TRAVEL ORDERS MANUAL "
         "SURVEY OPTICS CONTROL SENSORS").split()
SHORT_WORDS = [w for w in WORDS if len(w) < 6]


def cell(columns, index, rows=None, pixels=512):
    """Texture rectangle of a grid's cell, drawn in by a pixel and a half so that neighbours do not bleed in."""
    rows = rows or columns
    i, j = index % columns, index // columns
    d = 1.5 / pixels
    return (i / columns + d, j / rows + d, (i + 1) / columns - d, (j + 1) / rows - d)


# --- surfaces

def carpet(rng, base, fleck, size=512):
    """Carpet tiles of half a metre, 4 by 4 to the picture, the pile turned in every other one."""
    c = Canvas(size, size, base)
    tile = size // 4
    for j in range(4):
        for i in range(4):
            c.rect(i * tile, j * tile, tile, tile, shade(base, 1.0 + (0.025 if (i + j) % 2 else -0.025)
                                                         + rng.uniform(-0.01, 0.01)))
    for _ in range(2600):   # flecks: short strands along the pile
        x, y = rng.randrange(size), rng.randrange(size)
        along = (x // tile + y // tile) % 2
        c.rect(x, y, 4 if along else 1, 1 if along else 4, mix(base, fleck, rng.uniform(0.4, 1.0)), 0.55)
    for k in range(4):
        c.rect(k * tile, 0, 1, size, (0, 0, 0), 0.22)
        c.rect(0, k * tile, size, 1, (0, 0, 0), 0.22)
    c.add_field(add(smooth_noise(size, size, 9, 9, rng, 3.5), smooth_noise(size, size, 128, 128, rng, 6.0)))
    c.grain(rng, 6.5)
    return c


def woodchip(c, rng, x, y, w, h, count):
    """Painted woodchip paper: chips that catch the light on one side and throw a shadow on the other."""
    for _ in range(count):
        i, j = x + rng.randrange(w), y + rng.randrange(h)
        n, m = rng.choice(((3, 1), (2, 1), (1, 2), (2, 2), (4, 2)))
        c.rect(i, j, n, m, (255, 255, 255), rng.uniform(0.15, 0.5))
        c.rect(i + 1, j + m, n, 1, (96, 92, 84), rng.uniform(0.15, 0.45))


def wall(rng, paint=(238, 235, 226), lower=(206, 214, 210), stripe=(86, 126, 140)):
    """2.7 m of wall: woodchip above, two stripes, panelling below, nail holes, scuffs near the floor."""
    c = Canvas(512, 512, paint)
    px = 512 / 2.7
    top_of_band = int((2.7 - 0.98) * px)
    woodchip(c, rng, 0, 0, 512, top_of_band, 5200)
    for k in range(0, 512, 100):   # where one length of paper meets the next
        c.rect(k + 30, 0, 1, top_of_band, (150, 146, 138), 0.5)
    c.rect(0, top_of_band, 512, 512, lower)
    c.rect(0, top_of_band - 9, 512, 8, stripe)
    c.rect(0, top_of_band - 14, 512, 2, mix(stripe, paint, 0.5))
    for k in range(6):   # panelling: boards with a raised field
        x = k * 512 // 6
        c.rect(x, top_of_band, 2, 512, shade(lower, 0.66))
        c.rect(x + 2, top_of_band, 2, 512, shade(lower, 1.12))
        fx, fy, fw, fh = x + 16, top_of_band + 18, 56, 134
        c.rect(fx, fy, fw, fh, shade(lower, rng.uniform(0.94, 1.05)))
        c.frame(fx, fy, fw, fh, 2, shade(lower, 0.76))
        c.bevel(fx + 2, fy + 2, fw - 4, fh - 4, 2, 0.4)
        for sx in (6, 78):
            for sy in (8, 164):
                c.ellipse(x + sx, top_of_band + sy, 2, 2, (110, 116, 118))
    for _ in range(110):
        x, y = rng.randrange(512), rng.randint(top_of_band + 20, 505)
        c.line(x, y, x + rng.randint(-26, 26), y + rng.randint(-4, 4), (120, 120, 116), 1, rng.uniform(0.15, 0.5))
    for _ in range(26):
        c.ellipse(rng.randrange(512), rng.randint(20, 500), rng.uniform(1, 2.6), rng.uniform(1, 2.6), (120, 118, 110), 0.5)
    for _ in range(22):   # nail holes and what is left where something hung
        x, y = rng.randrange(480), rng.randint(40, 260)
        c.rect(x, y, rng.randint(14, 46), rng.randint(18, 50), (255, 255, 250), 0.10)
        c.rect(x + 8, y - 2, 2, 2, (90, 86, 80))
    c.add_field(add(smooth_noise(512, 512, 6, 6, rng, 3), smooth_noise(512, 512, 70, 24, rng, 3),
                    smooth_noise(512, 512, 170, 170, rng, 4)))
    c.grain(rng, 1.6)
    return c


def plain_wall(rng):
    """Smooth paint, nothing else."""
    c = Canvas(128, 128, (222, 220, 212))
    c.add_field(smooth_noise(128, 128, 3, 3, rng, 1.5))
    return c


def plain_floor(rng):
    """Green linoleum without a pattern: plain as the walls, but of another colour."""
    c = Canvas(128, 128, (118, 146, 122))
    c.add_field(smooth_noise(128, 128, 3, 3, rng, 1.5))
    c.grain(rng, 1.2)
    return c


def plain(rng, colour):
    """A painted surface."""
    c = Canvas(64, 64, colour)
    c.grain(rng, 1.0)
    return c


def ceiling(rng):
    """Mineral fibre tiles, 2 by 2 of 0.6 m."""
    c = Canvas(256, 256, (232, 231, 226))
    for _ in range(2400):
        x, y = rng.randrange(256), rng.randrange(256)
        c.rect(x, y, rng.choice((1, 1, 2)), 1, (150, 148, 142), rng.uniform(0.3, 0.8))
    for k in (0, 128):
        c.rect(k, 0, 4, 256, (206, 206, 204))
        c.rect(0, k, 256, 4, (206, 206, 204))
        c.rect(k, 0, 1, 256, (140, 140, 138))
        c.rect(0, k, 256, 1, (140, 140, 138))
    return c


def wood(c, rng, amplitude=14, horizontal=True, x=0, y=0, w=None, h=None):
    """Grain over the whole canvas."""
    a, b = (4, 90) if horizontal else (90, 4)
    a2, b2 = (9, 200) if horizontal else (200, 9)
    a3, b3 = (2, 14) if horizontal else (14, 2)
    f = add(smooth_noise(c.w, c.h, a, b, rng, amplitude), smooth_noise(c.w, c.h, a2, b2, rng, amplitude * 0.7),
            smooth_noise(c.w, c.h, a3, b3, rng, amplitude * 0.9))
    c.add_field(f, (0.8, 1.0, 1.1))


def knots(c, rng, count, colour):
    for _ in range(count):
        x, y = rng.randrange(c.w), rng.randrange(c.h)
        for r in (11, 8, 5, 2):
            c.ellipse(x, y, r * 1.8, r, colour, 0.14)


def wood_shelf(rng, base=(192, 158, 114)):
    c = Canvas(256, 256, base)
    knots(c, rng, 5, shade(base, 0.55))
    wood(c, rng, 15)
    return c


def laminate(rng):
    """White board with a fine structure and marks of use."""
    c = Canvas(256, 256, (212, 214, 212))
    wood(c, rng, 5)
    for _ in range(30):
        x, y = rng.randrange(256), rng.randrange(256)
        c.line(x, y, x + rng.randint(-14, 14), y + rng.randint(-9, 9), (150, 152, 150), 1, 0.6)
    for _ in range(9):
        c.ellipse(rng.randrange(256), rng.randrange(256), 3, 3, (160, 160, 156))
    c.grain(rng, 2)
    return c


BEECH, LAMINATE = (206, 176, 134), (198, 201, 200)


def steel(rng):
    """The side of a steel cupboard: two pressed panels, rivets, scratches."""
    base = (164, 176, 182)
    c = Canvas(256, 256, base)
    for y in (10, 134):
        c.rect(14, y, 228, 110, shade(base, 1.03))
        c.bevel(14, y, 228, 110, 3, 0.4)
    for k in range(8):
        for x in (6, 250):
            c.ellipse(x, 16 + k * 32, 2, 2, shade(base, 0.5))
    for _ in range(40):
        x, y = rng.randrange(256), rng.randrange(256)
        c.line(x, y, x + rng.randint(-16, 16), y + rng.randint(-7, 7), shade(base, rng.choice((0.7, 0.8, 1.2))), 1, 0.7)
    for _ in range(4):
        x, y = rng.randint(24, 200), rng.randint(24, 200)
        c.ellipse(x, y, 12, 12, rng.choice(COLOURS))
        c.ellipse(x, y, 6, 6, (250, 250, 246))
    c.add_field(smooth_noise(256, 256, 90, 90, rng, 4))
    c.grain(rng, 2)
    return c


def skirting(rng):
    """A metre of skirting board."""
    c = Canvas(256, 32, (168, 134, 98))
    c.add_field(add(smooth_noise(256, 32, 3, 16, rng, 12), smooth_noise(256, 32, 40, 16, rng, 7)))
    c.rect(0, 0, 256, 6, (204, 172, 132), 0.8)
    c.rect(0, 6, 256, 1, (90, 68, 48))
    c.rect(0, 27, 256, 5, (84, 64, 46), 0.8)
    for _ in range(9):
        x = rng.randrange(240)
        c.line(x, rng.randint(9, 24), x + rng.randint(6, 22), rng.randint(9, 24), (104, 82, 62), 1, 0.7)
    c.grain(rng, 2)
    return c


def paper(c, rng, x, y, w, h, kind=None):
    """A sheet with something on it."""
    kind = kind if kind is not None else rng.randrange(6)
    c.rect(x + 2, y + 2, w, h, (0, 0, 0), 0.25)
    c.rect(x, y, w, h, rng.choice([(250, 250, 246), (250, 250, 246), (246, 244, 232), (236, 240, 248)]))
    m = max(3, w // 12)
    if kind == 0:
        c.rect(x + m, y + m, w * 0.6, max(2, h // 22), INK)
        c.lines_of_print(x + m, y + m + h // 9, w - 2 * m, int((h - 2 * m - h // 9) / 4), rng, (96, 98, 106))
    elif kind == 1:
        c.rect(x + m, y + m, w - 2 * m, h * 0.34, rng.choice(COLOURS))
        c.lines_of_print(x + m, y + m + h * 0.40, w - 2 * m, int(h * 0.48 / 4), rng, (90, 92, 100))
    elif kind == 2:   # plot
        c.rect(x + m, y + m, w * 0.5, max(2, h // 26), INK)
        gx, gy, gw, gh = x + m, y + h * 0.18, w - 2 * m, h * 0.42
        c.frame(gx, gy, gw, gh, 1, INK)
        for col in rng.sample(COLOURS, 3):
            v, pts = rng.random(), []
            for k in range(13):
                v = min(0.95, max(0.05, v + rng.uniform(-0.22, 0.22)))
                pts.append((gx + gw * k / 12.5, gy + gh * (1 - v)))
            c.polyline(pts, col, 2)
        c.lines_of_print(x + m, y + h * 0.68, w - 2 * m, int(h * 0.26 / 4), rng, (96, 98, 106))
    elif kind == 3:   # table
        rows = 9
        for k in range(rows):
            yy = y + m + k * (h - 2 * m) / rows
            c.rect(x + m, yy, w - 2 * m, 1, (130, 134, 140))
            c.lines_of_print(x + m + 2, yy + 3, w * rng.uniform(0.25, 0.4), 1, rng, INK)
            c.rect(x + w * 0.62, yy + 3, w * rng.uniform(0.08, 0.28), max(2, h // 24), rng.choice(COLOURS), 0.8)
    elif kind == 4:   # bars and a heading
        c.rect(x, y, w, h * 0.2, rng.choice(COLOURS))
        c.rect(x + m, y + h * 0.07, w * 0.6, max(2, h * 0.05), (255, 255, 255))
        for k in range(6):
            bh = h * rng.uniform(0.1, 0.5)
            c.rect(x + m + k * (w - 2 * m) / 6, y + h * 0.9 - bh, (w - 2 * m) / 8, bh, rng.choice(COLOURS))
    else:   # handwriting
        for k in range(int((h - 2 * m) / 11)):
            c.scribble(x + m, y + m + 8 + k * 11, (w - 2 * m) * rng.uniform(0.5, 1.0), rng, rng.choice([INK, BLUE]), 5)


def sticky(c, rng, x, y, s):
    c.rect(x + 1, y + 2, s, s, (0, 0, 0), 0.2)
    c.rect(x, y, s, s, rng.choice([(250, 230, 110), (250, 230, 110), (246, 160, 170), (166, 220, 150), (150, 206, 236)]))
    for k in range(max(1, int(s / 9))):
        c.scribble(x + 2, y + 7 + k * 8, s - 5, rng, INK, 4)


def desk_top(rng, base):
    """A desk top seen from above, 1.6 m across (u) by 0.8 m; the sitter is at the lower edge (v = 1)."""
    c = Canvas(512, 512, base)
    knots(c, rng, 3, (120, 84, 50))
    wood(c, rng, 10)
    for _ in range(7):   # the picture is twice as fine along v as along u
        side = rng.choice((0, 1))
        paper(c, rng, int(rng.uniform(12, 100) if side else rng.uniform(350, 420)), rng.randint(30, 330), 64, 150)
    c.rect(196, 330, 140, 4, (60, 62, 68))
    c.rect(366, 348, 52, 110, (70, 84, 112))
    c.frame(366, 348, 52, 110, 3, (40, 46, 60))
    for _ in range(3):
        c.ellipse(rng.randint(60, 460), rng.randint(60, 440), 11, 22, (110, 80, 52), 0.35)
    for _ in range(4):
        sticky(c, rng, rng.randint(20, 460), rng.randint(20, 460), 26)
    return c


def desk_front(rng, base, handle):
    """The front of a desk, 1.54 m by 0.70 m: drawers, the knee hole (a panel in its own shade), a cupboard door."""
    c = Canvas(512, 512, base)
    wood(c, rng, 15)
    edge = shade(base, 0.55)
    for k in range(3):   # drawers on the left
        y, h = 14 + k * 158, 150
        c.frame(8, y, 144, h, 4, edge)
        c.bevel(12, y + 4, 136, h - 8, 3, 0.22)
        c.rect(50, y + 34, 60, 16, handle)
        c.rect(50, y + 46, 60, 5, (0, 0, 0), 0.5)
    c.rect(94, 90 - 14, 34, 40, (246, 246, 240))
    c.lines_of_print(98, 82, 26, 6, rng, INK, 6, 2)
    c.rect(160, 6, 190, 506, shade(base, 0.50))   # knee hole
    c.rect(160, 6, 190, 30, (0, 0, 0), 0.35)
    c.rect(160, 6, 8, 506, (0, 0, 0), 0.4)
    c.rect(342, 6, 8, 506, (0, 0, 0), 0.3)
    for k in range(5):
        c.polyline([(180 + k * 32 + rng.randint(-8, 8), 40 + j * 60) for j in range(8)], shade(base, 0.35), 3)
    c.frame(360, 14, 144, 466, 4, edge)
    c.bevel(364, 18, 136, 458, 3, 0.22)
    c.rect(372, 190, 10, 80, handle)
    c.rect(382, 190, 4, 80, (0, 0, 0), 0.4)
    for _ in range(2):
        sticky(c, rng, rng.randint(396, 440), rng.randint(40, 380), 34)
    paper(c, rng, 400, rng.randint(60, 220), 70, 180)
    c.rect(0, 490, 512, 22, shade(base, 0.45))
    c.grain(rng, 2)
    return c


def desk_side(rng, base, busy):
    """A desk's end panel, 0.8 m by 0.7 m."""
    c = Canvas(512, 512, base)
    knots(c, rng, 6, (110, 76, 44))
    wood(c, rng, 19, horizontal=False)
    c.frame(0, 0, 512, 512, 8, shade(base, 0.72), 0.7)
    c.rect(0, 484, 512, 28, shade(base, 0.5))
    c.ellipse(430, 60, 24, 24, (60, 58, 56))       # cable outlet
    c.ellipse(430, 60, 14, 14, (20, 20, 22))
    c.polyline([(430, 60), (440, 180), (426, 300), (452, 420), (448, 512)], (40, 42, 46), 6)
    if busy:
        paper(c, rng, 60, 60, 120, 170)
        paper(c, rng, 200, 110, 110, 156)
        for _ in range(5):
            sticky(c, rng, rng.randint(50, 330), rng.randint(290, 420), 44)
        c.ellipse(350, 330, 34, 34, ORANGE)
        c.text(330, 322, "ROS", (255, 255, 255), 2)
    else:
        c.rect(70, 90, 150, 64, (236, 236, 230))
        c.text(80, 100, "KEEP", RED, 4)
        c.text(80, 130, "CLEAR", RED, 2)
        paper(c, rng, 250, 170, 126, 178)
        for _ in range(3):
            c.ellipse(rng.randint(60, 400), rng.randint(280, 440), 22, 22, rng.choice(COLOURS))
    c.grain(rng, 2)
    return c


def fabric(c, rng, amplitude=9):
    c.add_field(add(smooth_noise(c.w, c.h, 8, 8, rng, 4), smooth_noise(c.w, c.h, c.w // 3, 40, rng, amplitude),
                    smooth_noise(c.w, c.h, 40, c.h // 3, rng, amplitude)))


def partition(rng, base):
    """A screen between desks, 1.5 m by 1.2 m, with what people pin to it in its upper part."""
    c = Canvas(512, 512, base)
    fabric(c, rng)
    c.frame(0, 0, 512, 512, 9, (150, 152, 156))
    c.rect(9, 190, 494, 4, (120, 122, 126))
    spots = [(24 + k * 80 + rng.randint(-6, 8), 18 + rng.randint(0, 22)) for k in range(6)]
    for x, y in spots:
        if rng.random() < 0.85:
            paper(c, rng, x, y, 62, rng.choice((84, 110, 120)))
            c.ellipse(x + 31, y + 4, 4, 4, rng.choice(COLOURS))
    for _ in range(9):
        sticky(c, rng, rng.randint(16, 460), rng.randint(14, 156), 28)
    for _ in range(6):   # lower part: papers hung low, a cable tray
        paper(c, rng, rng.randint(20, 420), rng.randint(204, 330), 60, 90)
    c.rect(9, 450, 494, 16, (90, 92, 98))
    return c


def chair_fabric(rng, base):
    c = Canvas(256, 256, base)
    fabric(c, rng, 8)
    for k in range(1, 4):
        c.rect(0, k * 64, 256, 2, shade(base, 0.6))
        c.rect(0, k * 64 + 2, 256, 1, shade(base, 1.25))
    c.frame(0, 0, 256, 256, 7, shade(base, 0.7), 0.8)
    for _ in range(120):
        x, y = rng.randrange(256), rng.randrange(256)
        c.rect(x, y, 3, 2, mix(base, (255, 255, 255), 0.5), 0.6)
    c.grain(rng, 4)
    return c


def chair_base(rng):
    """The chair's skirt: a column, a star foot and castors in front of dark cloth; wraps around four times."""
    c = Canvas(256, 256, (74, 76, 82))
    fabric(c, rng, 8)
    c.rect(0, 0, 256, 30, (52, 54, 60))
    c.rect(112, 30, 32, 140, (138, 140, 146))
    c.rect(118, 30, 8, 140, (186, 188, 192))
    c.poly([(112, 160), (144, 160), (250, 214), (250, 232), (128, 190), (6, 232), (6, 214)], (120, 122, 128))
    c.polyline([(128, 166), (246, 220)], (190, 192, 196), 3)
    c.polyline([(128, 166), (10, 220)], (190, 192, 196), 3)
    for x in (22, 128, 234):
        c.ellipse(x, 236, 17, 18, (28, 28, 32))
        c.ellipse(x, 236, 8, 8, (120, 122, 126))
    c.grain(rng, 3)
    return c


def plastic(rng):
    """Back of a monitor or a printer's side: dark grey, vents, a label, a cable."""
    c = Canvas(256, 256, (78, 80, 86))
    c.frame(0, 0, 256, 256, 8, (52, 54, 58))
    for k in range(9):
        c.rect(46, 24 + k * 8, 164, 3, (30, 31, 34))
    c.rect(96, 120, 64, 64, (104, 106, 112))
    c.bevel(96, 120, 64, 64, 3)
    c.rect(26, 196, 62, 34, (210, 210, 206))
    c.lines_of_print(30, 200, 54, 6, rng, INK, 5, 2)
    c.ellipse(200, 160, 15, 15, (170, 172, 178))
    c.grain(rng, 5)
    return c


def monitor_back(rng):
    """The back of a monitor, light grey: a raised middle with vents and plugs, a badge, an inventory label, cables."""
    c = Canvas(256, 256, (176, 178, 182))
    c.add_field(smooth_noise(256, 256, 3, 40, rng, 4))
    c.frame(0, 0, 256, 256, 5, (96, 98, 104))
    c.bevel(5, 5, 246, 246, 3, 0.5)
    c.rect(62, 66, 132, 128, (150, 152, 158))
    c.bevel(62, 66, 132, 128, 4, 0.5)
    for k in range(8):
        c.rect(76, 76 + k * 6, 104, 3, (44, 46, 50))
    c.frame(98, 130, 60, 52, 2, (92, 94, 100))
    for x in (106, 148):
        for y in (138, 172):
            c.ellipse(x, y, 4, 4, (52, 54, 58))
    c.rect(20, 20, 60, 14, (60, 62, 68))
    c.text(24, 24, "VISIO", (236, 238, 240), 1)
    c.rect(176, 18, 58, 34, (246, 246, 240))
    c.text(180, 22, f"NO {rng.randint(100, 999)}", INK, 1)
    for k in range(22):
        c.rect(180 + k * 2, 34, rng.choice((1, 1, 2)), 14, INK)
    for x, col in ((74, BLUE), (92, (30, 30, 34)), (164, (30, 30, 34)), (178, ORANGE)):
        c.rect(x - 5, 196, 11, 9, (36, 38, 42))
        c.polyline([(x, 204), (x + rng.randint(-7, 7), 222), (x + rng.randint(-10, 10), 240), (128, 256)], col, 4)
    c.ellipse(34, 222, 13, 13, rng.choice(COLOURS))
    c.ellipse(34, 222, 8, 8, (250, 250, 246))
    c.grain(rng, 3)
    return c


# --- screens

def screen(rng, kind):
    c = Canvas(256, 256, (30, 32, 36))
    c.frame(0, 0, 256, 256, 8, (34, 35, 38))
    x0, y0, w, h = 8, 8, 240, 236
    if kind == 0:      # editor
        c.rect(x0, y0, w, h, (38, 42, 54))
        c.rect(x0, y0, 46, h, (50, 55, 70))
        for k in range(30):
            x = x0 + 56 + 10 * rng.randint(0, 4)
            for _ in range(rng.randint(1, 5)):
                n = rng.randint(8, 34)
                if x + n > 236:
                    break
                c.rect(x, y0 + 8 + k * 7, n, 4, rng.choice([(220, 220, 220), (120, 190, 230), (230, 170, 100),
                                                             (150, 210, 130), (210, 130, 190)]))
                x += n + 5
    elif kind == 1:    # map of a room
        c.rect(x0, y0, w, h, (200, 202, 206))
        c.rect(30, 26, 196, 200, (248, 248, 248))
        for _ in range(9):
            c.rect(rng.randint(34, 180), rng.randint(30, 190), rng.randint(20, 50), rng.randint(12, 34), (60, 60, 66))
        pts = [(120, 120)]
        for _ in range(24):
            pts.append((min(220, max(36, pts[-1][0] + rng.randint(-40, 40))),
                        min(220, max(32, pts[-1][1] + rng.randint(-40, 40)))))
        c.polyline(pts, RED, 3)
        c.ellipse(pts[-1][0], pts[-1][1], 6, 6, BLUE)
    elif kind == 2:    # spreadsheet
        c.rect(x0, y0, w, h, (250, 250, 250))
        c.rect(x0, y0, w, 26, (60, 130, 90))
        for j in range(16):
            c.rect(x0, 36 + j * 13, w, 1, (180, 184, 190))
            for i in range(5):
                if rng.random() < 0.8:
                    c.rect(x0 + 6 + i * 48, 41 + j * 13, rng.randint(14, 38), 4, (70, 74, 84))
        for i in range(6):
            c.rect(x0 + i * 48, 26, 1, 218, (180, 184, 190))
    elif kind == 3:    # web page
        c.rect(x0, y0, w, h, (244, 246, 250))
        c.rect(x0, y0, w, 16, (210, 214, 222))
        c.rect(x0, 26, w, 66, TEAL)
        c.text(24, 46, "PANOPTES", (255, 255, 255), 4)
        for i in range(3):
            c.rect(18 + i * 76, 104, 66, 54, rng.choice(COLOURS))
            c.lines_of_print(18 + i * 76, 166, 64, 14, rng, (90, 94, 104), 5, 2)
    elif kind == 4:    # plots
        c.rect(x0, y0, w, h, (246, 246, 246))
        for i in range(4):
            paper(c, rng, 16 + (i % 2) * 116, 16 + (i // 2) * 114, 106, 106, 2 if i != 3 else 4)
    else:              # a photograph as background
        c.gradient(x0, y0, w, 140, (96, 150, 214), (216, 226, 236))
        c.poly([(8, 150), (60, 84), (110, 140), (160, 70), (248, 150), (248, 244), (8, 244)], (88, 104, 110))
        c.poly([(8, 180), (90, 140), (180, 190), (248, 160), (248, 244), (8, 244)], (70, 124, 76))
        for j in range(5):
            c.rect(18, 18 + j * 34, 18, 18, rng.choice(COLOURS))
            c.rect(14, 38 + j * 34, 26, 4, (250, 250, 250))
        c.rect(8, 232, 240, 12, (40, 44, 54))
    c.rect(112, 247, 32, 3, (150, 152, 158))
    return c


# --- shelves and cupboards

BOOK_ROWS = 4


def books(rng, palette):
    """Four rows of spines; a row is 0.9 m long and 0.30 m high."""
    c = Canvas(512, 512, (60, 46, 34))
    for row in range(BOOK_ROWS):
        x, y0 = 0, row * 128
        while x < 512:
            if rng.random() < 0.2:      # a run of ring binders
                col = rng.choice(palette + [(70, 74, 84), (230, 230, 226)])
                for _ in range(rng.randint(2, 5)):
                    w = 36
                    c.rect(x, y0, w - 1, 128, col)
                    c.bevel(x, y0, w - 1, 128, 2, 0.3)
                    c.rect(x + 6, y0 + 14, w - 13, 56, (248, 248, 244))
                    for k, ch in enumerate(rng.choice(WORDS)[:4]):
                        c.text(x + 11, y0 + 18 + k * 13, ch, INK, 2)
                    c.ellipse(x + w / 2, y0 + 102, 8, 8, (40, 40, 44))
                    x += w
                continue
            w = rng.randint(9, 30)
            col = shade(rng.choice(palette), rng.uniform(0.75, 1.2))
            short = rng.choice((0, 0, 6, 12, 20))
            c.rect(x, y0 + short, w - 1, 128 - short, col)
            c.rect(x, y0 + short, 2, 128 - short, (255, 255, 255), 0.25)
            c.rect(x + w - 3, y0 + short, 2, 128 - short, (0, 0, 0), 0.3)
            bright = mix(col, (255, 250, 230), 0.8) if sum(col) < 380 else mix(col, (20, 20, 30), 0.8)
            if w >= 14:
                for k, ch in enumerate(rng.choice(WORDS)[:rng.randint(3, 7)]):
                    c.text(x + (w - 6) // 2, y0 + short + 16 + k * 9, ch, bright, 1)
            else:
                c.rect(x + 3, y0 + short + 18, w - 7, rng.randint(16, 60), bright)
            c.rect(x + 1, y0 + short + 7, w - 3, 3, bright)
            c.rect(x + 1, y0 + 112, w - 3, rng.randint(2, 8), bright)
            x += w
    c.grain(rng, 3)
    return c


def cupboard(rng, base, kind):
    """The front of a cupboard with two doors."""
    c = Canvas(512, 512, base)
    if kind == 0:
        wood(c, rng, 16, horizontal=False)
    else:
        c.add_field(add(smooth_noise(512, 512, 4, 30, rng, 5), smooth_noise(512, 512, 128, 128, rng, 4)))
    for x in (6, 260):
        c.frame(x, 8, 246, 468, 4, shade(base, 0.55))
        c.bevel(x + 4, 12, 238, 460, 3, 0.3)
        if kind:
            for k in range(7):
                c.rect(x + 60, 400 + k * 8, 126, 3, shade(base, 0.5))
    for x in (232, 266):
        c.rect(x, 210, 12, 70, (96, 98, 104))
        c.rect(x + 2, 212, 4, 66, (200, 202, 206))
    paper(c, rng, 60, 60 + rng.randint(0, 40), 100, 140)
    c.rect(320, 70, 120, 44, (246, 246, 240))
    c.text(328, 78, rng.choice(SHORT_WORDS), INK, 3)
    for _ in range(6):
        sticky(c, rng, rng.choice([rng.randint(20, 190), rng.randint(290, 450)]), rng.randint(240, 380), 40)
    for _ in range(5):
        c.ellipse(rng.randint(290, 480), rng.randint(140, 240), 12, 12, rng.choice(COLOURS))
    c.rect(0, 482, 512, 30, shade(base, 0.42))
    c.grain(rng, 2)
    return c


def lockers(rng):
    """The front of a steel cupboard: three tall doors with vents, locks, name plates and what sticks to them."""
    base = (164, 176, 182)
    c = Canvas(512, 512, shade(base, 0.5))
    for k in range(3):
        x, col = 6 + k * 168, (base, (96, 128, 150), base)[k]
        c.rect(x, 6, 164, 478, col)
        c.bevel(x, 6, 164, 478, 4, 0.4)
        for row in (28, 430):
            for j in range(5):
                c.rect(x + 46, row + j * 9, 72, 4, shade(col, 0.4))
                c.rect(x + 46, row + j * 9 + 4, 72, 1, shade(col, 1.3))
        c.rect(x + 50, 92, 64, 26, (246, 246, 240))
        c.text_centred(x + 82, 98, rng.choice(SHORT_WORDS), INK, 2)
        c.rect(x + 138, 226, 14, 50, (70, 72, 78))
        c.rect(x + 141, 230, 5, 40, (206, 208, 212))
        c.ellipse(x + 145, 292, 6, 6, (206, 208, 212))
        c.rect(x + 144, 289, 2, 7, INK)
        for _ in range(3):
            kind = rng.randrange(3)
            at = (x + rng.randint(10, 90), rng.randint(130, 370))
            if kind == 0:
                paper(c, rng, *at, 60, 84)
                c.ellipse(at[0] + 30, at[1] + 4, 6, 6, rng.choice(COLOURS))
            elif kind == 1:
                c.ellipse(at[0] + 20, at[1] + 20, 20, 20, rng.choice(COLOURS))
                c.ellipse(at[0] + 20, at[1] + 20, 9, 9, (250, 250, 246))
            else:
                sticky(c, rng, *at, 40)
        for _ in range(12):   # dents and scratches
            sx, sy = x + rng.randint(6, 150), rng.randint(300, 470)
            c.line(sx, sy, sx + rng.randint(-18, 18), sy + rng.randint(-6, 6), shade(col, 0.7), 1, 0.7)
    c.rect(0, 484, 512, 28, (60, 62, 68))
    c.add_field(add(smooth_noise(512, 512, 4, 30, rng, 4), smooth_noise(512, 512, 128, 128, rng, 3)))
    c.grain(rng, 2)
    return c


def glass_cupboard(rng):
    """Two glass doors before four boards of binders, boxes and a cup that somebody won."""
    c = Canvas(512, 512, (70, 58, 46))
    for row in range(4):
        y0, x = 14 + row * 118, 10
        c.rect(0, y0 + 104, 512, 10, (150, 116, 78))
        while x < 496:
            kind = rng.random()
            if kind < 0.6:
                w, h, col = rng.randint(20, 34), rng.randint(84, 98), rng.choice(COLOURS + [INK, (230, 230, 226)])
                c.rect(x, y0 + 104 - h, w - 2, h, col)
                c.bevel(x, y0 + 104 - h, w - 2, h, 2, 0.3)
                c.rect(x + 4, y0 + 116 - h, w - 10, 34, (248, 248, 244))
                c.lines_of_print(x + 6, y0 + 120 - h, w - 14, 5, rng, INK, 6, 2)
                c.ellipse(x + w / 2 - 1, y0 + 90, 5, 5, (30, 30, 34))
            elif kind < 0.95:
                w, h = rng.randint(44, 90), rng.randint(40, 80)
                c.rect(x, y0 + 104 - h, w, h, rng.choice([(196, 154, 104), (220, 216, 204), (120, 144, 160)]))
                c.rect(x + 8, y0 + 112 - h, w * 0.5, 16, (250, 250, 246))
                c.lines_of_print(x + 10, y0 + 115 - h, w * 0.4, 2, rng, INK, 5, 2)
            else:
                w = 40
                c.ellipse(x + 20, y0 + 60, 16, 20, (214, 180, 80))
                c.rect(x + 17, y0 + 76, 6, 18, (180, 146, 60))
                c.rect(x + 8, y0 + 92, 24, 12, INK)
            x += w + rng.choice((1, 1, 8))
    for x in (120, 350):   # the sky in the panes
        c.poly([(x, 10), (x + 46, 10), (x - 60, 480), (x - 106, 480)], (236, 244, 250), 0.22)
    for x in (0, 254):
        c.frame(x, 0, 258, 486, 12, (176, 140, 96))
        c.frame(x + 11, 11, 236, 464, 2, (84, 64, 44))
    for x in (236, 264):
        c.rect(x, 216, 8, 60, (206, 208, 212))
    c.rect(0, 484, 512, 28, (110, 84, 56))
    c.grain(rng, 2)
    return c


# --- on the walls

def window(rng, kind):
    """What is seen through a window of 1.64 m by 1.44 m, a blind drawn down a little. It shines, which draws it 1.26
    times as bright as it is here."""
    c = Canvas(512, 512, (168, 180, 190))
    c.gradient(0, 0, 512, 330, (112, 148, 186), (184, 192, 198))
    for _ in range(16):
        x, y = rng.randint(0, 500), rng.randint(60, 200)
        for k in range(6):
            c.ellipse(x + k * 16 - 40, y + rng.randint(-6, 6), rng.randint(14, 30), rng.randint(6, 14), (198, 200, 200), 0.5)
    for row in range(2):   # houses, the nearer ones lower and clearer
        x = -20
        while x < 512:
            w, h = rng.randint(50, 110), rng.randint(110, 200) - 60 * row
            col = mix(rng.choice([(160, 116, 92), (176, 168, 154), (128, 138, 146), (166, 142, 112), (150, 92, 76)]),
                      (172, 184, 194), 0.4 - 0.4 * row)
            foot = 340 + 30 * row
            c.rect(x, foot - h, w, h, col)
            if rng.random() < 0.5:
                c.poly([(x - 4, foot - h), (x + w / 2, foot - h - 34), (x + w + 4, foot - h)], shade(col, 0.62))
                c.rect(x + w * 0.7, foot - h - 34, 8, 24, shade(col, 0.5))
            c.rect(x, foot - h, 3, h, shade(col, 0.72))
            for j in range(int(h / 24)):
                for i in range(int(w / 18)):
                    pane = rng.choice([(64, 78, 94), (88, 106, 124), (196, 180, 120), (52, 60, 72)])
                    c.rect(x + 6 + i * 18, foot + 8 - h + j * 24, 9, 13, pane)
                    c.rect(x + 6 + i * 18, foot + 21 - h + j * 24, 9, 2, shade(col, 1.2))
            x += w + rng.randint(-4, 16)
    c.rect(0, 370, 512, 142, (104, 108, 108))          # a street
    c.rect(0, 366, 512, 12, (150, 148, 142))
    for k in range(12):
        c.rect(k * 46 + 6, 424, 26, 4, (196, 196, 188))
    for k in range(5):
        x, col = k * 104 + rng.randint(0, 36), rng.choice(COLOURS)
        c.rect(x, 386, 66, 20, shade(col, 0.8))
        c.poly([(x + 10, 386), (x + 18, 372), (x + 48, 372), (x + 58, 386)], (58, 70, 82))
        c.ellipse(x + 14, 406, 7, 7, (30, 30, 34))
        c.ellipse(x + 52, 406, 7, 7, (30, 30, 34))
    c.rect(0, 446, 512, 66, (142, 138, 130))           # the pavement on this side
    for k in range(14):
        c.rect(k * 38, 446, 1, 66, (104, 102, 96))
    for _ in range(3 if kind == 0 else 6):             # trees
        x, y = rng.randint(20, 490), rng.randint(230, 300)
        c.rect(x - 4, y, 8, 450 - y, (84, 66, 50))
        for _ in range(60):
            g = rng.choice([(62, 98, 54), (84, 124, 66), (48, 82, 48), (110, 138, 76)])
            a, r = rng.uniform(0, 6.3), rng.uniform(0, 50)
            c.ellipse(x + r * math.cos(a), y - 20 + 0.9 * r * math.sin(a), rng.randint(5, 12), rng.randint(4, 10), g, 0.9)
    if kind == 1:
        c.rect(392, 250, 6, 210, (70, 74, 80))
        c.rect(362, 250, 66, 34, (40, 92, 156))
        c.text_centred(395, 260, "P 24H", (204, 204, 200), 1)
    for k in range(11 if kind == 0 else 5):   # blind
        c.rect(0, k * 15, 512, 9, (196, 192, 180))
        c.rect(0, 9 + k * 15, 512, 2, (126, 122, 114))
    c.grain(rng, 2)
    return c


def door(rng):
    """A door with its frame, 1.0 m by 2.1 m."""
    c = Canvas(512, 512, (120, 128, 134))
    c.bevel(0, 0, 512, 560, 5, 0.4)
    c.rect(36, 16, 440, 496, (196, 158, 108))
    d = Canvas(440, 496, (196, 158, 108))
    knots(d, rng, 4, (120, 80, 46))
    wood(d, rng, 16, horizontal=False)
    c.paste(d, 36, 16)
    c.frame(36, 16, 440, 496, 3, (60, 50, 40))
    c.rect(150, 60, 212, 90, (180, 200, 206))     # pane
    c.frame(150, 60, 212, 90, 5, (90, 92, 96))
    c.line(170, 140, 260, 66, (240, 246, 248), 8, 0.5)
    c.rect(84, 250, 44, 44, (150, 152, 156))      # handle
    c.rect(92, 262, 96, 12, (214, 216, 220))
    c.rect(92, 274, 96, 4, (60, 60, 60))
    c.rect(150, 168, 212, 44, (38, 84, 150))
    c.text_centred(256, 180, "OFFICE 2.14", (255, 255, 255), 3)
    c.rect(300, 226, 90, 60, (30, 140, 80))
    c.text_centred(345, 246, "EXIT", (255, 255, 255), 3)
    paper(c, rng, 200, 226, 76, 60, 0)
    c.rect(40, 470, 432, 40, (176, 178, 180))     # kick plate
    for _ in range(60):
        x = rng.randint(44, 440)
        y = rng.randint(472, 506)
        c.line(x, y, x + rng.randint(5, 30), y + rng.randint(-2, 2), (120, 122, 124), 1)
    return c


def whiteboard(rng):
    """2.0 m by 1.2 m, in use."""
    c = Canvas(512, 512, (240, 243, 244))
    c.add_field(smooth_noise(512, 512, 7, 5, rng, 6))
    c.text(28, 34, "LOOP CLOSURE", BLUE, 3)
    c.line(28, 64, 240, 62, BLUE, 3)
    for k in range(8):
        c.scribble(30, 100 + k * 27, rng.randint(100, 210), rng, rng.choice([BLUE, INK, INK, RED]), 12, 2)
    nodes = [(300 + 170 * math.cos(a) * 0.55 + 60, 170 + 110 * math.sin(a)) for a in
             [2 * math.pi * k / 7 for k in range(7)]]
    for a, b in zip(nodes, nodes[1:] + nodes[:1]):
        c.line(a[0], a[1], b[0], b[1], INK, 2)
    c.line(nodes[0][0], nodes[0][1], nodes[3][0], nodes[3][1], RED, 3)
    for k, (x, y) in enumerate(nodes):
        c.ellipse(x, y, 15, 18, GREEN)
        c.ellipse(x, y, 11, 14, (240, 243, 244))
        c.text(int(x) - 5, int(y) - 6, str(k + 1), INK, 2)
    c.text(292, 332, "X = A X + B U", BLUE, 2)
    c.text(292, 364, "P = A P A + Q", RED, 2)
    c.frame(284, 320, 206, 80, 2, INK)
    c.line(60, 440, 60, 330, INK, 2)
    c.line(60, 440, 230, 440, INK, 2)
    c.polyline([(60 + 8 * k, 436 - 90 * (1 - math.exp(-k / 6)) + rng.randint(-6, 6)) for k in range(21)], RED, 3)
    for k in range(5):
        sticky(c, rng, 270 + k * 44, 424 + rng.randint(-8, 8), 36)
    c.ellipse(420, 60, 50, 22, (200, 206, 210), 0.6)
    c.frame(0, 0, 512, 512, 9, (168, 170, 174))
    c.rect(0, 488, 512, 24, (140, 142, 146))
    for k, col in enumerate((RED, BLUE, INK, GREEN)):
        c.rect(80 + k * 60, 484, 42, 9, col)
    return c


def extinguisher(rng):
    """Half of the way around a fire extinguisher."""
    c = Canvas(128, 128, (190, 40, 36))
    c.gradient(0, 0, 128, 128, (202, 48, 42), (168, 32, 30))
    c.rect(14, 30, 100, 66, (244, 240, 228))
    c.rect(14, 30, 100, 15, INK)
    c.text_centred(64, 34, "FIRE", (250, 250, 246), 1)
    for k, name in enumerate("ABC"):
        c.frame(20 + k * 32, 50, 26, 22, 2, INK)
        c.text(28 + k * 32, 54, name, RED, 2)
    c.lines_of_print(20, 78, 88, 4, rng, INK, 4, 2)
    c.rect(0, 114, 128, 14, (60, 24, 24))
    c.grain(rng, 2)
    return c


def pinboard(rng):
    c = Canvas(512, 512, (184, 142, 98))
    c.add_field(smooth_noise(512, 512, 170, 170, rng, 22))
    c.grain(rng, 6)
    for k in range(22):
        x, y = 18 + (k % 6) * 80 + rng.randint(-6, 10), 20 + (k // 6) * 116 + rng.randint(-6, 10)
        paper(c, rng, x, y, rng.choice((56, 66, 70)), rng.choice((80, 92, 100)))
        c.ellipse(x + 30, y + 5, 4, 4, rng.choice(COLOURS))
    for _ in range(9):
        sticky(c, rng, rng.randint(20, 450), rng.randint(20, 450), 36)
    c.frame(0, 0, 512, 512, 11, (146, 108, 66))
    return c


def _lighthouse(c, rng, size):
    c.gradient(0, 40, size, 140, (120, 170, 214), (236, 226, 200))
    c.rect(0, 180, size, 80, (40, 92, 124))
    for _ in range(50):
        c.rect(rng.randint(0, size), rng.randint(184, 250), rng.randint(6, 26), 2, (190, 216, 226))
    c.poly([(60, 190), (120, 160), (220, 176), (256, 210), (256, 256), (40, 256)], (92, 80, 70))
    for k in range(6):
        w = 40 - 3 * k
        c.rect(150 - w / 2, 160 - 18 * k, w, 18, RED if k % 2 == 0 else (246, 244, 236))
    c.rect(138, 50, 24, 20, (250, 232, 140))
    c.poly([(134, 50), (150, 36), (166, 50)], INK)
    for k in range(7):
        c.line(150, 60, 20 + 10 * k, 44 + 14 * k, (252, 240, 180), 2, 0.5)


def _lines(c, rng, size):
    c.rect(0, 0, size, size, (246, 244, 236))
    stops = []
    for col in COLOURS:
        x, y = 16, rng.randint(50, 240)
        points = [(x, y)]
        while x < 240:
            x += rng.choice((24, 32, 40))
            y = min(244, max(52, y + rng.choice((-32, 0, 0, 32))))
            points.append((x, y))
        c.polyline(points, col, 6)
        stops += points[1:-1]
    for x, y in stops:
        c.ellipse(x, y, 6, 6, INK)
        c.ellipse(x, y, 4, 4, (250, 250, 250))
        if rng.random() < 0.4:
            c.text(x + 5, y - 12, rng.choice(SHORT_WORDS), INK, 1)


def _elements(c, rng, size):
    c.rect(0, 0, size, size, (30, 34, 46))
    for j in range(7):
        for i in range(11):
            if j < 2 and 1 < i < 7:
                continue
            x, y = 6 + i * 22, 48 + j * 28
            c.rect(x, y, 20, 26, rng.choice(COLOURS))
            c.text(x + 4, y + 5, rng.choice("HBCNOFKPSVWUYI") + rng.choice("AEIORUN"), (250, 250, 250), 1)
            c.rect(x + 3, y + 17, rng.randint(6, 14), 2, (250, 250, 250), 0.8)


def _herbs(c, rng, size):
    c.rect(0, 0, size, size, (244, 238, 220))
    for k in range(6):
        x, y = 44 + (k % 3) * 84, 130 + (k // 3) * 104
        green = rng.choice([(70, 110, 58), (96, 134, 70), (52, 92, 70)])
        c.polyline([(x, y), (x + rng.randint(-8, 8), y - 40), (x + rng.randint(-8, 8), y - 78)], shade(green, 0.7), 3)
        for j in range(9):
            side, yy = (-1, 1)[j % 2], y - 8 - j * 8
            c.poly([(x, yy), (x + side * 12, yy - 10), (x + side * rng.randint(20, 32), yy - 8), (x + side * 12, yy + 3)], green)
        c.ellipse(x, y - 84, 9, 9, rng.choice([RED, PURPLE, YELLOW, BLUE]))
        c.ellipse(x, y - 84, 4, 4, (250, 240, 190))
        c.lines_of_print(x - 24, y + 4, 48, 2, rng, (110, 100, 84), 4, 2)


def _night(c, rng, size):
    c.gradient(0, 0, size, size, (16, 22, 52), (44, 40, 84))
    stars = [(rng.randint(6, 250), rng.randint(46, 250)) for _ in range(120)]
    for x, y in stars:
        c.ellipse(x, y, *rng.choice(((1, 1), (1, 1), (2, 2), (3, 3))), rng.choice([(250, 250, 250), (250, 236, 190), (190, 210, 250)]))
    for first in stars[:7]:   # constellations: from a star on to near ones
        near = sorted(stars, key=lambda p: math.hypot(p[0] - first[0], p[1] - first[1]))[:9:2]
        c.polyline(near, (150, 160, 200), 1)
    c.ellipse(190, 96, 28, 28, (236, 230, 204))
    for _ in range(8):
        c.ellipse(rng.randint(172, 208), rng.randint(78, 114), rng.randint(2, 6), rng.randint(2, 5), (206, 198, 170))


def _bicycle(c, rng, size):
    c.rect(0, 0, size, size, (236, 196, 84))
    for k in range(14):
        c.poly([(128, 300), (k * 40 - 140, 30), (k * 40 - 122, 30)], (250, 222, 130))
    for x in (74, 184):
        for r, col in ((46, INK), (41, (236, 196, 84))):
            c.ellipse(x, 186, r, r, col)
        for k in range(10):
            a = k * math.pi / 5
            c.line(x, 186, x + 42 * math.cos(a), 186 + 42 * math.sin(a), INK, 1)
    for a, b in (((74, 186), (118, 186)), ((118, 186), (166, 128)), ((166, 128), (100, 128)), ((100, 128), (118, 186)),
                 ((74, 186), (100, 128)), ((184, 186), (162, 110)), ((96, 118), (104, 140))):
        c.line(*a, *b, RED, 7)
    c.rect(82, 112, 32, 7, INK)
    c.line(162, 110, 184, 104, INK, 5)


def _words(c, rng, size):
    c.rect(0, 0, size, size, (40, 44, 56))
    y = 52
    for _ in range(6):
        word, col = rng.choice(WORDS), rng.choice(COLOURS + [(244, 244, 240)])
        c.text(12, y, word, col, min(4, int(230 / (6 * len(word)))))
        y += 34


def _sails(c, rng, size):
    c.gradient(0, 0, size, 150, (150, 200, 226), (230, 240, 240))
    for row in range(8):
        y = 150 + row * 14
        col = mix((80, 150, 180), (20, 60, 100), row / 7)
        c.rect(0, y, size, 20, col)
        for k in range(9):
            x = k * 32 + (row % 2) * 16
            c.poly([(x, y), (x + 16, y - 9), (x + 30, y)], shade(col, 1.15))
    for x, y, h, col in ((60, 156, 70, RED), (150, 176, 96, (250, 250, 246)), (214, 160, 54, ORANGE)):
        c.poly([(x - 24, y), (x + 24, y), (x + 16, y + 12), (x - 16, y + 12)], (92, 60, 44))
        c.poly([(x - 1, y - 4), (x - 1, y - h), (x - 26, y - 4)], col)
        c.poly([(x + 3, y - 4), (x + 3, y - h), (x + 22, y - 4)], shade(col, 0.86))
        c.rect(x, y - h, 3, h, INK)


NEWER_POSTERS = [_lighthouse, _lines, _elements, _herbs, _night, _bicycle, _words, _sails]


def poster(rng, kind, size=256):
    c = Canvas(size, size, (248, 248, 244))
    title = ["FIELD ROBOTICS", "SEE THE WORLD", "CITY MARATHON", "OPTICS LAB", "OPEN DAY", "JAZZ NIGHT", "THE ALPS",
             "SUMMER SCHOOL", "LIGHTHOUSES", "CITY LINES", "THE ELEMENTS", "WILD HERBS", "NIGHT SKY", "BY BICYCLE",
             "KEEP LOOKING", "SEA AND WIND"][kind]
    if kind >= 8:
        NEWER_POSTERS[kind - 8](c, rng, size)
    elif kind in (1, 6):
        c.gradient(0, 0, size, 170, (70, 130, 200) if kind == 1 else (240, 190, 130), (230, 236, 240))
        c.poly([(0, 170), (60, 70), (96, 120), (150, 40), (256, 170)], (110, 118, 130))
        c.poly([(128, 70), (150, 40), (176, 72), (160, 66), (146, 80)], (250, 250, 252))
        c.poly([(0, 200), (80, 140), (180, 180), (256, 150), (256, 256), (0, 256)], (64, 112, 72))
        for _ in range(40):
            x, y = rng.randint(4, 250), rng.randint(180, 220)
            c.poly([(x, y), (x + 6, y - 22), (x + 12, y)], (38, 78, 50))
    elif kind in (0, 3):
        c.rect(0, 0, size, size, (34, 50, 82) if kind == 0 else (240, 236, 224))
        col = (240, 240, 240) if kind == 0 else INK
        for k in range(9):
            c.line(20, 60 + k * 16, 128, 130, rng.choice(COLOURS), 2)
            c.line(128, 130, 240, 60 + k * 16, rng.choice(COLOURS), 2)
        c.ellipse(128, 130, 18, 52, (180, 210, 230), 0.8)
        c.rect(40, 190, 90, 34, RED)
        for x in (56, 112):
            c.ellipse(x, 226, 13, 13, (30, 30, 34))
        c.lines_of_print(146, 190, 90, 9, rng, col, 5, 2)
    elif kind in (2, 5):
        base = rng.choice((ORANGE, PURPLE))
        c.rect(0, 0, size, size, base)
        for k in range(26):
            x, y = rng.randint(0, 240), rng.randint(50, 230)
            c.ellipse(x, y, rng.randint(6, 28), rng.randint(6, 28), rng.choice(COLOURS + [(250, 250, 250)]), 0.85)
        for k in range(12):
            x = 14 + k * 20
            c.rect(x, 228 - rng.randint(20, 90), 12, 100, INK)
    else:
        for j in range(5):
            for i in range(5):
                c.rect(8 + i * 49, 52 + j * 40, 44, 34, rng.choice(COLOURS + [(220, 224, 228), INK]))
                if rng.random() < 0.6:
                    c.ellipse(30 + i * 49, 69 + j * 40, 11, 11, rng.choice(COLOURS + [(255, 255, 255)]))
    c.rect(0, 0, size, 40, rng.choice([INK, RED, BLUE, TEAL]))
    c.text_centred(size // 2, 12, title, (255, 255, 255), 2)
    c.frame(0, 0, size, size, 4, (250, 250, 250))
    c.grain(rng, 2)
    return c


def posters(rng, first):
    c = Canvas(512, 512)
    for k in range(4):
        c.paste(poster(rng, first + k), (k % 2) * 256, (k // 2) * 256)
    return c


SIGNS = ["fire_plan", "clock", "calendar", "socket", "switch", "exit", "extinguisher", "notice", "thermostat", "rota",
         "picture", "certificate", "no_smoking", "recycling", "arrow", "first_aid"]


def clock_face(c, r, case, rim, dial, mark, hour, minute):
    """A clock of radius r on a picture of 128 px: its marks of the hours are so long, its hands point there."""
    c.rect(0, 0, 128, 128, case)
    c.ellipse(64, 64, r, r, rim)
    c.ellipse(64, 64, r - 6, r - 6, dial)
    for h in range(12):
        x, y = math.sin(h * math.pi / 6), -math.cos(h * math.pi / 6)
        out = r - 9
        c.line(64 + (out - mark) * x, 64 + (out - mark) * y, 64 + out * x, 64 + out * y, INK, 4)
    c.line(64, 64, *hour, INK, 5)
    c.line(64, 64, *minute, INK, 3)


def signs(rng):
    sheet = Canvas(512, 512)
    for k, name in enumerate(SIGNS):
        c = Canvas(128, 128, (246, 246, 242))
        if name == "fire_plan":
            c.rect(0, 0, 128, 22, RED)
            c.text_centred(64, 7, "FIRE PLAN", (255, 255, 255), 2)
            c.frame(10, 30, 108, 88, 3, INK)
            for _ in range(7):
                c.rect(rng.randint(14, 90), rng.randint(34, 100), rng.randint(8, 24), rng.randint(5, 14), (150, 154, 160))
            c.polyline([(20, 110), (20, 64), (70, 64), (70, 40), (112, 40)], GREEN, 4)
            c.ellipse(20, 110, 5, 5, BLUE)
        elif name == "clock":
            clock_face(c, 58, (60, 62, 68), (30, 30, 34), (252, 252, 250), 7, (84, 44), (56, 24))
            c.line(64, 64, 40, 92, RED, 2)
        elif name == "calendar":
            c.rect(0, 0, 128, 30, TEAL)
            c.text_centred(64, 8, "MARCH", (255, 255, 255), 2)
            for d in range(31):
                x, y = 6 + (d % 7) * 17, 36 + (d // 7) * 18
                c.frame(x, y, 15, 16, 1, (170, 172, 176))
                c.text(x + 2, y + 4, str(d + 1), RED if d % 7 > 4 else INK, 1)
            c.ellipse(64, 82, 12, 12, RED, 0.5)
        elif name == "socket":
            for i in (0, 1):
                c.frame(4 + i * 62, 24, 58, 80, 3, (200, 200, 196))
                c.ellipse(33 + i * 62, 64, 24, 24, (206, 206, 202))
                c.ellipse(25 + i * 62, 64, 4, 4, (30, 30, 30))
                c.ellipse(41 + i * 62, 64, 4, 4, (30, 30, 30))
        elif name == "switch":
            c.bevel(4, 4, 120, 120, 5, 0.3)
            c.rect(26, 22, 34, 84, (226, 226, 222))
            c.bevel(26, 22, 34, 84, 4, 0.4)
            c.rect(68, 22, 34, 84, (226, 226, 222))
            c.bevel(68, 22, 34, 84, 4, 0.4)
        elif name == "exit":
            c.rect(0, 0, 128, 128, (24, 140, 80))
            c.text_centred(64, 20, "EXIT", (255, 255, 255), 4)
            c.poly([(20, 76), (74, 76), (74, 60), (112, 88), (74, 116), (74, 100), (20, 100)], (255, 255, 255))
        elif name == "extinguisher":
            c.rect(0, 0, 128, 128, RED)
            c.rect(46, 44, 36, 70, (255, 255, 255))
            c.rect(56, 26, 16, 18, (255, 255, 255))
            c.line(56, 30, 30, 60, (255, 255, 255), 6)
        elif name == "notice":
            paper(c, rng, 0, 0, 128, 128, 1)
        elif name == "thermostat":
            c.bevel(4, 4, 120, 120, 4, 0.3)
            c.rect(24, 22, 80, 42, (150, 176, 150))
            c.text(36, 32, "21.5", INK, 3)
            c.ellipse(64, 94, 18, 18, (200, 200, 196))
            c.line(64, 94, 76, 82, INK, 3)
        elif name == "rota":
            c.text_centred(64, 6, "CLEANING", BLUE, 2)
            for j in range(7):
                c.rect(6, 26 + j * 14, 116, 1, INK)
                c.scribble(8, 36 + j * 14, 40, rng, INK, 6)
                for i in range(4):
                    if rng.random() < 0.5:
                        c.text(60 + i * 16, 29 + j * 14, "X", RED, 1)
        elif name == "picture":
            c.gradient(0, 0, 128, 80, (250, 200, 140), (250, 236, 210))
            c.ellipse(88, 52, 18, 18, (250, 240, 200))
            c.rect(0, 78, 128, 50, (60, 100, 140))
            for j in range(9):
                c.rect(rng.randint(0, 90), 82 + j * 5, rng.randint(14, 40), 2, (180, 206, 226))
            c.poly([(30, 86), (66, 86), (58, 98), (38, 98)], (90, 50, 40))
            c.poly([(48, 84), (48, 40), (74, 78)], (252, 252, 252))
            c.frame(0, 0, 128, 128, 8, (90, 62, 40))
        elif name == "certificate":
            c.frame(6, 6, 116, 116, 4, (196, 160, 70))
            c.text_centred(64, 22, "1ST PRIZE", INK, 2)
            c.lines_of_print(26, 46, 76, 8, rng, (110, 112, 120), 6, 2)
            c.ellipse(96, 104, 12, 12, RED)
            c.frame(0, 0, 128, 128, 5, (50, 44, 40))
        elif name == "no_smoking":
            c.ellipse(64, 64, 54, 54, RED)
            c.ellipse(64, 64, 42, 42, (250, 250, 250))
            c.rect(34, 58, 60, 12, INK)
            c.line(28, 28, 100, 100, RED, 11)
        elif name == "recycling":
            c.rect(0, 0, 128, 128, BLUE)
            for a in (0, 2.1, 4.2):
                x, y = 64 + 30 * math.cos(a), 60 + 30 * math.sin(a)
                c.poly([(x + 20 * math.cos(a + t), y + 20 * math.sin(a + t)) for t in (0.5, 2.6, 4.7)], (255, 255, 255))
            c.text_centred(64, 108, "PAPER", (255, 255, 255), 2)
        elif name == "arrow":
            c.rect(0, 0, 128, 128, (236, 200, 70))
            c.poly([(14, 52), (70, 52), (70, 28), (116, 64), (70, 100), (70, 76), (14, 76)], INK)
        else:
            c.rect(0, 0, 128, 128, (30, 130, 80))
            c.rect(50, 20, 28, 88, (255, 255, 255))
            c.rect(20, 50, 88, 28, (255, 255, 255))
        sheet.paste(c, (k % 4) * 128, (k // 4) * 128)
    sheet.grain(rng, 1.5)
    return sheet


def plates(rng):
    """64 numbered plates, no two alike."""
    sheet = Canvas(512, 512)
    for k in range(64):
        c = Canvas(64, 64, (246, 246, 240))
        col = COLOURS[(k * 3 + k // 7) % 7]
        c.rect(0, 0, 64, 18, col)
        c.text_centred(32, 5, rng.choice(WORDS)[:7], (255, 255, 255) if sum(col) < 520 else INK, 1)
        c.text_centred(32, 26, f"{k + 1:02d}", INK, 4)
        c.frame(0, 0, 64, 64, 2, shade(col, 0.7))
        c.rect(4, 58, rng.randint(10, 54), 3, col)
        sheet.paste(c, (k % 8) * 64, (k // 8) * 64)
    return sheet


def sheets(rng):
    """16 pages."""
    sheet = Canvas(512, 512)
    for k in range(16):
        c = Canvas(128, 128, (250, 250, 246))
        paper(c, rng, -2, -2, 132, 132, k % 6)
        if k % 3 == 0:
            c.rect(0, 46, 128, 36, (250, 250, 246))
            c.text_centred(64, 54, rng.choice([w for w in WORDS if len(w) < 7]), rng.choice([RED, BLUE, INK]), 3)
        sheet.paste(c, (k % 4) * 128, (k // 4) * 128)
    return sheet


PROPS = ["radiator", "lamp", "printer", "printer_top", "cardboard", "pot", "leaves", "keyboard", "phone", "mug", "coat",
         "bin", "duct", "skirting", "metal", "soil"]


def props(rng):
    """Small things, one cell each."""
    sheet = Canvas(512, 512)
    for k, name in enumerate(PROPS):
        c = Canvas(128, 128, (230, 230, 226))
        if name == "radiator":
            c.rect(0, 0, 128, 128, (222, 220, 210))
            for i in range(10):
                c.rect(3 + i * 13, 8, 8, 108, (240, 238, 230))
                c.rect(11 + i * 13, 8, 3, 108, (150, 148, 140))
            c.rect(0, 0, 128, 6, (190, 188, 180))
            c.rect(0, 120, 128, 8, (120, 118, 112))
        elif name == "lamp":
            c.rect(0, 0, 128, 128, (255, 255, 250))
            c.frame(0, 0, 128, 128, 4, (200, 202, 204))
            for i in range(1, 8):
                c.rect(i * 16, 4, 1, 120, (214, 216, 218))
            c.rect(4, 62, 120, 4, (220, 222, 224))
        elif name == "printer":
            c.rect(0, 0, 128, 128, (214, 214, 208))
            c.rect(0, 0, 128, 26, (60, 62, 68))
            c.rect(12, 6, 34, 14, (120, 190, 200))
            for i in range(5):
                c.ellipse(64 + i * 12, 13, 4, 4, rng.choice(COLOURS))
            c.rect(14, 34, 100, 14, (30, 31, 34))
            for j in range(3):
                c.rect(6, 54 + j * 24, 116, 21, (196, 196, 190))
                c.bevel(6, 54 + j * 24, 116, 21, 2, 0.3)
                c.rect(46, 60 + j * 24, 36, 6, (80, 82, 86))
        elif name == "printer_top":
            c.rect(0, 0, 128, 128, (204, 204, 198))
            c.rect(10, 10, 90, 100, (84, 86, 92))
            paper(c, rng, 22, 20, 64, 80, 0)
        elif name == "cardboard":
            c.rect(0, 0, 128, 128, (190, 150, 102))
            c.add_field(smooth_noise(128, 128, 60, 6, rng, 9))
            c.rect(0, 54, 128, 14, (214, 190, 140))
            c.text(10, 18, "FRAGILE", RED, 2)
            c.rect(70, 80, 50, 36, (246, 246, 240))
            c.lines_of_print(74, 84, 42, 5, rng, INK, 6, 2)
            c.poly([(20, 112), (32, 84), (44, 112)], INK)
        elif name == "pot":
            c.rect(0, 0, 128, 128, (184, 104, 72))
            c.rect(0, 0, 128, 24, (204, 124, 88))
            c.rect(0, 24, 128, 4, (110, 60, 40))
            c.add_field(smooth_noise(128, 128, 12, 40, rng, 12))
        elif name == "leaves":
            c.rect(0, 0, 128, 128, (46, 84, 44))
            for _ in range(110):
                x, y, a = rng.randint(0, 128), rng.randint(0, 128), rng.uniform(0, 6.3)
                col = rng.choice([(84, 136, 66), (110, 160, 80), (62, 110, 56), (138, 176, 96)])
                c.poly([(x, y), (x + 12 * math.cos(a + 0.4), y + 12 * math.sin(a + 0.4)),
                        (x + 24 * math.cos(a), y + 24 * math.sin(a)),
                        (x + 12 * math.cos(a - 0.4), y + 12 * math.sin(a - 0.4))], col)
        elif name == "keyboard":
            c.rect(0, 0, 128, 128, (50, 52, 58))
            for j in range(5):
                for i in range(12):
                    c.rect(4 + i * 10, 8 + j * 23, 8, 18, (92, 94, 102))
        elif name == "phone":
            c.rect(0, 0, 128, 128, (64, 66, 74))
            c.rect(46, 14, 70, 30, (150, 180, 160))
            for j in range(4):
                for i in range(3):
                    c.rect(52 + i * 22, 54 + j * 18, 16, 12, (200, 200, 200))
            c.rect(8, 8, 26, 112, (36, 38, 42))
        elif name == "mug":
            c.rect(0, 0, 128, 128, (240, 240, 236))
            c.rect(0, 30, 128, 40, RED)
            c.text_centred(64, 42, "TEA", (255, 255, 255), 3)
        elif name == "coat":
            c.gradient(0, 0, 128, 128, (84, 96, 132), (60, 70, 104))
            c.add_field(smooth_noise(128, 128, 12, 3, rng, 26))
            c.poly([(36, 0), (92, 0), (76, 34), (52, 34)], (196, 72, 60))       # a scarf
            for j in range(4):
                c.rect(44 + 4 * (j % 2), 4 + 8 * j, 42 - 6 * j, 3, (240, 226, 190))
            c.line(64, 34, 60, 128, (30, 34, 50), 3)
            for j in range(4):
                c.ellipse(70, 46 + j * 22, 3, 3, (220, 210, 170))
            for x in (14, 84):
                c.rect(x, 78, 34, 6, (30, 34, 50))
                c.rect(x, 84, 34, 2, (130, 140, 170))
        elif name == "bin":
            c.rect(0, 0, 128, 128, (72, 76, 84))
            for j in range(8):
                for i in range(16):
                    c.rect(i * 8, 18 + j * 14, 4, 9, (36, 38, 42))
            c.rect(0, 0, 128, 10, (110, 114, 120))
        elif name == "duct":
            c.rect(0, 0, 128, 128, (224, 224, 218))
            c.rect(0, 0, 128, 10, (180, 180, 174))
            c.rect(0, 112, 128, 16, (160, 160, 154))
            for x in (16, 80):
                c.frame(x, 34, 34, 50, 3, (150, 150, 146))
                c.ellipse(x + 11, 58, 4, 5, (30, 30, 30))
                c.ellipse(x + 23, 58, 4, 5, (30, 30, 30))
        elif name == "skirting":
            c.rect(0, 0, 128, 128, (150, 118, 84))
            c.add_field(smooth_noise(128, 128, 4, 60, rng, 14))
            c.rect(0, 0, 128, 20, (186, 154, 116))
            c.rect(0, 108, 128, 20, (96, 74, 52))
        elif name == "metal":
            c.rect(0, 0, 128, 128, (170, 172, 176))
            c.add_field(smooth_noise(128, 128, 3, 100, rng, 14))
        else:
            c.rect(0, 0, 128, 128, (70, 52, 40))
            c.grain(rng, 16)
        sheet.paste(c, (k % 4) * 128, (k // 4) * 128)
    sheet.grain(rng, 2)
    return sheet


LIVELY = [BLUE, RED, GREEN, ORANGE, TEAL, PURPLE, (200, 190, 170), (240, 236, 220), (60, 64, 76)]
CALM = [(92, 112, 150), (150, 96, 84), (110, 132, 110), (196, 176, 130), (226, 222, 210), (86, 90, 100), (170, 120, 80)]

TEXTURES = {
    "carpet_blue": lambda r: carpet(r, (112, 126, 146), (164, 178, 196)),
    "carpet_sand": lambda r: carpet(r, (164, 146, 116), (204, 186, 150)),
    "wall": wall,
    "wall_b": lambda r: wall(r, (240, 230, 206), (192, 176, 148), (150, 96, 62)),
    "wall_plain": plain_wall,
    "floor_plain": plain_floor,
    "skirting": skirting,
    "ceiling": ceiling,
    "window_a": lambda r: window(r, 0),
    "window_b": lambda r: window(r, 1),
    "window_c": lambda r: window(r, 0),
    "window_d": lambda r: window(r, 1),
    "extinguisher": extinguisher,
    "door": door,
    "whiteboard": whiteboard,
    "pinboard": pinboard,
    "posters_a": lambda r: posters(r, 0),
    "posters_b": lambda r: posters(r, 4),
    "posters_c": lambda r: posters(r, 8),
    "posters_d": lambda r: posters(r, 12),
    "signs": signs,
    "plates": plates,
    "sheets": sheets,
    "props": props,
    "desk_top_a": lambda r: desk_top(r, (214, 186, 146)),
    "desk_top_b": lambda r: desk_top(r, (222, 212, 194)),
    "desk_front_a": lambda r: desk_front(r, BEECH, (120, 122, 128)),
    "desk_front_b": lambda r: desk_front(r, LAMINATE, (70, 70, 76)),
    "desk_side_a": lambda r: desk_side(r, BEECH, True),
    "desk_side_b": lambda r: desk_side(r, LAMINATE, False),
    "partition_a": lambda r: partition(r, (120, 146, 158)),
    "partition_b": lambda r: partition(r, (172, 150, 118)),
    "screen_1": lambda r: screen(r, 0),
    "screen_2": lambda r: screen(r, 1),
    "screen_3": lambda r: screen(r, 2),
    "screen_4": lambda r: screen(r, 3),
    "screen_5": lambda r: screen(r, 4),
    "screen_6": lambda r: screen(r, 5),
    "plastic": plastic,
    "monitor_back": monitor_back,
    "chair_blue": lambda r: chair_fabric(r, (66, 92, 140)),
    "chair_red": lambda r: chair_fabric(r, (152, 62, 58)),
    "chair_base": chair_base,
    "books_a": lambda r: books(r, LIVELY),
    "books_b": lambda r: books(r, CALM),
    "wood_shelf": wood_shelf,
    "wood_dark": lambda r: wood_shelf(r, (134, 98, 70)),
    "laminate": laminate,
    "cupboard_a": lambda r: cupboard(r, (200, 172, 132), 0),
    "cupboard_b": lambda r: cupboard(r, (176, 184, 188), 1),
    "cupboard_c": lockers,
    "cupboard_d": glass_cupboard,
    "plain_white": lambda r: plain(r, (214, 214, 210)),
    "plain_steel": steel,
    "plain_grey": lambda r: plain(r, (150, 154, 158)),
    "plain_wood": lambda r: plain(r, (194, 164, 124)),
    "plain_blue": lambda r: plain(r, (84, 108, 146)),
}


def paint(name):
    return TEXTURES[name](random.Random("office " + name))


def paint_and_save(job):
    name, path = job
    paint(name).save(path)
    return name
