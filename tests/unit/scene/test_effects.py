"""Scene → effects: derived with reasons; what does nothing calls for nothing, and changes no bit."""

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
import pytest

import equaltime as et
from equaltime.images import image_files as images
from equaltime.pricing import derive, leave_out
from equaltime.rendering.core import make_renderer
from equaltime.scene.effects.kinds import KINDS

ROOT = Path(__file__).parents[3]
SHIPPED = sorted(path for path in (ROOT / "scenes").rglob("*.toml") if "experiments" not in path.parts)
GREY: dict[str, Any] = {"type": "diffuse"}
FLAT = {"type": "checkerboard", "color0": [0.5, 0.5, 1.0], "color1": [0.5, 0.5, 1.0]}
SQUARES = {"type": "checkerboard", "color0": [0.8, 0.2, 0.2], "color1": [0.2, 0.2, 0.2]}
CHECKED = {"type": "diffuse", "reflectance": SQUARES}
RED = {"type": "rgb", "value": [0.8, 0.2, 0.2]}


def rgb(*values: float) -> dict[str, Any]:
    return {"type": "rgb", "value": list(values)}


def scene(bsdf: Any = GREY, sensor: Any = None, depth: int = -1, **more: Any) -> et.Scene:
    """A floor under a rectangular lamp, whose BSDF, camera and lights may be others."""
    film = {"type": "hdrfilm", "width": 12, "height": 8, "rfilter": {"type": "box"}}
    camera = {"type": "perspective", "fov": 50.0, **(sensor or {}), "film": film}
    camera["to_world"] = [{"look_at": {"origin": [0, -3, 2], "target": [0, 0, 0.3], "up": [0, 0, 1]}}]
    down = np.diag([0.4, -0.4, -1.0, 1.0])
    down[2, 3] = 2.5
    lamp = {"type": "rectangle", "to_world": down.tolist(), "bsdf": GREY, "emitter": {"type": "area", **BRIGHT}}
    floor = {"type": "rectangle", "bsdf": bsdf}
    integrator = {"type": "path", "max_depth": depth}
    return et.load_dict(
        {"type": "scene", "integrator": integrator, "camera": camera, "lamp": lamp, "floor": floor, **more}
    )


BRIGHT = {"radiance": rgb(8.0, 8.0, 8.0)}


def pane(bsdf: Any) -> dict[str, Any]:
    above = np.eye(4)
    above[2, 3] = 0.5
    return {"type": "rectangle", "to_world": above.tolist(), "bsdf": bsdf}


def bits(scene: et.Scene) -> bytes:
    renderer = make_renderer(scene, et.Strategy(), 3, 1)
    renderer.advance(4)
    return bytes(renderer.moments.tobytes())


def exr(path: Path, color: tuple[float, float, float]) -> str:
    images.write_exr(path, np.broadcast_to(np.array(color, np.float32), (48, 64, 3)))  # 36 kB of texels
    return str(path)


def ramp(path: Path) -> str:
    images.write_exr(path, np.broadcast_to(np.linspace(0.0, 1.0, 4, dtype=np.float32)[:, None], (3, 4, 3)))
    return str(path)


def png(path: Path, color: tuple[int, int, int]) -> str:
    buffer = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(4, 3, 3, "uint8"))
    OpenImageIO.ImageBufAlgo.fill(buffer, tuple(c / 255.0 for c in color))
    assert buffer.write(str(path))
    return str(path)


