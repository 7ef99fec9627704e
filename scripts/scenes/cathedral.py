"""The inside of a Gothic cathedral: a nave of six bays with aisles, triforium and clerestory under
ribbed vaults, an apse of five sides, a rose window over the west wall. Three chandeliers, the altar's
candles and a lamp over the choir are the five point lights; the windows glow.

The nave runs along Z: the west wall stands at z = 0, the altar towards -Z.
"""

import math

import numpy as np

from . import statue, surfaces
from .gltf import Level, Part
from .mesh import (arched_wall, bent, box, circle, faceted, ground, lathe, move, on_path, patch, pointed,
                   pointed_arch, prism, rectangle, sweep, tube, turn)
from .texture import from_srgb

TRIANGLES = 205_000
BAYS = 6
BAY = 6.0        # along the nave, between the middles of piers
NAVE = 6.0       # half the width between the arcades
AISLE = 5.4      # width of an aisle
PIER = 6.6       # height of a pier's capital
STRING = (10.9, 14.6)  # below the triforium, below the clerestory
SPRING = 14.6    # where the nave's vault begins
RISE = 8.2
END = -BAYS * BAY


# A rib: a roll between hollows, seen along the arch; up is away from the vault's middle.
def rib_profile(w):
    if w < 0.28:  # far up or small: a chamfer and a fillet
        half = [(0.5, 0.5), (0.5, 0.05), (0.22, -0.2), (0.16, -0.5)]
        return w * np.array([(-x, y) for x, y in half] + half[::-1])
    half = [(0.5, 0.55), (0.5, 0.2), (0.36, 0.12), (0.30, -0.12), (0.19, -0.34), (0.0, -0.5)]
    points = half + [(-x, y) for x, y in half[-2::-1]]
    return w * np.array(points[::-1])


MOULDING = np.array([(0.0, -0.16), (0.05, -0.12), (0.08, -0.04), (0.17, 0.02), (0.22, 0.05), (0.22, 0.11),
                     (0.0, 0.16)])  # a string course: out, up


def string_course(path, scale=1.0):
    """A moulding along a path, standing out to its right."""
    return sweep(MOULDING * scale, path)


def clustered(shafts, bulge):
    """The outline of a pier: round shafts before a round core."""
    return lambda angles: 1 + bulge * np.abs(np.cos(0.5 * shafts * angles)) ** 0.7


def pier(radius, height, segments=28):
    """A clustered pier with base and capital."""
    r = radius
    lobes = clustered(8, 0.22)
    base = lathe([(1.75 * r, 0), (1.75 * r, 0.35)], 8).at(turn("y", 22.5))
    base_top = lathe([(1.75 * r, 0.35), (1.55 * r, 0.42)], 8).at(turn("y", 22.5))
    shaft = lathe([(1.42 * r, 0.40), (1.46 * r, 0.48), (1.36 * r, 0.58), (1.22 * r, 0.62), (1.26 * r, 0.70),
                   (1.1 * r, 0.80), (r, 0.86), (r, height - 1.0)], segments, lobes)
    ring = lathe([(r, height - 1.0), (1.1 * r, height - 0.96), (1.1 * r, height - 0.90), (r, height - 0.86)],
                 segments, lobes)
    # Leaves curl outwards in two rows.
    y = np.linspace(height - 0.86, height - 0.22, 10)
    t = (y - y[0]) / (y[-1] - y[0])
    angles = np.linspace(0, 2 * math.pi, segments + 1)
    bell = r * (1.02 + 0.5 * t ** 2.2)
    curl = 0.10 * r * np.maximum(np.sin(2 * math.pi * t), 0) + 0.16 * r * np.maximum(np.sin(math.pi * t) - 0.3, 0)
    leaf = 1 + np.outer(np.cos(16 * angles), curl / bell) + np.outer(clustered(8, 0.16)(angles) - 1, 1 - 0.6 * t)
    out = bell * leaf
    capital = patch(np.stack([out * np.sin(angles)[:, None], np.broadcast_to(y, out.shape),
                              out * np.cos(angles)[:, None]], axis=2), closed_u=True)
    top = [(1.62 * r, height - 0.22), (1.72 * r, height - 0.16), (1.72 * r, height - 0.04), (1.66 * r, height),
           (0.3, height)]
    abacus = lathe(top, 8).at(turn("y", 22.5))
    return [base, base_top, shaft, ring, capital, abacus]


