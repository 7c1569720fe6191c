# SPDX-License-Identifier: BSD-3-Clause
"""A small painter: an RGB picture in a bytearray, and a PNG writer. Plain Python, no other library.

Pixels: x to the right, y down, (0, 0) top left. Colours are (red, green, blue), 0..255.
"""

import math
import struct
import zlib

# A 5 x 7 letter set: seven rows of five bits, most significant bit on the left.
_GLYPHS = {
    "A": "0E11111F111111", "B": "1E11111E11111E", "C": "0E11101010110E", "D": "1E11111111111E",
    "E": "1F10101E10101F", "F": "1F10101E101010", "G": "0E11101711110F", "H": "1111111F111111",
    "I": "0E04040404040E", "J": "0702020202120C", "K": "11121418141211", "L": "1010101010101F",
    "M": "111B1515111111", "N": "11191513111111", "O": "0E11111111110E", "P": "1E11111E101010",
    "Q": "0E11111115120D", "R": "1E11111E141211", "S": "0F10100E01011E", "T": "1F040404040404",
    "U": "1111111111110E", "V": "11111111110A04", "W": "11111115151B11", "X": "11110A040A1111",
    "Y": "11110A04040404", "Z": "1F01020408101F", "0": "0E11131519110E", "1": "040C040404040E",
    "2": "0E11010608101F", "3": "1F02040201110E", "4": "02060A121F0202", "5": "1F101E0101110E",
    "6": "0608101E11110E", "7": "1F010204080808", "8": "0E11110E11110E", "9": "0E11110F01020C",
    "-": "0000001F000000", ".": "000000000C0C00", ":": "000C0C000C0C00", "/": "01010204081010",
    "+": "0004041F040400", "=": "00001F001F0000", "(": "02040808080402", ")": "08040202020408",
    "?": "0E110106040004", "!": "04040404040004", "%": "19190204081313", ",": "0000000C0C0408",
}

_CLAMP_MARGIN = 512
_CLAMP = bytes([0] * _CLAMP_MARGIN + list(range(256)) + [255] * _CLAMP_MARGIN)


def mix(a, b, t):
    """Colour between a (t = 0) and b (t = 1)."""
    return tuple(int(round(a[i] + (b[i] - a[i]) * t)) for i in range(3))


def shade(colour, factor):
    return tuple(max(0, min(255, int(round(c * factor)))) for c in colour)


