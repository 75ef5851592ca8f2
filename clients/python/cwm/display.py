"""Objects as text for people: a line, and a table in a notebook."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

from cwm import shapes

if TYPE_CHECKING:
    from cwm.objects import Object, Part

# A line of a terminal or of a list is about as wide.
_MAX_NAME = 32


def _mm(value_m: float) -> str:
    return f"{1000 * value_m:.0f}"


def shape_text(shape: shapes.Shape) -> str:
    """The kind and the sizes of a shape: "Box 70 x 190 x 270 mm"."""
    kind = type(shape).__name__
    if isinstance(shape, shapes.Box):
        sizes = (shape.size_x_m, shape.size_y_m, shape.size_z_m)
        return f"{kind} {' x '.join(map(_mm, sizes))} mm"
    if isinstance(shape, shapes.Sphere):
        return f"{kind} r {_mm(shape.radius_m)} mm"
    if isinstance(shape, (shapes.Cylinder, shapes.Capsule)):
        return f"{kind} r {_mm(shape.radius_m)}, l {_mm(shape.length_m)} mm"
    if isinstance(shape, shapes.Cone):
        radii = f"{_mm(shape.radius_bottom_m)} to {_mm(shape.radius_top_m)}"
        return f"{kind} r {radii}, l {_mm(shape.length_m)} mm"
    if isinstance(shape, shapes.Plate):
        return f"{kind} of {len(shape.outline)} corners, {_mm(shape.thickness_m)} mm thick"
    return kind


def part_text(part: Part) -> str:
    """A part in words: a vessel, or its shape."""
    if part.vessel is not None:
        vessel = part.vessel
        return f"Vessel r {_mm(vessel.rim_radius_m)}, h {_mm(vessel.height_m)} mm"
    return shape_text(part.shape)


def _geometry_text(obj: Object) -> str:
    if not obj.parts:
        triangles = sum(surface.triangle_count for surface in obj.surfaces)
        return f"mesh of {triangles} triangles" if triangles else "no shape"
    more = len(obj.parts) - 1
    return part_text(obj.parts[0]) + (f" and {more} more" if more else "")


def object_line(obj: Object) -> str:
    """An object in one line of at most 120 characters."""
    name = obj.name if len(obj.name) <= _MAX_NAME else obj.name[: _MAX_NAME - 3] + "..."
    place = " ".join(f"{value:.3f}" for value in obj.position)
    return f"Object({name!r}, {obj.kind.name}, {_geometry_text(obj)}, at {place} m)"


def _row(*cells: str, tag: str = "td") -> str:
    return f"<tr>{''.join(f'<{tag}>{html.escape(cell)}</{tag}>' for cell in cells)}</tr>"


def object_html(obj: Object) -> str:
    """An object as a table: each part with its fit and the names of its coefficients."""
    place = " ".join(f"{value:.3f}" for value in obj.position)
    head = f"{obj.name} ({obj.kind.name.lower()}), at {place} m"
    if obj.supported_by:
        head += f", on {obj.supported_by}"
    rows = [_row("part", "role", "rms", "observed", "coefficients", tag="th")]
    for part in obj.parts:
        fit = part.fit
        rows.append(
            _row(
                part_text(part),
                part.role.name.lower(),
                "" if fit is None else f"{1000 * fit.rms_m:.1f} mm",
                "" if fit is None else f"{100 * fit.observed_fraction:.0f} %",
                ", ".join(f"{name} {value:.4f}" for name, value in part.coefficients.items()),
            )
        )
    for surface in obj.surfaces:
        rows.append(_row(f"mesh of {surface.triangle_count} triangles", "measured", "", "", ""))
    return f"<table><caption>{html.escape(head)}</caption>{''.join(rows)}</table>"
