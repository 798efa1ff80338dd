"""Numbers and elements of both formats; numbers have all their digits."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from xml.etree import ElementTree

from hydrocrane.export.chain import Chain, Place, Vector

# Radii of the drawn links, barrels and rods, as shares of the longest outline.
THICKNESS = 0.02


def numbers(values: Iterable[float]) -> str:
    """Numbers with spaces between them; reading gives the same bits. Zero has no sign."""
    return " ".join(repr(float(value) + 0.0) for value in values)


def in_space(place: Place | Vector) -> str:
    """A point in space, or one of the plane."""
    return numbers(place if len(place) == 3 else (place[0], 0.0, place[1]))


def written(root: ElementTree.Element, head: str) -> str:
    """The document as text, with a comment at its head, in which no two hyphens may meet."""
    ElementTree.indent(root, "  ")
    body = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="utf-8"?>\n<!-- {re.sub("-(?=-)", "- ", head)} -->\n{body}\n'


def thickness(chain: Chain) -> float:
    """Radius of a drawn part, m."""
    longest = max((math.dist(a, b) for link in chain.links for a, b in segments(link.outline)), default=1.0)
    return THICKNESS * longest


def segments(outline: tuple[Place, ...]) -> list[tuple[Place, Place]]:
    """Segments of an outline with nonzero length."""
    return [(a, b) for a, b in zip(outline, outline[1:], strict=False) if math.dist(a, b) > 0]
