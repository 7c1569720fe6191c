# SPDX-License-Identifier: BSD-3-Clause
"""The pictures of the street: brick and plaster, windows, doors, shops, asphalt, paving, cars, leaves."""

import math

from canvas import Canvas, add, mix, shade, smooth_noise
from home_textures import around, blossom, grid, leaf
from textures import BLUE, COLOURS, GREEN, INK, ORANGE, PURPLE, RED, TEAL, WORDS, YELLOW, knots, poster, wood
from warehouse_textures import brick


def asphalt(rng):
    """2 m of road: stones of all shades, patches, a crack, oil."""
    base = (122, 123, 126)
    c = Canvas(512, 512, base)
    c.add_field(add(smooth_noise(512, 512, 4, 4, rng, 5), smooth_noise(512, 512, 20, 20, rng, 4)))
    for _ in range(4200):
        x, y, r = rng.randrange(512), rng.randrange(512), rng.uniform(0.8, 2.8)
        col = shade(base, rng.choice((0.74, 0.8, 0.86, 1.12, 1.2, 1.28)))
        around(c, x, y, 4, lambda px, py: c.ellipse(px, py, r, r * 0.8, col))
    for _ in range(5):
        x, y, points = rng.randrange(512), rng.randrange(512), []
        for _ in range(8):
            points.append((x, y))
            x, y = x + rng.randint(4, 30), y + rng.randint(-26, 26)
        around(c, 0, 0, 600, lambda px, py: c.polyline([(a + px, b + py) for a, b in points], shade(base, 0.6), 2))
    for _ in range(3):
        c.rect(rng.randint(20, 380), rng.randint(20, 380), rng.randint(50, 110), rng.randint(40, 90), shade(base, 0.85), 0.6)
    for _ in range(9):   # leaves, chewing gum, a ticket
        x, y = rng.randrange(500), rng.randrange(500)
        leaf(c, x, y, rng.uniform(9, 16), rng.uniform(0, 6.3), rng.choice([(176, 130, 60), (150, 90, 50), (140, 150, 70)]))
    c.grain(rng, 6)
    return c


def paving(rng):
    """2 m of slabs of half a metre in a bond of halves."""
    base = (174, 169, 160)
    c = Canvas(512, 512, base)
    for j in range(4):
        for i in range(4):
            x, y = (i * 128 + (64 if j % 2 else 0)), j * 128
            tone = shade(base, rng.uniform(0.92, 1.07))
            for dx in (0, -512):
                c.rect(x + dx, y, 128, 128, tone)
                c.rect(x + dx, y, 128, 3, shade(base, 0.62))
                c.rect(x + dx, y, 3, 128, shade(base, 0.62))
                c.rect(x + dx + 3, y + 3, 125, 2, shade(base, 1.2), 0.6)
    for _ in range(2600):
        x, y, r = rng.randrange(512), rng.randrange(512), rng.uniform(0.8, 2.8)
        col = shade(base, rng.choice((0.78, 0.84, 0.9, 1.1, 1.18)))
        around(c, x, y, 4, lambda px, py: c.ellipse(px, py, r, r, col))
    for _ in range(26):
        x, y = rng.randrange(512), rng.randrange(512)
        c.ellipse(x, y, rng.uniform(3, 7), rng.uniform(3, 6), shade(base, 0.78), 0.8)
    for j in range(5):   # moss in the joints
        for _ in range(20):
            c.ellipse(rng.randrange(512), j * 128 + rng.randint(-1, 4), 3, 2, (112, 120, 84), 0.7)
    c.add_field(smooth_noise(512, 512, 6, 6, rng, 5))
    c.grain(rng, 5)
    return c


def kerb(rng):
    """Kerb stones, flush with the road, of the paving's stone: 2 m long."""
    base = (178, 173, 164)
    c = Canvas(256, 256, base)
    for _ in range(1100):
        r = rng.uniform(0.8, 2.4)
        c.ellipse(rng.randrange(256), rng.randrange(256), r, r, shade(base, rng.choice((0.78, 0.86, 1.12, 1.2))))
    for k in range(2):
        c.rect(k * 128, 0, 3, 256, shade(base, 0.62))
    c.rect(0, 0, 256, 7, shade(base, 0.62))
    c.rect(0, 249, 256, 7, shade(base, 0.62))
    c.grain(rng, 5)
    return c


