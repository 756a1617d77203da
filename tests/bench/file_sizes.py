"""How large a saved render is by its samples a pixel, and what saving and reading it take.

Cornell's box fills a square of its film, the terrain and its sky all of it. Sizes do not depend on the machine.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from measuring import SCENES, arguments, parsed

import equaltime as et
from equaltime.rendering.render_file import RenderFile

FILES = {"cornell box": SCENES / "cornell-box.toml", "terrain": SCENES / "terrain" / "terrain.toml"}


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--height", type=int, default=1080, help="pixels; the width is 16/9 of it [%(default)s]")
    parser.add_argument("--most", type=int, default=64, help="samples a pixel, of 1, 2, 4, 16, 64 [%(default)s]")
    options = parsed(parser, height=54, most=4)
    size = (options.height * 16 // 9, options.height)
    print("scene          spp    file, MB  small, MB   saving, s  reading, s")
    with tempfile.TemporaryDirectory(prefix="equaltime-") as folder:
        path = Path(folder) / "a.exr"
        for name, file in FILES.items():
            scene = et.load(file).with_(size=size)
            for spp in [count for count in (1, 2, 4, 16, 64) if count <= options.most]:
                result = et.render(scene, spp=spp, threads=options.threads)
                result.save(path, small=True, overwrite=True)
                small = path.stat().st_size
                begin = time.perf_counter()
                result.save(path, overwrite=True)
                middle = time.perf_counter()
                RenderFile.read(path)
                end = time.perf_counter()
                sizes = f"{path.stat().st_size / 1e6:10.1f} {small / 1e6:10.1f}"
                print(f"{name:<12} {spp:5} {sizes}  {middle - begin:10.2f}  {end - middle:10.2f}", flush=True)


if __name__ == "__main__":
    main()
