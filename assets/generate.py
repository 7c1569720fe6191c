# SPDX-License-Identifier: BSD-3-Clause
"""Makes the synthetic office: meshes and textures in assets/office/, and scenes/worlds/office.yaml.

    python3 assets/generate.py [--meshes-only]

Plain Python 3, nothing to install, the same output every time.
"""

import os
import sys
from concurrent.futures import ProcessPoolExecutor

from furniture import all_meshes
from layout import place, world_yaml
from room import room
from textures import TEXTURES, paint_and_save

HERE = os.path.dirname(os.path.abspath(__file__))


def main():
    out = os.path.join(HERE, "office")
    world = os.path.join(HERE, "..", "scenes", "worlds", "office.yaml")
    os.makedirs(out, exist_ok=True)
    os.makedirs(os.path.dirname(world), exist_ok=True)
    if "--meshes-only" not in sys.argv[1:]:
        with ProcessPoolExecutor() as pool:
            list(pool.map(paint_and_save, [(name, os.path.join(out, name + ".png")) for name in TEXTURES]))
    meshes = {m.name: m for m in [room()] + all_meshes()}
    objects = place()
    used = {o[1] for o in objects}
    for old in os.listdir(out):
        if old.endswith(".gltf") and old[:-5] not in used or old.endswith(".png") and old[:-4] not in TEXTURES:
            os.remove(os.path.join(out, old))
    for name in sorted(used):
        meshes[name].write_gltf(os.path.join(out, name + ".gltf"))
    with open(world, "w", encoding="utf-8") as f:
        f.write(world_yaml(objects, meshes))
    triangles = sum(meshes[o[1]].triangles() for o in objects)
    size = sum(os.path.getsize(os.path.join(out, f)) for f in os.listdir(out))
    print(f"{len(TEXTURES)} textures, {len(used)} meshes, {len(objects)} objects, {triangles} triangles, "
          f"{size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