def paint(rng):
    """Paint on the road, worn through to the stones."""
    c = Canvas(256, 256, (226, 226, 220))
    c.add_field(smooth_noise(256, 256, 10, 10, rng, 10))
    for _ in range(640):
        c.ellipse(rng.randrange(256), rng.randrange(256), rng.uniform(1, 4), rng.uniform(1, 4), rng.choice([(110, 112, 116), (150, 150, 150)]), 0.9)
    for _ in range(16):
        x, y = rng.randrange(256), rng.randrange(256)
        c.line(x, y, x + rng.randint(-50, 50), y + rng.randint(-50, 50), (90, 92, 96), 2)
    c.grain(rng, 4)
    return c


def plaster(rng, base):
    """1.8 m of scratched plaster with a course of ashlar, cracks, stains and flaked places that show the brick."""
    c = Canvas(512, 512, base)
    c.add_field(add(smooth_noise(512, 512, 6, 6, rng, 8), smooth_noise(512, 512, 70, 70, rng, 10),
                    smooth_noise(512, 512, 200, 100, rng, 10)))
    for j in range(4):
        c.rect(0, j * 128, 512, 5, shade(base, 0.62))
        c.rect(0, j * 128 + 5, 512, 2, shade(base, 1.2))
        for i in range(3):
            x = i * 170.7 + (85 if j % 2 else 0)
            c.rect(x, j * 128, 4, 128, shade(base, 0.66))
            c.rect(x + 4, j * 128 + 5, 2, 123, shade(base, 1.18))
    for _ in range(230):
        x, y, r = rng.randrange(512), rng.randrange(512), rng.uniform(1.5, 5)
        c.ellipse(x, y, r, r * rng.uniform(0.5, 1), shade(base, rng.choice((0.6, 0.75, 1.2))), 0.85)
    for _ in range(7):
        x, y = rng.randint(20, 470), rng.randint(20, 470)
        for _ in range(5):
            px, py = x + rng.randint(-16, 16), y + rng.randint(-12, 12)
            c.ellipse(px, py, rng.randint(7, 16), rng.randint(5, 11), (160, 96, 74))
            c.rect(px - 9, py, 18, 2, (196, 184, 166))
            c.rect(px, py - 7, 2, 14, (196, 184, 166))
    for _ in range(8):
        x, y, points = rng.randrange(512), rng.randrange(512), []
        for _ in range(7):
            points.append((x, y))
            x, y = x + rng.randint(-14, 14), y + rng.randint(6, 20)
        c.polyline(points, shade(base, 0.5), 1.4)
    c.grain(rng, 4)
    return c


def plinth(rng):
    """1.6 m of rough stones at the foot of a house."""
    c = Canvas(512, 512, (120, 114, 106))
    for j in range(6):
        x = -rng.randint(0, 60)
        while x < 512:
            w = rng.randint(56, 130)
            tone = shade(rng.choice([(150, 144, 136), (134, 126, 120), (160, 148, 130)]), rng.uniform(0.85, 1.15))
            y = j * 85.3
            c.poly([(x + 5, y + 6 + rng.randint(0, 5)), (x + w - 5, y + 4 + rng.randint(0, 6)), (x + w - 4, y + 80 - rng.randint(0, 5)),
                    (x + 4, y + 81 - rng.randint(0, 6))], tone)
            for _ in range(10):
                c.ellipse(x + rng.uniform(10, w - 10), y + rng.uniform(12, 72), rng.uniform(1.5, 6), rng.uniform(1.5, 4), shade(tone, rng.choice((0.65, 0.8, 1.25))))
            x += w
    c.grain(rng, 7)
    return c


