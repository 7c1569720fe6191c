# SPDX-License-Identifier: BSD-3-Clause
"""The pictures of the corridors of a public building: linoleum, painted walls, doors, boards, machines."""

import math

from canvas import Canvas, add, mix, shade, smooth_noise
from home_textures import around, grid
from textures import BLUE, COLOURS, GREEN, INK, ORANGE, RED, TEAL, WORDS, YELLOW, fabric, knots, paper, sticky, wood


def linoleum(rng):
    """2 m of marbled sheets, half a metre each, every other one a shade darker."""
    base = (158, 168, 156)
    c = Canvas(512, 512, base)
    for j in range(4):
        for i in range(4):
            c.rect(i * 128, j * 128, 128, 128, shade(base, (0.95 if (i + j) % 2 else 1.05) * rng.uniform(0.98, 1.02)))
    c.add_field(add(smooth_noise(512, 512, 14, 40, rng, 5), smooth_noise(512, 512, 60, 24, rng, 5)))
    for _ in range(2400):
        x, y, r = rng.randrange(512), rng.randrange(512), rng.uniform(0.8, 3.0)
        col = shade(base, rng.choice((0.76, 0.82, 0.88, 1.12, 1.18, 1.22)))
        around(c, x, y, 4, lambda px, py: c.ellipse(px, py, r, r * 0.8, col))
    for _ in range(20):   # marks of shoes and wheels
        x, y = rng.randrange(512), rng.randrange(512)
        c.line(x, y, x + rng.randint(-50, 50), y + rng.randint(-14, 14), shade(base, 0.6), 2, 0.5)
    for k in range(4):
        c.rect(k * 128, 0, 1, 512, shade(base, 0.68))
        c.rect(0, k * 128, 512, 1, shade(base, 0.68))
    c.grain(rng, 4)
    return c


def wall(rng, lower, upper):
    """2.6 m of wall, floor to ceiling: a dado of glazed bricks, a rail, rough paint with patches above."""
    c = Canvas(512, 512, upper)
    c.add_field(add(smooth_noise(512, 512, 9, 9, rng, 6), smooth_noise(512, 512, 90, 90, rng, 9),
                    smooth_noise(512, 512, 200, 200, rng, 9)))
    for _ in range(150):   # chips, nail holes, strips of tape, pencilled numbers
        x, y, kind = rng.randrange(512), rng.randint(2, 290), rng.random()
        if kind < 0.4:
            c.ellipse(x, y, rng.uniform(1.2, 3.5), rng.uniform(1.2, 3), shade(upper, rng.choice((0.55, 0.7, 1.2))), 0.9)
        elif kind < 0.6:
            c.rect(x, y, rng.randint(5, 16), rng.randint(3, 6), shade(upper, rng.choice((0.8, 1.15))))
        elif kind < 0.85:
            c.line(x, y, x + rng.randint(-22, 22), y + rng.randint(-12, 12), shade(upper, 0.7), 1, 0.8)
        else:
            c.text(x, y, rng.choice(WORDS)[:3] if kind > 0.95 else str(rng.randint(1, 99)), shade(upper, 0.6), 1)
    top = 300
    rows, brick = 14, 512 / 16
    pitch = (512 - top) / rows
    for j in range(rows):
        for i in range(17):
            x = (i - (0.5 if j % 2 else 0)) * brick
            tone = shade(lower, rng.uniform(0.80, 1.16))
            y = top + j * pitch
            c.rect(x, y, brick, pitch, tone)
            c.rect(x + 1, y + 1, brick - 2, 2, (255, 255, 255), 0.35)
            if rng.random() < 0.35:
                c.ellipse(x + rng.uniform(5, brick - 5), y + rng.uniform(4, pitch - 4), rng.uniform(1.5, 4), rng.uniform(1.5, 3),
                          shade(lower, rng.choice((0.45, 1.4))))
            c.rect(x, y, 1.4, pitch, shade(lower, 0.5))
        c.rect(0, top + j * pitch, 512, 1.4, shade(lower, 0.5))
    c.rect(0, top - 12, 512, 14, (146, 108, 72))
    c.rect(0, top - 12, 512, 2, (196, 160, 120))
    c.rect(0, top + 1, 512, 2, (60, 46, 36))
    for k in range(8):
        c.ellipse(32 + k * 64, top - 5, 3, 3, (70, 54, 40))
    c.grain(rng, 3)
    return c


