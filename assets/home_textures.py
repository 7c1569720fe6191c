# SPDX-License-Identifier: BSD-3-Clause
"""The pictures of the home: parquet, wallpaper, tiles, quilts, kitchen fronts, paintings."""

import math

from canvas import Canvas, add, mix, shade, smooth_noise
from textures import BLUE, COLOURS, GREEN, INK, ORANGE, RED, TEAL, YELLOW, clock_face, fabric, knots, paper, wood

OAK, WALNUT, WHITE = (196, 156, 108), (128, 92, 64), (232, 230, 222)


def grid(size, columns, rows, names, draw):
    """A sheet of small pictures; draw(canvas, name) paints one."""
    w, h = size // columns, size // rows
    sheet = Canvas(size, size)
    for k, name in enumerate(names):
        c = Canvas(w, h, WHITE)
        draw(c, name)
        sheet.paste(c, (k % columns) * w, (k // columns) * h)
    return sheet


def around(c, x, y, reach, paint):
    """Paints at (x, y) and again where it leaves the picture, so that the picture repeats without a seam."""
    for dx in (-c.w, 0, c.w):
        for dy in (-c.h, 0, c.h):
            if -reach < x + dx < c.w + reach and -reach < y + dy < c.h + reach:
                paint(x + dx, y + dy)


def leaf(c, x, y, length, angle, colour):
    """A leaf with its stalk at (x, y)."""
    ux, uy = math.cos(angle), math.sin(angle)
    vx, vy = -uy, ux
    w = length * 0.27
    c.poly([(x, y), (x + ux * length * 0.35 + vx * w, y + uy * length * 0.35 + vy * w),
            (x + ux * length * 0.7 + vx * w * 0.7, y + uy * length * 0.7 + vy * w * 0.7),
            (x + ux * length, y + uy * length),
            (x + ux * length * 0.7 - vx * w * 0.7, y + uy * length * 0.7 - vy * w * 0.7),
            (x + ux * length * 0.35 - vx * w, y + uy * length * 0.35 - vy * w)], colour)
    c.line(x, y, x + ux * length * 0.9, y + uy * length * 0.9, shade(colour, 0.7), 1)


def blossom(c, x, y, r, colour, rng):
    turn = rng.uniform(0, 2)
    for k in range(5):
        a = turn + 2 * math.pi * k / 5
        c.ellipse(x + r * 0.6 * math.cos(a), y + r * 0.6 * math.sin(a), r * 0.48, r * 0.48, colour)
    c.ellipse(x, y, r * 0.34, r * 0.34, YELLOW)


# --- surfaces of rooms

# Floors keep to one colour in lighter and darker shades, as floors do: a robot that knows them by colour can tell them.

def parquet(rng, base=OAK):
    """1.6 m of boards, 10 cm wide."""
    c = Canvas(512, 512, base)
    for row in range(16):
        x = rng.randint(0, 200)
        end = x + 512
        while x < end:
            w = min(rng.randint(90, 230), end - x)
            if end - x - w < 60:
                w = end - x
            tone = shade(base, rng.uniform(0.91, 1.08))
            for dx in (0, -512):
                c.rect(x + dx, row * 32, w, 32, tone)
                c.rect(x + dx, row * 32, 1, 32, shade(base, 0.6))
                for px in (6, w - 8):
                    for py in (7, 24):
                        c.ellipse(x + dx + px, row * 32 + py, 1.6, 1.6, shade(base, 0.65))
            for _ in range(rng.randint(1, 3)):
                kx, ky = x + rng.randint(12, max(13, w - 12)), row * 32 + rng.randint(8, 24)
                for dx in (0, -512):
                    c.ellipse(kx + dx, ky, rng.uniform(3, 6), rng.uniform(2, 3), shade(base, 0.75), 0.8)
            x += w
        c.rect(0, row * 32, 512, 1, shade(base, 0.62))
    c.add_field(add(smooth_noise(512, 512, 6, 150, rng, 8), smooth_noise(512, 512, 20, 256, rng, 7)), (1.0, 0.8, 0.55))
    c.grain(rng, 3)
    return c


def floor_tiles(rng):
    """1.2 m of clay tiles of 20 cm."""
    base = (196, 150, 122)
    c = Canvas(512, 512, base)
    t = 512 / 6
    for j in range(6):
        for i in range(6):
            x, y = i * t, j * t
            c.rect(x, y, t, t, shade(base, rng.uniform(0.93, 1.07)))
            c.rect(x + 5, y + 5, t - 8, 2, shade(base, 1.12))
            for _ in range(rng.randint(6, 14)):
                r = rng.uniform(1, 3.4)
                c.ellipse(x + rng.uniform(8, t - 8), y + rng.uniform(8, t - 8), r, r * 0.8, shade(base, rng.uniform(0.8, 1.16)), 0.8)
            c.rect(x, y, t, 3, (170, 150, 132))
            c.rect(x, y, 3, t, (170, 150, 132))
    c.add_field(add(smooth_noise(512, 512, 8, 8, rng, 5), smooth_noise(512, 512, 128, 128, rng, 5)), (1.0, 0.77, 0.62))
    c.grain(rng, 3)
    return c


def wallpaper_leaves(rng):
    """1.3 m of twigs with leaves and berries."""
    base = (228, 224, 206)
    c = Canvas(512, 512, base)
    c.add_field(smooth_noise(512, 512, 60, 60, rng, 5))
    greens = [(94, 128, 92), (128, 156, 112), (70, 104, 96), (152, 168, 108)]
    for j in range(7):
        for i in range(6):
            x = (i + (0.5 if j % 2 else 0)) * 512 / 6 + rng.uniform(-8, 8)
            y = j * 512 / 7 + rng.uniform(-8, 8)
            lean, col = rng.uniform(-0.7, 0.7) - math.pi / 2, rng.choice(greens)
            lengths = [rng.uniform(18, 30) for _ in range(6)]
            berries = rng.random() < 0.6

            def twig(px, py):
                ux, uy = math.cos(lean), math.sin(lean)
                c.line(px, py, px + ux * 62, py + uy * 62, shade(col, 0.6), 2)
                for k, length in enumerate(lengths):
                    s = 8 + 9 * k
                    leaf(c, px + ux * s, py + uy * s, length, lean + (0.9 if k % 2 else -0.9), shade(col, 0.9 + 0.05 * k))
                if berries:
                    for k in range(3):
                        c.ellipse(px + ux * 60 + 7 * (k - 1), py + uy * 60 - 3 * (k % 2), 4, 4, (184, 76, 62))
            around(c, x, y, 80, twig)
    c.grain(rng, 2)
    return c


def wallpaper_stripes(rng):
    """1.3 m of stripes with blossoms in a seeded disorder."""
    c = Canvas(512, 512, (222, 214, 220))
    for k in range(8):
        c.rect(k * 64, 0, 30, 512, (196, 200, 216))
        c.rect(k * 64 + 30, 0, 2, 512, (140, 150, 180))
        c.rect(k * 64 - 2, 0, 2, 512, (140, 150, 180))
    colours = [(176, 96, 116), (112, 120, 172), (204, 148, 96), (150, 104, 150)]
    for j in range(11):
        for k in range(8):
            x = k * 64 + (15 if j % 2 else 47) + rng.uniform(-5, 5)
            y = j * 512 / 11 + rng.uniform(-8, 8)
            r, col, angle = rng.uniform(8, 13), rng.choice(colours), rng.uniform(0, 6.28)

            def bloom(px, py):
                leaf(c, px, py, r * 1.9, angle, (110, 138, 102))
                leaf(c, px, py, r * 1.7, angle + 2.4, (132, 156, 116))
                blossom(c, px, py, r, col, rng)
            around(c, x, y, 30, bloom)
    c.grain(rng, 2)
    return c


def wallpaper_retro(rng):
    """1.3 m of rings and rounded squares."""
    c = Canvas(512, 512, (222, 210, 178))
    colours = [(206, 132, 70), (176, 92, 64), (122, 138, 110), (88, 122, 132), (230, 190, 110)]
    n = 7
    for j in range(n):
        for i in range(n):
            x, y, s = i * 512 / n, j * 512 / n, 512 / n
            a, b, d = rng.sample(colours, 3)
            c.rect(x + 3, y + 3, s - 6, s - 6, a)
            if rng.random() < 0.6:
                c.ellipse(x + s / 2, y + s / 2, s * 0.40, s * 0.40, b)
                c.ellipse(x + s / 2, y + s / 2, s * 0.26, s * 0.26, (232, 222, 194))
                c.ellipse(x + s / 2 + rng.uniform(-4, 4), y + s / 2 + rng.uniform(-4, 4), s * 0.13, s * 0.13, d)
            else:
                c.poly([(x + 6, y + s - 6), (x + s / 2, y + 8), (x + s - 6, y + s - 6)], b)
                c.ellipse(x + s / 2, y + s * 0.62, s * 0.15, s * 0.15, d)
    c.add_field(add(smooth_noise(512, 512, 8, 8, rng, 4), smooth_noise(512, 512, 150, 150, rng, 5)))
    c.grain(rng, 2)
    return c


def wall_tiles(rng):
    """1.2 m of glazed tiles of 15 cm, some of them painted."""
    c = Canvas(512, 512, (220, 224, 224))
    t = 64
    for j in range(8):
        for i in range(8):
            x, y = i * t, j * t
            tone = shade((222, 226, 224), rng.uniform(0.92, 1.06))
            c.rect(x, y, t, t, tone)
            c.bevel(x + 2, y + 2, t - 4, t - 4, 2, 0.3)
            kind = rng.random()
            if kind < 0.22:
                blossom(c, x + 32, y + 34, rng.uniform(13, 20), rng.choice([(70, 104, 168), (60, 130, 140)]), rng)
            elif kind < 0.40:
                col = rng.choice([(70, 104, 168), (92, 140, 150), (186, 130, 90)])
                for k in range(4):
                    leaf(c, x + 32, y + 32, 24, k * math.pi / 2 + 0.78, col)
            elif kind < 0.50:
                col = rng.choice([(120, 160, 170), (150, 170, 140), (196, 160, 130)])
                c.rect(x + 4, y + 4, t - 8, t - 8, col)
                c.bevel(x + 4, y + 4, t - 8, t - 8, 2, 0.3)
            for _ in range(rng.randint(1, 3)):
                c.line(x + rng.randint(8, 50), y + rng.randint(8, 50), x + rng.randint(8, 56), y + rng.randint(8, 56),
                       (170, 176, 178), 1, 0.8)
            c.rect(x, y, t, 2, (150, 152, 150))
            c.rect(x, y, 2, t, (150, 152, 150))
    c.grain(rng, 2)
    return c


def ceiling_boards(rng):
    """1.2 m of painted boards."""
    c = Canvas(256, 256, (226, 224, 216))
    wood(c, rng, 6)
    for k in range(8):
        c.rect(0, k * 32, 256, 2, (150, 148, 142))
        c.rect(0, k * 32 + 2, 256, 1, (246, 246, 242))
        for _ in range(4):
            x = rng.randrange(256)
            c.ellipse(x, k * 32 + rng.randint(8, 26), rng.uniform(2, 5), rng.uniform(1.5, 3), (176, 164, 146), 0.8)
        c.rect(rng.randrange(256), k * 32, 1, 32, (150, 148, 142))
    return c


# --- furniture

def sofa(rng):
    c = Canvas(256, 256, (112, 134, 150))
    fabric(c, rng, 12)
    for k in range(9):
        for j in range(9):
            x, y = k * 28.4 + (14 if j % 2 else 0), j * 28.4
            c.ellipse(x, y, 4, 4, (206, 186, 140))
            c.ellipse(x, y, 2, 2, (70, 86, 104))
            c.line(x, y, x + 14, y + 28, (86, 106, 124), 1, 0.8)
            c.line(x, y, x - 14, y + 28, (86, 106, 124), 1, 0.8)
    c.frame(0, 0, 256, 256, 4, (82, 100, 118))
    c.grain(rng, 4)
    return c


def quilt(rng):
    """A patchwork cover, 2 m by 2 m."""
    c = Canvas(512, 512, (236, 230, 218))
    palette = [(176, 84, 82), (92, 116, 160), (206, 168, 96), (118, 146, 110), (228, 214, 190), (140, 104, 136)]
    for j in range(10):
        for i in range(10):
            x, y, s = i * 51.2, j * 51.2, 51.2
            a, b = rng.sample(palette, 2)
            c.rect(x, y, s, s, a)
            kind = rng.randrange(5)
            if kind == 0:
                c.poly([(x, y), (x + s, y), (x, y + s)], b)
            elif kind == 1:
                for dx in range(0, 52, 13):
                    for dy in range(0, 52, 13):
                        c.ellipse(x + dx + 5, y + dy + 5, 3, 3, b)
            elif kind == 2:
                for dx in range(0, 52, 12):
                    c.rect(x + dx, y, 5, s, b)
            elif kind == 3:
                blossom(c, x + s / 2, y + s / 2, 16, b, rng)
            else:
                c.rect(x + 12, y + 12, s - 24, s - 24, b)
            c.frame(x + 2, y + 2, s - 4, s - 4, 1, (250, 246, 236), 0.8)
            c.rect(x, y, s, 1, shade(a, 0.5))
            c.rect(x, y, 1, s, shade(a, 0.5))
    c.add_field(smooth_noise(512, 512, 20, 20, rng, 10))
    c.grain(rng, 3)
    return c


def cloth(rng):
    """A checked tablecloth with a border, 0.8 m."""
    c = Canvas(256, 256, (236, 232, 222))
    for k in range(8):
        c.rect(k * 32, 0, 16, 256, (178, 74, 70), 0.55)
    for k in range(8):
        c.rect(0, k * 32, 256, 16, (178, 74, 70), 0.55)
    for j in range(8):
        for i in range(8):
            if rng.random() < 0.45:
                blossom(c, i * 32 + 24, j * 32 + 24, 6, rng.choice([BLUE, (110, 138, 102), ORANGE]), rng)
    c.add_field(add(smooth_noise(256, 256, 10, 3, rng, 14), smooth_noise(256, 256, 80, 80, rng, 6)))
    c.grain(rng, 3)
    return c


def wardrobe(rng):
    """The front of a wardrobe of 1.6 m by 2.1 m: three doors, the middle one with a mirror that shows a blurred room."""
    c = Canvas(512, 512, WALNUT)
    knots(c, rng, 14, shade(WALNUT, 0.5))
    wood(c, rng, 22, horizontal=False)
    for k in range(3):
        x = 6 + k * 168
        c.frame(x, 10, 164, 470, 4, shade(WALNUT, 0.5))
        if k == 1:
            c.gradient(x + 20, 34, 124, 420, (206, 216, 220), (150, 140, 126))
            for _ in range(36):
                c.rect(x + rng.randint(22, 118), rng.randint(60, 420), rng.randint(8, 26), rng.randint(8, 40),
                       rng.choice(COLOURS + [WALNUT, OAK]), 0.5)
            c.frame(x + 20, 34, 124, 420, 5, (196, 170, 112))
        else:
            for y, h in ((34, 150), (204, 250)):
                c.frame(x + 20, y, 124, h, 4, shade(WALNUT, 0.6))
                c.bevel(x + 24, y + 4, 116, h - 8, 4, 0.35)
                cx, cy = x + 82, y + h / 2
                for a in range(8):
                    leaf(c, cx, cy, min(44, h * 0.28), a * math.pi / 4, shade(WALNUT, 1.35 if a % 2 else 0.7))
                c.ellipse(cx, cy, 8, 8, (196, 170, 112))
    for x in (158, 352):
        c.ellipse(x, 260, 7, 12, (206, 180, 116))
        c.ellipse(x, 260, 3, 6, (120, 96, 50))
    c.rect(0, 486, 512, 26, shade(WALNUT, 0.45))
    c.grain(rng, 2)
    return c


KITCHEN = ["cupboard", "drawers", "oven", "washer", "fridge", "sink", "glass", "jars"]


def kitchen(rng):
    """Fronts of kitchen units, eight of 0.6 m by 0.86 m."""
    base = (150, 176, 160)

    def draw(c, name):
        w, h = c.w, c.h
        c.rect(0, 0, w, h, base)
        wood(c, rng, 7, horizontal=False)
        dark = shade(base, 0.55)

        def panel(x, y, pw, ph):
            c.frame(x, y, pw, ph, 3, dark)
            c.bevel(x + 3, y + 3, pw - 6, ph - 6, 2, 0.3)
            if ph > 40:
                c.frame(x + 14, y + 14, pw - 28, ph - 28, 2, shade(base, 0.75))
                c.bevel(x + 16, y + 16, pw - 32, ph - 32, 2, 0.3)

        if name in ("cupboard", "sink"):
            panel(4, 4, w - 8, 40)
            panel(4, 48, w - 8, h - 76)
            c.rect(w - 30, 60, 8, 44, (96, 98, 100))
            c.rect(w - 28, 62, 3, 40, (214, 214, 210))
            if name == "sink":
                c.rect(20, 56, 60, 96, (206, 120, 96))           # a towel
                for k in range(7):
                    c.rect(20, 62 + k * 13, 60, 5, (240, 232, 220))
                c.rect(16, 52, 70, 4, (120, 122, 124))
        elif name == "drawers":
            for k in range(4):
                panel(4, 4 + k * 57, w - 8, 54)
                c.rect(40, 26 + k * 57, 48, 7, (96, 98, 100))
                c.rect(42, 26 + k * 57, 44, 2, (220, 220, 216))
        elif name == "oven":
            c.rect(0, 0, w, h, (96, 98, 104))
            c.rect(0, 0, w, 44, (180, 182, 184))
            for k in range(5):
                c.ellipse(16 + k * 24, 22, 8, 8, (50, 52, 58))
                c.line(16 + k * 24, 22, 16 + k * 24 + rng.randint(-5, 5), 15, (240, 240, 240), 2)
            c.rect(8, 54, w - 16, 8, (200, 202, 204))
            c.rect(12, 72, w - 24, 116, (28, 26, 28))
            for k in range(4):
                c.rect(18, 90 + k * 24, w - 36, 2, (140, 130, 110))
            c.ellipse(64, 128, 34, 12, (196, 130, 70))
            c.ellipse(64, 124, 26, 8, (226, 170, 100))
            c.rect(8, 200, w - 16, 40, (120, 122, 126))
            c.text_centred(64, 214, "HEAT", (230, 230, 230), 2)
        elif name == "washer":
            c.rect(0, 0, w, h, (232, 232, 230))
            c.rect(0, 0, w, 40, (212, 214, 216))
            c.rect(6, 8, 40, 24, (190, 192, 196))
            c.ellipse(74, 20, 11, 11, (90, 92, 98))
            for k in range(3):
                c.rect(94 + k * 11, 14, 7, 10, rng.choice(COLOURS))
            c.ellipse(64, 124, 50, 56, (150, 152, 156))
            c.ellipse(64, 124, 42, 48, (60, 66, 76))
            for _ in range(22):
                c.ellipse(64 + rng.uniform(-24, 24), 134 + rng.uniform(-26, 26), rng.uniform(4, 11), rng.uniform(4, 9),
                          rng.choice(COLOURS + [(240, 240, 240)]), 0.9)
            c.rect(6, 206, w - 12, 34, (206, 208, 208))
            c.lines_of_print(14, 212, 70, 4, rng, INK, 6, 2)
        elif name == "fridge":
            c.gradient(0, 0, w, h, (220, 222, 224), (196, 198, 200))
            c.rect(0, 92, w, 3, (90, 92, 96))
            for y in (48, 112):
                c.rect(10, y, 7, 36, (110, 112, 116))
            for _ in range(4):
                paper(c, rng, rng.randint(24, 84), rng.choice((8, 46, 104, 150)), 32, 40)
            for _ in range(14):
                c.ellipse(rng.randint(24, 120), rng.randint(6, 210), 5, 5, rng.choice(COLOURS))
        elif name == "glass":
            for k in range(2):
                c.rect(8 + 58 * k, 8, 54, h - 36, (84, 80, 72))
                for j in range(4):
                    y = 60 + j * 52
                    c.rect(8 + 58 * k, y, 54, 4, (206, 196, 170))
                    x = 12 + 58 * k
                    while x < 56 + 58 * k:
                        g = rng.randint(8, 13)
                        hh = rng.randint(14, 34)
                        c.rect(x, y - hh, g - 2, hh, rng.choice(COLOURS + [(240, 240, 236), (200, 214, 220)]))
                        c.rect(x, y - hh, g - 2, 3, (250, 250, 250))
                        x += g
                c.frame(8 + 58 * k, 8, 54, h - 36, 3, dark)
        else:
            c.rect(8, 8, w - 16, h - 36, (104, 84, 62))
            for j in range(5):
                y = 50 + j * 44
                x = 12
                while x < w - 20:
                    g = rng.randint(14, 24)
                    hh = rng.randint(20, 36)
                    col = rng.choice(COLOURS + [(226, 200, 150), (236, 230, 220)])
                    c.rect(x, y - hh, g - 3, hh, col)
                    c.rect(x, y - hh, g - 3, 5, shade(col, 0.6))
                    c.rect(x + 2, y - hh + 10, g - 7, 9, (246, 244, 236))
                    x += g
                c.rect(8, y, w - 16, 5, (190, 160, 116))
        if name not in ("fridge", "washer"):
            c.rect(0, h - 16, w, 16, (60, 58, 56))

    sheet = grid(512, 4, 2, KITCHEN, draw)
    sheet.grain(rng, 2)
    return sheet


TOPS = ["granite", "hob", "basin", "breakfast"]


def tops(rng):
    """Seen from above: granite, a hob, a sink, a laid table."""
    def granite(c):
        c.rect(0, 0, c.w, c.h, (150, 146, 142))
        for _ in range(1500):
            r = rng.uniform(0.8, 2.6)
            c.ellipse(rng.randrange(c.w), rng.randrange(c.h), r, r,
                      rng.choice([(96, 92, 92), (206, 202, 196), (120, 100, 90), (60, 60, 64)]))

    def draw(c, name):
        granite(c)
        if name == "hob":
            c.rect(20, 20, 216, 216, (34, 34, 38))
            c.frame(20, 20, 216, 216, 4, (190, 192, 196))
            for x, y, r in ((78, 78, 40), (178, 78, 30), (78, 178, 30), (178, 170, 44)):
                for k, t in enumerate((1.0, 0.7, 0.4)):
                    c.ellipse(x, y, r * t, r * t, ((130, 132, 136), (44, 44, 48), (120, 60, 50))[k])
        elif name == "basin":
            c.rect(16, 40, 224, 176, (196, 200, 202))
            c.rect(30, 56, 120, 144, (140, 146, 150))
            c.bevel(30, 56, 120, 144, 6, 0.4)
            c.ellipse(90, 128, 10, 10, (60, 62, 66))
            for k in range(7):
                c.rect(166, 60 + k * 20, 64, 6, (150, 156, 160))
            c.rect(84, 30, 12, 60, (226, 228, 230))
        elif name == "breakfast":
            c.rect(0, 0, c.w, c.h, (226, 214, 190))
            wood(c, rng, 12)
            for x, y in ((64, 64), (190, 64), (64, 190), (190, 190)):
                c.rect(x - 46, y - 36, 92, 72, rng.choice([(112, 134, 150), (176, 84, 82), (118, 146, 110)]))
                c.frame(x - 46, y - 36, 92, 72, 3, (240, 236, 226))
                c.ellipse(x, y, 27, 27, (246, 246, 242))
                c.ellipse(x, y, 19, 19, (226, 230, 232))
                c.ellipse(x + 3, y, 9, 7, rng.choice(COLOURS))
                c.rect(x + 32, y - 22, 4, 44, (150, 152, 156))
                c.rect(x - 38, y - 22, 4, 44, (150, 152, 156))
            c.ellipse(127, 127, 20, 20, (120, 160, 90))
            blossom(c, 127, 127, 16, RED, rng)

    sheet = grid(512, 2, 2, TOPS, draw)
    sheet.grain(rng, 2)
    return sheet


PAINTINGS = 16


def paintings(rng):
    """Sixteen framed pictures."""
    def draw(c, k):
        s = c.w
        kind = k % 8
        if kind == 0:       # mountains
            c.gradient(0, 0, s, s, (140, 180, 220), (240, 226, 200))
            for j in range(3):
                pts = [(0, s)]
                for i in range(9):
                    pts.append((i * s / 8, 40 + j * 22 + rng.randint(-18, 14)))
                c.poly(pts + [(s, s)], ((110, 120, 150), (84, 110, 110), (60, 92, 70))[j])
            c.ellipse(96, 26, 10, 10, (250, 240, 190))
        elif kind == 1:     # flowers in a vase
            c.rect(0, 0, s, s, rng.choice([(206, 196, 170), (150, 160, 170), (96, 84, 92)]))
            c.rect(0, 98, s, 30, (146, 108, 76))
            for _ in range(17):
                x, y = rng.randint(26, 102), rng.randint(16, 70)
                c.line(64, 84, x, y, (70, 110, 70), 2)
                blossom(c, x, y, rng.uniform(7, 12), rng.choice(COLOURS), rng)
            c.poly([(48, 78), (80, 78), (74, 112), (54, 112)], (70, 110, 150))
        elif kind == 2:     # the sea and boats
            c.gradient(0, 0, s, 64, (120, 170, 220), (226, 232, 236))
            c.gradient(0, 64, s, 64, (60, 120, 160), (40, 80, 120))
            for _ in range(6):
                x, y, h = rng.randint(10, 104), rng.randint(64, 104), rng.randint(14, 30)
                c.poly([(x, y), (x + h * 0.7, y), (x, y - h)], rng.choice([(250, 250, 246), RED, ORANGE]))
                c.poly([(x - 6, y + 1), (x + h * 0.8, y + 1), (x + h * 0.5, y + 7), (x, y + 7)], (96, 60, 40))
            for _ in range(30):
                x, y = rng.randint(6, 116), rng.randint(70, 122)
                c.line(x, y, x + 8, y, (170, 206, 226), 1)
        elif kind == 3:     # abstract
            c.rect(0, 0, s, s, (240, 236, 222))
            for _ in range(9):
                c.rect(rng.randint(0, 100), rng.randint(0, 100), rng.randint(14, 50), rng.randint(14, 50), rng.choice(COLOURS))
            for _ in range(5):
                y = rng.randint(10, 118)
                c.rect(0, y, s, 4, INK)
                c.rect(y, 0, 4, s, INK)
        elif kind == 4:     # portrait
            c.gradient(0, 0, s, s, (84, 92, 84), (52, 46, 44))
            c.poly([(24, 128), (40, 86), (88, 86), (106, 128)], rng.choice(COLOURS))
            c.ellipse(64, 58, 24, 31, (226, 184, 150))
            c.ellipse(64, 36, 27, 18, rng.choice([(70, 44, 30), (196, 160, 96), (40, 36, 36)]))
            for x in (55, 74):
                c.ellipse(x, 56, 3, 2, (40, 40, 50))
            c.rect(58, 74, 13, 3, (170, 80, 76))
        elif kind == 5:     # a wood
            c.rect(0, 0, s, s, (206, 214, 170))
            for _ in range(13):
                x = rng.randint(0, 124)
                c.rect(x, 0, rng.randint(4, 10), 110, rng.choice([(92, 74, 58), (220, 216, 206), (110, 96, 80)]))
            for _ in range(120):
                c.ellipse(rng.randrange(s), rng.choice((rng.randint(0, 60), rng.randint(104, 126))), 4, 3,
                          rng.choice([(90, 130, 60), (196, 140, 60), (60, 100, 60)]))
        elif kind == 6:     # family photographs
            c.rect(0, 0, s, s, (236, 232, 224))
            for j in range(2):
                for i in range(2):
                    x, y = 12 + i * 54, 12 + j * 54
                    c.gradient(x, y, 48, 48, (150, 180, 200), (120, 140, 90))
                    for m in range(rng.randint(1, 3)):
                        px = x + 10 + m * 13
                        c.rect(px - 5, y + 28, 11, 20, rng.choice(COLOURS))
                        c.ellipse(px, y + 22, 6, 7, (226, 184, 150))
        else:               # a map
            c.rect(0, 0, s, s, (176, 206, 220))
            for _ in range(9):
                c.ellipse(rng.randint(10, 116), rng.randint(10, 116), rng.randint(8, 26), rng.randint(8, 20),
                          rng.choice([(206, 190, 140), (170, 186, 130), (220, 206, 170)]))
            for i in range(1, 5):
                c.rect(i * 26, 0, 1, s, (96, 120, 140))
                c.rect(0, i * 26, s, 1, (96, 120, 140))
            c.polyline([(rng.randint(10, 116), rng.randint(10, 116)) for _ in range(5)], RED, 2)
        c.frame(0, 0, s, s, 8, ((92, 64, 42), (36, 36, 40), (196, 166, 100), (236, 234, 228))[k % 4])
        c.frame(7, 7, s - 14, s - 14, 2, (60, 50, 40), 0.7)

    sheet = grid(512, 4, 4, range(PAINTINGS), draw)
    sheet.grain(rng, 2)
    return sheet


def window(rng):
    """A window 1.4 m by 1.3 m with glazing bars, a garden behind it."""
    c = Canvas(512, 512, (244, 244, 240))
    c.gradient(0, 0, 512, 280, (184, 214, 242), (238, 242, 246))
    for _ in range(10):
        x, y = rng.randint(20, 480), rng.randint(30, 170)
        for k in range(5):
            c.ellipse(x + k * 15 - 30, y + rng.randint(-5, 5), rng.randint(12, 26), rng.randint(6, 12), (252, 252, 252), 0.7)
    for k in range(7):
        x = 30 + k * 74 + rng.randint(-16, 16)
        c.rect(x - 5, 200, 10, 130, (104, 82, 62))
        for _ in range(34):
            c.ellipse(x + rng.gauss(0, 26), 190 + rng.gauss(0, 34), rng.randint(5, 14), rng.randint(4, 11),
                      rng.choice([(76, 124, 62), (104, 150, 78), (58, 100, 56), (140, 170, 90)]))
    c.gradient(0, 320, 512, 192, (120, 160, 84), (88, 130, 66))
    for k in range(26):
        c.rect(k * 20, 296, 14, 50, (226, 220, 206))
        c.rect(k * 20, 296, 2, 50, (150, 146, 136))
    for _ in range(150):
        blossom(c, rng.randint(0, 512), rng.randint(352, 500), rng.uniform(4, 8), rng.choice(COLOURS), rng)
    c.rect(0, 0, 512, 512, (20, 26, 30), 0.30)   # it shines by itself
    for x in (0, 160, 330, 488):
        c.rect(x, 0, 24, 512, (240, 238, 230))
        c.rect(x + 22, 0, 3, 512, (160, 156, 148))
    for y in (0, 170, 488):
        c.rect(0, y, 512, 24, (240, 238, 230))
        c.rect(0, y + 22, 512, 3, (160, 156, 148))
    c.rect(172, 300, 10, 46, (150, 140, 110))
    c.grain(rng, 2)
    return c


def door(rng):
    """A panelled door, 0.9 m by 2.05 m."""
    base = (226, 220, 204)
    c = Canvas(512, 512, base)
    wood(c, rng, 8, horizontal=False)
    for x, y, w, h in ((60, 30, 170, 150), (282, 30, 170, 150), (60, 210, 170, 90), (282, 210, 170, 90),
                       (60, 330, 170, 150), (282, 330, 170, 150)):
        c.frame(x, y, w, h, 6, shade(base, 0.7))
        c.bevel(x + 6, y + 6, w - 12, h - 12, 6, 0.4)
        c.frame(x + 26, y + 18, w - 52, h - 36, 3, shade(base, 0.84))
    for _ in range(70):
        x, y = rng.randrange(512), rng.randint(300, 505)
        c.line(x, y, x + rng.randint(-24, 24), y + rng.randint(-5, 5), (140, 130, 116), 1, 0.7)
    c.rect(440, 236, 44, 66, (186, 160, 100))
    c.ellipse(462, 254, 22, 9, (226, 200, 130))
    c.ellipse(462, 288, 6, 5, (40, 36, 30))
    c.frame(0, 0, 512, 512, 6, shade(base, 0.6))
    c.grain(rng, 2)
    return c


def curtain(rng):
    c = Canvas(256, 256, (206, 172, 132))
    for i in range(8):
        for k in range(32):
            c.rect(i * 32 + k, 0, 1, 256, (255, 250, 236) if k < 14 else (90, 60, 40),
                   0.28 * abs(math.sin(math.pi * k / 16)))
    for j in range(10):
        for i in range(8):
            x, y = i * 32 + rng.uniform(6, 26), j * 25.6 + rng.uniform(4, 20)
            leaf(c, x, y, rng.uniform(9, 15), rng.uniform(0, 6.3), rng.choice([(150, 86, 60), (120, 130, 90), (224, 206, 170)]))
    c.grain(rng, 3)
    return c


def television(rng):
    """A football match, and the bar of loudspeakers below."""
    c = Canvas(256, 256, (24, 24, 28))
    c.rect(8, 8, 240, 190, (76, 138, 66))
    for k in range(6):
        c.rect(8 + k * 40, 8, 20, 190, (88, 150, 74))
    c.rect(8, 8, 240, 46, (110, 104, 110))
    for _ in range(420):
        c.rect(rng.randint(8, 244), rng.randint(8, 50), 3, 3, rng.choice(COLOURS + [(230, 220, 200)]))
    for k in range(8):
        c.rect(8 + k * 30, 54, 29, 12, rng.choice(COLOURS))
    c.line(8, 120, 248, 90, (240, 240, 240), 2)
    c.line(60, 198, 120, 66, (240, 240, 240), 2)
    for k in range(11):
        x, y = rng.randint(20, 236), rng.randint(80, 176)
        col = RED if k % 2 else (240, 240, 240)
        c.rect(x, y, 8, 12, col)
        c.ellipse(x + 4, y - 4, 4, 4, (214, 170, 140))
        c.rect(x, y + 12, 3, 9, INK)
        c.rect(x + 5, y + 12, 3, 9, INK)
    c.rect(14, 14, 70, 16, (20, 40, 90))
    c.text(18, 18, "2:1 74", (255, 255, 255), 1)
    c.frame(0, 0, 256, 206, 8, (28, 28, 32))
    c.rect(0, 206, 256, 50, (44, 46, 52))
    for x in (30, 90, 166, 226):
        c.ellipse(x, 231, 20, 19, (20, 20, 22))
        c.ellipse(x, 231, 9, 9, (100, 102, 108))
    c.grain(rng, 2)
    return c


def rug(rng, base):
    """A carpet of one wool in four shades, 1.8 m by 1.2 m."""
    light, dark = shade(base, 1.16), shade(base, 0.86)
    c = Canvas(512, 512, base)
    for k, col in enumerate((dark, light, dark, base)):
        c.rect(k * 16, k * 16, 512 - 32 * k, 512 - 32 * k, col)
    for k in range(24):
        for x, y in ((34 + k * 19, 24), (34 + k * 19, 488), (24, 34 + k * 19), (488, 34 + k * 19)):
            c.poly([(x, y - 7), (x + 7, y), (x, y + 7), (x - 7, y)], dark)
    for r, col in ((180, dark), (168, base), (100, light), (88, base)):
        c.poly([(256, 256 - r), (256 + r, 256), (256, 256 + r), (256 - r, 256)], col)
    for j in range(16):
        for i in range(16):
            x, y = 86 + i * 23, 86 + j * 23
            kind = (i * j + abs(i - 7) * 3) % 5
            if kind == 0:
                for a in range(4):
                    leaf(c, x, y, 11, a * math.pi / 2 + 0.4, light)
            elif kind == 2:
                leaf(c, x, y, 16, rng.uniform(0, 6.3), dark)
    weights = tuple(v / max(base) for v in base)
    c.add_field(add(smooth_noise(512, 512, 8, 8, rng, 6), smooth_noise(512, 512, 170, 170, rng, 9)), weights)
    c.grain(rng, 4)
    return c


THINGS = ["shade", "basket", "cushion_a", "cushion_b", "toilet", "tub", "mirror", "skirting", "shoes", "towel", "linen",
          "drawers", "lamp", "door_frame", "clock", "cat"]


def things(rng):
    """Small things of a household."""
    def draw(c, name):
        s = c.w
        if name == "shade":
            c.gradient(0, 0, s, s, (250, 232, 190), (236, 196, 130))
            for k in range(8):
                c.rect(k * 16, 0, 2, s, (190, 140, 90))
                leaf(c, k * 16 + 8, 84, 30, -math.pi / 2, (190, 120, 80))
        elif name == "basket":
            c.rect(0, 0, s, s, (170, 128, 80))
            for j in range(16):
                for i in range(8):
                    c.rect(i * 16 + (8 if j % 2 else 0), j * 8, 13, 6, shade((190, 148, 96), rng.uniform(0.8, 1.2)))
        elif name in ("cushion_a", "cushion_b"):
            base, other = ((206, 150, 80), (246, 230, 190)) if name == "cushion_a" else ((96, 120, 104), (226, 206, 150))
            c.rect(0, 0, s, s, base)
            for k in range(8):
                for j in range(8):
                    if (k + j) % 2:
                        c.poly([(k * 16 + 8, j * 16), (k * 16 + 16, j * 16 + 8), (k * 16 + 8, j * 16 + 16),
                                (k * 16, j * 16 + 8)], other)
            c.frame(0, 0, s, s, 6, shade(base, 0.6))
        elif name in ("toilet", "tub"):
            c.gradient(0, 0, s, s, (244, 244, 242), (206, 208, 208))
            for _ in range(10):
                x, y = rng.randrange(s), rng.randrange(s)
                c.line(x, y, x + rng.randint(-20, 20), y + rng.randint(-6, 6), (170, 172, 172), 1)
            c.rect(0, 12, s, 3, (160, 162, 164))
            if name == "tub":
                for k in range(4):
                    c.frame(6 + k * 30, 28, 26, 84, 2, (170, 172, 174))
            else:
                c.ellipse(64, 20, 10, 6, (150, 152, 156))
        elif name == "mirror":
            c.gradient(0, 0, s, s, (200, 214, 220), (150, 146, 140))
            for _ in range(26):
                c.rect(rng.randint(8, 100), rng.randint(8, 100), rng.randint(4, 18), rng.randint(6, 24), rng.choice(COLOURS), 0.6)
            c.line(16, 100, 96, 14, (250, 250, 250), 8, 0.5)
            c.frame(0, 0, s, s, 8, (176, 146, 84))
        elif name == "skirting":
            c.rect(0, 0, s, s, (226, 222, 210))
            c.add_field(smooth_noise(s, s, 4, 50, rng, 7))
            c.rect(0, 0, s, 14, (246, 244, 238))
            c.rect(0, 24, s, 4, (150, 144, 130))
            c.rect(0, 110, s, 18, (150, 144, 130))
            for _ in range(22):
                x = rng.randrange(s)
                c.line(x, rng.randint(34, 104), x + rng.randint(-9, 9), rng.randint(34, 104), (120, 112, 100), 1)
        elif name == "shoes":
            c.rect(0, 0, s, s, (96, 72, 52))
            for j in range(3):
                for i in range(3):
                    x, y = 8 + i * 40, 14 + j * 40
                    col = rng.choice(COLOURS + [INK, (150, 110, 80)])
                    for d in (0, 16):
                        c.ellipse(x + 8 + d, y + 14, 7, 13, col)
                        c.ellipse(x + 8 + d, y + 8, 4, 5, shade(col, 0.4))
                        c.rect(x + 5 + d, y + 16, 6, 2, (240, 240, 240))
                c.rect(0, j * 42 + 36, s, 5, (180, 146, 100))
        elif name == "towel":
            c.rect(0, 0, s, s, TEAL)
            c.add_field(smooth_noise(s, s, 10, 10, rng, 12))
            for k in range(5):
                c.rect(0, 10 + k * 25, s, 7, (236, 232, 220))
                for i in range(9):
                    c.ellipse(7 + i * 14, 26 + k * 25, 4, 4, (236, 190, 90))
        elif name == "linen":
            c.rect(0, 0, s, s, (238, 236, 230))
            c.add_field(add(smooth_noise(s, s, 6, 6, rng, 14), smooth_noise(s, s, 40, 40, rng, 6)))
            for _ in range(24):
                blossom(c, rng.randrange(s), rng.randrange(s), 6, rng.choice([(150, 170, 206), (206, 150, 160)]), rng)
        elif name == "drawers":
            c.rect(0, 0, s, s, OAK)
            wood(c, rng, 16)
            for k in range(3):
                c.frame(3, 3 + k * 42, s - 6, 39, 3, shade(OAK, 0.5))
                c.bevel(6, 6 + k * 42, s - 12, 33, 2, 0.3)
                for x in (36, 92):
                    c.ellipse(x, 23 + k * 42, 6, 6, (70, 60, 50))
                    c.ellipse(x - 1, 21 + k * 42, 2, 2, (230, 220, 200))
        elif name == "lamp":
            c.rect(0, 0, s, s, (255, 252, 240))
            c.frame(0, 0, s, s, 6, (226, 214, 180))
        elif name == "door_frame":
            c.rect(0, 0, s, s, (214, 206, 188))
            c.add_field(smooth_noise(s, s, 60, 4, rng, 8))
            c.rect(10, 0, 4, s, (150, 142, 124))
            c.rect(110, 0, 4, s, (150, 142, 124))
            for _ in range(12):
                c.ellipse(rng.randint(20, 104), rng.randrange(s), 3, 3, (150, 140, 120))
        elif name == "clock":
            clock_face(c, 56, (150, 96, 60), (60, 40, 26), (248, 244, 230), 9, (40, 52), (70, 24))
        else:
            c.rect(0, 0, s, s, (196, 140, 90))
            for k in range(7):
                c.poly([(0, 8 + k * 18), (s, 2 + k * 18), (s, 8 + k * 18), (0, 15 + k * 18)], (226, 190, 140))
            c.ellipse(64, 64, 30, 26, (150, 96, 60))
            for x in (52, 78):
                c.ellipse(x, 58, 5, 6, (120, 160, 70))
                c.ellipse(x, 58, 2, 5, INK)
            c.poly([(38, 52), (44, 26), (58, 42)], (150, 96, 60))
            c.poly([(90, 52), (84, 26), (70, 42)], (150, 96, 60))
            c.ellipse(64, 72, 4, 3, (226, 130, 130))

    sheet = grid(512, 4, 4, THINGS, draw)
    sheet.grain(rng, 2)
    return sheet


TEXTURES = {
    "parquet": parquet,
    "floor_tiles": floor_tiles,
    "wallpaper_leaves": wallpaper_leaves,
    "wallpaper_stripes": wallpaper_stripes,
    "wallpaper_retro": wallpaper_retro,
    "wall_tiles": wall_tiles,
    "ceiling": ceiling_boards,
    "sofa": sofa,
    "quilt": quilt,
    "cloth": cloth,
    "wardrobe": wardrobe,
    "kitchen": kitchen,
    "tops": tops,
    "paintings": paintings,
    "window": window,
    "door": door,
    "curtain": curtain,
    "television": television,
    "rug_a": lambda r: rug(r, (160, 84, 72)),
    "rug_b": lambda r: rug(r, (96, 128, 132)),
    "things": things,
}