def pane(c, x, y, w, h, rng, frame_colour):
    """A window pane that mirrors the sky and shows curtains."""
    c.gradient(x, y, w, h, (150, 178, 200), (70, 84, 100))
    for _ in range(4):
        c.ellipse(x + rng.uniform(8, w - 8), y + rng.uniform(8, h * 0.5), rng.uniform(6, w * 0.25), rng.uniform(3, 9), (214, 224, 232), 0.6)
    kind = rng.randrange(4)
    if kind == 0:       # curtains
        for k in range(5):
            c.rect(x + k * 4, y, 3, h, (236, 226, 206))
            c.rect(x + w - 4 - k * 4, y, 3, h, (236, 226, 206))
    elif kind == 1:     # a lace
        c.rect(x, y + h * 0.45, w, h * 0.55, (232, 232, 226), 0.7)
        for k in range(int(w / 8)):
            c.ellipse(x + 4 + k * 8, y + h * 0.5, 3, 3, (150, 160, 170))
    elif kind == 2:     # flowers
        for _ in range(6):
            blossom(c, x + rng.uniform(8, w - 8), y + h - rng.uniform(6, 20), 6, rng.choice(COLOURS), rng)
    else:               # a lamp, a shelf
        c.rect(x + w * 0.3, y + h * 0.5, w * 0.5, 4, (120, 90, 60))
        for k in range(5):
            c.rect(x + w * 0.32 + k * 7, y + h * 0.5 - rng.randint(10, 22), 5, 20, rng.choice(COLOURS))
    c.frame(x, y, w, h, 4, frame_colour)
    c.frame(x + 3, y + 3, w - 6, h - 6, 1, shade(frame_colour, 0.6))


def windows(rng):
    """Four windows of 1.2 m by 1.6 m with sills, shutters and boxes of flowers."""
    def draw(c, k):
        s = c.w
        wood_colour = [(236, 232, 222), (110, 74, 52), (86, 110, 96), (226, 222, 210)][k]
        c.rect(0, 0, s, s, [(206, 196, 176), (190, 184, 170), (200, 190, 176), (176, 168, 156)][k])
        c.grain(rng, 6)
        x, w = (20, 216) if k in (0, 3) else (56, 144)
        if k in (1, 2):    # shutters
            col = [(0, 0, 0), (72, 110, 92), (120, 66, 60), (0, 0, 0)][k]
            for sx in (4, 204):
                c.rect(sx, 22, 48, 196, col)
                for j in range(19):
                    c.rect(sx + 5, 28 + j * 10, 38, 5, shade(col, 0.65))
                    c.rect(sx + 5, 27 + j * 10, 38, 1, shade(col, 1.4))
                c.frame(sx, 22, 48, 196, 3, shade(col, 0.6))
        n = 2 if k != 3 else 3
        for i in range(n):
            pw = w / n
            pane(c, x + i * pw, 24, pw - 3, 60, rng, wood_colour)
            pane(c, x + i * pw, 86, pw - 3, 132, rng, wood_colour)
        c.frame(x - 6, 16, w + 12, 208, 7, wood_colour)
        c.rect(0, 0, s, 14, (150, 142, 130))
        for j in range(9):
            c.rect(j * 29, 0, 2, 14, (96, 90, 84))
        c.rect(0, 224, s, 32, (166, 160, 150))
        c.rect(0, 224, s, 4, (214, 208, 198))
        if k in (0, 2):
            c.rect(24, 212, 208, 26, (120, 84, 60))
            for _ in range(60):
                fx, fy = rng.randint(26, 230), rng.randint(190, 214)
                leaf(c, fx, fy, 12, rng.uniform(3.4, 6), (80, 120, 66))
            for _ in range(26):
                blossom(c, rng.randint(28, 228), rng.randint(188, 212), 7, rng.choice([RED, (230, 120, 150), PURPLE, ORANGE]), rng)

    return grid(512, 2, 2, range(4), draw)


def doors(rng):
    """Four doors of houses, 1.1 m by 2.2 m."""
    def draw(c, k):
        s = c.w
        base = [(52, 84, 70), (120, 48, 46), (58, 74, 116), (134, 96, 62)][k]
        c.rect(0, 0, s, s, (196, 188, 174))
        c.grain(rng, 6)
        for side in (0, 232):
            c.rect(side, 0, 24, s, (170, 160, 146))
            for j in range(7):
                c.rect(side, j * 38, 24, 2, (110, 102, 92))
        c.rect(26, 52, 204, 204, base)
        wood(c, rng, 7, horizontal=False)
        c.gradient(32, 10, 192, 38, (160, 186, 206), (96, 112, 126))
        for i in range(6):
            c.rect(30 + i * 33, 8, 4, 42, (236, 232, 222))
        c.text_centred(128, 20, str(rng.randint(2, 98)), (250, 246, 230), 3)
        for x, y, w, h in ((42, 64, 78, 74), (136, 64, 78, 74), (42, 154, 78, 84), (136, 154, 78, 84)):
            if k % 2 and y < 100:
                pane(c, x, y, w, h, rng, shade(base, 0.7))
            else:
                c.frame(x, y, w, h, 4, shade(base, 0.6))
                c.bevel(x + 4, y + 4, w - 8, h - 8, 4, 0.35)
                leaf(c, x + w / 2, y + h - 12, h - 30, -math.pi / 2, shade(base, 1.3))
        c.rect(92, 142, 70, 8, (206, 176, 96))
        c.rect(98, 144, 58, 3, (60, 48, 30))
        c.ellipse(204, 148, 7, 7, (220, 190, 110))
        c.rect(234, 120, 18, 34, (210, 206, 196))
        for j in range(3):
            c.ellipse(243, 127 + j * 10, 3, 3, (90, 84, 70))
        c.rect(26, 244, 204, 12, (150, 130, 90))

    return grid(512, 2, 2, range(4), draw)