def shaft(radius, low, high, segments=8):
    """A thin column with a little base and a flowered capital."""
    r = radius
    return lathe([(1.9 * r, low), (1.9 * r, low + 0.8 * r), (1.6 * r, low + 1.7 * r), (r, low + 2.4 * r),
                  (r, high - 4.6 * r), (1.2 * r, high - 3.0 * r), (2.2 * r, high - 0.9 * r), (2.2 * r, high)],
                 segments)


def vault(width, length, rise, steps=10):
    """Webs and ribs of one bay over width x length, springing at y = 0, middle at x = z = 0."""
    webs, ribs = [], []
    s = np.linspace(0, 1, steps + 1)
    for k in range(4):
        a, b = (width / 2, length / 2) if k % 2 == 0 else (length / 2, width / 2)
        for sign in (-1, 1):
            # From the crown (t = 0) to the side; s runs from the ridge to the groin.
            t, u = np.meshgrid(s, s, indexing="ij")
            y = rise * pointed(u * t) + 0.12 * np.sin(math.pi * t) * (1 - u)
            grid = np.stack([sign * a * u * t, y, b * t], axis=2)
            web = patch(grid if sign > 0 else grid.transpose(1, 0, 2))
            web = web if web.normals[:, 1].sum() < 0 else web.flipped()
            web.uvs = web.points[:, [0, 2]].copy()
            webs.append(web.at(turn("y", 90 * k)))
    t = np.linspace(-1, 1, 2 * steps + 1)
    for sign in (-1, 1):
        path = np.stack([width / 2 * t, rise * pointed(t) - 0.02, sign * length / 2 * t], axis=1)
        axis = np.cross([width, 0, sign * length], [0, 1, 0])
        ribs.append(arch_sweep(rib_profile(0.30), path, axis))
    boss = lathe([(0, -0.30), (0.14, -0.27), (0.24, -0.16), (0.34, -0.12), (0.30, 0.05)], 16,
                 lambda a: 1 + 0.1 * np.cos(8 * a)).at(move(0, rise - 0.02, 0))
    return webs, ribs + [boss]


def arch_sweep(profile, path, axis):
    """A profile along an arch in the upright plane whose normal is `axis`: its up points out of the arch."""
    profile, path = np.asarray(profile), np.asarray(path)
    start = path[1] - path[0]
    side = np.cross(start, axis)  # sweep()'s side at the arch's foot
    inwards = path[-1] - path[0]
    if side @ inwards > 0:
        return sweep(np.stack([-profile[:, 1], profile[:, 0]], axis=1), path, axis)
    return sweep(np.stack([profile[:, 1], profile[:, 0]], axis=1)[::-1], path, axis)


def moulded_arch(opening, width=0.34, z=0.0, axis=(0, 0, 1)):
    """A rib along the arched part of an opening."""
    arc = np.asarray(opening)[1:-1] if opening[0][0] == opening[1][0] else np.asarray(opening)
    return arch_sweep(rib_profile(width), on_path(arc, z), axis)


def tracery(half, foot, spring, top_sharp=2.0):
    """Bars of a window of two lights under a circle, in the plane z = 0; without its glass."""
    bar = np.array([(0.05, -0.09), (0.05, 0.09), (-0.05, 0.09), (-0.05, -0.09), (0.05, -0.09)])
    pieces = [tube([(0, foot, 0), (0, spring + 0.05, 0)], 0.09, 8)]
    light = half / 2
    for s in (-1, 1):
        arc = pointed_arch(light, spring - 0.1, spring - 0.1, 10) + [s * light, 0]
        pieces.append(sweep(bar, on_path(arc), (0, 0, 1)))
        cusp = circle(light * 0.42, 8, 20, 160) + [s * light, spring + 0.1]
        pieces.append(tube(on_path(cusp), 0.035, 5))
    rise = half * math.sqrt(2 * top_sharp - 1)
    middle = spring + 0.52 * rise
    radius = 0.40 * half
    ring = circle(radius, 20) + [0, middle]
    pieces.append(sweep(bar, on_path(ring), (0, 0, 1)))
    for k in range(4):
        foil = circle(radius * 0.42, 9) + radius * 0.48 * np.array(
            [math.cos(math.radians(90 * k + 45)), math.sin(math.radians(90 * k + 45))]) + [0, middle]
        pieces.append(tube(on_path(foil), 0.035, 5))
    return pieces