def door(rng, base, number):
    """A door leaf of 0.95 m by 2.1 m with a pane, a plate and what people stick to it."""
    c = Canvas(512, 512, base)
    knots(c, rng, 6, shade(base, 0.6))
    wood(c, rng, 14, horizontal=False)
    c.frame(0, 0, 512, 512, 7, shade(base, 0.55))
    c.rect(330, 40, 110, 190, (150, 176, 184))
    for k in range(9):
        c.line(330, 40 + k * 24, 440, 64 + k * 24, (206, 220, 224), 2, 0.6)
        c.line(440, 40 + k * 24, 330, 64 + k * 24, (90, 110, 116), 1, 0.6)
    c.frame(330, 40, 110, 190, 6, (84, 86, 90))
    c.rect(70, 70, 200, 52, (240, 240, 234))
    c.frame(70, 70, 200, 52, 3, INK)
    c.text_centred(170, 84, number, INK, 4)
    for _ in range(3):
        paper(c, rng, rng.randint(60, 200), rng.randint(136, 240), 80, 74)
    for _ in range(4):
        sticky(c, rng, rng.randint(50, 280), rng.randint(210, 330), 30)
    c.rect(448, 236, 40, 74, (160, 162, 166))
    c.rect(400, 262, 80, 12, (214, 216, 220))
    c.rect(400, 273, 80, 4, (60, 60, 60))
    c.ellipse(468, 296, 5, 5, (30, 30, 30))
    for k in range(4):
        c.frame(60 + k * 100, 350, 84, 84, 3, shade(base, 0.7))
        c.bevel(63 + k * 100, 353, 78, 78, 3, 0.35)
    c.rect(14, 452, 484, 50, (176, 178, 180))
    for _ in range(90):
        x, y = rng.randint(16, 480), rng.randint(454, 500)
        c.line(x, y, x + rng.randint(4, 26), y + rng.randint(-4, 4), (104, 106, 108), 1)
    c.grain(rng, 2)
    return c