def shop(rng, kind):
    """A shop front, 3.6 m by 3 m."""
    colour = [(44, 92, 84), (136, 52, 48), (64, 66, 104)][kind]
    name = ["BAKERY", "BOOKS AND MAPS", "CYCLES"][kind]
    c = Canvas(512, 512, colour)
    wood(c, rng, 7, horizontal=False)
    c.rect(0, 0, 512, 84, shade(colour, 0.8))
    c.frame(6, 6, 500, 72, 4, (226, 196, 120))
    c.text_centred(256, 26, name, (250, 236, 190), 6 if len(name) < 8 else 4)
    for k in range(16):   # awning
        c.poly([(k * 32, 84), (k * 32 + 32, 84), (k * 32 + 32, 124), (k * 32 + 16, 136), (k * 32, 124)],
               (240, 234, 220) if k % 2 else shade(colour, 1.4))
    for x, w in ((18, 160), (334, 160)):
        c.gradient(x, 140, w, 270, (196, 206, 206), (120, 112, 96))
        for j in range(4):
            y = 216 + j * 62
            c.rect(x, y, w, 6, (150, 116, 80))
            px = x + 6
            while px < x + w - 14:
                col = rng.choice(COLOURS + [(226, 180, 110), (240, 226, 190)])
                if kind == 0:
                    r = rng.randint(9, 15)
                    col = rng.choice([(206, 146, 80), (226, 176, 106), (170, 110, 62), (240, 214, 160), (150, 80, 60)])
                    c.ellipse(px + r, y - r * 0.6, r, r * 0.7, col)
                    c.line(px + r * 0.5, y - r, px + r * 1.5, y - r * 0.4, shade(col, 0.7), 2)
                    px += 2 * r + 3
                elif kind == 1:
                    w2, h2 = rng.randint(7, 16), rng.randint(30, 48)
                    c.rect(px, y - h2, w2 - 1, h2, col)
                    c.rect(px + 2, y - h2 + 8, w2 - 5, 9, (250, 246, 230))
                    px += w2
                else:
                    r = rng.randint(13, 20)
                    c.ellipse(px + r, y - r, r, r, INK)
                    c.ellipse(px + r, y - r, r - 4, r - 4, (190, 196, 196))
                    for a in range(6):
                        c.line(px + r, y - r, px + r + (r - 3) * math.cos(a), y - r + (r - 3) * math.sin(a), INK, 1)
                    c.line(px + r, y - r, px + 2 * r, y - 2 * r, col, 3)
                    px += 2 * r + 2
        c.line(x + 10, 300, x + 110, 150, (240, 246, 248), 8, 0.25)
        c.frame(x - 6, 134, w + 12, 282, 7, shade(colour, 1.3))
    c.rect(196, 140, 120, 372, shade(colour, 1.15))
    pane(c, 210, 156, 92, 190, rng, shade(colour, 0.7))
    c.rect(224, 180, 66, 40, (250, 250, 244))
    c.text_centred(257, 192, "OPEN", RED, 2)
    c.rect(292, 300, 10, 90, (214, 186, 110))
    for x, w in ((18, 160), (334, 160), (210, 92)):
        c.frame(x, 426, w, 66, 4, shade(colour, 0.6))
        c.bevel(x + 4, 430, w - 8, 58, 4, 0.3)
        for k in range(5):
            c.ellipse(x + w * (k + 0.5) / 5, 458, 7, 7, shade(colour, 1.5))
    c.rect(0, 500, 512, 12, (90, 86, 80))
    c.grain(rng, 3)
    return c