def pane(half, foot, top):
    """The glass of a window: one rectangle behind it."""
    return rectangle(2 * half, top - foot).at(move(0, foot, 0))


def window(part, half, foot, spring, width, low, high, depth, glass="window"):
    """A wall with a traceried window, its outside towards -Z; fills low .. high."""
    top = spring + half * math.sqrt(3)
    opening = pointed_arch(half, spring, foot, 14)
    part.add("ashlar", arched_wall(opening, width, high, depth, rows=2, back=False))
    if foot > low:
        part.add("ashlar", faceted([[(-width / 2, low, depth / 2), (width / 2, low, depth / 2),
                                     (width / 2, foot, depth / 2), (-width / 2, foot, depth / 2)]]))
        # A sloping sill.
        part.add("stone", faceted([[(-half, foot, depth / 2 + 0.05), (half, foot, depth / 2 + 0.05),
                                    (half, foot + 0.35, -depth / 2), (-half, foot + 0.35, -depth / 2)]]))
    part.add("stone", *[m.at(move(0, 0, -0.15)) for m in tracery(half, foot, spring)])
    part.add("stone", moulded_arch(opening, 0.26, depth / 2))
    for s in (-1, 1):
        part.add("stone", shaft(0.07, foot, spring).at(move(s * (half + 0.02), 0, depth / 2 + 0.02)))
    part.add(glass, pane(half, foot, top).at(move(0, 0, -depth / 2 + 0.05)))


def bay_side():
    """One bay of the north side, seen from the nave: built along X, later turned; x is along the nave,
    +Z towards its middle. Its arcade stands in z = 0, the aisle behind it."""
    part = Part("bay")
    # Arcade.
    clear = BAY / 2 - 0.55
    opening = pointed_arch(clear, PIER, PIER, 18)
    part.add("ashlar", arched_wall(opening, BAY, STRING[0], 1.1, rows=3))
    for z in (0.55, -0.55):
        part.add("stone", moulded_arch(opening, 0.42, z))
    part.add("stone", string_course([(-BAY / 2, STRING[0], 0.55), (BAY / 2, STRING[0], 0.55)]))
    # Triforium: four openings before a dark passage.
    low, high = STRING[0], STRING[1]
    count, width = 4, (BAY - 1.0) / 4
    for k in range(count):
        x = (k - (count - 1) / 2) * width
        arch = pointed_arch(width / 2 - 0.16, low + 2.0, low + 0.5, 8)
        part.add("ashlar", arched_wall(arch, width, high, 0.5, rows=1, back=False).at(move(x, 0, 0.3)))
        part.add("ashlar", faceted([[(x - width / 2, low, 0.55), (x + width / 2, low, 0.55),
                                     (x + width / 2, low + 0.5, 0.55), (x - width / 2, low + 0.5, 0.55)]]))
        part.add("stone", moulded_arch(arch, 0.16, 0.55).at(move(x, 0, 0)))
        foil = circle(0.16, 10) + [x + width / 2, low + 2.95]
        if k < count - 1:
            part.add("stone", tube(on_path(foil, 0.55), 0.04, 5))
    for k in range(count + 1):
        part.add("stone", shaft(0.085, low + 0.5, low + 2.0).at(move((k - count / 2) * width, 0, 0.56)))
    for s in (-1, 1):
        x = s * (BAY / 2 - 0.25)
        part.add("ashlar", box(0.5, high - low, 0.5, 0, (x, (low + high) / 2, 0.3)))
    part.add("plaster", faceted([[(-BAY / 2, low, -0.55), (BAY / 2, low, -0.55), (BAY / 2, high, -0.55),
                                  (-BAY / 2, high, -0.55)]]))
    part.add("stone", string_course([(-BAY / 2, high, 0.55), (BAY / 2, high, 0.55)]))
    # Clerestory, in the wall arch of the vault.
    window(part, 1.45, high + 1.2, high + 4.0, BAY, high, SPRING + RISE + 0.3, 0.9)
    part.add("stone", arch_sweep(rib_profile(0.3), np.stack(
        [BAY / 2 * np.linspace(-1, 1, 19), SPRING + RISE * pointed(np.linspace(-1, 1, 19)),
         np.full(19, 0.45)], axis=1), (0, 0, 1)))
    # Aisle: its vault, its outer wall with a window over a blind arcade.
    rise = 3.6
    webs, ribs = vault(BAY, AISLE - 0.4, rise, 4)
    middle = move(0, PIER - 0.4, -AISLE / 2 - 0.1)
    part.add("web", *[m.at(middle) for m in webs])
    part.add("stone", *[m.at(middle) for m in ribs])
    outer = Part("outer wall")
    window(outer, 1.35, 3.6, 6.6, BAY, 0, PIER + rise, 0.8)
    outer.add("stone", string_course([(-BAY / 2, 3.3, 0.4), (BAY / 2, 3.3, 0.4)]))
    outer.add("stone", string_course([(-BAY / 2, 0.3, 0.4), (BAY / 2, 0.3, 0.4)], 0.8))
    for k in range(5):
        x = (k - 2) * 1.0
        arch = pointed_arch(0.38, 2.0, 0.5, 8)
        outer.add("stone", moulded_arch(arch, 0.15, 0.5).at(move(x, 0, 0)))
    for k in range(6):
        outer.add("stone", shaft(0.06, 0.5, 2.0, 6).at(move(k - 2.5, 0, 0.5)))
    for material, meshes in outer.pieces.items():
        part.add(material, *[m.at(move(0, 0, -AISLE - 0.35)) for m in meshes])
    return part


