# SPDX-License-Identifier: BSD-3-Clause
"""What stands and hangs in the corridors. Origins as in home.py."""

from corridors_textures import THINGS
from furniture import part_of
from home import made_of, office_prop, on_wall
from textures import cell


def thing(name):
    return cell(4, THINGS.index(name), rows=2)


def door(name):
    """A closed door in its frame, 1.06 m by 2.14 m."""
    m = made_of(name, leaf="door_" + name[-1], things="things")
    frame = thing("frame")
    m.box(0, -0.48, -1.07, 0.015, 0.48, 1.02, "leaf", uv=(0, 0, 1, 0.02), faces={"+x": ("leaf", None)}, skip=("-x", "-z"))
    for s in (-1, 1):
        a, b = sorted((s * 0.481, s * 0.53))
        m.box(0, a, -1.07, 0.05, b, 1.07, "things", uv=frame, skip=("-x", "-z"))
    m.box(0, -0.4795, 1.021, 0.05, 0.4795, 1.069, "things", uv=part_of(frame, 0, 0, 1, 0.3), skip=("-x",))
    return m


def bench():
    m = made_of("bench", things="things")
    m.box(-0.20, -0.75, 0, 0.20, 0.75, 0.42, "things", uv=thing("plank"), faces={"+x": ("things", thing("plank"))}, skip=("-z", "+z"))
    m.box(-0.22, -0.78, 0.42, 0.22, 0.78, 0.47, "things", uv=part_of(thing("bench"), 0, 0, 1, 0.15), faces={"+z": ("things", thing("bench"))},
          skip=())
    return m


def cabinet(name, depth, width, height, picture):
    m = made_of(name, front=picture, side="things")
    m.box(-depth / 2, -width / 2, 0, depth / 2, width / 2, height, "side", uv=thing("frame"), faces={"+x": ("front", None)})
    return m


def extinguisher():
    """On its stand."""
    m = made_of("extinguisher", things="things")
    red = thing("extinguisher")
    m.prism(0, 0, 0, 0.08, 0.14, 0.12, 10, "things", uv=part_of(red, 0, 0.9, 1, 1), top=("things", part_of(red, 0, 0.75, 1, 0.9)))
    m.prism(0, 0, 0.081, 0.52, 0.085, 0.085, 10, "things", uv=red, skip_top=True)
    m.prism(0, 0, 0.521, 0.60, 0.085, 0.03, 10, "things", uv=part_of(red, 0, 0, 1, 0.15), top=("things", part_of(red, 0, 0.7, 1, 0.8)))
    m.box(-0.02, -0.09, 0.601, 0.02, 0.05, 0.66, "things", uv=part_of(red, 0, 0.75, 1, 0.85), skip=())
    return m


def sand():
    """A cylinder of sand for cigarettes, with a bin."""
    m = made_of("sand", things="things", props="../office/props")
    m.prism(0, 0, 0, 0.62, 0.17, 0.19, 12, "props", uv=office_prop("bin"), top=("things", thing("sand")), wraps=3)
    return m


def all_meshes():
    out = [door("door_" + k) for k in "abcd"]
    out += [on_wall("board_" + k, 1.6, 1.1, 0.04, "board", "board_" + k, (0, 0, 1, 1), (0, 0, 1, 0.02)) for k in "abc"]
    out += [bench(), cabinet("vending", 0.70, 0.95, 1.90, "vending"), cabinet("lockers", 0.44, 1.60, 1.90, "lockers"),
            extinguisher(), sand(),
            on_wall("hose", 0.62, 0.80, 0.16, "things", "things", thing("hose"), part_of(thing("hose"), 0, 0, 1, 0.05))]
    return out
