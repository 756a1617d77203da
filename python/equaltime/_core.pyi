"""The compiled core: scenes in world space and authoring units, renderers, mesh readers."""

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Floats = NDArray[np.float64]
_Counts = NDArray[np.int64]
_Named = dict[str, Any]
_Vec3 = Sequence[float] | _Floats

parts: Any  # a module of the estimator's pieces by themselves, over arrays: for tests

class MeshError(ValueError): ...

class MeshData:
    @property
    def vertices(self) -> _Floats: ...
    @property
    def faces(self) -> NDArray[np.uint32]: ...
    @property
    def normals(self) -> _Floats | None: ...
    @property
    def uvs(self) -> _Floats | None: ...
    @property
    def attributes(self) -> dict[str, _Floats]: ...
    @property
    def warnings(self) -> list[str]: ...

def read_ply(path: str | os.PathLike[str]) -> MeshData: ...
def read_obj(path: str | os.PathLike[str], material: str | None = None) -> MeshData: ...
def finished_mesh(
    path: str | os.PathLike[str],
    vertices: ArrayLike,
    faces: ArrayLike,
    normals: ArrayLike | None,
    uvs: ArrayLike | None,
    vertex_attributes: Mapping[str, ArrayLike] = {},
) -> MeshData: ...
def merge_moments(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]: ...
def join_replicates(moments: NDArray[Any]) -> tuple[_Floats, _Floats, _Counts]: ...
def box_sum(image: _Floats) -> _Floats: ...
def error_contributions(mean: _Floats, variance: _Floats, samples: _Counts, floor: float) -> tuple[_Floats, _Named]: ...
def standard_errors(mean: _Floats, variance: _Floats, samples: _Counts) -> NDArray[np.float32]: ...
def build_info() -> _Named: ...
def replay(scene: Scene, settings: Settings, seed: int, x: int, y: int, index: int, replicates: int = 2) -> _Named: ...
def measure_limit(
    scene: Scene,
    settings: Settings,
    seed: int = 0,
    threads: int = 0,
    tile: int = 16,
    samples: int = 16,
    pairs: int = 9,
    memory_bytes: int = 536870912,
    replay_first: bool = False,
) -> _Named: ...

class Scene:
    @property
    def shapes(self) -> int: ...
    @property
    def triangles(self) -> int: ...
    @property
    def instances(self) -> int: ...
    @property
    def dropped_triangles(self) -> int: ...
    @property
    def lights(self) -> int: ...
    @property
    def memory_bytes(self) -> int: ...
    @property
    def film_shape(self) -> tuple[int, int]: ...
    def effects(self) -> dict[str, bool]: ...
    def intersect(self, origins: ArrayLike, directions: ArrayLike, time: float = 0.5) -> dict[str, NDArray[Any]]: ...