def pier_part():
    """A pier with the shafts that rise from it to both vaults, and the wall's half pier across the aisle."""
    part = Part("pier")
    part.add("stone", *pier(0.62, PIER))
    for x in (-0.17, 0.0, 0.17):
        r = 0.13 if x == 0 else 0.09
        z = 0.66 if x == 0 else 0.6
        part.add("stone", shaft(r, PIER, SPRING).at(move(x, 0, z)))
    part.add("stone", shaft(0.14, PIER - 2.6, PIER - 0.4).at(move(0, 0, -0.72)))
    for x in (-0.2, 0.0, 0.2):
        part.add("stone", shaft(0.12, 0, PIER - 0.4).at(move(x, 0, -AISLE + 0.12 - 0.1 * (x != 0))))
    # The arch across the aisle.
    t = np.linspace(-1, 1, 21)
    path = np.stack([np.zeros(21), PIER - 0.4 + 3.6 * pointed(t), -AISLE / 2 - 0.1 + (AISLE - 0.4) / 2 * t], axis=1)
    part.add("stone", arch_sweep(rib_profile(0.4), path, (1, 0, 0)))
    return part


def nave_vault():
    part = Part("nave vault")
    webs, ribs = vault(2 * NAVE - 0.9, BAY, RISE, 9)
    part.add("web", *webs)
    part.add("stone", *ribs)
    return part


def nave_arch():
    part = Part("transverse arch")
    t = np.linspace(-1, 1, 23)
    path = np.stack([(NAVE - 0.45) * t, RISE * pointed(t) - 0.03, np.zeros(23)], axis=1)
    part.add("stone", arch_sweep(rib_profile(0.46), path, (0, 0, 1)))
    return part


def pew():
    """A bench with carved ends, facing -Z."""
    part = Part("pew")
    end = [(-0.28, 0), (0.24, 0), (0.26, 0.42), (0.20, 0.50), (0.02, 0.55), (-0.05, 0.70), (-0.08, 0.92), (-0.04, 1.02),
           (-0.08, 1.12), (-0.18, 1.15), (-0.26, 1.08), (-0.27, 0.9), (-0.24, 0.6)]
    for s in (-1, 1):
        part.add("wood", prism(end, 0.07, 0.012).at(turn("y", 90), move(s * 1.72, 0, 0)))
    part.add("wood", box(3.4, 0.05, 0.42, 0.012, (0, 0.44, -0.02)),
             box(3.4, 0.52, 0.04, 0.012, (0, 0.76, 0.2)).at(turn("x", 4)),
             box(3.4, 0.10, 0.03, 0, (0, 0.36, -0.2)), box(3.4, 0.05, 0.16, 0, (0, 0.88, 0.30)),
             box(3.4, 0.04, 0.18, 0, (0, 0.16, 0.42)))
    return part


