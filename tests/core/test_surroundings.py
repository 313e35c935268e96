"""What rectangles leave of a square, by property: the solid around free ones."""

from itertools import pairwise

import numpy as np
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.worlds.surroundings import largest_rectangles_beside


@st.composite
def rectangles(draw) -> np.ndarray:
    """One to five on a coarse grid, so that many of them overlap, touch or reach the walls."""

    def interval() -> tuple[int, int]:
        low = draw(st.integers(0, 7))
        return low, draw(st.integers(low + 1, 8))

    pairs = [(interval(), interval()) for _ in range(draw(st.integers(1, 5)))]
    return np.array([[x0, y0, x1, y1] for (x0, x1), (y0, y1) in pairs]) / 4.0


@given(free=rectangles())
@settings(derandomize=True, deadline=None, max_examples=60)
def test_the_solid_around_rectangles_is_all_that_they_leave_and_shows_no_seam(free):
    solids = [shapely.box(*solid) for solid in largest_rectangles_beside(free, 2.0)]
    left = shapely.box(0, 0, 2, 2).difference(shapely.union_all([shapely.box(*one) for one in free]))
    assert shapely.union_all(solids).symmetric_difference(left).area == 0.0
    edges = [edge for solid in solids for edge in faces(solid)]
    assert all(any(edge.covers(face) for edge in edges) for face in faces(left))


def faces(area: shapely.Geometry) -> list[shapely.LineString]:
    """Straight pieces of the border of an area, each as long as can be."""
    rings = [
        ring
        for part in getattr(area.simplify(0.0), "geoms", [area.simplify(0.0)])
        for ring in ([part.exterior, *part.interiors] if part.area else [])
    ]
    return [shapely.LineString(ends) for ring in rings for ends in pairwise(ring.coords)]
