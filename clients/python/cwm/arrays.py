"""Arrays of users, checked before they are sent. Lists, integers, float32, Fortran order and
strides are converted; what cannot be meant is refused by an error that names the argument, what
it is and the rule.
"""

from __future__ import annotations

from typing import Sequence

import numpy as np
import numpy.typing as npt

from cwm.v1 import geometry_pb2

FloatArray = npt.NDArray[np.floating]


_YEAR_S = 366 * 86_400
INT32_MAX = 2**31 - 1  # the range of a message's field


def numbers(value: npt.ArrayLike, name: str) -> FloatArray:
    """`value` as a C-ordered little-endian array of float32 (where it is one) or float64.
    TypeError for anything but numbers.
    """
    if isinstance(value, np.ma.MaskedArray):
        raise TypeError(
            f"{name} is a masked array, must be a plain one: fill or drop what is masked"
        )
    try:
        array = np.asarray(value)
    except ValueError as error:  # ragged lists
        raise TypeError(f"{name} must be a rectangular array of numbers: {error}") from None
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{name} has the type {array.dtype}, must be real numbers")
    kind = "<f4" if array.dtype.kind == "f" and array.dtype.itemsize == 4 else "<f8"
    return np.ascontiguousarray(array, dtype=kind)


def finite(array: FloatArray, name: str) -> FloatArray:
    """The array; ValueError names the first row with a NaN or an infinity."""
    good = np.isfinite(array)
    if not good.all():
        row = np.argwhere(~good)[0]
        place = ", ".join(str(int(i)) for i in row)
        raise ValueError(f"{name}[{place}] is {array[tuple(row)]}, must be finite")
    return array


def rows(value: npt.ArrayLike, name: str, width: int | None = None) -> FloatArray:
    """(N, width) finite numbers, N >= 1; one row may be given as (width,)."""
    array = numbers(value, name)
    if array.ndim == 1 and (width is None or array.shape[0] == width) and array.size > 0:
        array = array[np.newaxis, :]
    wanted = f"(N, {'M' if width is None else width})"
    if array.ndim != 2 or (width is not None and array.shape[1] != width):
        raise ValueError(f"{name} has the shape {array.shape}, must be {wanted}")
    if array.size == 0:
        raise ValueError(
            f"{name} has the shape {array.shape}, must be {wanted} with at least one row"
        )
    return finite(array, name)


def vector(value: npt.ArrayLike, name: str, size: int = 3) -> FloatArray:
    """(size,) finite float64."""
    array = np.asarray(numbers(value, name), dtype=np.float64)
    if array.shape != (size,):
        raise ValueError(f"{name} has the shape {array.shape}, must be ({size},)")
    return finite(array, name)


def seconds(value: float, name: str) -> float:
    """At least 0 and at most a year, more than which no server waits."""
    result = number(value, name, low=0)
    if result > _YEAR_S:
        raise ValueError(f"{name} is {value!r}, must be at most {_YEAR_S:g}")
    return result


def number(value: float, name: str, *, low: float | None = None) -> float:
    """A finite number, at least `low`."""
    if (
        isinstance(value, (bool, str, bytes))
        or not np.isscalar(value)
        or isinstance(value, complex)
    ):
        raise TypeError(f"{name} is {value!r}, must be a number")
    result = float(value)
    if not np.isfinite(result) or (low is not None and result < low):
        rule = "finite" if low is None else f"finite and at least {low:g}"
        raise ValueError(f"{name} is {value!r}, must be {rule}")
    return result


def count(value: int, name: str, *, low: int = 0, high: int = 2**63 - 1) -> int:
    """A whole number, at least `low`."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise TypeError(f"{name} is {value!r}, must be a whole number")
    if value < low:
        raise ValueError(f"{name} is {value}, must be at least {low}")
    if value > high:
        raise ValueError(f"{name} is {value}, must be at most {high}")
    return int(value)


def text(value: str, name: str) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{name} is {value!r}, must be a string")
    return value


def texts(value: Sequence[str], name: str) -> list[str]:
    if isinstance(value, str):
        raise TypeError(f"{name} is {value!r}, must be a sequence of strings: [{value!r}]")
    return [text(item, f"{name}[{i}]") for i, item in enumerate(value)]


def scalar_of(array: np.ndarray) -> int:
    """The wire's name of the array's precision."""
    return geometry_pb2.SCALAR_F32 if array.dtype.itemsize == 4 else geometry_pb2.SCALAR_F64


def columns(data: bytes, scalar: int, width: int = 1) -> np.ndarray:
    """A column of an answer, without a copy: (N,) or (N, width); read-only."""
    array = np.frombuffer(data, dtype="<f4" if scalar == geometry_pb2.SCALAR_F32 else "<f8")
    return array if width == 1 else array.reshape(-1, width)
