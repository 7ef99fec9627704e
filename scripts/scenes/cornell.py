"""A Cornell box of 3 m with a displaced statue on a plinth; one rectangular lamp."""

import math

import numpy as np

from . import statue, surfaces
from .gltf import Level, Part
from .mesh import box, faceted, ground, lathe, move, turn
from .texture import from_srgb

TRIANGLES = 34_000
SIDE = 3.0


def build():
    level = Level("Cornell box with a statue", {
        "white": surfaces.plaster(from_srgb(0.88, 0.86, 0.82), seed=3),
        "red": surfaces.plaster(from_srgb(0.78, 0.20, 0.15), seed=7),
        "green": surfaces.plaster(from_srgb(0.28, 0.58, 0.26), seed=11),
        "floor": surfaces.paving(from_srgb(0.80, 0.76, 0.70), from_srgb(0.34, 0.32, 0.31), 512, seed=5,
                                 tiles=4, tile=2.0, gloss=0.6),
        "marble": surfaces.marble(from_srgb(0.90, 0.88, 0.84), from_srgb(0.55, 0.50, 0.46), seed=2, gloss=0.55),
        "plinth": surfaces.marble(from_srgb(0.52, 0.57, 0.55), from_srgb(0.80, 0.80, 0.74), seed=9),
        "gold": surfaces.metal((0.95, 0.70, 0.30), seed=4, gloss=0.62),
        "lamp": surfaces.lamp((1.0, 0.86, 0.62), 40.0),
    })
    h = SIDE / 2
    room = Part("room")
    room.add("floor", ground(-h, h, -h, h))
    room.add("white",
             faceted([[(-h, SIDE, -h), (h, SIDE, -h), (h, SIDE, h), (-h, SIDE, h)]]),
             faceted([[(-h, 0, -h), (h, 0, -h), (h, SIDE, -h), (-h, SIDE, -h)]]))
    room.add("red", faceted([[(-h, 0, h), (-h, 0, -h), (-h, SIDE, -h), (-h, SIDE, h)]]))
    room.add("green", faceted([[(h, 0, -h), (h, 0, h), (h, SIDE, h), (h, SIDE, -h)]]))
    # Skirting boards along the three walls.
    room.add("white", box(SIDE, 0.12, 0.03, 0.008, (0, 0.06, -h + 0.015)),
             box(0.03, 0.12, SIDE, 0.008, (-h + 0.015, 0.06, 0)),
             box(0.03, 0.12, SIDE, 0.008, (h - 0.015, 0.06, 0)))
    level.place(room)

    lamp = Part("lamp")
    lamp.add("lamp", faceted([[(-0.35, 0, -0.3), (0.35, 0, -0.3), (0.35, 0, 0.3), (-0.35, 0, 0.3)]]))
    frame = [box(0.8, 0.05, 0.04, 0.01, (0, 0.015, s * 0.33)) for s in (-1, 1)]
    frame += [box(0.04, 0.05, 0.7, 0.01, (s * 0.38, 0.015, 0)) for s in (-1, 1)]
    lamp.add("white", *frame)
    level.place(lamp, move(0, SIDE - 0.025, 0))

    stand = Part("plinth")
    outline = [(r * math.sqrt(2), y) for r, y in statue.plinth(1.0, 0.5)]
    stand.add("plinth", faceted([quad for quad in _four_sided(outline)]).at(turn("y", 45)))
    level.place(stand, move(0.1, 0, -0.35), turn("y", 0))

    sphere = Part("ball")
    angles = np.radians(np.linspace(-90, 90, 37))
    sphere.add("gold", lathe(np.stack([0.3 * np.cos(angles), 0.3 + 0.3 * np.sin(angles)], axis=1), 64))
    level.place(sphere, move(-0.85, 0, 0.55))
    block = Part("block")
    block.add("plinth", box(0.55, 0.55, 0.55, 0.02, (0, 0.275, 0)))
    level.place(block, turn("y", 24), move(0.95, 0, 0.5))

    # The statue takes what is left.
    rows = 128
    columns = (TRIANGLES - level.triangle_count()) // (2 * rows)
    figure = Part("statue")
    figure.add("marble", statue.robed_figure(columns, rows))
    level.place(figure, turn("y", -14), move(0.1, 0.5, -0.35))

    level.camera("front", (0, 1.5, 5.6), (0, 1.42, 0), 38)
    level.camera("statue", (-0.7, 1.9, 1.9), (0.08, 1.75, -0.35), 38)
    level.camera("ball", (-0.2, 0.7, 1.9), (-0.6, 0.45, 0.2), 45)
    return level


def _four_sided(outline):
    """Quadrilaterals of an outline (radius, y) turned in four steps."""
    for k in range(4):
        a, b = math.pi / 2 * k, math.pi / 2 * (k + 1)
        for (r0, y0), (r1, y1) in zip(outline, outline[1:]):
            quad = [(r0 * math.sin(a), y0, r0 * math.cos(a)), (r0 * math.sin(b), y0, r0 * math.cos(b)),
                    (r1 * math.sin(b), y1, r1 * math.cos(b)), (r1 * math.sin(a), y1, r1 * math.cos(a))]
            yield quad if r1 > 0 else quad[:3]