def candle(height, radius=0.028):
    wax = lathe([(radius, 0), (radius, height), (0.5 * radius, height - 0.006), (0, height - 0.006)], 8)
    flame = lathe([(0, height), (0.010, height + 0.015), (0.013, height + 0.03), (0.006, height + 0.055),
                   (0, height + 0.08)], 6)
    return wax, flame


def chandelier():
    """A wheel of brass with sixteen candles, hung on chains; the middle of its ring at the origin."""
    part = Part("chandelier")
    radius = 1.25
    part.add("brass", tube([(radius * math.sin(a), 0, radius * math.cos(a)) for a in np.linspace(0, 2 * math.pi, 41)],
                           0.045, 6, closed=True))
    part.add("brass", tube([(0.55 * math.sin(a), 0.5, 0.55 * math.cos(a)) for a in np.linspace(0, 2 * math.pi, 25)],
                           0.03, 6, closed=True))
    part.add("brass", lathe([(0, -0.30), (0.07, -0.26), (0.12, -0.16), (0.08, -0.06), (0.16, 0.02), (0.08, 0.12),
                             (0.05, 0.5), (0.10, 0.6), (0.05, 0.72), (0.03, 1.5)], 16))
    for k in range(8):
        a = math.radians(45 * k)
        tip = np.array([math.sin(a), 0, math.cos(a)])
        part.add("brass", tube(bent([0.08 * tip, 0.5 * tip + [0, -0.16, 0], radius * tip], 0.3, 5), 0.022, 6))
        part.add("brass", tube([radius * tip, 0.03 * tip + [0, 1.9, 0]], 0.012, 5))
    part.add("brass", tube([(0, 1.5, 0), (0, 9.6, 0)], 0.025, 6))
    for k in range(16):
        a = math.radians(22.5 * k + 11.25)
        at = move(radius * math.sin(a), 0.0, radius * math.cos(a))
        part.add("brass", lathe([(0.02, 0.03), (0.07, 0.07), (0.075, 0.10), (0.03, 0.10)], 10).at(at))
        wax, flame = candle(0.24)
        part.add("wax", wax.at(at, move(0, 0.1, 0)))
        part.add("flame", flame.at(at, move(0, 0.1, 0)))
    return part


def altar():
    part = Part("altar")
    for k in range(4):
        w, y = 5.2 - 0.7 * k, 0.17 * k
        part.add("marble", box(w, 0.17, 3.6 - 0.6 * k, 0.012, (0, y + 0.085, 0.4 - 0.1 * k)))
    y = 0.68
    part.add("marble", box(2.3, 0.9, 0.9, 0.02, (0, y + 0.45, 0)), box(2.6, 0.1, 1.15, 0.02, (0, y + 0.97, 0)))
    for k in range(5):
        arch = pointed_arch(0.17, 0.5, 0.12, 10)
        part.add("brass", tube(on_path(arch, 0.46), 0.018, 6).at(move((k - 2) * 0.44, y, 0)))
    part.add("cloth", box(0.9, 0.012, 1.2, 0, (0, y + 1.028, 0)), box(0.9, 0.55, 0.012, 0, (0, y + 0.76, 0.585)))
    part.add("brass", box(0.07, 1.3, 0.05, 0.01, (0, y + 1.75, -0.3)), box(0.62, 0.07, 0.05, 0.01, (0, y + 2.05, -0.3)),
             lathe([(0.2, 0), (0.2, 0.04), (0.06, 0.12), (0.04, 0.2)], 16).at(move(0, y + 1.02, -0.3)))
    for x in (-1.05, -0.8, -0.55, 0.55, 0.8, 1.05):
        height = 0.62 - 0.35 * (abs(x) - 0.55)
        part.add("brass", lathe([(0.09, 0), (0.09, 0.02), (0.03, 0.06), (0.02, 0.14), (0.04, 0.18), (0.02, 0.22),
                                 (0.02, 0.30), (0.06, 0.33)], 12).at(move(x, y + 1.02, -0.15)))
        wax, flame = candle(height)
        part.add("wax", wax.at(move(x, y + 1.34, -0.15)))
        part.add("flame", flame.at(move(x, y + 1.34, -0.15)))
    return part


