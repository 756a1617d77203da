"""A renderer of your own, in NumPy: ``own_renderer.py SCENE.json SPP SEED OUT.pfm``, for own-renderer.toml.

It knows one diffuse sphere in a constant sky, and samples directions uniformly: what the presets call naive.
"""

import json
import sys
from pathlib import Path
from time import perf_counter, process_time

import numpy as np


def render(scene, spp, seed):
    """Return the mean of `spp` samples a pixel, (height, width, 3)."""
    film, camera = scene["sensor"]["film"], np.array(scene["sensor"]["to_world"])
    parts = {part["type"]: part for part in scene.values() if isinstance(part, dict)}
    if not {"sphere", "constant"} <= parts.keys():
        sys.exit("own_renderer.py renders one diffuse sphere in a constant sky, and no other scene")
    ball, sky = parts["sphere"], parts["constant"]
    albedo = np.array(scene[ball["bsdf"]["id"]]["reflectance"]["value"])
    radiance = np.array(sky["radiance"]["value"])
    width, height = film["width"], film["height"]
    half = np.tan(np.radians(scene["sensor"]["fov"]) / 2)
    rng = np.random.default_rng(seed)
    total = np.zeros((height, width, 3))
    for _ in range(spp):
        # a point in the pixel, which is what a box filter is; +x is to the left of the image, +y up
        x = (np.arange(width) + rng.random((height, width))) / width
        y = (np.arange(height)[:, None] + rng.random((height, width))) / height
        d = np.stack([(1 - 2 * x) * half, (1 - 2 * y) * half * height / width, np.ones_like(x)], axis=-1)
        d = unit(d) @ camera[:3, :3].T
        offset = camera[:3, 3] - ball["center"]
        b = d @ offset
        square = b**2 - offset @ offset + ball["radius"] ** 2
        hit = square > 0
        normal = (offset + (-b - np.sqrt(np.where(hit, square, 0)))[..., None] * d) / ball["radius"]
        wi = unit(rng.normal(size=d.shape))  # on the sphere; taken to the normal's side, pdf 1 / (2 pi)
        cosine = np.abs((wi * normal).sum(axis=-1))[..., None]
        total += np.where(hit[..., None], albedo / np.pi * cosine * radiance * (2 * np.pi), radiance)
    return total / spp


def unit(vectors):
    """Return vectors of length 1."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


if __name__ == "__main__":
    scene, begin, cpu_begin = json.loads(Path(sys.argv[1]).read_text()), perf_counter(), process_time()
    image = render(scene, int(sys.argv[2]), int(sys.argv[3]))
    times = {"seconds": perf_counter() - begin, "cpu_seconds": process_time() - cpu_begin}
    header = f"PF\n{image.shape[1]} {image.shape[0]}\n-1.0\n".encode()
    Path(sys.argv[4]).write_bytes(header + image[::-1].astype("<f4").tobytes())  # the format begins at the bottom
    sys.stdout.write(json.dumps(times))  # of rendering alone; without them, all of the process counts