class SceneBuilder:
    def __init__(self) -> None: ...
    def add_diffuse(self, reflectance: _Vec3) -> int: ...
    def add_conductor(self, eta: _Vec3, k: _Vec3, specular_reflectance: _Vec3) -> int: ...
    def add_rough_conductor(
        self,
        distribution: Literal["ggx", "beckmann"],
        alpha_u: float,
        alpha_v: float,
        eta: _Vec3,
        k: _Vec3,
        specular_reflectance: _Vec3,
    ) -> int: ...
    def add_dielectric(self, ior: float, specular_reflectance: _Vec3, specular_transmittance: _Vec3) -> int: ...
    def add_thin_dielectric(self, ior: float, specular_reflectance: _Vec3, specular_transmittance: _Vec3) -> int: ...
    def add_rough_dielectric(
        self,
        distribution: Literal["ggx", "beckmann"],
        alpha_u: float,
        alpha_v: float,
        ior: float,
        specular_reflectance: _Vec3,
        specular_transmittance: _Vec3,
    ) -> int: ...
    def add_plastic(
        self, ior: float, diffuse_reflectance: _Vec3, specular_reflectance: _Vec3, nonlinear: bool
    ) -> int: ...
    def add_principled(
        self,
        base_color: _Vec3,
        *,
        roughness: float,
        anisotropic: float,
        metallic: float,
        spec_trans: float,
        ior: float,
        spec_tint: float,
        sheen: float,
        sheen_tint: float,
        flatness: float,
        clearcoat: float,
        clearcoat_gloss: float,
    ) -> int: ...
    def add_rough_plastic(
        self,
        distribution: Literal["ggx", "beckmann"],
        alpha: float,
        ior: float,
        diffuse_reflectance: _Vec3,
        specular_reflectance: _Vec3,
        nonlinear: bool,
    ) -> int: ...
    def add_mesh(
        self,
        vertices: ArrayLike,
        faces: ArrayLike,
        normals: ArrayLike | None = None,
        uvs: ArrayLike | None = None,
        *,
        front: int | None,
        back: int | None,
        radiance: _Vec3 | None,
    ) -> int: ...
    def add_rectangle(
        self, to_world: ArrayLike, *, flip_normals: bool, front: int | None, back: int | None, radiance: _Vec3 | None
    ) -> int: ...
    def add_disk(
        self, to_world: ArrayLike, *, flip_normals: bool, front: int | None, back: int | None, radiance: _Vec3 | None
    ) -> int: ...
    def add_sphere(
        self,
        center: _Vec3,
        radius: float,
        *,
        flip_normals: bool,
        front: int | None,
        back: int | None,
        radiance: _Vec3 | None,
        pole: _Vec3 = [0.0, 0.0, 1.0],
        meridian: _Vec3 = [1.0, 0.0, 0.0],
        mirrored: bool = False,
    ) -> int: ...
    def add_cylinder(
        self,
        base: _Vec3,
        end: _Vec3,
        radius: float,
        *,
        flip_normals: bool,
        front: int | None,
        back: int | None,
        radiance: _Vec3 | None,
        meridian: _Vec3 = [1.0, 0.0, 0.0],
        mirrored: bool = False,
    ) -> int: ...
    def add_bitmap(
        self,
        texels: ArrayLike,
        *,
        srgb: bool,
        filter: Literal["nearest", "bilinear"] = "bilinear",
        wrap: Literal["repeat", "mirror", "clamp"] = "repeat",
        to_uv: ArrayLike | None = None,
    ) -> int: ...
    def add_checkerboard(self, color0: _Vec3, color1: _Vec3, *, to_uv: ArrayLike | None = None) -> int: ...
    def add_mesh_attribute(self) -> int: ...
    def keep_uvs(self) -> None: ...
    def set_attribute(self, shape: int, texture: int, values: ArrayLike, *, per_face: bool) -> None: ...
    def add_medium(self, sigma_t: _Vec3, albedo: _Vec3, g: float = 0.0) -> int: ...
    def set_media(self, shape: int, *, exterior: int | None, interior: int | None) -> None: ...
    def set_priority(self, shape: int, priority: int) -> None: ...
    def set_camera_medium(self, medium: int) -> None: ...
    def cross_freely(self) -> None: ...
    def hide_emitters(self) -> None: ...
    def bind_radiance(self, shape: int, texture: int) -> None: ...
    def bend(
        self,
        bsdf: int,
        texture: int,
        *,
        bump: bool,
        scale: float = 1.0,
        flip_invalid: bool = True,
        shadowing: bool = True,
        turned: bool = False,
    ) -> None: ...
    def add_null(self) -> int: ...
    def add_mixture(self, first: int, second: int, weight: float) -> int: ...
    def bind(self, bsdf: int, parameter: str, texture: int, times: int | None = None) -> None: ...
    def add_group(self, first_shape: int) -> int: ...
    def add_instance(self, group: int, to_world: ArrayLike) -> int: ...
    def add_moving_instance(self, group: int, times: ArrayLike, matrices: ArrayLike) -> int: ...
    def deform_mesh(self, shape: int, vertices: ArrayLike, normals: ArrayLike | None = None) -> None: ...
    def move_sensor(self, times: ArrayLike, matrices: ArrayLike) -> None: ...
    def add_point_light(self, position: _Vec3, intensity: _Vec3) -> int: ...
    def add_spot_light(
        self, position: _Vec3, direction: _Vec3, intensity: _Vec3, cutoff_degrees: float, beam_degrees: float
    ) -> int: ...
    def add_directional_light(self, direction: _Vec3, irradiance: _Vec3) -> int: ...
    def add_constant_environment(self, radiance: _Vec3) -> None: ...
    def add_image_environment(self, pixels: ArrayLike, scale: float, to_world: ArrayLike) -> None: ...
    def set_perspective(
        self,
        to_world: ArrayLike,
        x_fov_degrees: float,
        near: float | None = None,
        far: float | None = None,
        principal_point_offset: Sequence[float] = [0.0, 0.0],
        aperture_radius: float = 0.0,
        focus_distance: float = 1.0,
        blades: int = 0,
        rotation_degrees: float = 0.0,
    ) -> None: ...
    def set_orthographic(self, to_world: ArrayLike, near: float | None = None, far: float | None = None) -> None: ...
    def set_spherical(self, to_world: ArrayLike, near: float | None = None, far: float | None = None) -> None: ...
    def set_film(
        self, width: int, height: int, crop: Sequence[int], filter: str, parameter: float, second: float = 0.0
    ) -> None: ...
    def build(self, intersection: Literal["robust", "fast"] = "robust") -> Scene: ...

