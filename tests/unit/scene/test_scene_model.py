"""The model: Mitsuba 3's defaults, and values that make no sense refused."""

import numpy as np
import pytest
from pydantic import ValidationError

from equaltime.scene import model as m

NONUNIFORM = np.diag([1.0, 2.0, 1.0, 1.0])


# -- defaults, as Mitsuba 3.9 prints them ----------------------------------------------------------------------------


def test_defaults_of_bsdfs_are_mitsubas() -> None:
    assert m.Diffuse().reflectance == (0.5, 0.5, 0.5)
    assert (m.Conductor().eta, m.Conductor().k) == ((0.0,) * 3, (1.0,) * 3)
    assert m.Conductor().specular_reflectance == (1.0, 1.0, 1.0)
    rough = m.RoughConductor()
    assert (rough.distribution, rough.alphas) == ("beckmann", (0.1, 0.1))
    glass = m.Dielectric()
    assert glass.int_ior / glass.ext_ior == pytest.approx(1.50418, abs=1e-5)


def test_defaults_of_the_camera_are_mitsubas() -> None:
    sensor = m.Perspective()
    assert sensor.film.size == (768, 576)
    assert sensor.film.crop == (0, 0, 768, 576)
    assert sensor.film.rfilter == m.Gaussian(stddev=0.5)
    assert m.Tent().radius == 1.0
    assert sensor.sampler == m.Independent(sample_count=4)
    assert sensor.x_fov == pytest.approx(38.1848, abs=1e-4)


def test_clips_apply_only_when_given() -> None:
    assert (m.Perspective().near_clip, m.Perspective().far_clip) == (None, None)
    assert m.Perspective(near_clip=0.01).near_clip == 0.01


def test_defaults_of_integrators_are_mitsubas() -> None:
    assert (m.Path().max_depth, m.Path().rr_depth) == (-1, 5)
    assert m.Direct().max_depth == 2


def test_defaults_of_emitters_and_shapes_are_mitsubas() -> None:
    assert m.Area().radiance == m.Constant().radiance == m.Point().intensity == (1.0, 1.0, 1.0)
    assert m.Point().world_position == (0.0, 0.0, 0.0)
    assert (m.Sphere().center, m.Sphere().radius) == ((0.0, 0.0, 0.0), 1.0)
    assert m.Obj(filename="x").flip_tex_coords
    assert not m.Ply(filename="x").flip_tex_coords


# -- field of view ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("axis", "degrees"),  # what Mitsuba 3.9.1 makes of fov = 50 on a film of 64 x 32
    [("x", 50.0), ("larger", 50.0), ("y", 86.00614166), ("smaller", 86.00614166), ("diagonal", 45.27991104)],
)
def test_field_of_view_along_any_axis_agrees_with_mitsuba(axis: str, degrees: float) -> None:
    film = m.HdrFilm(width=64, height=32, crop_width=10, crop_height=20)
    assert m.Perspective(fov=50.0, fov_axis=axis, film=film).x_fov == pytest.approx(degrees, rel=1e-6)


@pytest.mark.parametrize("length", ["35mm", "35", 35, 35.0])
def test_focal_length_is_in_millimetres_of_35_mm_film(length: object) -> None:
    assert m.Perspective(focal_length=length).x_fov == pytest.approx(52.62254333, rel=1e-6)


@pytest.mark.parametrize("fov", [0.0, -10.0, 180.0, 200.0, float("nan")])
def test_a_field_of_view_outside_0_to_180_degrees_is_refused(fov: float) -> None:
    with pytest.raises(ValidationError):
        m.Perspective(fov=fov)


def test_a_field_of_view_can_be_too_wide_only_horizontally() -> None:
    with pytest.raises(ValidationError, match="horizontal field of view"):
        m.Perspective(fov=179.9999999999, fov_axis="y", film=m.HdrFilm(width=1_000_000, height=1))


def test_field_of_view_and_focal_length_exclude_each_other() -> None:
    with pytest.raises(ValidationError, match="either fov"):
        m.Perspective(fov=40.0, focal_length="50mm")


def test_the_near_plane_must_be_before_the_far_plane() -> None:
    with pytest.raises(ValidationError, match="near_clip"):
        m.Perspective(near_clip=2.0, far_clip=1.0)


# -- film ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [(0, 10), (10, 0), (-1, 10)])
def test_an_image_without_pixels_is_refused(size: tuple[int, int]) -> None:
    with pytest.raises(ValidationError, match="greater than 0"):
        m.HdrFilm(width=size[0], height=size[1])


def test_an_image_beyond_memory_is_refused_with_what_it_would_need_and_the_limit() -> None:
    with pytest.raises(
        ValidationError, match=r"would need 112 EB of memory; the limit is 268435456 pixels \(30.1 GB\)"
    ):
        m.HdrFilm(width=10**9, height=10**9)


def test_a_crop_window_must_fit_into_the_film() -> None:
    assert m.HdrFilm(width=8, height=6, crop_offset_x=2, crop_width=6).crop == (2, 0, 6, 6)
    with pytest.raises(ValidationError, match="crop window, 8x6 from \\(2, 0\\)"):
        m.HdrFilm(width=8, height=6, crop_offset_x=2)


