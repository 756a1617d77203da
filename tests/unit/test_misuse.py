"""The wrong objects for an argument: an error with a sentence, whatever they are."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import equaltime as et

LENS: dict[str, Any] = {"type": "perspective", "film": {"type": "hdrfilm", "width": 2, "height": 2}}


class Silent:
    def __repr__(self) -> str:
        raise OSError("no words")


def endless() -> list[Any]:
    """A list that contains itself."""
    found: list[Any] = []
    found.append(found)
    return found


def doubled(leaf: Any, join: Callable[[Any], Any], levels: int = 40) -> Any:
    for _ in range(levels):
        leaf = join(leaf)
    return leaf


def scene(**parts: Any) -> dict[str, Any]:
    return {"type": "scene", "sensor": LENS, **parts}


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"type": np.array([])}, "expected a dictionary with 'type': 'scene', found array([]"),
        ({"type": np.array(["scene", "scene"])}, "expected a dictionary with 'type': 'scene'"),
        (scene(ball={"type": np.array([])}), "an object needs a 'type' with the name of a plugin"),
        (scene(ball={"type": Silent()}), "with the name of a plugin, found an object of type Silent"),
        (scene(ball={"type": "sphere", "radius": Silent()}), "found an object of type Silent"),
        (scene(ball={"type": "sphere", "center": endless()}), "lists are nested more than 64 deep"),
        (scene(ball={"type": "sphere", "to_world": endless()}), "lists are nested more than 64 deep"),
        (scene(ball={"type": "sphere", "to_world": [{"translate": endless()}]}), "lists are nested more than 64 deep"),
        (scene(ball={"type": endless()}), "with the name of a plugin, found [["),
        (scene(ball={"type": doubled([1], lambda x: [x, x])}), "with the name of a plugin, found [["),
    ],
)
def test_a_scene_of_odd_objects_is_a_scene_error(given: dict[str, Any], words: str) -> None:
    with pytest.raises(et.SceneError) as caught:
        et.load_dict(given)
    assert words in str(caught.value)
    assert len(str(caught.value)) < 300


def test_a_dictionary_that_contains_itself_is_a_scene_error() -> None:
    mask: dict[str, Any] = {"type": "mask"}
    mask["bsdf"] = mask
    with pytest.raises(et.SceneError, match="objects are nested more than 64 deep"):
        et.load_dict(scene(ball={"type": "sphere", "bsdf": mask}))


@pytest.mark.parametrize("given", [None, 5, ["scene"], Silent()])
def test_no_scene_is_a_type_error_with_a_sentence(given: Any) -> None:
    with pytest.raises(TypeError, match="a scene is a Scene, the path of a file or a dictionary; found"):
        et.render(given)
    with pytest.raises(TypeError, match="expected a dictionary with 'type': 'scene', found"):
        et.load_dict(given)


@pytest.mark.parametrize("strategy", [None, 5])
def test_no_strategy_is_a_type_error_with_a_sentence(strategy: Any) -> None:
    with pytest.raises(TypeError, match=r"a strategy is a Strategy, or text such as .*; found (None|5)"):
        et.render(scene(), spp=1, strategy=strategy)


def test_no_image_is_a_type_error() -> None:
    nothing: Any = None
    with pytest.raises(TypeError, match="not NoneType"):
        et.compare(nothing, nothing)


@pytest.mark.parametrize("change", [{"size": (1,)}, {"size": 3}, {"size": (1, 2, 3)}, {"crop": (1, 2)}, {"crop": ()}])
def test_another_number_of_sizes_is_a_value_error_with_a_sentence(change: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"(size is \(width, height\)|crop is \(x, y, width, height\)), found"):
        et.load_dict(scene()).with_(**change)


def test_sizes_may_be_numpys() -> None:
    width, height = np.array([3, 2])
    assert et.load_dict(scene()).with_(size=(width, height)).size == (3, 2)