def inert(folder: Path) -> dict[str, tuple[et.Scene, et.Scene]]:
    """Scenes with an element that does nothing, each with the same scene without it."""
    plain = scene()
    open_pane = pane({"type": "mask", "opacity": 0.0, "bsdf": GREY})
    same_ior = {"type": "dielectric", "int_ior": 1.33, "ext_ior": 1.33}
    dark = {"type": "point", "position": [0, 0, 1], "intensity": rgb(0, 0, 0)}
    dark_lamp = {**pane(GREY), "emitter": {"type": "area", "radiance": rgb(0, 0, 0)}}
    flat = exr(folder / "flat.exr", (0.5, 0.5, 1.0))
    one_color = {"type": "bitmap", "filename": exr(folder / "one.exr", (0.75, 0.25, 0.25)), "raw": True}
    black = {"type": "envmap", "filename": exr(folder / "black.exr", (0.0, 0.0, 0.0))}
    white = {"type": "envmap", "filename": exr(folder / "white.exr", (1.0, 1.0, 1.0)), "scale": 0.0}
    shadowless = {"type": "thindielectric", "int_ior": 1.0, "ext_ior": 1.0}
    bent = {"type": "normalmap", "bsdf": GREY, "normalmap": {"type": "bitmap", "filename": flat, "raw": True}}
    half_blend = {"type": "blendbsdf", "weight": 0.5, "a": GREY, "b": {"type": "diffuse"}}
    nothing_blend = {"type": "blendbsdf", "weight": 0.0, "a": GREY, "b": {"type": "conductor"}}
    slope = {"type": "bitmap", "filename": ramp(folder / "slope.exr"), "raw": True}
    height = {"type": "bumpmap", "bsdf": GREY, "texture": slope, "scale": 0.0}
    even = {"type": "bumpmap", "bsdf": GREY, "texture": FLAT}
    steps = {"type": "bumpmap", "bsdf": GREY, "texture": SQUARES}
    return {
        "a checkerboard of one colour": (
            scene({"type": "diffuse", "reflectance": {**SQUARES, "color1": SQUARES["color0"]}}),
            scene({"type": "diffuse", "reflectance": RED}),
        ),
        "a bitmap of one colour": (
            scene({"type": "diffuse", "reflectance": one_color}),
            scene({"type": "diffuse", "reflectance": rgb(0.75, 0.25, 0.25)}),
        ),
        "a lens of no aperture": (
            scene(sensor={"type": "thinlens", "aperture_radius": 0.0, "focus_distance": 2.0}),
            plain,
        ),
        "a light of no power": (scene(light=dark), plain),
        "a spot of no power": (scene(light={"type": "spot", "intensity": rgb(0, 0, 0)}), plain),
        "a sun of no power": (scene(light={"type": "directional", "irradiance": rgb(0, 0, 0)}), plain),
        "a lamp of no power": (scene(other=dark_lamp), scene(other=pane(GREY))),
        "a black environment": (scene(sky={"type": "constant", "radiance": rgb(0, 0, 0)}), plain),
        "a black image around": (scene(sky=black), plain),
        "an image around of scale 0": (scene(sky=white), plain),
        "glass of the air's own index": (scene(pane=pane(same_ior)), plain),
        "a thin pane of index 1": (scene(pane=pane(shadowless)), plain),
        "a mask that is open": (scene(pane=open_pane), plain),
        "a surface of nothing": (scene(pane=pane({"type": "null"})), plain),
        "a mask that is opaque": (scene({"type": "mask", "opacity": 1.0, "bsdf": GREY}), plain),
        "a blend with none of the second": (scene(nothing_blend), plain),
        "a blend of twice the same": (scene(half_blend), plain),
        "a flat normal map": (scene({"type": "normalmap", "bsdf": GREY, "normalmap": FLAT}), plain),
        "a flat image of normals": (scene(bent), plain),
        "a bump map of scale 0": (scene(height), plain),
        "a bump map of one height": (scene(even), plain),
        "a bump map of squares, which have no slope": (scene(steps), plain),
        "a roughness that is the same both ways": (
            scene({"type": "roughconductor", "alpha_u": 0.2, "alpha_v": 0.2}),
            scene({"type": "roughconductor", "alpha": 0.2}),
        ),
    }


def test_what_does_nothing_calls_for_nothing_and_changes_no_bit(tmp_path: Path) -> None:
    cases = inert(tmp_path).items()
    assert [what for what, (it, none) in cases if derive(it).keys() != derive(none).keys()] == []
    assert [what for what, (it, none) in cases if it.core.effects() != none.core.effects()] == []
    assert [what for what, (it, none) in cases if bits(it) != bits(none)] == []
    # a texture of one colour leaves its record, without its texels, and a mask the records of its parts
    assert [what for what, (it, none) in cases if it.core.memory_bytes - none.core.memory_bytes > 4096] == []