def garage(rng):
    """A garage door with a coat of posters, 2.6 m by 2.3 m."""
    c = Canvas(512, 512, (176, 170, 156))
    for j in range(6):
        for i in range(4):
            c.rect(i * 128, j * 85, 128, 85, shade((176, 170, 156), rng.uniform(0.92, 1.06)))
            c.frame(i * 128 + 8, j * 85 + 8, 112, 69, 4, (120, 114, 104))
            c.bevel(i * 128 + 12, j * 85 + 12, 104, 61, 3, 0.4)
    for x, y, k in ((30, 180, 2), (236, 140, 5), (350, 260, 7)):
        p = poster(rng, k, 128)
        c.paste(p, x, y)
    c.text(60, 380, rng.choice(WORDS), (60, 80, 150), 9, 0.8)
    c.text(66, 386, "SLAM", (226, 90, 90), 9, 0.8)
    for _ in range(90):
        x, y = rng.randrange(512), rng.randint(300, 510)
        c.line(x, y, x + rng.randint(-20, 20), y + rng.randint(-6, 6), (96, 90, 82), 1.4)
    c.rect(236, 486, 40, 12, (60, 60, 64))
    c.grain(rng, 4)
    return c


def roof(rng):
    """1.6 m of roof tiles."""
    c = Canvas(256, 256, (120, 62, 50))
    for j in range(8):
        for i in range(9):
            x = i * 32 - (16 if j % 2 else 0)
            tone = shade((166, 86, 64), rng.uniform(0.72, 1.2))
            c.rect(x, j * 32, 30, 22, tone)
            c.ellipse(x + 15, j * 32 + 20, 15, 10, tone)
            c.rect(x + 3, j * 32 + 2, 3, 20, shade(tone, 1.25))
    c.grain(rng, 5)
    return c


def foliage(c, rng, count, lengths, greens):
    """So many leaves all over, from the shortest to the longest."""
    for _ in range(count):
        x, y, angle, length = rng.randrange(c.w), rng.randrange(c.h), rng.uniform(0, 6.28), rng.uniform(*lengths)
        colour = shade(rng.choice(greens), rng.uniform(0.7, 1.15))
        around(c, x, y, lengths[1] + 2, lambda px, py: leaf(c, px, py, length, angle, colour))


def hedge(rng):
    """1.2 m of a clipped hedge."""
    c = Canvas(512, 512, (42, 62, 36))
    foliage(c, rng, 2100, (13, 26), [(84, 124, 62), (110, 146, 76), (66, 104, 56), (136, 164, 88)])
    for _ in range(70):
        x, y = rng.randrange(500), rng.randrange(500)
        blossom(c, x, y, 5, rng.choice([(240, 240, 226), (236, 200, 210)]), rng)
    return c


def crown(rng):
    """The crown of a tree, some sky in it."""
    c = Canvas(256, 256, (58, 84, 44))
    foliage(c, rng, 900, (9, 20), [(96, 140, 66), (124, 160, 80), (70, 112, 56), (150, 176, 96)])
    for _ in range(40):
        c.ellipse(rng.randrange(256), rng.randrange(256), rng.uniform(2, 5), rng.uniform(2, 5), (190, 214, 230), 0.9)
    return c


def bark(rng):
    c = Canvas(256, 256, (110, 92, 74))
    for _ in range(420):
        x, y = rng.randrange(256), rng.randrange(256)
        h = rng.randint(8, 34)
        c.rect(x, y, rng.randint(2, 6), h, rng.choice([(70, 56, 44), (140, 122, 100), (90, 74, 58), (160, 144, 120)]))
    for _ in range(26):
        c.ellipse(rng.randrange(256), rng.randrange(256), rng.uniform(4, 9), rng.uniform(3, 6), rng.choice([(140, 150, 110), (60, 46, 36)]))
    c.grain(rng, 7)
    return c


# Where the parts of a car lie in its picture: x, y, width, height in pixels. Its sides have the full width.
CAR = {"side": (0, 0, 512, 150), "glass_side": (0, 150, 512, 106), "front": (0, 256, 171, 256), "back": (171, 256, 171, 256),
       "glass_front": (342, 256, 170, 110), "bonnet": (342, 366, 170, 110), "under": (342, 476, 85, 36),
       "body": (427, 476, 85, 36)}


