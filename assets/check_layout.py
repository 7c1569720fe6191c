# SPDX-License-Identifier: BSD-3-Clause
"""How much of the office a round robot can reach, and how wide the passages are.

    python3 assets/check_layout.py [overview.png]

Draws the footprints of everything lower than 0.8 m on a 1 cm grid, measures each free cell's distance to the nearest
obstacle, and looks for passages: places whose nearest obstacles lie on opposite sides.
"""

import math
import os
import sys

from canvas import Canvas
from furniture import all_meshes
from layout import place
from room import SIZE, room

CELL = 0.01
N = int(SIZE / CELL)
RADIUS = 0.25


def outlines(objects, meshes, low=0.02, high=0.80):
    for name, mesh, x, y, theta, z, _ in objects:
        c, s = math.cos(math.radians(theta)), math.sin(math.radians(theta))
        for hull in meshes[mesh].footprints(low - z, high - z):
            yield name, [(x + c * px - s * py, y + s * px + c * py) for px, py in hull]


def rasterise(objects, meshes, low=0.02, high=0.80):
    """1 where something stands; row j is y = (j + 0.5) * CELL."""
    grid = [bytearray(N) for _ in range(N)]
    for _, hull in outlines(objects, meshes, low, high):
        ys = [p[1] for p in hull]
        for j in range(max(0, int(min(ys) / CELL)), min(N - 1, int(max(ys) / CELL)) + 1):
            y = (j + 0.5) * CELL
            xs = []
            for (xa, ya), (xb, yb) in zip(hull, hull[1:] + hull[:1]):
                if (ya <= y) != (yb <= y):
                    xs.append(xa + (y - ya) * (xb - xa) / (yb - ya))
            if len(xs) >= 2:
                a, b = max(0, round(min(xs) / CELL)), min(N, round(max(xs) / CELL))
                if b > a:
                    grid[j][a:b] = b"\x01" * (b - a)
    return grid


def nearest(grid):
    """For each cell, squared distance in cells to the nearest occupied cell and that cell, by two sweeps of vectors."""
    far = 1 << 20
    dx = [[0 if v else far for v in row] for row in grid]
    dy = [[0 if v else far for v in row] for row in grid]
    # The room's walls lie outside the grid; the skirting stands inside it, so the border is occupied anyway.

    def relax(j, i, jj, ii):
        if 0 <= jj < N and 0 <= ii < N and dx[jj][ii] < far:
            a, b = dx[jj][ii] + ii - i, dy[jj][ii] + jj - j
            if a * a + b * b < dx[j][i] ** 2 + dy[j][i] ** 2:
                dx[j][i], dy[j][i] = a, b

    for j in range(N):
        for i in range(N):
            if not grid[j][i]:
                relax(j, i, j - 1, i - 1)
                relax(j, i, j - 1, i)
                relax(j, i, j - 1, i + 1)
                relax(j, i, j, i - 1)
        for i in range(N - 1, -1, -1):
            if not grid[j][i]:
                relax(j, i, j, i + 1)
    for j in range(N - 1, -1, -1):
        for i in range(N):
            if not grid[j][i]:
                relax(j, i, j + 1, i - 1)
                relax(j, i, j + 1, i)
                relax(j, i, j + 1, i + 1)
                relax(j, i, j, i - 1)
        for i in range(N - 1, -1, -1):
            if not grid[j][i]:
                relax(j, i, j, i + 1)
    return dx, dy


def components(inside):
    """Sizes of the connected parts, and their labels."""
    label = [[0] * N for _ in range(N)]
    sizes = []
    for j in range(N):
        for i in range(N):
            if inside[j][i] and not label[j][i]:
                sizes.append(0)
                k = len(sizes)
                stack = [(j, i)]
                label[j][i] = k
                while stack:
                    b, a = stack.pop()
                    sizes[-1] += 1
                    for bb, aa in ((b - 1, a), (b + 1, a), (b, a - 1), (b, a + 1)):
                        if 0 <= bb < N and 0 <= aa < N and inside[bb][aa] and not label[bb][aa]:
                            label[bb][aa] = k
                            stack.append((bb, aa))
    return sizes, label


