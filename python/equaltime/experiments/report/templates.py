"""Renders templates to pages: one file each, with style and script inside, written atomically."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Any

from equaltime.experiments.report.looks import DARK, LIGHT
from equaltime.extras import optional
from equaltime.files import replacing
from equaltime.images.image_files import SOFTWARE

__all__ = ["write_page"]

_PALETTES = (("all", LIGHT), ("screen and (prefers-color-scheme: dark)", DARK))


def write_page(template: str, path: Path, **values: object) -> Path:
    """Fill in a template and replace ``path`` by it atomically, so that a reader never sees half a page."""
    jinja: Any = optional("jinja2")
    markup: Any = optional("markupsafe").Markup
    files = resources.files(__package__) / "template"
    environment = jinja.Environment(
        loader=jinja.FunctionLoader(lambda name: (files / name).read_text("utf-8")),
        autoescape=True,
        undefined=jinja.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    text = environment.get_template(template).render(
        software=SOFTWARE,
        style=markup((files / "style.css").read_text("utf-8")),
        script=markup((files / "page.js").read_text("utf-8")),
        palettes=_PALETTES,
        **values,
    )
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path
