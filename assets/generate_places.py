# SPDX-License-Identifier: BSD-3-Clause
"""Makes the meshes and textures of the other places, and the people: assets/{home,corridors,warehouse,street,people}/.

    python3 assets/generate_places.py [PLACE ...] [--meshes-only]

Where things stand there is decided by the generators in sim/world. Plain Python 3, nothing to install, the same output
every time.
"""

import importlib
import os
import random
import sys
from concurrent.futures import ProcessPoolExecutor

HERE = os.path.dirname(os.path.abspath(__file__))
PLACES = ("home", "corridors", "warehouse", "street", "people")


def paint_and_save(job):
    place, name, path = job
    pictures = importlib.import_module(place + "_textures")
    pictures.TEXTURES[name](random.Random(f"{place} {name}")).save(path)


def main():
    wanted = [a for a in sys.argv[1:] if not a.startswith("--")] or PLACES
    jobs = []
    for place in wanted:
        out = os.path.join(HERE, place)
        os.makedirs(out, exist_ok=True)
        names = importlib.import_module(place + "_textures").TEXTURES
        meshes = importlib.import_module(place).all_meshes()
        keep = {name + ".png" for name in names} | {m.name + ".gltf" for m in meshes}
        for old in os.listdir(out):
            if old not in keep:
                os.remove(os.path.join(out, old))
        for m in meshes:
            m.write_gltf(os.path.join(out, m.name + ".gltf"))
        jobs += [(place, name, os.path.join(out, name + ".png")) for name in names]
        print(f"{place}: {len(names)} textures, {len(meshes)} meshes of at most {max(m.triangles() for m in meshes)} triangles")
    if "--meshes-only" not in sys.argv[1:]:
        with ProcessPoolExecutor() as pool:
            list(pool.map(paint_and_save, jobs))


if __name__ == "__main__":
    main()
