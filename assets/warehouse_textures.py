# SPDX-License-Identifier: BSD-3-Clause
"""The pictures of the warehouse: concrete, brick, corrugated sheet, cartons, pallets, barrels."""

import math

from canvas import Canvas, add, mix, shade, smooth_noise
from home_textures import around, grid
from textures import BLUE, COLOURS, GREEN, INK, ORANGE, RED, TEAL, WORDS, YELLOW, knots, wood

CARDBOARD = (190, 150, 102)


def concrete(rng):
    """2.5 m of worn floor: stones in the screed, cracks, tyre marks, stains."""
    base = (162, 158, 150)
    c = Canvas(512, 512, base)
    c.add_field(add(smooth_noise(512, 512, 5, 5, rng, 5), smooth_noise(512, 512, 24, 24, rng, 5),
                    smooth_noise(512, 512, 128, 128, rng, 6)))
    for _ in range(2400):
        x, y, r = rng.randrange(512), rng.randrange(512), rng.uniform(0.8, 2.6)
        col = shade(base, rng.choice((0.78, 0.84, 0.9, 1.1, 1.16, 1.2)))
        around(c, x, y, 4, lambda px, py: c.ellipse(px, py, r, r * 0.85, col))
    for _ in range(6):
        x, y, points = rng.randrange(512), rng.randrange(512), []
        for _ in range(9):
            points.append((x, y))
            x, y = x + rng.randint(-26, 26), y + rng.randint(4, 26)
        around(c, 0, 0, 600, lambda px, py: c.polyline([(a + px, b + py) for a, b in points], shade(base, 0.62), 1.4))
    for _ in range(7):
        x, y, w = rng.randrange(512), rng.randrange(512), rng.randint(60, 200)
        for k in range(0, w, 7):
            c.rect(x + k, y + (k % 14) // 7, 4, 11, shade(base, 0.55), 0.4)
    for _ in range(8):
        c.ellipse(rng.randrange(512), rng.randrange(512), rng.randint(6, 24), rng.randint(6, 20), shade(base, 0.7), 0.3)
    c.rect(0, 0, 512, 2, shade(base, 0.6))
    c.rect(0, 0, 2, 512, shade(base, 0.6))
    c.grain(rng, 4)
    return c


def brick(rng, base, mortar=(190, 182, 168), courses=24):
    """1.8 m of brickwork: 24 courses of 7.5 cm, stretchers of 22.5 cm."""
    c = Canvas(512, 512, mortar)
    c.grain(rng, 9)
    h, w = 512 / courses, 64
    for j in range(courses):
        for i in range(9):
            x, y = (i - (0.5 if j % 2 else 0)) * w, j * h
            if x >= 512 - 1:
                continue
            tone = shade(mix(base, (120, 70, 60), rng.uniform(0, 0.35)), rng.uniform(0.70, 1.22))
            if i == 0 and j % 2:
                tone = first = tone
            if i == 8:
                tone = first
            c.rect(x + 2, y + 2, w - 4, h - 4, tone)
            c.rect(x + 2, y + 2, w - 4, 2, (255, 240, 220), 0.22)
            c.rect(x + 2, y + h - 4, w - 4, 2, (0, 0, 0), 0.25)
            if 0 <= x < 448:
                for _ in range(rng.randint(0, 4)):
                    c.ellipse(x + rng.uniform(8, w - 8), y + rng.uniform(5, h - 5), rng.uniform(1.2, 4.5), rng.uniform(1, 3.5),
                              shade(tone, rng.choice((0.5, 0.65, 1.35))))
    c.add_field(add(smooth_noise(512, 512, 6, 6, rng, 8), smooth_noise(512, 512, 150, 150, rng, 7)))
    c.grain(rng, 4)
    return c


def corrugated(rng):
    """2.5 m of corrugated sheet with rivets, dents, rust, and numbers sprayed on."""
    base = (134, 152, 164)
    c = Canvas(512, 512, base)
    for k in range(512):
        c.rect(k, 0, 1, 512, (255, 255, 255) if (k // 16) % 2 else (0, 0, 0), 0.18 * abs(math.sin(math.pi * k / 16)))
    c.add_field(add(smooth_noise(512, 512, 6, 6, rng, 8), smooth_noise(512, 512, 120, 40, rng, 7)))
    for j in range(6):
        y = j * 85.3
        c.rect(0, y, 512, 2, shade(base, 0.5))
        for i in range(16):
            c.ellipse(i * 32 + 8, y + 8, 3.2, 3.2, (70, 76, 82))
            c.ellipse(i * 32 + 7, y + 7, 1.3, 1.3, (226, 230, 234))
            if rng.random() < 0.6:
                c.rect(i * 32 + 6, y + 11, 4, rng.randint(8, 44), (146, 92, 56), rng.uniform(0.3, 0.8))
    for _ in range(150):
        c.ellipse(rng.randrange(512), rng.randrange(512), rng.uniform(1.5, 6), rng.uniform(1.5, 4),
                  rng.choice([(150, 96, 60), (84, 96, 106), (196, 206, 212), (120, 72, 44)]), 0.8)
    for _ in range(60):
        x, y = rng.randrange(512), rng.randrange(512)
        c.line(x, y, x + rng.randint(-34, 34), y + rng.randint(-12, 12), rng.choice([(80, 90, 98), (210, 216, 220)]), 1.2)
    for _ in range(5):
        c.text(rng.randint(10, 420), rng.randint(10, 480), rng.choice(WORDS)[:2] + str(rng.randint(10, 99)), INK, 3, 0.55)
    c.rect(0, 0, 512, 3, (84, 94, 102))
    c.grain(rng, 3)
    return c


def gate(rng):
    """A roller gate, 3 m by 3 m, with a number and stripes of warning."""
    c = Canvas(512, 512, (196, 200, 202))
    for j in range(32):
        c.rect(0, j * 16, 512, 16, shade((196, 200, 202), rng.uniform(0.9, 1.06)))
        c.rect(0, j * 16, 512, 2, (110, 114, 118))
        c.rect(0, j * 16 + 3, 512, 2, (236, 238, 240))
        for _ in range(5):
            x = rng.randrange(512)
            c.ellipse(x, j * 16 + 9, rng.uniform(1, 4), rng.uniform(1, 3), rng.choice([(120, 90, 66), (96, 100, 104)]))
    c.rect(166, 90, 180, 130, (250, 220, 60))
    c.text_centred(256, 116, "GATE 2", INK, 4)
    c.text_centred(256, 166, "KEEP CLEAR", RED, 2)
    for i in range(3):
        c.rect(60 + i * 150, 250, 92, 56, (96, 120, 136))
        c.line(60 + i * 150, 300, 140 + i * 150, 254, (220, 230, 236), 6, 0.6)
        c.frame(60 + i * 150, 250, 92, 56, 4, (50, 54, 58))
    for x in (0, 480):
        for k in range(18):
            c.poly([(x, k * 32), (x + 32, k * 32 - 20), (x + 32, k * 32 - 4), (x, k * 32 + 16)],
                   (240, 204, 40) if k % 2 else (30, 30, 32))
    for k in range(26):
        c.poly([(k * 24, 512), (k * 24 + 14, 470), (k * 24 + 26, 470), (k * 24 + 12, 512)], (240, 204, 40) if k % 2 else (30, 30, 32))
    for _ in range(50):
        x, y = rng.randint(40, 470), rng.randint(320, 468)
        c.line(x, y, x + rng.randint(-34, 34), y + rng.randint(-6, 6), (84, 86, 90), 1.5)
    c.grain(rng, 3)
    return c


CARTONS = 16


def cartons(rng):
    """Sixteen faces of cartons."""
    def draw(c, k):
        base = rng.choice([CARDBOARD, CARDBOARD, (206, 172, 126), (170, 130, 84), (226, 220, 206), (110, 136, 160)])
        c.rect(0, 0, 128, 128, base)
        c.add_field(smooth_noise(128, 128, 4, 40, rng, 8))
        c.rect(0, 56, 128, 14, mix(base, (240, 226, 170), 0.6))
        word = rng.choice(["FRAGILE", "THIS WAY", "PARTS", "PAPER", "TOOLS", "LAMPS", "SEEDS", "PUMPS", "WIRE", "BOLTS",
                           "GLASS", "TEA", "PAINT", "VALVES"])
        c.text(8, 10, word, rng.choice([INK, RED, BLUE, GREEN]), 3 if len(word) < 6 else 2)
        c.text(8, 38, str(rng.randint(1000, 99999)), INK, 2)
        x, y = rng.randint(60, 74), rng.randint(76, 84)
        c.rect(x, y, 50, 38, (248, 248, 244))
        at = x + 3
        while at < x + 44:
            w = rng.choice((1, 1, 2, 3))
            c.rect(at, y + 3, w, 18, INK)
            at += w + rng.choice((1, 2))
        c.lines_of_print(x + 4, y + 25, 40, 3, rng, INK, 4, 2)
        kind = k % 4
        if kind == 0:
            for dx in (0, 24):
                c.poly([(10 + dx, 100), (20 + dx, 82), (30 + dx, 100)], INK)
                c.rect(17 + dx, 100, 6, 14, INK)
        elif kind == 1:
            c.ellipse(30, 98, 18, 18, rng.choice(COLOURS))
            c.ellipse(30, 98, 10, 10, (250, 250, 246))
        elif kind == 2:
            c.poly([(12, 116), (30, 80), (48, 116)], YELLOW)
            c.text(26, 98, "!", INK, 2)
        else:
            c.rect(10, 80, 40, 36, rng.choice(COLOURS))
            c.text(16, 90, rng.choice(WORDS)[:3], (255, 255, 255), 2)
        for _ in range(5):
            px, py = rng.randrange(128), rng.randrange(128)
            c.line(px, py, px + rng.randint(-18, 18), py + rng.randint(-5, 5), shade(base, 0.6), 1)
        c.frame(0, 0, 128, 128, 2, shade(base, 0.6))

    sheet = grid(512, 4, 4, range(CARTONS), draw)
    sheet.grain(rng, 3)
    return sheet


def timber(rng):
    """Boards of pallets."""
    base = (186, 150, 104)
    c = Canvas(256, 256, base)
    for k in range(8):
        c.rect(0, k * 32, 256, 28, shade(base, rng.uniform(0.8, 1.15)))
        c.rect(0, k * 32 + 28, 256, 4, (56, 42, 30))
        for x in (14, 22, 122, 134, 236, 244):
            c.ellipse(x, k * 32 + rng.randint(8, 20), 2.4, 2.4, (60, 56, 54))
        if rng.random() < 0.6:
            c.text(rng.randint(30, 190), k * 32 + 8, rng.choice(("EUR", "EPAL", "HT 04", "DE 7")), (70, 50, 34), 2, 0.8)
    knots(c, rng, 9, (90, 60, 36))
    wood(c, rng, 16)
    c.grain(rng, 4)
    return c


def wrapped(rng):
    """Goods on a pallet under film: bags and cartons seen through it."""
    c = Canvas(256, 256, (176, 180, 184))
    for j in range(4):
        for i in range(3):
            col = rng.choice(COLOURS + [CARDBOARD, CARDBOARD, (226, 226, 220)])
            c.rect(i * 86, j * 64, 84, 62, col)
            c.rect(i * 86 + 8, j * 64 + 10, 52, 24, (246, 246, 240))
            c.text(i * 86 + 12, j * 64 + 14, rng.choice(WORDS)[:4], INK, 2)
            c.lines_of_print(i * 86 + 8, j * 64 + 42, 66, 3, rng, INK, 5, 2)
    for _ in range(40):   # the shine of the film
        y = rng.randint(-40, 256)
        c.line(0, y, 256, y + rng.randint(-50, 50), (240, 246, 250), rng.choice((1.4, 2, 3)), rng.uniform(0.2, 0.55))
    c.grain(rng, 3)
    return c


def barrel(rng):
    c = Canvas(256, 256, (44, 92, 150))
    c.add_field(add(smooth_noise(256, 256, 6, 6, rng, 10), smooth_noise(256, 256, 60, 60, rng, 8)))
    for y in (0, 80, 166, 244):
        c.rect(0, y, 256, 9, (30, 62, 104))
        c.rect(0, y + 1, 256, 2, (120, 160, 206))
    for i in range(2):
        c.rect(20 + i * 128, 96, 84, 62, (246, 244, 236))
        c.poly([(32 + i * 128, 126), (50 + i * 128, 104), (68 + i * 128, 126), (50 + i * 128, 148)], RED if i else YELLOW)
        c.text(46 + i * 128, 119, "!", INK, 2)
        c.text(72 + i * 128, 106, "OIL" if i else "ACID", INK, 1)
        c.lines_of_print(74 + i * 128, 120, 26, 6, rng, INK, 5, 2)
    for _ in range(90):
        c.ellipse(rng.randrange(256), rng.randrange(256), rng.uniform(1, 5), rng.uniform(1, 4),
                  rng.choice([(150, 96, 60), (120, 74, 46), (90, 140, 190)]), 0.85)
    for _ in range(20):
        x, y = rng.randrange(256), rng.randrange(256)
        c.line(x, y, x + rng.randint(-4, 4), y + rng.randint(8, 30), (140, 88, 54), 2, 0.7)
    c.grain(rng, 3)
    return c


def lane(rng):
    """Lane paint, worn."""
    c = Canvas(256, 256, (226, 190, 56))
    c.add_field(smooth_noise(256, 256, 12, 12, rng, 10))
    for _ in range(520):
        c.ellipse(rng.randrange(256), rng.randrange(256), rng.uniform(1, 6), rng.uniform(1, 5), (160, 156, 148), 0.9)
    for _ in range(30):
        x, y = rng.randrange(256), rng.randrange(256)
        c.line(x, y, x + rng.randint(-30, 30), y + rng.randint(-30, 30), (100, 96, 84), 1.5)
    c.grain(rng, 4)
    return c


THINGS = ["steel", "beam", "upright", "number", "stripes", "fork", "cab", "wheel", "plate_a", "plate_b", "plate_c", "plate_d",
          "lamp", "fence", "lid", "film"]


def things(rng):
    def draw(c, name):
        s = c.w
        if name == "steel":
            c.rect(0, 0, s, s, (150, 154, 158))
            c.add_field(smooth_noise(s, s, 4, 60, rng, 12))
            for _ in range(12):
                c.ellipse(rng.randrange(s), rng.randrange(s), 3, 3, (110, 84, 66))
        elif name == "beam":
            c.rect(0, 0, s, s, (222, 110, 40))
            c.add_field(smooth_noise(s, s, 20, 6, rng, 10))
            for k in range(4):
                c.rect(10 + k * 32, 44, 18, 34, (246, 244, 236))
                c.lines_of_print(12 + k * 32, 50, 14, 4, rng, INK, 6, 3)
            for _ in range(20):
                c.ellipse(rng.randrange(s), rng.randrange(s), 3, 2, (110, 60, 30))
        elif name == "upright":
            c.rect(0, 0, s, s, (46, 84, 140))
            for j in range(8):
                c.rect(28, j * 16 + 4, 18, 8, (20, 30, 46))
                c.rect(84, j * 16 + 4, 18, 8, (20, 30, 46))
            for _ in range(26):
                c.ellipse(rng.randrange(s), rng.randrange(s), 3, 3, rng.choice([(150, 150, 150), (120, 70, 40)]))
        elif name == "number":
            c.rect(0, 0, s, s, (246, 214, 60))
            c.text_centred(64, 36, "A1", INK, 8)
            c.frame(0, 0, s, s, 6, INK)
        elif name == "stripes":
            c.rect(0, 0, s, s, (240, 204, 40))
            for k in range(-2, 5):
                c.poly([(k * 40, s), (k * 40 + 20, s), (k * 40 + 84, 0), (k * 40 + 64, 0)], (30, 30, 32))
            for _ in range(26):
                c.ellipse(rng.randrange(s), rng.randrange(s), 4, 3, (130, 126, 120))
        elif name == "fork":
            c.rect(0, 0, s, s, (70, 72, 76))
            c.grain(rng, 10)
        elif name == "cab":
            c.rect(0, 0, s, s, (236, 186, 40))
            c.bevel(4, 4, 120, 120, 4, 0.4)
            c.text_centred(64, 14, "LIFT", INK, 4)
            for k in range(6):
                c.rect(16, 54 + k * 9, 96, 4, (120, 90, 20))
            c.ellipse(24, 114, 8, 8, (250, 250, 240))
            c.ellipse(104, 114, 8, 8, RED)
        elif name == "wheel":
            c.rect(0, 0, s, s, (30, 30, 32))
            c.ellipse(64, 64, 60, 60, (44, 44, 46))
            c.ellipse(64, 64, 34, 34, (190, 190, 186))
            for k in range(6):
                a = k * math.pi / 3
                c.ellipse(64 + 22 * math.cos(a), 64 + 22 * math.sin(a), 5, 5, (60, 60, 62))
        elif name.startswith("plate"):
            col = {"a": RED, "b": BLUE, "c": GREEN, "d": ORANGE}[name[-1]]
            c.rect(0, 0, s, s, (246, 246, 242))
            c.rect(0, 0, s, 42, col)
            c.text_centred(64, 12, {"a": "DANGER", "b": "HELMET", "c": "EXIT", "d": "FORKS"}[name[-1]], (255, 255, 255), 3)
            c.poly([(64, 50), (104, 116), (24, 116)], col if name[-1] in "ad" else mix(col, (255, 255, 255), 0.3))
            c.text_centred(66, 80, "!", (255, 255, 255), 4)
            c.frame(0, 0, s, s, 4, INK)
        elif name == "lamp":
            c.rect(0, 0, s, s, (255, 253, 244))
            c.frame(0, 0, s, s, 8, (190, 190, 186))
        elif name == "fence":
            c.rect(0, 0, s, s, (90, 96, 100))
            for k in range(8):
                c.rect(k * 16, 0, 3, s, (206, 190, 60))
                c.rect(0, k * 16, s, 3, (206, 190, 60))
        elif name == "lid":
            c.rect(0, 0, s, s, (40, 84, 138))
            c.ellipse(64, 64, 56, 56, (60, 110, 168))
            c.ellipse(92, 50, 10, 10, (30, 50, 80))
            c.ellipse(40, 80, 6, 6, (30, 50, 80))
            c.line(20, 64, 108, 70, (140, 90, 56), 3)
        else:
            c.rect(0, 0, s, s, (206, 214, 220))
            c.add_field(smooth_noise(s, s, 8, 8, rng, 24))

    sheet = grid(512, 4, 4, THINGS, draw)
    sheet.grain(rng, 2)
    return sheet


def roof(rng):
    """2.4 m of roof: trapezoid sheets and a purlin."""
    c = Canvas(256, 256, (150, 156, 160))
    for k in range(256):
        c.rect(k, 0, 1, 256, (0, 0, 0) if (k // 16) % 2 else (255, 255, 255), 0.16)
    for j in range(2):
        c.rect(0, j * 128, 256, 22, (120, 96, 84))
        for k in range(8):
            c.ellipse(16 + k * 32, j * 128 + 11, 4, 4, (60, 50, 46))
    for _ in range(60):
        c.ellipse(rng.randrange(256), rng.randrange(256), rng.uniform(2, 5), rng.uniform(2, 4), (110, 104, 96), 0.8)
    c.grain(rng, 3)
    return c


TEXTURES = {
    "concrete": concrete,
    "brick": lambda r: brick(r, (168, 92, 70)),
    "corrugated": corrugated,
    "gate": gate,
    "cartons": cartons,
    "timber": timber,
    "wrapped": wrapped,
    "barrel": barrel,
    "lane": lane,
    "things": things,
    "roof": roof,
}