def apse(level):
    """Five tall windows round the altar, under a half vault of ribs that meet in the crown."""
    sides, radius = 5, NAVE - 0.45
    panel = 2 * radius * math.tan(math.radians(90 / sides))
    part = Part("apse side")
    window(part, 0.95, 3.2, 15.4, panel + 0.1, 0, SPRING + RISE, 0.8, "choir window")
    part.add("stone", string_course([(-panel / 2, 2.9, 0.4), (panel / 2, 2.9, 0.4)]))
    part.add("stone", string_course([(-panel / 2, 0.3, 0.4), (panel / 2, 0.3, 0.4)], 0.8))
    for k in range(3):
        part.add("stone", moulded_arch(pointed_arch(0.42, 1.7, 0.5, 12), 0.15, 0.5).at(move((k - 1) * 1.08, 0, 0)))
    corner = Part("apse shaft")
    corner.add("stone", shaft(0.15, 0, SPRING, 12), shaft(0.10, 0, SPRING).at(move(0.22, 0, 0.05)),
               shaft(0.10, 0, SPRING).at(move(-0.22, 0, 0.05)))
    t = np.linspace(0, 1, 21)
    rib = np.stack([np.zeros(21), SPRING + RISE * pointed(t) - 0.03, radius * t], axis=1)
    ribs = Part("apse rib")
    ribs.add("stone", arch_sweep(rib_profile(0.34), rib, (1, 0, 0)))
    for k in range(sides):
        angle = -72 + 36 * k
        level.place(part, move(0, 0, -radius - 0.4), turn("y", angle), move(0, 0, END))
    for k in range(sides + 1):
        angle = 90 + 36 * k
        out = radius / math.cos(math.radians(90 / sides))
        level.place(corner, move(0, 0, out - 0.15), turn("y", angle), move(0, 0, END))
        level.place(ribs, turn("y", angle), move(0, 0, END))
    web = Part("apse vault")
    u = np.linspace(0, 1, 13)
    for k in range(sides):
        for half in (-1, 1):
            a0 = math.radians(180 + (-72 + 36 * k))
            a1 = a0 + half * math.radians(18)
            s, v = np.meshgrid(np.linspace(0, 1, 5), u, indexing="ij")
            x = radius * v * ((1 - s) * math.sin(a0) + s * math.sin(a1) / math.cos(math.radians(18)))
            z = radius * v * ((1 - s) * math.cos(a0) + s * math.cos(a1) / math.cos(math.radians(18)))
            y = SPRING + RISE * pointed(v * s)
            mesh = patch(np.stack([x, y, z], axis=2))
            mesh = mesh if mesh.normals[:, 1].sum() < 0 else mesh.flipped()
            mesh.uvs = mesh.points[:, [0, 2]].copy()
            web.add("web", mesh)
    level.place(web, move(0, 0, END))


