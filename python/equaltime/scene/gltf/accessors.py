"""Reads accessors, the typed arrays of a glTF file: interleaved or not, with or without sparse corrections."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.gltf.document import Document, Malformed

__all__ = ["floats", "integers"]

COMPONENTS: Final = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS: Final = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
MOST_ZEROS: Final = 1 << 19
"""Largest number of elements of an accessor without a buffer view, whose zeros take memory but no bytes of the file."""


def floats(document: Document, index: int, *types: str) -> NDArray[np.float64]:
    """Return the values of accessor `index` of `document` as floats (count, components).

    Normalised integers become numbers in [0, 1] or [-1, 1]. Raises `Malformed` if the data is not in the file, or if
    the accessor's type, such as ``VEC3``, is not in `types`.
    """
    accessor = document.gltf.accessors[index]
    values = _values(document, index, types)
    with np.errstate(invalid="ignore"):  # NaNs are checked where the values are used
        result = values.astype(np.float64)
    if accessor.normalized and values.dtype.kind in "iu":
        result = np.maximum(result / np.iinfo(values.dtype).max, -1.0)
    return result


def integers(document: Document, index: int, *types: str) -> NDArray[np.uint32]:
    """Return the values of accessor `index` of `document`, which must be unsigned integers, as (count, components).

    Raises `Malformed` if the data is not in the file, or if the accessor's type, such as ``SCALAR``, is not in `types`.
    """
    values = _values(document, index, types)
    if values.dtype.kind != "u":
        raise Malformed((f"accessors[{index}].componentType", "expected unsigned integers (5121, 5123 or 5125)"))
    return values.astype(np.uint32)


def _values(document: Document, index: int, types: tuple[str, ...]) -> NDArray[Any]:
    accessor, place = document.gltf.accessors[index], f"accessors[{index}]"
    if accessor.type not in types:
        raise Malformed((f"{place}.type", f"expected {' or '.join(types)}, found {accessor.type}"))
    dtype, width, count = np.dtype(COMPONENTS[accessor.componentType]), WIDTHS[accessor.type], int(accessor.count)
    if accessor.bufferView is None:
        if count > MOST_ZEROS:
            raise Malformed((f"{place}.count", f"{count} elements without data; the limit is {MOST_ZEROS}"))
        values: NDArray[Any] = np.zeros((count, width), dtype)
    else:
        stride = int(document.gltf.bufferViews[accessor.bufferView].byteStride or 0)
        if 0 < stride < (size := width * dtype.itemsize):
            message = f"expected at least {size}, the bytes of an element of {place}, found {stride}"
            raise Malformed((f"bufferViews[{accessor.bufferView}].byteStride", message))
        values = _array(document, accessor.bufferView, accessor, dtype, (count, width), stride, place)
    return values if accessor.sparse is None else _corrected(document, accessor, values, place)


def _array(
    document: Document,
    view: int,
    where: Any,
    dtype: np.dtype[Any],
    shape: tuple[int, int],
    stride: int,
    place: str,
) -> NDArray[Any]:
    """Return the array of this shape in a buffer view, without a copy; `where` holds its byteOffset."""
    data, begin = document.view(view), int(where.byteOffset or 0)
    count, width = shape
    stride = stride or width * dtype.itemsize
    end = begin + (count - 1) * stride + width * dtype.itemsize if count else begin
    if end > len(data):
        message = f"{count} elements end at byte {end} of buffer view {view}, which has {len(data)}"
        raise Malformed((place, message))
    if count == 0:
        return np.zeros(shape, dtype)
    return np.ndarray(shape, dtype, data, begin, (stride, dtype.itemsize))


def _corrected(document: Document, accessor: Any, values: NDArray[Any], place: str) -> NDArray[Any]:
    """Return the values with the sparse corrections put in."""
    sparse, place = accessor.sparse, f"{place}.sparse"
    count = int(sparse.count)
    if count > len(values):
        raise Malformed((f"{place}.count", f"expected at most the accessor's {len(values)} elements, found {count}"))
    kind = np.dtype(COMPONENTS[sparse.indices.componentType])
    where = _array(document, sparse.indices.bufferView, sparse.indices, kind, (count, 1), 0, f"{place}.indices")[:, 0]
    if count and int(where.max()) >= len(values):
        raise Malformed((f"{place}.indices", f"element {where.max()} does not exist (there are {len(values)})"))
    size = (count, values.shape[1])
    given = _array(document, sparse.values.bufferView, sparse.values, values.dtype, size, 0, f"{place}.values")
    result = values.copy()
    result[where] = given
    return result
