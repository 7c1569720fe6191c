# SPDX-License-Identifier: BSD-3-Clause
"""What people wear, and doors that move: a sheet of cells for each figure."""

from canvas import Canvas, add, mix, shade, smooth_noise
from home_textures import grid
from textures import COLOURS, INK, YELLOW, fabric

CELLS = ["shirt", "shirt_back", "trousers", "sleeve", "face", "hair", "skin", "shoe"]


def clothes(rng, shirt, trousers, hair, skin, pattern):
    """One figure's clothes and head."""
    def draw(c, name):
        w, h = c.w, c.h
        if name in ("shirt", "shirt_back", "sleeve"):
            c.rect(0, 0, w, h, shirt)
            fabric(c, rng, 7)
            if pattern == "check":
                for k in range(8):
                    c.rect(k * w / 8, 0, w / 18, h, shade(shirt, 0.55), 0.7)
                    c.rect(0, k * h / 8, w, h / 22, shade(shirt, 1.5), 0.7)
            elif pattern == "stripes":
                for k in range(9):
                    c.rect(0, k * h / 9, w, h / 22, (244, 240, 230))
            if name == "shirt":
                c.rect(w / 2 - 2, 0, 4, h, shade(shirt, 0.5))
                for k in range(6):
                    c.ellipse(w / 2, 16 + k * h / 6, 3, 3, (246, 240, 220))
                c.poly([(w * 0.36, 0), (w * 0.64, 0), (w / 2, 34)], skin)
                c.frame(w * 0.62, 50, w * 0.22, 40, 2, shade(shirt, 0.5))
                c.rect(w * 0.66, 44, w * 0.12, 20, (250, 250, 246))
            elif name == "shirt_back" and pattern == "plain":
                c.rect(w * 0.2, 10, w * 0.6, h * 0.6, (70, 92, 76))        # a rucksack
                c.frame(w * 0.2, 10, w * 0.6, h * 0.6, 4, (40, 54, 44))
                c.rect(w * 0.28, h * 0.34, w * 0.44, h * 0.2, (96, 120, 100))
                c.rect(w * 0.46, 20, w * 0.08, 50, (230, 180, 60))
            elif name == "shirt_back":
                c.text_centred(w / 2, 50, "07", (250, 246, 230), 8)
        elif name == "trousers":
            c.rect(0, 0, w, h, trousers)
            fabric(c, rng, 8)
            c.rect(w * 0.24, 0, 3, h, shade(trousers, 0.6))
            c.rect(w * 0.74, 0, 3, h, shade(trousers, 0.6))
            for k in range(9):
                y = 20 + k * h / 10
                c.line(0, y, w, y + rng.randint(-14, 14), shade(trousers, rng.choice((0.7, 1.3))), 2, 0.6)
            c.rect(0, 0, w, 12, (80, 56, 40))
        elif name == "face":     # wraps around the head, the face in the middle
            c.rect(0, 0, w, h, hair)
            c.grain(rng, 12)
            c.rect(w * 0.24, h * 0.3, w * 0.52, h * 0.7, skin)
            c.ellipse(w / 2, h * 0.34, w * 0.26, h * 0.16, skin)
            for x in (0.38, 0.62):
                c.ellipse(w * x, h * 0.5, 7, 6, (250, 250, 248))
                c.ellipse(w * x, h * 0.5, 3.4, 5, (60, 70, 90))
                c.rect(w * x - 9, h * 0.43, 18, 4, shade(hair, 0.8))
            c.poly([(w * 0.5, h * 0.5), (w * 0.56, h * 0.68), (w * 0.46, h * 0.68)], shade(skin, 0.85))
            c.rect(w * 0.41, h * 0.80, w * 0.18, 6, (170, 84, 80))
            c.ellipse(w * 0.24, h * 0.62, 6, 14, shade(skin, 0.9))
            c.ellipse(w * 0.76, h * 0.62, 6, 14, shade(skin, 0.9))
        elif name == "hair":
            c.rect(0, 0, w, h, hair)
            c.add_field(smooth_noise(w, h, 30, 4, rng, 22))
        elif name == "skin":
            c.rect(0, 0, w, h, skin)
            c.grain(rng, 4)
        else:
            c.rect(0, 0, w, h, (60, 48, 44))
            c.rect(0, h * 0.8, w, h * 0.2, (226, 222, 214))
            for k in range(5):
                c.line(w * 0.3, h * 0.1 + k * 20, w * 0.7, h * 0.15 + k * 20, (236, 230, 220), 3)
            c.grain(rng, 8)

    sheet = grid(512, 4, 2, CELLS, draw)
    sheet.grain(rng, 2)
    return sheet


TEXTURES = {
    "clothes_a": lambda r: clothes(r, (176, 70, 62), (62, 76, 110), (70, 46, 32), (226, 182, 150), "check"),
    "clothes_b": lambda r: clothes(r, (70, 120, 130), (120, 108, 90), (196, 160, 100), (236, 200, 172), "stripes"),
    "clothes_c": lambda r: clothes(r, (226, 176, 70), (70, 74, 70), (34, 30, 30), (150, 106, 78), "plain"),
}