def west_wall(level):
    part = Part("west wall")
    radius, middle = 3.1, 14.6
    a = np.linspace(0, 2 * math.pi, 49)
    ring = np.stack([radius * np.cos(a), middle + radius * np.sin(a)], axis=1)
    half = NAVE + 0.2
    low, high = 9.0, SPRING + RISE + 0.4
    edge = []
    for x, y in ring - [0, middle]:
        reach = min(half / max(abs(x), 1e-9), ((high - middle) if y > 0 else (middle - low)) / max(abs(y), 1e-9))
        edge.append((x * reach, middle + y * reach))
    grid = np.stack([on_path(ring), on_path(edge)])
    wall = patch(grid)
    wall = wall if wall.normals[:, 2].sum() > 0 else wall.flipped()
    wall.normals[:] = 0, 0, 1
    wall.uvs = wall.points[:, :2] * [1, -1]
    part.add("ashlar", wall)
    part.add("ashlar", patch(np.stack([on_path(ring, 0.0), on_path(ring, -0.6)])))
    bar = np.array([(0.07, -0.1), (0.07, 0.1), (-0.07, 0.1), (-0.07, -0.1), (0.07, -0.1)])
    for r in (radius, 0.66 * radius, 0.3 * radius):
        part.add("stone", sweep(bar, on_path(circle(r, 36) + [0, middle], -0.2), (0, 0, 1)))
    for k in range(12):
        angle = math.radians(30 * k)
        d = np.array([math.cos(angle), math.sin(angle), 0])
        part.add("stone", tube([0.3 * radius * d + [0, middle, -0.2], 0.66 * radius * d + [0, middle, -0.2]], 0.06, 6))
        d = np.array([math.cos(angle + 0.26), math.sin(angle + 0.26)])
        for r, size_ in ((0.82, 0.17), (0.5, 0.11)):
            part.add("stone", tube(on_path(circle(size_ * radius, 12) + r * radius * d + [0, middle], -0.2), 0.045, 5))
    part.add("stone", tube(on_path(circle(radius + 0.1, 40) + [0, middle], 0.05), 0.16, 8))
    part.add("rose", rectangle(2 * radius, 2 * radius).at(move(0, middle - radius, -0.5)))
    # Below: the doors in a deep portal.
    door = pointed_arch(1.7, 3.4, 0.0, 24)
    part.add("ashlar", arched_wall(door, 2 * half, low, 1.2, rows=2, back=False).at(move(0, 0, -0.6)))
    for k in range(3):
        order = pointed_arch(1.7 + 0.22 * k, 3.4, 0.0, 24)
        part.add("stone", moulded_arch(order, 0.26, 0.04 + 0.05 * k))
        for s in (-1, 1):
            part.add("stone", shaft(0.1, 0, 3.4).at(move(s * (1.7 + 0.22 * k), 0, 0.06 + 0.05 * k)))
    part.add("wood", rectangle(3.5, 6.6).at(move(0, 0, -0.9)))
    for s in (-1, 1):
        for k in range(6):
            part.add("iron", box(1.5, 0.09, 0.03, 0.01, (s * 0.85, 0.5 + 0.85 * k, -0.88)))
    part.add("stone", string_course([(-half, low, 0.02), (half, low, 0.02)], 1.4))
    # The aisles' ends.
    for s in (-1, 1):
        x = s * (NAVE + AISLE / 2 + 0.3)
        part.add("ashlar", faceted([[(x - 3.2, 0, 0), (x + 3.2, 0, 0), (x + 3.2, 11, 0), (x - 3.2, 11, 0)]]))
    level.place(part, turn("y", 180))
    east = Part("aisle's end")
    east.add("ashlar", faceted([[(-3.2, 0, 0), (3.2, 0, 0), (3.2, 11, 0), (-3.2, 11, 0)]]))
    for s in (-1, 1):
        level.place(east, move(s * (NAVE + 3.2), 0, END))