def test_a_large_film_is_fine_if_its_crop_is_small() -> None:
    film = m.HdrFilm(width=1_000_000, height=1_000_000, crop_width=16, crop_height=16)
    assert film.crop == (0, 0, 16, 16)


def test_output_formats_are_checked_in_any_case_of_letters() -> None:
    assert m.HdrFilm(file_format="OpenEXR").file_format == "openexr"
    with pytest.raises(ValidationError):
        m.HdrFilm(file_format="jpeg")


# -- colours ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("value", [0.25, [0.25, 0.25, 0.25], (0.25,) * 3, np.full(3, 0.25), m.Spectrum(0.25)])
def test_a_colour_may_be_one_number_three_or_a_constant_spectrum(value: object) -> None:
    assert m.Diffuse(reflectance=value).reflectance == (0.25, 0.25, 0.25)


def test_a_constant_spectrum_of_emission_is_equal_energy_not_white() -> None:
    assert m.Area(radiance=m.Spectrum(5.0)).radiance == pytest.approx((6.02397, 4.74146, 4.54458), abs=1e-5)
    assert m.Area(radiance=5).radiance == (5.0, 5.0, 5.0)


@pytest.mark.parametrize("value", [1.01, -0.1, [0.5, 2.0, 0.5], float("nan"), [1, 2], "red", True, None, [True] * 3])
def test_a_reflectance_that_is_none_is_refused(value: object) -> None:
    with pytest.raises(ValidationError):
        m.Diffuse(reflectance=value)


@pytest.mark.parametrize("value", [-1.0, float("inf"), [1.0, 1.0, -1e-9]])
def test_a_radiance_that_is_none_is_refused(value: object) -> None:
    with pytest.raises(ValidationError):
        m.Area(radiance=value)


# -- materials -------------------------------------------------------------------------------------------------------


def test_roughness_is_one_number_or_both_of_two() -> None:
    assert m.RoughConductor(alpha_u=0.1, alpha_v=0.2).alphas == (0.1, 0.2)
    for wrong in ({"alpha_u": 0.1}, {"alpha": 0.1, "alpha_v": 0.2}, {"alpha": 0.1, "alpha_u": 0.1, "alpha_v": 0.2}):
        with pytest.raises(ValidationError, match="either alpha, or both"):
            m.RoughConductor(**wrong)


def test_a_metal_may_be_given_by_name() -> None:
    gold = m.RoughConductor(material="au")
    assert gold.material == "Au"
    assert gold.ior == m.METALS["Au"]
    assert m.Conductor(material="none").ior == ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    with pytest.raises(ValidationError, match="did you mean 'Au'"):
        m.Conductor(material="Aux")


def test_a_texture_may_stand_for_a_colour_or_a_number() -> None:
    board = m.Checkerboard()
    assert m.Diffuse(reflectance=board).reflectance is board
    assert m.RoughConductor(alpha=board).alphas == (board, board)
    assert m.Mask(opacity=board, bsdf=m.Diffuse()).opacity is board
    assert m.BlendBsdf(weight=m.Spectrum(0.25), bsdf=(m.Diffuse(), m.Plastic())).weight == 0.25
    assert m.Mask(opacity=(0.1, 0.2, 0.3), bsdf=m.Diffuse()).opacity == pytest.approx(0.2)  # its mean, as in Mitsuba


def test_the_parameters_that_take_a_texture_are_known() -> None:
    texture = frozenset({"texture"})
    assert m.Diffuse.slots() == {"reflectance": texture}
    assert m.RoughConductor.slots().keys() == {"eta", "k", "specular_reflectance", "alpha", "alpha_u", "alpha_v"}
    assert m.Sphere.slots() == {"interior": frozenset({"medium"}), "exterior": frozenset({"medium"})}
    assert m.BumpMap.slots() == {}
    assert m.NormalMap.slots() == {"normalmap": texture}


def test_light_comes_from_where_a_transform_takes_it() -> None:
    down = ((1, 0, 0, 5), (0, 0, 1, 6), (0, -2, 0, 7), (0, 0, 0, 1))
    assert m.Directional(to_world=down).world_direction == pytest.approx((0.0, 1.0, 0.0))
    assert m.Directional(direction=(0, 0, -3)).world_direction == (0.0, 0.0, -1.0)
    assert m.Spot(cutoff_angle=40).beam == 30.0


def test_an_index_of_refraction_may_be_a_name() -> None:
    assert m.Dielectric(int_ior="Water", ext_ior="vacuum").int_ior == 1.333
    assert m.Dielectric(int_ior=2).int_ior == 2.0
    with pytest.raises(ValidationError, match="did you mean 'diamond'"):
        m.Dielectric(int_ior="dimond")
    with pytest.raises(ValidationError):
        m.Dielectric(int_ior=0.0)