def car(rng, base, number):
    """The pictures of a car."""
    dark, bright = shade(base, 0.55), mix(base, (255, 255, 255), 0.5)

    def body(c):
        c.gradient(0, 0, c.w, c.h, bright, base)
        c.add_field(smooth_noise(c.w, c.h, 6, 6, rng, 6))

    def draw(c, name):
        w, h = c.w, c.h
        body(c)
        if name == "side":     # 4.2 m by 0.8 m, squeezed into a square of the sheet
            c.rect(0, h * 0.52, w, 5, bright)
            c.rect(0, h * 0.56, w, 3, dark)
            for x in (0.30, 0.52, 0.74):
                c.rect(w * x, 0, 2, h * 0.86, dark)
            for x in (0.46, 0.68):
                c.rect(w * x, h * 0.26, w * 0.045, h * 0.05, (206, 208, 210))
                c.rect(w * x, h * 0.31, w * 0.045, 3, (40, 40, 44))
            c.rect(w * 0.80, h * 0.16, w * 0.06, h * 0.15, shade(base, 0.8))
            for x in (0.19, 0.82):
                c.ellipse(w * x, h * 0.80, w * 0.10, h * 0.44, (26, 26, 28))
                c.ellipse(w * x, h * 0.84, w * 0.078, h * 0.36, (56, 56, 58))
                c.ellipse(w * x, h * 0.84, w * 0.055, h * 0.25, (196, 198, 200))
                for k in range(5):
                    a = k * 1.2566
                    c.ellipse(w * x + w * 0.034 * math.cos(a), h * 0.84 + h * 0.16 * math.sin(a), w * 0.012, h * 0.05, (50, 50, 54))
            c.rect(0, h * 0.1, w * 0.04, h * 0.2, (240, 230, 200))
            c.rect(w * 0.965, h * 0.1, w * 0.035, h * 0.2, (200, 40, 40))
            c.rect(w * 0.3, h * 0.9, w * 0.42, h * 0.1, (50, 50, 52))
            for _ in range(60):
                c.ellipse(rng.uniform(0, w), rng.uniform(h * 0.3, h), 2, 2, (110, 104, 96), 0.8)
            for _ in range(14):
                x, y = rng.uniform(0, w), rng.uniform(h * 0.1, h * 0.8)
                c.line(x, y, x + rng.randint(-30, 30), y + rng.randint(-3, 3), bright, 1.2)
        elif name in ("front", "back"):
            lamp = (246, 240, 214) if name == "front" else (206, 40, 44)
            for x in (0.02, 0.74):
                c.rect(w * x, h * 0.12, w * 0.24, h * 0.2, lamp)
                c.frame(w * x, h * 0.12, w * 0.24, h * 0.2, 3, (60, 60, 64))
                c.ellipse(w * (x + 0.12), h * 0.22, w * 0.05, h * 0.07, mix(lamp, (255, 255, 255), 0.6))
            if name == "front":
                c.rect(w * 0.28, h * 0.14, w * 0.44, h * 0.18, (36, 36, 40))
                for k in range(5):
                    c.rect(w * 0.29, h * 0.155 + k * h * 0.033, w * 0.42, 2, (180, 182, 184))
                c.ellipse(w * 0.5, h * 0.1, 7, 7, (220, 222, 224))
            else:
                c.text(w * 0.30, h * 0.14, "TURBO", (230, 232, 234), 2)
            c.rect(w * 0.27, h * 0.42, w * 0.46, h * 0.13, (250, 246, 220))
            c.text_centred(w / 2, h * 0.45, number, INK, 2)
            c.rect(0, h * 0.6, w, h * 0.06, dark)
            c.rect(w * 0.1, h * 0.72, w * 0.8, h * 0.2, (40, 40, 44))
            for k in range(6):
                c.rect(w * 0.12, h * 0.73 + k * h * 0.03, w * 0.76, 2, (90, 92, 96))
        elif name in ("glass_side", "glass_front"):
            c.gradient(0, 0, w, h, (120, 150, 176), (44, 52, 62))
            for k in range(6):
                c.rect(rng.randint(0, w), h * 0.5, rng.randint(14, 34), h * 0.4, (70, 66, 66))
            c.line(w * 0.1, h, w * 0.5, 0, (220, 230, 238), 9, 0.4)
            c.line(w * 0.6, h, w * 0.9, 0, (220, 230, 238), 5, 0.4)
            c.frame(0, 0, w, h, 7, base)
            if name == "glass_side":
                for x in (0.33, 0.66):
                    c.rect(w * x, 0, 8, h, base)
            else:
                c.rect(w * 0.44, 4, 18, 12, (30, 30, 34))
                c.rect(8, h - 26, 26, 18, (240, 230, 160))
                c.line(30, h - 8, 70, h - 30, (24, 24, 26), 3)
        elif name == "bonnet":
            c.line(w * 0.25, 0, w * 0.3, h, dark, 3)
            c.line(w * 0.75, 0, w * 0.7, h, dark, 3)
            for _ in range(14):
                leaf(c, rng.uniform(0, w), rng.uniform(0, h), rng.uniform(8, 14), rng.uniform(0, 6.3), rng.choice([(176, 130, 60), (120, 140, 70)]))
        elif name == "under":
            c.rect(0, 0, w, h, (34, 34, 36))
            c.grain(rng, 8)
        for _ in range(10):
            c.ellipse(rng.uniform(0, w), rng.uniform(0, h), 1.6, 1.6, dark, 0.7)

    sheet = Canvas(512, 512)
    for name, (x, y, w, h) in CAR.items():
        c = Canvas(w, h)
        draw(c, name)
        sheet.paste(c, x, y)
    sheet.grain(rng, 2)
    return sheet