def test_what_nearly_does_nothing_is_left_in(tmp_path: Path) -> None:
    slope = {"type": "bitmap", "filename": ramp(tmp_path / "slope.exr"), "raw": True}
    assert "normal_maps" in derive(scene({"type": "bumpmap", "bsdf": GREY, "texture": slope}))
    leaning = {"type": "bitmap", "filename": png(tmp_path / "n.png", (128, 128, 255)), "raw": True}
    assert "normal_maps" in derive(scene({"type": "normalmap", "bsdf": GREY, "normalmap": leaning}))
    assert "specular" in derive(scene(pane=pane({"type": "dielectric", "int_ior": 1.001, "ext_ior": 1.0})))
    tinted = {"type": "dielectric", "int_ior": 1.0, "ext_ior": 1.0, "specular_transmittance": RED}
    assert "specular" in derive(scene(pane=pane(tinted)))
    assert "masks" in derive(scene({"type": "mask", "opacity": 0.999, "bsdf": GREY}))


def test_a_surface_of_nothing_stays_where_it_counts_as_a_vertex_or_is_asked_for() -> None:
    assert "masks" in derive(scene(depth=4, pane=pane({"type": "null"})))
    assert scene(depth=4, pane=pane({"type": "null"})).core.shapes == 3
    assert scene(pane=pane({"type": "null"})).core.shapes == 2


def test_a_complaint_names_the_shape_though_one_before_it_is_folded_away() -> None:
    flat = {**pane(GREY), "to_world": np.diag([1.0, 0.0, 1.0, 1.0]).tolist()}
    with pytest.raises(et.SceneError, match="flat"):
        _ = scene(pane=pane({"type": "null"}), flat=flat).core


def test_reasons_name_file_line_and_element(tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(
        '[camera]\ntype = "thinlens"\naperture_radius = 0.1\n[ball]\ntype = "sphere"\n'
        '[ball.bsdf]\ntype = "dielectric"\n[sky]\ntype = "constant"\n'
    )
    reasons = derive(et.load(file).with_(size=(8, 6), max_depth=9))
    assert list(reasons) == ["analytic_shapes", "specular", "environment", "lens", "long_paths"]
    assert reasons["long_paths"][0].what == "paths of up to 9 segments"
    assert [str(reasons[name][0]) for name in ("analytic_shapes", "specular", "environment", "lens")] == [
        f"{file}:4: ball: shape 'sphere'",
        f"{file}:6: ball.bsdf: bsdf 'dielectric'",
        f"{file}:8: sky: emitter 'constant'",
        f"{file}:1: camera: sensor 'thinlens'",
    ]


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: str(path.relative_to(ROOT / "scenes")))
def test_every_effect_that_the_core_sees_in_a_shipped_scene_has_a_reason(path: Path) -> None:
    loaded = et.load(path)
    for name, reasons in derive(loaded).items():
        assert all(str(path) in reason.place or path.suffix != ".toml" for reason in reasons[:1]), (name, reasons)
        assert reasons[0].what != "the scene as a whole", name


def test_every_effect_of_the_core_is_known_by_name() -> None:
    assert scene().core.effects().keys() <= KINDS.keys()


@pytest.mark.parametrize(
    ("bsdf", "name", "instead"),
    [
        (
            {"type": "diffuse", "reflectance": SQUARES},
            "textures",
            {"type": "diffuse", "reflectance": rgb(0.5, 0.2, 0.2)},
        ),
        ({"type": "mask", "opacity": 0.5, "bsdf": GREY}, "masks", GREY),
        ({"type": "normalmap", "bsdf": GREY, "normalmap": SQUARES}, "normal_maps", GREY),
    ],
)
def test_an_effect_is_left_out_as_it_says(bsdf: Any, name: str, instead: Any) -> None:
    whole = scene(bsdf)
    assert name in derive(whole)
    less, strategy = leave_out(whole, et.Strategy(), (name,))
    assert name not in derive(less)
    assert strategy == et.Strategy()
    assert bits(less) == bits(scene(instead))


