"""Pages with pictures: every plugin that changes a picture has one; scripts make the pictures; pages show them."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import equaltime as et
from equaltime.experiments.model.reader import read_experiment
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


def test_the_commands_and_edits_of_the_page_on_rendering_work_and_make_its_pictures(tmp_path: Path) -> None:
    folder = tmp_path / "scenes" / "render"
    shutil.copytree(GALLERY.parent / "render", folder)
    page, pictures = (folder / "README.md").read_text(), sorted(folder.glob("*.jpg"))
    assert set(re.findall(r"\]\((\w+\.jpg)\)", page)) == {path.name for path in pictures}
    assert sum(path.stat().st_size for path in pictures) < 1e6
    assert max(path.stat().st_size for path in pictures) < 150e3
    before = [path.read_bytes() for path in pictures]
    done = subprocess.run([sys.executable, folder / "make.py", "--quick"], capture_output=True, text=True, check=True)
    assert all(path.read_bytes() != old for path, old in zip(pictures, before, strict=True))
    commands = re.findall(r"^equaltime .*$", page, re.MULTILINE)
    assert done.stdout.count("$ equaltime ") >= len(commands) > 10


def test_the_model_of_the_page_on_rendering_is_made_by_its_script(tmp_path: Path) -> None:
    kept, made = GALLERY.parent / "render" / "windmill.glb", tmp_path / "windmill.glb"
    subprocess.run([sys.executable, kept.with_name("model.py"), made], check=True)
    old, new = et.load(kept), et.load(made)
    assert [shape.type for shape in old.model.shapes] == [shape.type for shape in new.model.shapes]
    assert made.stat().st_size == kept.stat().st_size


def test_the_page_to_learn_from_has_a_table_below_every_picture() -> None:
    page = (GALLERY.parent / "learn" / "README.md").read_text()
    rows = re.findall(r"<!-- (\w+) -->\n!\[.*\]\((\w+)\.jpg\)\n\n\| from left to right \|", page)
    assert rows
    assert all(name == picture for name, picture in rows)
    assert {name for name, _ in rows} == {path.stem for path in (GALLERY.parent / "learn").glob("*.jpg")}


def test_the_page_of_renderers_has_a_row_for_each_renderer_on_each_scene() -> None:
    page = (GALLERY.parent / "renderers" / "README.md").read_text()
    experiment = read_experiment(GALLERY.parent / "experiments" / "against-mitsuba.toml")
    heading, *renderers = re.findall(r"^\| [^|]* \| ([^|]+) \|", page, re.MULTILINE)
    assert heading == "renderer"
    assert renderers == [entry.label for entry in experiment.strategies] * len(experiment.scenes)
