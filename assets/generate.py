# SPDX-License-Identifier: BSD-3-Clause
"""Makes the synthetic office: meshes and textures in assets/office/, and its two worlds in scenes/worlds/.

    python3 assets/generate.py [--meshes-only]

Plain Python 3, nothing to install, the same output every time.
"""

import os
import sys
from concurrent.futures import ProcessPoolExecutor

from furniture import all_meshes
from layout import place, with_overhangs, world_yaml
from room import room
from textures import TEXTURES, paint_and_save

HERE = os.path.dirname(os.path.abspath(__file__))


def main():
    out = os.path.join(HERE, "office")
    worlds = os.path.join(HERE, "..", "scenes", "worlds")
    os.makedirs(out, exist_ok=True)
    os.makedirs(worlds, exist_ok=True)
    if "--meshes-only" not in sys.argv[1:]:
        with ProcessPoolExecutor() as pool:
            list(pool.map(paint_and_save, [(name, os.path.join(out, name + ".png")) for name in TEXTURES]))
    meshes = {m.name: m for m in [room()] + all_meshes()}
    objects = place()
    for old in os.listdir(out):
        if old.endswith(".gltf") and old[:-5] not in meshes or old.endswith(".png") and old[:-4] not in TEXTURES:
            os.remove(os.path.join(out, old))
    for name in sorted(meshes):
        meshes[name].write_gltf(os.path.join(out, name + ".gltf"))
    for name, what, things in (
            ("office", "A 10 m x 10 m office with rows of desks that look alike, aisles down to 0.9 m, and two carpets.",
             objects),
            ("office-overhangs", "The same office with desks on legs, table edges and seats that reach over the floor.",
             with_overhangs(objects))):
        with open(os.path.join(worlds, name + ".yaml"), "w", encoding="utf-8") as f:
            f.write(world_yaml(name, what, things, meshes))
        print(f"{name}: {len(things)} objects, {sum(meshes[o[1]].triangles() for o in things)} triangles")
    size = sum(os.path.getsize(os.path.join(out, f)) for f in os.listdir(out))
    print(f"{len(TEXTURES)} textures, {len(meshes)} meshes, {size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