def passages(grid, dx, dy, below):
    """Narrow places: (width, x, y), the narrowest of each cluster of cells that lie between opposite obstacles."""
    found = []
    for j in range(1, N - 1):
        for i in range(1, N - 1):
            if grid[j][i]:
                continue
            ax, ay = dx[j][i], dy[j][i]
            r = math.hypot(ax, ay)
            if 2 * r * CELL > below + 0.02 or r < 3:
                continue
            for bj, bi in ((j, i + 1), (j + 1, i)):
                if not grid[bj][bi]:
                    bx, by = dx[bj][bi] + bi - i, dy[bj][bi] + bj - j
                    gap = math.hypot(ax - bx, ay - by)
                    if gap > 1.90 * r and gap * CELL < below:
                        found.append(((gap - 1) * CELL, i * CELL, j * CELL))
    found.sort()
    kept = []
    for g in found:
        if all(math.hypot(g[1] - k[1], g[2] - k[2]) > 0.6 for k in kept):
            kept.append(g)
    return kept


def main():
    meshes = {m.name: m for m in [room()] + all_meshes()}
    objects = place()
    grid = rasterise(objects, meshes)
    dx, dy = nearest(grid)
    clear = [[math.hypot(a, b) * CELL for a, b in zip(ra, rb)] for ra, rb in zip(dx, dy)]
    free = sum(row.count(0) for row in grid) * CELL * CELL
    inside = [[d >= RADIUS + 0.5 * CELL for d in row] for row in clear]
    sizes, label = components(inside)
    sizes_m2 = sorted((s * CELL * CELL for s in sizes), reverse=True)
    main_label = max(range(len(sizes)), key=lambda k: sizes[k]) + 1
    # Loops: holes in the reachable region are the parts of its complement that do not touch the border.
    holes, hole_label = components([[label[j][i] != main_label for i in range(N)] for j in range(N)])
    print(f"free floor {free:.1f} m2; reachable by a disc of {RADIUS} m: {sizes_m2[0]:.1f} m2, "
          f"{len(sizes)} component(s) {[round(s, 2) for s in sizes_m2[1:]]}, "
          f"{sum(h > 400 for h in holes) - 1} loops")
    spots = sum(d >= 0.75 for row in clear for d in row) * CELL * CELL
    print(f"centres of discs of 1.5 m diameter: {spots:.2f} m2")
    foot = rasterise(objects, meshes, 0.005, 0.02)
    fx, fy = nearest(foot)
    over = max((math.hypot(fx[j][i], fy[j][i]) * CELL, i * CELL, j * CELL)
               for j in range(N) for i in range(N) if grid[j][i])
    print(f"farthest from the foot of something, below 0.8 m: {over[0]:.3f} m at ({over[1]:.2f}, {over[2]:.2f})")
    gaps = passages(grid, dx, dy, 2.0)
    print("passages too narrow for the robot, m:", " ".join(f"{w:.2f}({x:.1f},{y:.1f})" for w, x, y in gaps if 0.12 < w < 0.5))
    print("ambiguous passages 0.50-0.86 m:", [(round(w, 2), round(x, 2), round(y, 2)) for w, x, y in gaps if 0.5 <= w < 0.86])
    print("passages, m:", " ".join(f"{w:.2f}({x:.1f},{y:.1f})" for w, x, y in gaps if w >= 0.86))
    if len(sys.argv) > 1:
        picture = Canvas(N, N)
        for j in range(N):
            row = bytearray()
            for i in range(N):
                row += (b"\x28\x2c\x34" if grid[j][i] else b"\x8c\xc8\x96" if label[j][i] == main_label
                        else b"\xf0\x50\x50" if label[j][i] else b"\xe8\xe8\xe0")
            picture.data[(N - 1 - j) * N * 3:(N - j) * N * 3] = row
        for w, x, y in gaps:
            px, py = x / CELL, N - y / CELL
            picture.ellipse(px, py, 5, 5, (200, 40, 40) if w < 0.86 else (40, 80, 200))
            picture.text(int(px) + 8, int(py) - 6, f"{w:.2f}", (0, 0, 0), 2)
        picture.save(sys.argv[1])


if __name__ == "__main__":
    sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
    main()