def test_a_lens_an_environment_and_long_paths_are_left_out_together() -> None:
    lens = {"type": "thinlens", "aperture_radius": 0.2, "focus_distance": 2.0}
    whole = scene(sensor=lens, sky={"type": "constant"})
    less, strategy = leave_out(whole, et.Strategy(), ("lens", "environment", "long_paths=3"))
    assert bits(less) == bits(scene())
    assert strategy.truncate == 3
    assert strategy.biased


@pytest.mark.filterwarnings("ignore:the picture is black")
def test_a_slide_is_a_texture_and_left_out_it_is_its_mean() -> None:
    lamp = {"type": "spot", "intensity": rgb(4, 2, 1), "to_world": [{"translate": [0, 0, -3]}]}
    whole = scene(lamp=lamp | {"texture": SQUARES})
    assert whole.core.effects()["textures"]
    assert [str(reason) for reason in derive(whole)["textures"]] == ["lamp.texture: texture 'checkerboard'"]
    (plain,) = leave_out(whole, et.Strategy(), ("textures",))[0].model.emitters
    mean = np.mean([SQUARES["color0"], SQUARES["color1"]], axis=0)
    assert plain.texture is None  # type: ignore[union-attr]
    np.testing.assert_allclose(plain.intensity, mean * (4, 2, 1))  # type: ignore[union-attr]
    even = scene(lamp=lamp | {"texture": {"type": "checkerboard", "color0": 0.5, "color1": 0.5}})
    assert not even.core.effects()["textures"]
    half = scene(lamp=lamp | {"intensity": rgb(2, 1, 0.5)})
    assert (et.render(even, spp=2).image == et.render(half, spp=2).image).all()


def test_what_a_scene_does_not_have_leaves_it_as_it_is() -> None:
    whole = scene()
    assert leave_out(whole, et.Strategy(), ("lens", "textures", "masks", "media"))[0] is whole


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("lense", "unknown effect 'lense'; did you mean 'lens'?"),
        ("specular", "the effect 'specular' cannot be left out; expected one of environment, lens, "),
        ("long_paths=0", "'long_paths=0': expected the name alone, or long_paths=K with a depth K of at least 1"),
    ],
)
def test_what_cannot_be_left_out_is_refused(name: str, message: str) -> None:
    with pytest.raises(et.EffectError) as caught:
        leave_out(scene(), et.Strategy(), (name,))
    assert str(caught.value).startswith(message)


def test_glass_of_the_airs_own_index_is_there_where_its_crossings_count_or_light_is_aimed() -> None:
    """It is a vertex also for `volpath`; lights that no ray meets do not shine through it, at any depth of paths."""
    glass = pane({"type": "dielectric", "int_ior": 1.33, "ext_ior": 1.33})
    bulb = {"type": "point", "position": [0, 0, 3]}
    for kind, depth, light, there in (("volpath", 4, None, 2), ("path", -1, bulb, 2), ("path", -1, None, 1)):
        integrator = {"type": kind, "max_depth": depth}
        found = scene(integrator=integrator, pane=glass, **({} if light is None else {"light": light}))
        assert found.core.shapes - scene(integrator=integrator).core.shapes == there - 1, (kind, depth)


def test_a_sheet_of_the_airs_own_index_is_not_there_where_crossings_are_no_vertices() -> None:
    """Lights that no ray meets shine through it then."""
    glass = pane({"type": "thindielectric", "int_ior": 1.33, "ext_ior": 1.33})
    bulb = {"type": "point", "position": [0, 0, 3]}
    for kind, there in (("volpath", 0), ("path", 1)):
        integrator = {"type": kind, "max_depth": 4}
        found, bare = (scene(integrator=integrator, light=bulb, **more) for more in ({"pane": glass}, {}))
        assert found.core.shapes - bare.core.shapes == there, kind
        assert (bits(found) == bits(bare)) == (kind == "volpath")


def test_thin_glass_calls_for_what_lets_light_pass_where_crossings_are_no_vertices() -> None:
    for kind in ("volpath", "path"):
        whole = scene(integrator={"type": kind}, pane=pane({"type": "thindielectric"}), light={"type": "point"})
        assert ("masks" in derive(whole)) == (kind == "volpath") == whole.core.effects()["masks"]