class Canvas:
    def __init__(self, width, height, colour=(255, 255, 255)):
        self.w, self.h = width, height
        self.data = bytearray(bytes(colour) * (width * height))

    # --- areas

    def rect(self, x, y, w, h, colour, alpha=1.0):
        x0, y0 = max(0, int(round(x))), max(0, int(round(y)))
        x1, y1 = min(self.w, int(round(x + w))), min(self.h, int(round(y + h)))
        if x1 <= x0 or y1 <= y0:
            return
        if alpha >= 1.0:
            row = bytes(colour) * (x1 - x0)
            for j in range(y0, y1):
                self.data[(j * self.w + x0) * 3:(j * self.w + x1) * 3] = row
        else:
            tables = [bytes(int(v + (c - v) * alpha + 0.5) for v in range(256)) for c in colour]
            for j in range(y0, y1):
                a, b = (j * self.w + x0) * 3, (j * self.w + x1) * 3
                for c in range(3):
                    self.data[a + c:b:3] = self.data[a + c:b:3].translate(tables[c])

    def frame(self, x, y, w, h, thick, colour, alpha=1.0):
        self.rect(x, y, w, thick, colour, alpha)
        self.rect(x, y + h - thick, w, thick, colour, alpha)
        self.rect(x, y + thick, thick, h - 2 * thick, colour, alpha)
        self.rect(x + w - thick, y + thick, thick, h - 2 * thick, colour, alpha)

    def bevel(self, x, y, w, h, thick=2, strength=0.35):
        """Light from above: a raised panel."""
        self.rect(x, y, w, thick, (255, 255, 255), strength)
        self.rect(x, y, thick, h, (255, 255, 255), strength * 0.6)
        self.rect(x, y + h - thick, w, thick, (0, 0, 0), strength)
        self.rect(x + w - thick, y, thick, h, (0, 0, 0), strength * 0.7)

    def gradient(self, x, y, w, h, top, bottom):
        for j in range(int(h)):
            self.rect(x, y + j, w, 1, mix(top, bottom, j / max(1, h - 1)))

    def poly(self, points, colour, alpha=1.0):
        ys = [p[1] for p in points]
        n = len(points)
        for j in range(max(0, int(math.floor(min(ys)))), min(self.h, int(math.ceil(max(ys))) + 1)):
            yc = j + 0.5
            xs = []
            for i in range(n):
                (xa, ya), (xb, yb) = points[i], points[(i + 1) % n]
                if (ya <= yc) != (yb <= yc):
                    xs.append(xa + (yc - ya) * (xb - xa) / (yb - ya))
            xs.sort()
            for a, b in zip(xs[0::2], xs[1::2]):
                self.rect(round(a), j, round(b) - round(a), 1, colour, alpha)

    def ellipse(self, cx, cy, rx, ry, colour, alpha=1.0):
        for j in range(int(cy - ry), int(cy + ry) + 1):
            t = 1 - ((j + 0.5 - cy) / ry) ** 2
            if t > 0:
                half = rx * math.sqrt(t)
                self.rect(round(cx - half), j, round(cx + half) - round(cx - half), 1, colour, alpha)

    def line(self, x0, y0, x1, y1, colour, width=1, alpha=1.0):
        length = math.hypot(x1 - x0, y1 - y0)
        if length < 1e-9:
            return
        nx, ny = -(y1 - y0) / length * width / 2, (x1 - x0) / length * width / 2
        if width <= 1.5:
            steps = int(max(abs(x1 - x0), abs(y1 - y0))) + 1
            for i in range(steps + 1):
                self.rect(int(x0 + (x1 - x0) * i / steps), int(y0 + (y1 - y0) * i / steps), 1, 1,
                          colour, alpha)
        else:
            self.poly([(x0 + nx, y0 + ny), (x1 + nx, y1 + ny), (x1 - nx, y1 - ny), (x0 - nx, y0 - ny)],
                      colour, alpha)

    def polyline(self, points, colour, width=1, alpha=1.0):
        for a, b in zip(points, points[1:]):
            self.line(a[0], a[1], b[0], b[1], colour, width, alpha)

    # --- writing

    def text(self, x, y, words, colour, scale=1, alpha=1.0):
        for ch in words.upper():
            rows = _GLYPHS.get(ch)
            if rows:
                for j in range(7):
                    bits = int(rows[2 * j:2 * j + 2], 16)
                    for i in range(5):
                        if bits >> (4 - i) & 1:
                            self.rect(x + i * scale, y + j * scale, scale, scale, colour, alpha)
            x += 6 * scale
        return x

    def text_centred(self, cx, y, words, colour, scale=1):
        self.text(int(cx - (6 * len(words) - 1) * scale / 2), y, words, colour, scale)

    def scribble(self, x, y, w, rng, colour, height=8, width=1):
        """A line of handwriting nobody can read."""
        end = x + w
        while x < end:
            word_end = min(end, x + rng.randint(2, 7) * height * 0.55)
            points = []
            while x < word_end:
                tall = 1.6 if rng.random() < 0.25 else 1.0
                points.append((x, y - rng.random() * height * 0.5 * tall))
                points.append((x + height * 0.2, y + rng.random() * height * 0.25 * tall))
                x += height * 0.38
            self.polyline(points, colour, width)
            x += height * 0.7

    def lines_of_print(self, x, y, w, count, rng, colour, pitch=4, thick=2, alpha=1.0):
        """Small print as dashes of word length."""
        for k in range(count):
            px, end = x, x + w * (rng.uniform(0.4, 0.8) if k % 6 == 5 else rng.uniform(0.9, 1.0))
            while px < end:
                word = min(end - px, rng.randint(3, 11))
                self.rect(px, y + k * pitch, word, thick, colour, alpha)
                px += word + 2

    # --- noise

    def add_field(self, field, weights=(1.0, 1.0, 1.0)):
        """Adds a list of w*h numbers to the three channels."""
        for c in range(3):
            k = weights[c]
            chan = self.data[c::3]
            if k == 1.0:
                self.data[c::3] = bytes([_CLAMP[v + int(f) + _CLAMP_MARGIN] for v, f in zip(chan, field)])
            else:
                self.data[c::3] = bytes([_CLAMP[v + int(f * k) + _CLAMP_MARGIN]
                                         for v, f in zip(chan, field)])

    def grain(self, rng, sigma):
        """White noise, equal in the three channels."""
        table = [round(rng.gauss(0, sigma)) for _ in range(256)]
        self.add_field([table[b] for b in rng.randbytes(self.w * self.h)])

    def paste(self, other, x, y):
        for j in range(other.h):
            if 0 <= y + j < self.h:
                n = min(other.w, self.w - x)
                a = ((y + j) * self.w + x) * 3
                self.data[a:a + 3 * n] = other.data[j * other.w * 3:(j * other.w + n) * 3]

    # --- file

    def save(self, path):
        """PNG, 8 bits RGB, with whichever row filter packs best."""
        stride = self.w * 3
        rows = [self.data[j * stride:(j + 1) * stride] for j in range(self.h)]
        best = None
        for kind in (0, 1, 2):
            raw = bytearray()
            before = bytes(stride)
            for row in rows:
                raw.append(kind)
                if kind == 0:
                    raw += row
                elif kind == 1:
                    raw += bytes([(a - b) & 255 for a, b in zip(row, bytes(3) + row[:-3])])
                else:
                    raw += bytes([(a - b) & 255 for a, b in zip(row, before)])
                before = row
            packed = zlib.compress(bytes(raw), 9)
            if best is None or len(packed) < len(best):
                best = packed

        def chunk(tag, body):
            return struct.pack(">I", len(body)) + tag + body + struct.pack(">I", zlib.crc32(tag + body))

        with open(path, "wb") as f:
            f.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", self.w, self.h, 8, 2, 0, 0, 0))
                    + chunk(b"IDAT", best) + chunk(b"IEND", b""))


def smooth_noise(w, h, nx, ny, rng, amplitude):
    """Value noise on an nx by ny lattice that wraps around, between -amplitude and +amplitude."""
    lattice = [[rng.uniform(-amplitude, amplitude) for _ in range(nx)] for _ in range(ny)]
    columns = []
    for i in range(w):
        u = i * nx / w
        a = int(u)
        t = u - a
        columns.append((a % nx, (a + 1) % nx, t * t * (3 - 2 * t)))
    out = []
    for j in range(h):
        v = j * ny / h
        b = int(v)
        t = v - b
        t = t * t * (3 - 2 * t)
        low, high = lattice[b % ny], lattice[(b + 1) % ny]
        row = [p + (q - p) * t for p, q in zip(low, high)]
        out += [row[a] + (row[c] - row[a]) * s for a, c, s in columns]
    return out


def add(*fields):
    return [sum(values) for values in zip(*fields)]
