# SPDX-License-Identifier: BSD-3-Clause
"""Builds meshes out of convex parts and writes them as glTF 2.0 with the buffer embedded.

Everything here is in the project's axes (x forward, y left, z up, metres). write_gltf turns them into glTF's own
(y up): x_gltf = x, y_gltf = z, z_gltf = -y. Texture coordinates are glTF's: (0, 0) is the top left of the picture.
"""

import base64
import json
import math
import struct

FULL = (0.0, 0.0, 1.0, 1.0)


class Mesh:
    def __init__(self, name):
        self.name = name
        self.textures = {}   # material -> file name of its texture
        self.faces = {}      # material -> list of (four or three corners, uvs, normal)
        self.parts = []      # corners of each convex part, for footprints
        self._taken = set()

    def material(self, name, texture):
        self.textures[name] = texture
        self.faces.setdefault(name, [])

    def _face(self, corners, uvs, mat):
        a, b, c = corners[0], corners[1], corners[2]
        u = [b[i] - a[i] for i in range(3)]
        v = [c[i] - a[i] for i in range(3)]
        n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        length = math.sqrt(sum(k * k for k in n))
        self.faces[mat].append((corners, uvs, tuple(k / length for k in n)))

    def _claim(self, corners):
        """True if no other part has a corner here: parts are told apart by their corners."""
        keys = {tuple(round(c * 10000) for c in p) for p in corners}
        if keys & self._taken:
            return False
        self._taken |= keys
        self.parts.append(list(corners))
        return True

    def box(self, x0, y0, z0, x1, y1, z1, mat, faces=None, skip=("-z",), tile=None, uv=None, yaw_deg=0.0,
            shift=(0.0, 0.0)):
        """A box. `faces` gives single faces another (material, uv rectangle); `tile` is the size in metres of one
        repetition of the texture, without it each face shows the whole of `uv`. Faces named in `skip` are left out."""
        faces = faces or {}
        cx, cy = (x0 + x1) / 2, (y0 + y1) / 2
        co, si = math.cos(math.radians(yaw_deg)), math.sin(math.radians(yaw_deg))

        def turn(x, y, z):
            return (cx + co * (x - cx) - si * (y - cy), cy + si * (x - cx) + co * (y - cy), z)

        for _ in range(40):   # parts that would touch in a corner are shrunk by a fraction of a millimetre
            p = {(i, j, k): turn((x0, x1)[i], (y0, y1)[j], (z0, z1)[k])
                 for i in (0, 1) for j in (0, 1) for k in (0, 1)}
            if self._claim(list(p.values())):
                break
            d = 0.0003
            x0, y0, x1, y1, z1 = x0 + d, y0 + d, x1 - d, y1 - d, z1 - d
        else:
            raise ValueError(f"{self.name}: no room for a part at {x0}, {y0}, {z0}")
        sides = {   # corners from lower left, counter-clockwise as seen from outside; width and height in metres
            "+x": ([p[1, 0, 0], p[1, 1, 0], p[1, 1, 1], p[1, 0, 1]], y1 - y0, z1 - z0),
            "-x": ([p[0, 1, 0], p[0, 0, 0], p[0, 0, 1], p[0, 1, 1]], y1 - y0, z1 - z0),
            "+y": ([p[1, 1, 0], p[0, 1, 0], p[0, 1, 1], p[1, 1, 1]], x1 - x0, z1 - z0),
            "-y": ([p[0, 0, 0], p[1, 0, 0], p[1, 0, 1], p[0, 0, 1]], x1 - x0, z1 - z0),
            "+z": ([p[1, 0, 1], p[1, 1, 1], p[0, 1, 1], p[0, 0, 1]], y1 - y0, x1 - x0),
            "-z": ([p[0, 0, 0], p[0, 1, 0], p[1, 1, 0], p[1, 0, 0]], y1 - y0, x1 - x0),
        }
        for side, (corners, width, height) in sides.items():
            if side in skip:
                continue
            m, rect = faces.get(side, (mat, None))
            if side in faces:
                rect = rect or FULL
            else:
                if tile:
                    rect = (shift[0], shift[1], shift[0] + width / tile, shift[1] + height / tile)
                else:
                    rect = uv or FULL
            u0, v0, u1, v1 = rect
            self._face(corners, [(u0, v1), (u1, v1), (u1, v0), (u0, v0)], m)

    def prism(self, cx, cy, z0, z1, r0, r1, sides, mat, uv=FULL, top=None, skip_top=False, turn_deg=0.0, stretch=1.0,
              wraps=1):
        """A (tapered) cylinder or prism, radius r0 below and r1 above; `top` is (material, uv) of the lid."""
        def ring(r, z):
            out = []
            for i in range(sides):
                a = math.radians(turn_deg) + 2 * math.pi * i / sides
                out.append((cx + r * math.cos(a), cy + r * stretch * math.sin(a), z))
            return out
        for _ in range(40):
            low, high = ring(r0, z0), ring(r1, z1)
            if self._claim(low + high):
                break
            r0, r1 = r0 - 0.0003, r1 - 0.0003
        else:
            raise ValueError(f"{self.name}: no room for a prism at {cx}, {cy}, {z0}")
        u0, v0, u1, v1 = uv
        for i in range(sides):
            k = (i + 1) % sides
            a = u0 + (u1 - u0) * ((i * wraps / sides) % 1.0)
            b = a + (u1 - u0) * wraps / sides
            self._face([low[i], low[k], high[k], high[i]], [(a, v1), (b, v1), (b, v0), (a, v0)], mat)
        if not skip_top:
            m, (u0, v0, u1, v1) = top or (mat, uv)
            def lid(i):
                a = 2 * math.pi * i / sides
                return (u0 + (u1 - u0) * (0.5 + 0.5 * math.cos(a)), v0 + (v1 - v0) * (0.5 - 0.5 * math.sin(a)))
            for i in range(1, sides - 1):
                self._face([high[0], high[i], high[i + 1]], [lid(0), lid(i), lid(i + 1)], m)

    def pillar(self, outline, z0, z1, mat, wraps=1.0):
        """An upright prism over a convex counter-clockwise outline, open above and below; the picture runs around it."""
        low, high = [(x, y, z0) for x, y in outline], [(x, y, z1) for x, y in outline]
        if not self._claim(low + high):
            raise ValueError(f"{self.name}: a pillar shares a corner with another part")
        around = sum(math.dist(a, b) for a, b in zip(low, low[1:] + low[:1]))
        u = 0.0
        for i in range(len(low)):
            k = (i + 1) % len(low)
            v = u + math.dist(low[i], low[k]) / around * wraps
            self._face([low[i], low[k], high[k], high[i]], [(u, 1), (v, 1), (v, 0), (u, 0)], mat)
            u = v

    def loft(self, low, high, mat, uv=FULL, sides=None, top=None, bottom=None):
        """A convex part between two horizontal outlines of as many corners, counter-clockwise from above, each corner
        above its partner so that the sides are flat. The picture runs once around, from the first corner on;
        `sides(i)` gives side i another (material, uv rectangle), `top` and `bottom` (material, uv) close the ends."""
        if not self._claim(low + high):
            raise ValueError(f"{self.name}: a loft shares a corner with another part")
        n = len(low)
        for i in range(n):
            k = (i + 1) % n
            m, (u0, v0, u1, v1) = sides(i) if sides else (mat, (uv[0] + (uv[2] - uv[0]) * i / n, uv[1],
                                                                uv[0] + (uv[2] - uv[0]) * (i + 1) / n, uv[3]))
            self._face([low[i], low[k], high[k], high[i]], [(u0, v1), (u1, v1), (u1, v0), (u0, v0)], m)

        def end(corners, m, rect):
            (x0, x1), (y0, y1) = ((min(c[j] for c in corners), max(c[j] for c in corners)) for j in (0, 1))
            u0, v0, u1, v1 = rect
            self._face(corners, [(u0 + (u1 - u0) * (y1 - c[1]) / (y1 - y0), v0 + (v1 - v0) * (x1 - c[0]) / (x1 - x0))
                                 for c in corners], m)
        if top:
            end(high, *top)
        if bottom:
            end(low[::-1], *bottom)

    def wall_quads(self, quads):
        """One flat part made of several (corners, uv, material): a wall or floor divided for its textures."""
        corners = [c for q in quads for c in q[0]]
        if not self._claim(corners):
            raise ValueError(f"{self.name}: a wall shares a corner with another part")
        for c, (u0, v0, u1, v1), mat in quads:
            self._face(c, [(u0, v1), (u1, v1), (u1, v0), (u0, v0)], mat)

    def triangles(self):
        return sum(len(c) - 2 for faces in self.faces.values() for c, _, _ in faces)

    def footprints(self, z_low=0.02, z_high=0.80):
        """Convex outlines of the parts' slices between two heights. Parts here are prisms or boxes, whose slice lies
        inside the outline of their corners; a tapered part counts as wide as it is anywhere."""
        out = []
        for part in self.parts:
            zs = [p[2] for p in part]
            if max(zs) > z_low and min(zs) < z_high:
                out.append(convex_hull([(p[0], p[1]) for p in part]))
        return out

    def write_gltf(self, path):
        buffer = bytearray()
        accessors, views, primitives, materials, textures, images = [], [], [], [], [], []

        def store(fmt, rows, kind, component, target, bounds=False):
            while len(buffer) % 4:
                buffer.append(0)
            start = len(buffer)
            for row in rows:
                buffer.extend(struct.pack(fmt, *row))
            views.append({"buffer": 0, "byteOffset": start, "byteLength": len(buffer) - start, "target": target})
            acc = {"bufferView": len(views) - 1, "componentType": component, "count": len(rows), "type": kind}
            if bounds:   # of the numbers as stored, so that they hold exactly
                stored = [struct.unpack(fmt, struct.pack(fmt, *r)) for r in rows]
                acc["min"] = [min(r[i] for r in stored) for i in range(3)]
                acc["max"] = [max(r[i] for r in stored) for i in range(3)]
            accessors.append(acc)
            return len(accessors) - 1

        for mat, faces in self.faces.items():
            if not faces:
                continue
            points, normals, uvs, indices = [], [], [], []
            for corners, coords, n in faces:
                base = len(points)
                for (x, y, z), t in zip(corners, coords):
                    points.append((x, z, -y))
                    normals.append((n[0], n[2], -n[1]))
                    uvs.append(t)
                for i in range(1, len(corners) - 1):
                    indices += [(base,), (base + i,), (base + i + 1,)]
            images.append({"uri": self.textures[mat]})
            textures.append({"sampler": 0, "source": len(images) - 1})
            materials.append({"name": mat, "pbrMetallicRoughness": {
                "baseColorTexture": {"index": len(textures) - 1}, "metallicFactor": 0.0, "roughnessFactor": 1.0}})
            primitives.append({
                "attributes": {"POSITION": store("<3f", points, "VEC3", 5126, 34962, True),
                               "NORMAL": store("<3f", normals, "VEC3", 5126, 34962),
                               "TEXCOORD_0": store("<2f", uvs, "VEC2", 5126, 34962)},
                "indices": store("<H", indices, "SCALAR", 5123, 34963), "material": len(materials) - 1})
        document = {
            "asset": {"version": "2.0", "generator": "assets/generate.py", "copyright": "BSD-3-Clause, Panoptes"},
            "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": self.name}],
            "meshes": [{"name": self.name, "primitives": primitives}],
            "materials": materials, "textures": textures, "images": images,
            "samplers": [{"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}],
            "accessors": accessors, "bufferViews": views,
            "buffers": [{"byteLength": len(buffer), "uri": "data:application/octet-stream;base64,"
                         + base64.b64encode(bytes(buffer)).decode()}],
        }
        with open(path, "w", encoding="utf-8") as f:
            json.dump(document, f, separators=(",", ":"))
            f.write("\n")


def convex_hull(points):
    points = sorted(set(points))
    if len(points) < 3:
        return points

    def half(seq):
        out = []
        for p in seq:
            while len(out) >= 2 and ((out[-1][0] - out[-2][0]) * (p[1] - out[-2][1])
                                     - (out[-1][1] - out[-2][1]) * (p[0] - out[-2][0])) <= 0:
                out.pop()
            out.append(p)
        return out[:-1]
    return half(points) + half(reversed(points))