class Settings:
    def __init__(
        self,
        *,
        technique: Literal["uniform", "bsdf", "light", "mis", "mixture"] = "mis",
        heuristic: Literal["balance", "power"] | None = "power",
        lights: Literal["uniform", "power", "tree"] = "power",
        environment: Literal["plain", "compensated"] | None = "plain",
        roulette: Literal["none", "constant", "albedo", "throughput", "efficiency"] = "throughput",
        roulette_depth: int | None = 5,
        survival: float | None = 0.75,
        truncate: int = 0,
        sampler: Literal["independent", "stratified", "sobol"] = "sobol",
        max_depth: int = -1,
    ) -> None: ...

class Renderer:
    def __init__(
        self,
        scene: Scene,
        settings: Settings,
        seed: int = 0,
        threads: int = 0,
        tile: int = 16,
        replicates: int = 2,
        pixel_rays: bool = False,
        also: Sequence[str] = (),
        traps: Literal["ignore", "check", "stop"] = "ignore",
    ) -> None: ...
    def advance(self, samples: int, seconds: float | None = None, poll: Callable[[], bool] | None = None) -> bool: ...
    def take_up(self, *, paths: int, rays: int, shadow_rays: int, position: tuple[int, int, int]) -> None: ...
    def adapt(self, pilot: int, rates: NDArray[np.float32]) -> None: ...
    @property
    def pixel_rays(self) -> NDArray[np.uint64]: ...
    @property
    def position(self) -> tuple[int, int, int]: ...
    @property
    def moments(self) -> NDArray[Any]: ...
    @property
    def counters(self) -> dict[str, int]: ...
    @property
    def nonfinite(self) -> list[tuple[int, int, int]]: ...
    @property
    def faulty(self) -> list[tuple[int, int, int, str]]: ...
    @property
    def kernel(self) -> str: ...
    @property
    def threads(self) -> int: ...

def split_light(
    scene: Scene, settings: Settings, seed: int = 0, threads: int = 0, samples: int = 1, replicates: int = 2
) -> tuple[list[tuple[str, str]], _Floats]: ...
def unshadowed(
    scene: Scene,
    settings: Settings,
    pixels: NDArray[np.uint32],
    seed: int = 0,
    threads: int = 0,
    samples: int = 1,
    replicates: int = 2,
) -> _Floats: ...