def test_two_sides_need_one_or_two_opaque_materials() -> None:
    one, two = m.Diffuse(), m.Conductor()
    assert m.TwoSided(bsdf=(one, two)).bsdf == (one, two)
    for wrong in ((), (one, two, one), (m.Dielectric(),)):
        with pytest.raises(ValidationError):
            m.TwoSided(bsdf=wrong)


# -- shapes and transforms -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("radius", [0.0, -1.0, float("inf"), True, "1"])
def test_a_radius_must_be_a_positive_number(radius: object) -> None:
    with pytest.raises(ValidationError):
        m.Sphere(radius=radius)


def test_a_sphere_stays_a_sphere() -> None:
    shear = np.eye(4)
    shear[0, 1] = 0.5
    assert not m.Sphere(to_world=np.diag([-3.0, 3.0, 3.0, 1.0])).is_stretched
    for matrix in (NONUNIFORM, shear):
        sphere = m.Sphere(to_world=3.0 * matrix - np.diag([0.0, 0.0, 0.0, 2.0]), radius=2.0)
        assert sphere.is_stretched
        assert sphere.world_radius == pytest.approx(6.0)


def test_a_camera_and_an_environment_keep_lengths() -> None:
    mirror = np.diag([-1.0, 1.0, 1.0, 1.0])
    assert m.Perspective(to_world=mirror).to_world[0][0] == -1.0
    twice = 2.0 * np.eye(4) - np.diag([0.0, 0.0, 0.0, 1.0])
    for scaled, found in ((NONUNIFORM, "scales unevenly or shears"), (twice, "scales by 2")):
        with pytest.raises(ValidationError, match=f"must keep lengths, but {found}; leave only rotations"):
            m.Perspective(to_world=scaled)
        with pytest.raises(ValidationError, match=f"must keep lengths, but {found}; leave only rotations"):
            m.EnvMap(filename="x", to_world=scaled)


def test_transforms_must_be_invertible_affine_and_finite() -> None:
    projection, singular, infinite = np.eye(4), np.diag([1.0, 0.0, 1.0, 1.0]), np.eye(4)
    projection[3, 2], infinite[0, 3] = 1.0, np.inf
    for wrong in (projection, singular, infinite, np.eye(3), "up", None, [[1, 2], [3, 4]]):
        with pytest.raises(ValidationError):
            m.Rectangle(to_world=wrong)


@pytest.mark.parametrize("scale", [1e-200, 1e-9, 1e9, 1e200])
def test_a_tiny_or_a_huge_transform_is_not_singular(scale: float) -> None:
    assert m.Rectangle(to_world=np.diag([scale, 1.0, 1.0, 1.0]))
    sphere = m.Sphere(to_world=np.diag([scale, scale, scale, 1.0]))
    assert m.linear_scale(sphere.to_world) == pytest.approx(scale)


def test_a_point_light_has_one_position() -> None:
    moved = np.eye(4)
    moved[:3, 3] = (1, 2, 3)
    assert m.Point(to_world=moved).world_position == m.Point(position=[1, 2, 3]).world_position == (1.0, 2.0, 3.0)
    with pytest.raises(ValidationError, match="either position or to_world"):
        m.Point(to_world=moved, position=[1, 2, 3])


def test_a_scene_has_one_environment_at_most() -> None:
    with pytest.raises(ValidationError, match="only one environment"):
        m.SceneModel(sensor=m.Perspective(), emitters=(m.Constant(), m.EnvMap(filename="x")))


# -- nodes as values -------------------------------------------------------------------------------------------------


def test_nodes_are_frozen_comparable_and_hashable() -> None:
    node = m.Sphere(bsdf=m.Diffuse(reflectance=0.2))
    assert node == m.Sphere(bsdf=m.Diffuse(reflectance=[0.2, 0.2, 0.2]))
    assert len({node, m.Sphere(bsdf=m.Diffuse(reflectance=0.2)), m.Sphere()}) == 2
    with pytest.raises(ValidationError):
        node.radius = 2.0  # type: ignore[misc]


def test_a_node_is_changed_by_making_another_one() -> None:
    sensor = m.Perspective(fov=40.0, fov_axis="y")
    assert sensor.replace(fov=50.0) == m.Perspective(fov=50.0, fov_axis="y")
    with pytest.raises(ValidationError):
        sensor.replace(fov=0.0)


def test_what_makes_the_image_says_whether_emitters_are_hidden() -> None:
    assert m.Moment(integrators=(m.Path(hide_emitters=True),)).hides_emitters
    assert not m.Aov(aovs="d:depth", hide_emitters=True, integrators=(m.Path(),)).hides_emitters


def test_every_supported_plugin_but_our_own_is_one_that_mitsuba_knows_and_belongs_to_the_same_family() -> None:
    from equaltime.scene.substitutes import mitsuba_kind

    ours = {"gltf": "shape", "roughdiffuse": "bsdf", "spherical": "sensor"}
    known = {name: ours.get(name, mitsuba_kind(name)) for name in m.PLUGINS}
    assert {name: plugin.kind for name, plugin in m.PLUGINS.items()} == known


def test_the_whole_model_has_a_json_schema() -> None:
    assert "sensor" in m.SceneModel.model_json_schema()["required"]
