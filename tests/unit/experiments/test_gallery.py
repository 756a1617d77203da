"""Every plugin that changes a picture has one in the gallery, and the page shows it."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

from equaltime.images.image_files import read as read_picture
from equaltime.scene.model import PLUGINS

GALLERY = Path(__file__).parents[3] / "scenes" / "gallery"
KINDS = {"shape", "bsdf", "texture", "emitter", "volume", "medium", "phase", "sensor", "rfilter", "integrator"}
SEEN_WITH_OTHERS = {"shapegroup", "volpath", "volpathmis", "moment"}
"""In the picture of an instance; and integrators that make the same picture as `path`."""
SPECTRA = {"blackbody", "d65", "irregular", "rawconstant", "regular", "srgb", "uniform"}
"""Are colours."""


def test_every_plugin_has_a_picture() -> None:
    wanted = {name for name, plugin in PLUGINS.items() if plugin.kind in KINDS} - SEEN_WITH_OTHERS - SPECTRA
    assert wanted <= {path.stem for path in GALLERY.glob("*.jpg")}


def test_every_picture_is_on_the_page_and_all_are_small() -> None:
    page = (GALLERY.parent / "README.md").read_text()
    pictures = list(GALLERY.glob("*.jpg"))
    assert [path.name for path in pictures if f'src="gallery/{path.name}"' not in page] == []
    assert page.count('src="gallery/') == len(pictures)
    assert sum(path.stat().st_size for path in pictures) < 1.5e6


def test_the_pictures_are_made_by_their_scripts(tmp_path: Path) -> None:
    gallery = tmp_path / "scenes" / "gallery"
    shutil.copytree(GALLERY.parent, gallery.parent)
    learn = gallery.parent / "learn"
    made = [gallery / "plastic.jpg", tmp_path / "errors.png", learn / "both.jpg"]
    before = [made[0].read_bytes(), made[2].read_bytes()]
    scripts = (
        [gallery / "make.py", "--spp", "1", "plastic"],
        [gallery / "errors.py", "--size", "16", "--errors", "0.9", "0.5", "--to", made[1]],
        [learn / "make.py", "--size", "16", "--reference", "8", "both"],
    )
    for script in scripts:
        subprocess.run([sys.executable, *map(str, script)], check=True, capture_output=True)
    assert before[0] != made[0].read_bytes()
    assert before[1] != made[2].read_bytes()
    assert read_picture(made[1]).image.shape == (16, 32, 3)


def test_the_page_to_learn_from_has_a_table_below_every_picture() -> None:
    page = (GALLERY.parent / "learn" / "README.md").read_text()
    rows = re.findall(r"<!-- (\w+) -->\n!\[.*\]\((\w+)\.jpg\)\n\n\| from left to right \|", page)
    assert rows
    assert all(name == picture for name, picture in rows)
    assert {name for name, _ in rows} == {path.stem for path in (GALLERY.parent / "learn").glob("*.jpg")}