THINGS = ["post", "lamp", "bin", "column", "sign_stop", "sign_park", "sign_name", "meter", "letterbox", "bench", "manhole", "pot",
          "board", "grate", "gutter", "dish"]


def things(rng):
    def draw(c, name):
        s = c.w
        if name == "post":
            c.rect(0, 0, s, s, (64, 84, 74))
            c.add_field(smooth_noise(s, s, 4, 50, rng, 10))
            for k in range(4):
                c.rect(0, 10 + 32 * k, s, 5, (110, 134, 120))
                c.rect(k * 32 + 6, 18, 14, 10, (206, 176, 96))
            for _ in range(20):
                c.ellipse(rng.randrange(s), rng.randrange(s), 3, 4, rng.choice([(140, 90, 60), (240, 236, 226)]))
        elif name == "lamp":
            c.rect(0, 0, s, s, (250, 246, 226))
            for k in range(4):
                c.rect(k * 32, 0, 5, s, (50, 66, 58))
            c.rect(0, 0, s, 12, (50, 66, 58))
            c.rect(0, 116, s, 12, (50, 66, 58))
        elif name == "bin":
            c.rect(0, 0, s, s, (70, 104, 70))
            for k in range(8):
                c.rect(k * 16, 24, 6, 90, (40, 66, 44))
            c.rect(0, 8, s, 10, (170, 180, 170))
            c.rect(36, 44, 56, 44, (240, 240, 232))
            c.text_centred(64, 56, "LITTER", GREEN, 1)
            c.ellipse(64, 76, 8, 8, GREEN)
        elif name == "column":
            for j in range(3):
                for i in range(3):
                    p = rng.choice(COLOURS + [(240, 236, 220), INK])
                    c.rect(i * 43, j * 43, 42, 42, p)
                    c.text(i * 43 + 4, j * 43 + 5, rng.choice(WORDS)[:5], (255, 255, 255), 1)
                    for _ in range(4):
                        c.ellipse(i * 43 + rng.randint(6, 36), j * 43 + rng.randint(18, 38), rng.randint(2, 7), rng.randint(2, 6), rng.choice(COLOURS + [(250, 250, 250)]))
        elif name == "sign_stop":
            c.rect(0, 0, s, s, (150, 152, 154))
            c.poly([(38, 4), (90, 4), (124, 38), (124, 90), (90, 124), (38, 124), (4, 90), (4, 38)], RED)
            c.text_centred(64, 50, "STOP", (255, 255, 255), 4)
        elif name == "sign_park":
            c.rect(0, 0, s, s, (36, 84, 170))
            c.frame(4, 4, s - 8, s - 8, 4, (255, 255, 255))
            c.text_centred(64, 18, "P", (255, 255, 255), 9)
            c.text_centred(64, 96, "9-18 H", (255, 255, 255), 2)
        elif name == "sign_name":
            c.rect(0, 0, s, s, (36, 66, 120))
            c.frame(4, 4, s - 8, s - 8, 4, (255, 255, 255))
            c.text_centred(64, 26, "LONG", (255, 255, 255), 4)
            c.text_centred(64, 70, "LANE", (255, 255, 255), 4)
        elif name == "meter":
            c.rect(0, 0, s, s, (96, 100, 108))
            c.rect(16, 12, 96, 34, (160, 190, 160))
            c.text(24, 20, "2.40", INK, 3)
            for k in range(6):
                c.rect(20 + (k % 3) * 32, 56 + (k // 3) * 26, 22, 18, rng.choice(COLOURS))
            c.rect(30, 112, 68, 8, (20, 20, 22))
        elif name == "letterbox":
            c.rect(0, 0, s, s, (236, 196, 40))
            c.rect(20, 20, 88, 14, (40, 36, 20))
            c.poly([(30, 50), (98, 50), (98, 92), (30, 92)], (250, 250, 246))
            c.polyline([(30, 50), (64, 74), (98, 50)], INK, 3)
            c.lines_of_print(24, 102, 80, 4, rng, INK, 6, 2)
        elif name == "bench":
            c.rect(0, 0, s, s, (40, 36, 30))
            for k in range(5):
                c.rect(0, k * 26, s, 20, shade((150, 110, 70), rng.uniform(0.85, 1.15)))
                for x in (14, 112):
                    c.ellipse(x, k * 26 + 10, 3, 3, (60, 60, 64))
            c.add_field(smooth_noise(s, s, 3, 50, rng, 12))
        elif name == "manhole":
            c.rect(0, 0, s, s, (108, 110, 114))
            c.grain(rng, 12)
            c.ellipse(64, 64, 58, 58, (58, 58, 62))
            c.ellipse(64, 64, 50, 50, (92, 92, 96))
            for j in range(6):
                for i in range(6):
                    if (i - 2.5) ** 2 + (j - 2.5) ** 2 < 7.5:
                        c.rect(24 + i * 14, 24 + j * 14, 9, 9, (50, 50, 54) if (i + j) % 2 else (140, 140, 142))
        elif name == "pot":
            c.rect(0, 0, s, s, (176, 100, 70))
            for k in range(6):
                c.rect(0, k * 22, s, 4, (140, 76, 54))
                for i in range(8):
                    c.ellipse(i * 16 + 8, k * 22 + 13, 4, 4, (206, 140, 104))
        elif name == "board":
            c.rect(0, 0, s, s, (40, 44, 42))
            c.frame(0, 0, s, s, 8, (150, 110, 70))
            c.text_centred(64, 16, "TODAY", (250, 240, 200), 3)
            for k in range(5):
                c.scribble(14, 54 + k * 14, rng.randint(50, 98), rng, rng.choice([(250, 250, 240), YELLOW, (240, 160, 160)]), 9, 2)
        elif name == "grate":
            c.rect(0, 0, s, s, (84, 86, 90))
            for k in range(8):
                c.rect(k * 16 + 4, 12, 8, 104, (26, 26, 28))
        elif name == "gutter":
            c.rect(0, 0, s, s, (120, 132, 130))
            c.add_field(smooth_noise(s, s, 40, 4, rng, 12))
            for k in range(3):
                c.rect(0, k * 46 + 10, s, 10, (90, 100, 98))
        else:
            c.rect(0, 0, s, s, (206, 208, 208))
            for r in (50, 38, 26, 14):
                c.ellipse(64, 64, r, r, (150 + r, 154 + r, 156 + r))

    sheet = grid(512, 4, 4, THINGS, draw)
    sheet.grain(rng, 3)
    return sheet


TEXTURES = {
    "asphalt": asphalt,
    "paving": paving,
    "kerb": kerb,
    "paint": paint,
    "brick_red": lambda r: brick(r, (172, 88, 68)),
    "brick_yellow": lambda r: brick(r, (206, 176, 126), (150, 140, 126)),
    "plaster_ochre": lambda r: plaster(r, (214, 186, 134)),
    "plaster_blue": lambda r: plaster(r, (166, 184, 196)),
    "plinth": plinth,
    "windows": windows,
    "doors": doors,
    "shop_a": lambda r: shop(r, 0),
    "shop_b": lambda r: shop(r, 1),
    "shop_c": lambda r: shop(r, 2),
    "garage": garage,
    "roof": roof,
    "hedge": hedge,
    "crown": crown,
    "bark": bark,
    "car_red": lambda r: car(r, (170, 44, 44), "LN 4071"),
    "car_blue": lambda r: car(r, (56, 92, 150), "MK 518"),
    "car_grey": lambda r: car(r, (150, 154, 158), "PT 2290"),
    "things": things,
}