def build():
    pale = from_srgb(0.74, 0.70, 0.63)
    level = Level("Cathedral", {
        "ashlar": surfaces.masonry(pale, 6, 4, seed=21, tile=2.4, spread=0.13, depth=0.004),
        "stone": surfaces.stone(from_srgb(0.79, 0.75, 0.68), seed=23, tile=1.2),
        "web": surfaces.masonry(from_srgb(0.76, 0.73, 0.68), 10, 3, seed=25, tile=2.5, spread=0.08, depth=0.002),
        "plaster": surfaces.plaster(from_srgb(0.42, 0.38, 0.33), seed=27),
        "floor": surfaces.paving(from_srgb(0.76, 0.71, 0.62), from_srgb(0.30, 0.27, 0.26), seed=29, tiles=6, tile=4.8,
                                 gloss=0.62),
        "wood": surfaces.wood(from_srgb(0.42, 0.26, 0.15), seed=31, boards=3),
        "marble": surfaces.marble(from_srgb(0.90, 0.88, 0.84), from_srgb(0.50, 0.44, 0.42), seed=33),
        "brass": surfaces.metal((0.93, 0.72, 0.38), seed=35, gloss=0.52),
        "iron": surfaces.metal((0.30, 0.29, 0.28), seed=37, gloss=0.42),
        "wax": surfaces.plaster(from_srgb(0.94, 0.90, 0.80), 128, seed=39, tile=0.3, rough=0.0003),
        "flame": surfaces.glow((1.0, 0.82, 0.45)),
        "carpet": surfaces.cloth(from_srgb(0.55, 0.07, 0.08), from_srgb(0.80, 0.56, 0.20), seed=41, tile=1.4),
        "cloth": surfaces.cloth(from_srgb(0.90, 0.88, 0.82), from_srgb(0.78, 0.60, 0.24), 256, seed=43, tile=0.9),
        "window": surfaces.glass_window(seed=45, strength=5.0),
        "choir window": surfaces.glass_window(seed=47, strength=9.0),
        "rose": surfaces.glass_rose(seed=49, strength=9.0),
    })
    bay, pier_, vault_, arch = bay_side(), pier_part(), nave_vault(), nave_arch()
    for k in range(BAYS):
        z = -(k + 0.5) * BAY
        for s in (-1, 1):
            level.place(bay, turn("y", -90 * s), move(s * NAVE, 0, z))
        level.place(vault_, move(0, SPRING, z))
    for k in range(BAYS + 1):
        for s in (-1, 1):
            level.place(pier_, turn("y", -90 * s), move(s * NAVE, 0, -k * BAY))
        level.place(arch, move(0, SPRING, -k * BAY))
    apse(level)
    west_wall(level)

    floor = Part("floor")
    wide = NAVE + AISLE + 1
    floor.add("floor", ground(-wide, wide, END - NAVE, 0.2, 8, 12))
    floor.add("carpet", box(2.0, 0.012, -END - 3, 0, (0, 0.006, END / 2 - 1.0)))
    level.place(floor)
    bench = pew()
    for row in range(17):
        for s in (-1, 1):
            level.place(bench, move(s * 3.0, 0, -6.2 - 1.15 * row))
    level.place(altar(), move(0, 0, END - 1.6))

    lamp = chandelier()
    warm = (1.0, 0.80, 0.56)
    for z in (-7.5, -18.0, -28.5):
        level.place(lamp, move(0, 9.2, z))
        level.light("point", warm, 230.0, move(0, 8.0, z), 34.0)
    level.light("point", warm, 90.0, move(0, 3.6, END - 0.6), 24.0)
    level.light("point", (1.0, 0.88, 0.72), 160.0, move(0, 15.0, END + 2.6), 34.0)

    # Figures before the piers take what is left.
    spots = [(s * (NAVE - 0.95), -k * BAY) for k in (2, 4) for s in (-1, 1)]
    stand = Part("bracket")
    stand.add("stone", lathe([(0.02, 0), (0.1, 0.1), (0.16, 0.3), (0.3, 0.42), (0.34, 0.5), (0.34, 0.6), (0, 0.6)], 16),
              lathe([(0.36, 2.9), (0.40, 2.95), (0.40, 3.05), (0.28, 3.2), (0.12, 3.6), (0.05, 4.0), (0.08, 4.05),
                     (0, 4.15)], 8))
    for x, z in spots:
        level.place(stand, move(x, 2.6, z))
    rows = 64
    columns = (TRIANGLES - level.triangle_count()) // (2 * rows * len(spots))
    figure = Part("saint")
    figure.add("stone", statue.robed_figure(max(columns, 12), rows))
    for x, z in spots:
        level.place(figure, turn("y", -90 if x > 0 else 90), move(x, 3.2, z))

    level.camera("nave", (0.0, 2.3, -0.8), (0, 8.0, END), 66, 16 / 9)
    level.camera("aisle", (-NAVE - 2.9, 1.8, -2.0), (-NAVE - 1.2, 3.6, -24.0), 62, 16 / 9)
    level.camera("vault", (2.6, 1.9, -10.0), (-1.6, 12.4, -28.0), 72, 16 / 9)
    level.camera("west", (0.6, 4.8, END - 2.0), (0, 8.6, 0), 62, 16 / 9)
    level.camera("altar", (1.8, 2.0, END + 9.5), (0, 3.9, END - 3), 52, 16 / 9)
    return level
