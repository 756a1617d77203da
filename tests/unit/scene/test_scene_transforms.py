"""Transforms as users write them."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from equaltime.scene import transforms as t

coordinate = st.floats(-10.0, 10.0)
vector = st.tuples(coordinate, coordinate, coordinate)


def apply(matrix: np.ndarray, point: tuple[float, float, float]) -> np.ndarray:
    return matrix[:3, :3] @ point + matrix[:3, 3]


def test_steps_are_applied_in_the_order_in_which_they_are_written() -> None:
    steps = [{"scale": 2}, {"rotate": {"axis": [0, 0, 1], "angle": 90}}, {"translate": [1, 0, 0]}]
    assert apply(t.parse(steps), (1, 0, 0)) == pytest.approx((1, 2, 0))
    assert apply(t.parse(steps[::-1]), (1, 0, 0)) == pytest.approx((0, 4, 0))


def test_a_rotation_turns_counter_clockwise_about_its_axis() -> None:
    assert apply(t.rotate([0, 0, 5], 90), (1, 0, 0)) == pytest.approx((0, 1, 0))
    assert apply(t.rotate([0, 1, 0], 90), (0, 0, 1)) == pytest.approx((1, 0, 0))
    assert apply(t.rotate([1, 0, 0], -90), (0, 0, 1)) == pytest.approx((0, 1, 0))


@given(axis=vector.filter(lambda v: np.linalg.norm(v) > 1e-3), angle=st.floats(-720, 720), point=vector)
def test_a_rotation_keeps_lengths_and_its_axis(axis: tuple, angle: float, point: tuple) -> None:
    rotation = t.rotate(axis, angle)
    assert rotation[:3, :3] @ rotation[:3, :3].T == pytest.approx(np.eye(3), abs=1e-14)
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    assert apply(rotation, axis) == pytest.approx(np.array(axis), abs=1e-12)


def test_looking_along_minus_z_puts_minus_x_to_the_left_of_the_image() -> None:
    camera = t.look_at([0, 1, 6.8], [0, 1, 0], [0, 1, 0])
    assert camera == pytest.approx(np.array([[-1, 0, 0, 0], [0, 1, 0, 1], [0, 0, -1, 6.8], [0, 0, 0, 1]]))


@given(origin=vector, target=vector)
def test_looking_without_an_up_direction_gives_some_right_handed_frame(origin: tuple, target: tuple) -> None:
    if np.linalg.norm(np.subtract(target, origin)) < 1e-3:
        return
    camera = t.look_at(origin, target)
    assert camera[:3, :3] @ camera[:3, :3].T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(camera[:3, :3]) == pytest.approx(1.0)
    distance = np.linalg.norm(np.subtract(target, origin))
    assert apply(camera, (0, 0, distance)) == pytest.approx(np.array(target), abs=1e-9)


def test_looking_without_an_up_direction_does_as_mitsuba() -> None:
    of_mitsuba = [[0.0792865, 0.960357, 0.267261], [-0.841427, -0.0792865, 0.534522], [0.534522, -0.267261, 0.801784]]
    assert t.look_at([0, 0, 0], [1, 2, 3])[:3, :3] == pytest.approx(np.array(of_mitsuba), abs=1e-6)


def test_a_matrix_is_given_row_by_row_and_nine_numbers_are_its_linear_part() -> None:
    assert t.matrix(range(16))[0].tolist() == [0, 1, 2, 3]
    assert t.matrix(range(9))[1].tolist() == [3, 4, 5, 0]
    assert t.parse({"matrix": np.eye(4).tolist()}).tolist() == np.eye(4).tolist()


@pytest.mark.parametrize(
    "value",
    [
        np.diag([2.0, 2.0, 2.0, 1.0]),
        np.diag([2.0, 2.0, 2.0, 1.0]).tolist(),
        SimpleNamespace(matrix=np.diag([2.0, 2.0, 2.0, 1.0])),
        SimpleNamespace(matrix=np.diag([2.0, 2.0, 2.0, 1.0])[..., None]),
        {"scale": 2},
        [{"scale": [2, 2, 2]}],
        ({"scale": 4}, {"scale": 0.5}),
    ],
)
def test_a_transform_can_be_written_in_many_ways(value: object) -> None:
    assert t.parse(value).tolist() == np.diag([2.0, 2.0, 2.0, 1.0]).tolist()


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([{"rotat": 3}], "unknown transform step 'rotat'; did you mean 'rotate'"),
        ([{"translate": [0, 1]}], "translate: expected 3 numbers, found 2"),
        ([{"translate": [0, 1, "2"]}], "translate: expected finite numbers"),
        ([{"scale": float("inf")}], "scale: expected finite numbers"),
        ([{"rotate": {"axis": [0, 0, 0], "angle": 30}}], "axis of a rotation must have a direction"),
        ([{"rotate": {"axis": [0, 0, 1]}}], "rotate: expected a table with angle, axis"),
        ([{"rotate": {"axis": [0, 0, 1], "angle": 3, "x": 1}}], "expected a table with"),
        ([{"look_at": {"origin": [0, 0, 0], "target": [0, 0, 0]}}], "target that is not its origin"),
        ([{"look_at": {"origin": [0, 0, 0], "target": [0, 2, 0], "up": [0, 1, 0]}}], "along the line of sight"),
        ([{"scale": 1, "translate": [0, 0, 0]}], "a step of a transform has one key, found scale, translate"),
        ([{}], "one key, found none"),
        ({"matrix": [1, 2, 3]}, "matrix: expected 9 or 16 numbers, found 3"),
        ([1, 2, 3], "expected a 4x4 matrix or a list of steps"),
        ("up", "expected a 4x4 matrix"),
        (None, "expected a 4x4 matrix"),
        ([], "expected a 4x4 matrix"),
    ],
)
def test_a_mistake_in_a_transform_is_said_in_words(value: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        t.parse(value)