def board(rng, base, title):
    """A notice board, 1.6 m by 1.1 m, full."""
    c = Canvas(512, 512, base)
    c.add_field(smooth_noise(512, 512, 170, 170, rng, 18))
    c.rect(0, 0, 512, 56, INK)
    c.text_centred(256, 16, title, (250, 250, 246), 4)
    for k in range(24):
        x, y = 20 + (k % 6) * 80 + rng.randint(-8, 8), 68 + (k // 6) * 108 + rng.randint(-6, 8)
        paper(c, rng, x, y, rng.choice((54, 64, 70)), rng.choice((76, 86, 96)))
        c.ellipse(x + 28, y + 5, 4, 4, rng.choice(COLOURS))
    for _ in range(12):
        sticky(c, rng, rng.randint(16, 460), rng.randint(70, 460), 34)
    c.frame(0, 0, 512, 512, 11, (150, 152, 156))
    return c


def vending(rng):
    """The front of a machine for snacks, 0.9 m by 1.9 m."""
    c = Canvas(512, 512, (150, 40, 44))
    c.gradient(0, 0, 512, 70, (190, 60, 60), (120, 28, 34))
    c.text_centred(256, 20, "SNACKS", (255, 250, 230), 6)
    c.rect(24, 80, 330, 330, (40, 42, 50))
    for j in range(6):
        y = 132 + j * 54
        x = 32
        while x < 330:
            w = rng.randint(26, 38)
            col = rng.choice(COLOURS + [(240, 236, 226)])
            c.rect(x, y - 40, w - 5, 40, col)
            c.rect(x, y - 30, w - 5, 12, mix(col, (255, 255, 255), 0.7))
            c.ellipse(x + w / 2 - 2, y - 10, 5, 5, rng.choice(COLOURS))
            c.rect(x + 4, y + 3, 14, 7, (240, 240, 236))
            x += w
        c.rect(24, y, 330, 3, (170, 172, 178))
    c.rect(378, 90, 110, 70, (40, 60, 60))
    c.text(388, 110, "1.20", (150, 230, 160), 3)
    for j in range(4):
        for i in range(3):
            c.rect(384 + i * 34, 180 + j * 30, 27, 22, (206, 208, 212))
            c.text(392 + i * 34, 184 + j * 30, "123456789-0."[3 * j + i], INK, 2)
    c.rect(390, 320, 80, 16, (20, 20, 22))
    c.rect(400, 350, 60, 44, (190, 192, 196))
    c.rect(50, 428, 280, 56, (24, 24, 28))
    c.text_centred(190, 446, "PUSH", (200, 200, 200), 3)
    for k in range(9):
        c.rect(380, 424 + k * 8, 100, 3, (70, 20, 24))
    c.frame(0, 0, 512, 512, 8, (84, 22, 28))
    c.grain(rng, 2)
    return c


def lockers(rng):
    """Two rows of lockers, 1.6 m by 1.9 m."""
    c = Canvas(512, 512, (90, 122, 140))
    for j in range(2):
        for i in range(4):
            x, y = i * 128, j * 250
            col = shade(rng.choice([(96, 130, 150), (96, 130, 150), (150, 140, 110), (140, 96, 84)]), rng.uniform(0.92, 1.08))
            c.rect(x + 4, y + 4, 120, 242, col)
            c.bevel(x + 4, y + 4, 120, 242, 3, 0.4)
            for k in range(6):
                c.rect(x + 30, y + 18 + k * 8, 68, 3, shade(col, 0.4))
            c.rect(x + 34, y + 78, 60, 24, (240, 240, 236))
            c.text(x + 40, y + 83, str(rng.randint(100, 399)), INK, 2)
            c.rect(x + 98, y + 120, 14, 30, (60, 62, 66))
            c.ellipse(x + 105, y + 146, 8, 8, (206, 176, 90))
            for _ in range(rng.randint(0, 3)):
                kind = rng.random()
                if kind < 0.5:
                    c.ellipse(x + rng.randint(20, 100), y + rng.randint(160, 230), 12, 12, rng.choice(COLOURS))
                else:
                    sticky(c, rng, x + rng.randint(10, 80), y + rng.randint(160, 210), 26)
            for _ in range(8):
                px, py = x + rng.randint(8, 110), y + rng.randint(110, 240)
                c.line(px, py, px + rng.randint(-12, 12), py + rng.randint(-8, 8), shade(col, 0.6), 1)
    c.rect(0, 500, 512, 12, (40, 44, 50))
    c.grain(rng, 3)
    return c


THINGS = ["extinguisher", "bench", "sand", "glass", "plank", "hose", "frame", "copier"]


def things(rng):
    def draw(c, name):
        w, h = c.w, c.h
        if name == "extinguisher":
            c.rect(0, 0, w, h, (196, 40, 38))
            c.rect(0, 40, w, 100, (244, 240, 230))
            c.text_centred(64, 50, "FOAM", RED, 3)
            c.lines_of_print(10, 80, 106, 8, rng, INK, 7, 3)
            c.rect(0, 180, w, 10, (30, 30, 32))
        elif name == "bench":
            c.rect(0, 0, w, h, (176, 132, 86))
            wood(c, rng, 16)
            for k in range(6):
                c.rect(0, k * 43, w, 4, (60, 44, 30))
                for x in (14, 112):
                    c.ellipse(x, k * 43 + 22, 4, 4, (70, 70, 74))
        elif name == "sand":
            c.rect(0, 0, w, h, (206, 196, 166))
            c.grain(rng, 26)
        elif name == "glass":
            c.gradient(0, 0, w, h, (206, 222, 226), (150, 166, 170))
            for k in range(8):
                c.line(0, k * 40, w, k * 40 - 60, (236, 244, 246), 3, 0.6)
        elif name == "plank":
            c.rect(0, 0, w, h, (120, 90, 62))
            wood(c, rng, 20)
        elif name == "hose":
            c.rect(0, 0, w, h, (180, 34, 34))
            c.frame(0, 0, w, h, 6, (110, 16, 20))
            c.text_centred(64, 20, "FIRE", (255, 255, 255), 4)
            c.text_centred(64, 56, "HOSE", (255, 255, 255), 4)
            for r in (48, 40, 32, 24, 16, 8):
                c.ellipse(64, 160, r, r, (236, 226, 200) if r % 16 == 0 else (120, 26, 28))
        elif name == "frame":
            c.rect(0, 0, w, h, (120, 126, 130))
            c.add_field(smooth_noise(w, h, 40, 4, rng, 10))
            c.rect(8, 0, 5, h, (70, 74, 78))
            for k in range(9):
                c.ellipse(64, 14 + k * 28, 3, 3, (60, 62, 66))
        else:
            c.rect(0, 0, w, h, (212, 212, 206))
            for k in range(5):
                c.bevel(4, 90 + k * 32, 120, 28, 3, 0.4)
                c.rect(44, 102 + k * 32, 40, 6, (80, 82, 88))
            c.rect(8, 10, 60, 40, (70, 120, 130))
            for k in range(9):
                c.ellipse(80 + (k % 3) * 16, 18 + (k // 3) * 16, 5, 5, rng.choice(COLOURS))

    sheet = grid(512, 4, 2, THINGS, draw)
    sheet.grain(rng, 2)
    return sheet


TEXTURES = {
    "linoleum": linoleum,
    "wall_a": lambda r: wall(r, (112, 146, 138), (226, 222, 204)),
    "wall_b": lambda r: wall(r, (176, 134, 96), (214, 220, 222)),
    "door_a": lambda r: door(r, (176, 128, 84), "1.04"),
    "door_b": lambda r: door(r, (92, 122, 146), "LAB 7"),
    "door_c": lambda r: door(r, (150, 70, 62), "STORE"),
    "door_d": lambda r: door(r, (120, 140, 96), "1.19"),
    "board_a": lambda r: board(r, (184, 142, 98), "NOTICES"),
    "board_b": lambda r: board(r, (84, 110, 140), "RESULTS"),
    "board_c": lambda r: board(r, (110, 134, 98), "CLUBS AND TALKS"),
    "vending": vending,
    "lockers": lockers,
    "things": things,
}
