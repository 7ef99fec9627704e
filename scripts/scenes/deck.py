"""A hall on a ship's deck, 16 sections of 8 m: plated walls between heavy frames, catwalks, pipes, ducts,
cables, crates, machines, consoles, stairs and doors. The sun falls through open slots in the roof; 49 lamps
with ranges do the rest. build_small() is one section, with as many lights as one wants.

The hall runs along -Z. Halves are built on the +X side and mirrored.
"""

import math

import numpy as np

from . import surfaces
from .gltf import Level, Part, looking
from .mesh import (bent, box, circle, faceted, lathe, merge, move, on_path, patch, prism, rectangle, size, sweep,
                   tube, turn)
from .texture import from_srgb

TRIANGLES = 1_804_000
SECTIONS, LENGTH = 16, 8.0
HALF, HEIGHT = 11.0, 10.0
WALK = 4.4                 # level of the catwalks
MIRROR = size(-1, 1, 1)


# ---- Small things


def bolt(radius=0.03):
    """A hexagonal head, up along Y."""
    r = radius
    return lathe([(r, 0), (r, 0.8 * r), (0, 0.8 * r)], 6)


def along(mesh, points):
    return [mesh.at(move(*p)) for p in points]


def plate(width, height, thick, bolts=True, inset=0.08):
    """A panel in the XY plane with its bolts, facing +Z, from its lower left corner."""
    parts = [box(width - 0.02, height - 0.02, thick, min(0.02, 0.4 * thick), (width / 2, height / 2, 0))]
    if bolts:
        head = bolt(0.018).at(turn("x", 90))
        for x in (inset, width - inset):
            for y in (inset, height - inset):
                parts.append(head.at(move(x, y, thick / 2)))
    return parts


def quilt(width, height, seed, least=0.45, depth=0.06):
    """A wall of panels of many sizes, some raised, some with vents; as (material, mesh)."""
    rng = np.random.default_rng(seed)
    pending, out = [(0.0, 0.0, width, height)], []
    while pending:
        x, y, w, h = pending.pop()
        if max(w, h) > 2 * least and (max(w, h) > 3.5 * least or rng.random() < 0.75):
            t = rng.choice([0.35, 0.5, 0.5, 0.65])
            if w > h:
                pending += [(x, y, t * w, h), (x + t * w, y, (1 - t) * w, h)]
            else:
                pending += [(x, y, w, t * h), (x, y + t * h, w, (1 - t) * h)]
            continue
        thick = depth * rng.choice([0.6, 1.0, 1.0, 1.7])
        kind = rng.choice(["hull", "hull", "dark", "pale", "vent", "box"], p=[0.34, 0.2, 0.16, 0.14, 0.1, 0.06])
        here = move(x, y, 0)
        if kind == "vent" and min(w, h) > 0.25:
            out += [("dark", m.at(here)) for m in plate(w, h, 0.5 * depth)]
            count = int(h / 0.06)
            for k in range(count):
                slat = box(w - 0.16, 0.012, 0.06).at(turn("x", 40), move(w / 2, 0.1 + (h - 0.2) * (k + 0.5) / count, 0.05))
                out.append(("steel", slat.at(here)))
        else:
            out += [(kind if kind in ("hull", "dark", "pale") else "hull", m.at(here)) for m in plate(w, h, thick)]
            if kind == "box" and min(w, h) > 0.3:
                out.append(("accent", box(0.6 * w, 0.6 * h, 0.16, 0.03, (w / 2, h / 2, 0.08)).at(here)))
                for k in range(3):
                    out.append(("steel", box(0.5 * w, 0.02, 0.02, 0.004, (w / 2, h * (0.4 + 0.1 * k), 0.17)).at(here)))
    return out


def add_all(part, pieces, *steps):
    for material, mesh in pieces:
        part.add(material, mesh.at(*steps))


def pipe(points, radius, material="pipe", segments=20, flange=2.0, rounding=None):
    """A pipe with rounded bends and bolted flanges; as (material, mesh)."""
    path = bent(points, 3 * radius if rounding is None else rounding, 8)
    out = [(material, tube(path, radius, segments))]
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    where = np.concatenate([[0], np.cumsum(steps)])
    for s in np.arange(0.5 * flange, where[-1] - 0.2, flange):
        k = np.searchsorted(where, s) - 1
        point = path[k] + (path[k + 1] - path[k]) * (s - where[k]) / steps[k]
        d = (path[k + 1] - path[k]) / steps[k]
        if steps[k] < 0.5:
            continue
        r = radius
        disc = lathe([(r, -0.06), (1.45 * r, -0.06), (1.5 * r, -0.045), (1.5 * r, 0.045), (1.45 * r, 0.06), (r, 0.06)], segments)
        heads = [bolt(0.1 * r + 0.006).at(move(1.28 * r * math.sin(a), 0.06, 1.28 * r * math.cos(a)))
                 for a in np.linspace(0, 2 * math.pi, 9)[:-1]]
        aligned = merge([disc] + heads).at(pointing(d), move(*point))
        out.append(("steel", aligned))
    return out


def pointing(direction):
    """Turns +Y to a direction."""
    d = np.asarray(direction, float)
    helper = np.array([1.0, 0, 0]) if abs(d[0]) < 0.9 else np.array([0, 0, 1.0])
    x = np.cross(d, helper)
    x /= np.linalg.norm(x)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = x, d, np.cross(x, d)
    return matrix


def hanging(a, b, sag, steps):
    t = np.linspace(0, 1, steps + 1)[:, None]
    path = (1 - t) * np.asarray(a, float) + t * np.asarray(b, float)
    path[:, 1] -= 4 * sag * (t * (1 - t))[:, 0]
    return path


def grating(width, length, pitch=0.09):
    """Bars one way and the other, in the XZ plane from the origin, up to y = 0."""
    bars = []
    for x in np.arange(0.5 * pitch, width, pitch):
        bars.append(box(0.012, 0.05, length, 0, (x, -0.025, length / 2)))
    for z in np.arange(0.25, length, 0.5):
        bars.append(box(width, 0.02, 0.012, 0, (width / 2, -0.012, z)))
    frame = [box(0.05, 0.1, length, 0.008, (x, -0.05, length / 2)) for x in (0.0, width)]
    frame += [box(width, 0.1, 0.05, 0.008, (width / 2, -0.05, z)) for z in (0.025, length - 0.025)]
    return bars + frame


def railing(path, posts, height=1.1):
    """Posts and three rails along a straight line on the floor."""
    a, b = np.asarray(path[0], float), np.asarray(path[1], float)
    out = []
    for t in np.linspace(0, 1, posts):
        p = a + t * (b - a)
        out.append(("rail", tube([p, p + [0, height, 0]], 0.03, 10)))
        out.append(("steel", lathe([(0.07, 0), (0.07, 0.02), (0.04, 0.05)], 10).at(move(*p))))
    for y, r in ((height, 0.036), (0.72 * height, 0.02), (0.4 * height, 0.02)):
        out.append(("rail", tube([a + [0, y, 0], b + [0, y, 0]], r, 12)))
    toe = 0.5 * (a + b)
    length = np.linalg.norm(b - a)
    out.append(("hazard", box(0.012, 0.12, length, 0, (toe[0], toe[1] + 0.06, toe[2])) if abs(b[2] - a[2]) > abs(b[0] - a[0])
                else box(length, 0.12, 0.012, 0, (toe[0], toe[1] + 0.06, toe[2]))))
    return out


# ---- The hall


PROFILE = [(11.0, 0.0), (11.0, 3.4), (11.6, 4.2), (11.6, 6.6), (8.6, 9.6), (3.2, 10.0), (0.0, 10.0)]  # x, y


def beam(width, height, web=0.06):
    """An I, as (side, up)."""
    w, h, t = width / 2, height / 2, web / 2
    return np.array([(-w, -h), (w, -h), (w, -h + 2 * t), (t, -h + 2 * t), (t, h - 2 * t), (w, h - 2 * t), (w, h), (-w, h),
                     (-w, h - 2 * t), (-t, h - 2 * t), (-t, -h + 2 * t), (-w, -h + 2 * t), (-w, -h)])


def frame_half():
    """A frame across the hall, at z = 0: a beam along the wall with stiffeners, bolts and a foot."""
    part = Part("frame")
    line = on_path([(x - 0.25 if k < 4 else x, y - (0.0 if k < 4 else 0.3)) for k, (x, y) in enumerate(PROFILE)])
    part.add("accent", sweep(beam(0.5, 0.55), bent(line, 0.5, 5), (0, 0, 1)))
    steps = np.diff(line, axis=0)
    for (a, d) in zip(line, steps):
        length = np.linalg.norm(d)
        d = d / length
        inward = np.array([-d[1], d[0], 0])
        for s in np.arange(0.4, length - 0.2, 0.55):
            p = a + s * d
            matrix = np.eye(4)
            matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = inward, d, np.cross(inward, d)
            part.add("accent", box(0.42, 0.03, 0.44, 0.006).at(matrix, move(*p)))
            for z in (-0.17, 0.17):
                for off in (-0.12, 0.12):
                    part.add("steel", bolt(0.024).at(pointing(inward), move(*(p + off * d + 0.276 * inward + [0, 0, z]))))
    part.add("dark", box(1.0, 0.5, 0.9, 0.05, (10.7, 0.25, 0)), box(0.8, 0.3, 0.7, 0.04, (10.7, 0.62, 0)))
    part.add("hazard", box(0.3, 1.1, 0.56, 0.02, (10.46, 1.4, 0)))
    return part


def wall_half(seed):
    """One side of a section, z from -LENGTH to 0."""
    part = Part("side %d" % seed)
    w = LENGTH - 0.56
    inner = turn("y", -90)  # +Z of a panel wall becomes -X
    # Lower wall, with a recess for pipes above it and panels up to the roof.
    place = lambda x, y, lean=0.0: (turn("x", lean), inner, move(x, y, -LENGTH + 0.28))
    add_all(part, quilt(w, 1.5, seed, 0.5), *place(11.0, 0.35))
    add_all(part, quilt(w, 1.3, seed + 1, 0.4), *place(11.0, 2.05))
    part.add("dark", box(0.2, 0.35, w, 0.03, (10.98, 0.17, -LENGTH / 2)), box(0.14, 0.18, w, 0.03, (10.98, 1.95, -LENGTH / 2)))
    add_all(part, quilt(w, 1.7, seed + 2, 0.55), *place(11.6, 4.6))
    slope = math.degrees(math.atan2(3.0, 3.0))
    add_all(part, quilt(w, 3.6, seed + 3, 0.7, 0.08), *place(11.35, 6.75, slope))
    part.add("hull", faceted([[(x0, y0, 0), (x1, y1, 0), (x1, y1, -LENGTH), (x0, y0, -LENGTH)]
                              for (x0, y0), (x1, y1) in zip([(x + 0.12, y) for x, y in PROFILE[:5]],
                                                            [(x + 0.12, y) for x, y in PROFILE[1:5]])]))
    # Pipes in the recess, cables above the catwalk.
    z0, z1 = 0.0, -LENGTH
    for y, r, material in ((3.62, 0.13, "pipe"), (3.95, 0.10, "copper"), (4.2, 0.06, "accent")):
        add_all(part, pipe([(11.15, y, z0), (11.15, y, z1)], r, material, 24))
    for k in range(7):
        y = 6.15 + 0.07 * (k % 4)
        part.add("rubber", tube(hanging((11.35 - 0.07 * (k // 4), y, z0), (11.35 - 0.07 * (k // 4), y, z1), 0.0, 1), 0.028, 10))
    for z in np.arange(-LENGTH + 0.5, 0, 1.0):
        part.add("steel", box(0.3, 0.03, 0.06, 0.006, (11.38, 6.08, z)), box(0.3, 0.03, 0.06, 0.006, (11.38, 6.44, z)),
                 box(0.03, 0.36, 0.06, 0.006, (11.24, 6.26, z)))
    # Tubes of light over the catwalk and at the floor.
    for y, x in ((6.66, 11.2), (3.3, 10.86)):
        for k in range(2):
            z = -LENGTH * (0.28 + 0.44 * k)
            part.add("dark", box(0.16, 0.14, 1.7, 0.03, (x, y, z)))
            part.add("tube", tube([(x - 0.09, y - 0.04, z - 0.75), (x - 0.09, y - 0.04, z + 0.75)], 0.035, 10))
    # The catwalk, its brackets and railing.
    part.add("steel", *[m.at(move(8.2, WALK, -LENGTH + 0.02)) for m in grating(2.9, LENGTH - 0.04)])
    for z in (-0.35, -LENGTH / 2, -LENGTH + 0.35):
        part.add("accent", sweep(beam(0.14, 0.24, 0.03), [(11.3, WALK - 0.22, z), (8.2, WALK - 0.22, z)]))
        part.add("accent", sweep(beam(0.12, 0.16, 0.03), [(10.9, WALK - 1.7, z), (8.9, WALK - 0.35, z)]))
        part.add("steel", box(0.04, 0.5, 0.34, 0.008, (10.94, WALK - 1.75, z)))
        for y in (-1.9, -1.6):
            for s in (-0.1, 0.1):
                part.add("steel", bolt(0.022).at(turn("z", 90), move(10.92, WALK + y, z + s)))
    add_all(part, railing([(8.22, WALK, -0.02), (8.22, WALK, -LENGTH + 0.02)], 6))
    return part


def floor_half():
    part = Part("floor")
    z = -LENGTH / 2
    # Road plates, a gutter with pipes under a grating, the raised side with deck plates.
    for i in range(3):
        for k in range(6):
            w, l = 1.45, LENGTH / 6
            x, zz = 0.02 + w * (i + 0.5), -l * (k + 0.5)
            part.add("tread", box(w - 0.015, 0.08, l - 0.015, 0.012, (x, -0.04, zz)))
            for sx in (-1, 1):
                for sz in (-1, 1):
                    part.add("steel", bolt(0.02).at(move(x + sx * (w / 2 - 0.09), -0.004, zz + sz * (l / 2 - 0.09))))
    part.add("dark", faceted([[(4.4, -0.7, 0), (5.6, -0.7, 0), (5.6, -0.7, -LENGTH), (4.4, -0.7, -LENGTH)],
                              [(4.38, 0, 0), (4.38, -0.7, 0), (4.38, -0.7, -LENGTH), (4.38, 0, -LENGTH)][::-1],
                              [(5.62, 0.1, 0), (5.62, -0.7, 0), (5.62, -0.7, -LENGTH), (5.62, 0.1, -LENGTH)]]))
    for x, r, material in ((4.75, 0.14, "pipe"), (5.1, 0.1, "copper"), (5.36, 0.08, "pipe")):
        add_all(part, pipe([(x, -0.45, 0), (x, -0.45, -LENGTH)], r, material, 20, 4.0))
    part.add("steel", *[m.at(move(4.42, 0.0, -LENGTH + 0.02)) for m in grating(1.16, LENGTH - 0.04, 0.06)])
    part.add("hazard", box(0.16, 0.14, LENGTH, 0.02, (5.68, 0.06, z)))
    for i in range(3):
        for k in range(4):
            w, l = 5.2 / 3, LENGTH / 4
            part.add("hull" if (i + k) % 3 else "pale", box(w - 0.02, 0.08, l - 0.02, 0.012, (5.78 + w * (i + 0.5), 0.08, -l * (k + 0.5))))
    part.add("yellow", box(0.14, 0.004, LENGTH, 0, (4.1, 0.003, z)))
    for k in range(4):
        part.add("yellow", box(0.12, 0.004, 1.1, 0, (0.06, 0.003, -1.0 - 2 * k)))
    return part


def roof_half():
    """Plates on both sides of the open slot, a duct, a tray of cables, lamps."""
    part = Part("roof")
    z = -LENGTH / 2
    add_all(part, quilt(5.4, LENGTH - 0.56, 77, 0.8, 0.08), turn("x", 90), turn("z", -4.2), move(3.2, 10.0, -LENGTH + 0.28))
    part.add("dark", faceted([[(3.2, 10.15, 0), (8.7, 9.75, 0), (8.7, 9.75, -LENGTH), (3.2, 10.15, -LENGTH)]]))
    # The rim of the slot and its bars; it is open for the middle half of the section.
    part.add("accent", box(0.3, 0.6, LENGTH, 0.04, (3.1, 9.9, z)))
    part.add("dark", box(3.2, 0.3, 1.9, 0.04, (1.5, 10.1, -0.9)), box(3.2, 0.3, 1.9, 0.04, (1.5, 10.1, -LENGTH + 0.9)))
    for k in range(5):
        part.add("steel", sweep(beam(0.1, 0.3, 0.025), [(0, 10.0, -2.2 - 0.9 * k), (3.0, 10.0, -2.2 - 0.9 * k)]))
    # Duct with bands and grilles.
    duct = np.array([(-0.45, -0.3), (0.45, -0.3), (0.45, 0.3), (-0.45, 0.3), (-0.45, -0.3)])
    part.add("steel", sweep(duct, [(6.4, 9.1, 0), (6.4, 9.1, -LENGTH)]))
    for k in range(8):
        part.add("dark", sweep(duct * 1.07, [(6.4, 9.1, -0.5 - k), (6.4, 9.1, -0.58 - k)]))
        for s in range(12):
            part.add("steel", box(0.012, 0.03, 0.5, 0, (6.1 + 0.05 * s, 8.79, -1.04 - k))) if k % 2 else None
    for zz in (-1.5, -6.5):
        for s in (-0.5, 0.5):
            part.add("steel", tube([(6.4 + s, 8.75, zz), (6.4 + s, 9.9, zz)], 0.02, 8))
        part.add("steel", box(1.1, 0.05, 0.06, 0.01, (6.4, 8.76, zz)))
    for x, r, material in ((4.3, 0.17, "pipe"), (4.75, 0.11, "copper"), (5.1, 0.08, "pipe")):
        add_all(part, pipe([(x, 9.3, 0), (x, 9.3, -LENGTH)], r, material, 24, 2.0))
    # Cables that hang between the frames.
    rng = np.random.default_rng(9)
    for k in range(6):
        x = 7.3 + 0.09 * k
        part.add("rubber", tube(hanging((x, 9.0, 0), (x, 9.0, -LENGTH), 0.25 + 0.3 * rng.random(), 16), 0.03, 8))
    # Lamps on arms.
    for zz in (-2.0, -6.0):
        part.add("dark", lathe([(0.10, 0.4), (0.12, 0.1), (0.34, -0.1), (0.36, -0.16), (0.33, -0.16), (0.1, 0.0)], 24).at(move(8.0, 8.2, zz)),
                 tube([(8.0, 8.5, zz), (8.0, 9.7, zz)], 0.03, 8))
        part.add("tube", lathe([(0.0, -0.10), (0.16, -0.08), (0.2, 0.0), (0.16, 0.02)], 16).at(move(8.0, 8.2, zz)))
    return part


# ---- What stands in it


def crate(material):
    """A container with ribs, corner castings, a door with bars and a plate."""
    part = Part(material + " crate")
    w, h, l = 2.2, 2.2, 3.4
    part.add(material, box(w - 0.16, h - 0.16, l - 0.16, 0.03, (0, h / 2, 0)))
    for sx in (-1, 1):
        for k in range(11):
            z = -l / 2 + 0.32 + (l - 0.64) * k / 10
            part.add(material, box(0.06, h - 0.4, 0.14, 0.025, (sx * (w / 2 - 0.07), h / 2, z)))
        for sy in (0.1, h - 0.1):
            part.add("dark", box(0.2, 0.2, l - 0.1, 0.03, (sx * (w / 2 - 0.1), sy, 0)))
        for sz in (-1, 1):
            part.add("dark", box(0.2, h, 0.2, 0.03, (sx * (w / 2 - 0.1), h / 2, sz * (l / 2 - 0.1))))
            for sy in (0.1, h - 0.1):
                part.add("steel", box(0.26, 0.26, 0.26, 0.04, (sx * (w / 2 - 0.1), sy, sz * (l / 2 - 0.1))))
    for x in (-0.6, -0.2, 0.2, 0.6):
        part.add("steel", tube([(x, 0.2, l / 2 - 0.02), (x, h - 0.2, l / 2 - 0.02)], 0.03, 10))
        part.add("steel", box(0.2, 0.06, 0.08, 0.01, (x + 0.08, 1.05, l / 2)))
        for y in (0.5, 1.1, 1.7):
            part.add("steel", box(0.12, 0.08, 0.1, 0.015, (x, y, l / 2 - 0.04)))
    part.add("hazard", box(w - 0.5, 0.18, 0.02, 0, (0, 0.34, l / 2 - 0.06)))
    return part


def barrel():
    part = Part("barrel")
    profile = [(0, 0), (0.29, 0), (0.31, 0.02), (0.29, 0.04), (0.29, 0.28), (0.31, 0.30), (0.29, 0.32), (0.29, 0.58), (0.31, 0.60),
               (0.29, 0.62), (0.29, 0.86), (0.31, 0.88), (0.29, 0.90), (0.27, 0.87), (0, 0.87)]
    part.add("accent", lathe(profile, 32))
    part.add("steel", bolt(0.05).at(move(0.15, 0.87, 0)), bolt(0.03).at(move(-0.12, 0.87, 0.08)))
    return part


def console(screens):
    """A desk with three displays, keys and a back full of cables."""
    part = Part("console")
    side = [(-0.5, 0), (0.5, 0), (0.5, 0.75), (0.62, 0.86), (0.58, 0.94), (0.05, 1.08), (-0.22, 1.75), (-0.4, 1.8), (-0.5, 1.7)]
    for x in (-1.55, 1.55):
        part.add("accent", prism(side, 0.1, 0.02).at(turn("y", -90), move(x, 0, 0)))
    part.add("dark", prism([(px * 0.96, py * 0.98) for px, py in side], 3.0).at(turn("y", -90)))
    lean = math.degrees(math.atan2(0.27, 0.67))
    for k, name in enumerate(screens):
        x = (k - 1) * 1.0
        part.add("hull", box(0.94, 0.66, 0.06, 0.02, (0, 0.33, -0.02)).at(turn("x", -lean), move(x, 1.12, 0.035)))
        part.add(name, rectangle(0.86, 0.58).at(move(0, 0.04, 0.014), turn("x", -lean), move(x, 1.12, 0.035)))
    for i in range(26):
        for k in range(4):
            if (i * 7 + k * 3) % 11 == 0:
                continue
            z = 0.16 + 0.1 * k
            part.add("pale" if (i + k) % 5 else "yellow", box(0.07, 0.03, 0.07, 0.008, (-1.3 + 0.104 * i, 1.07 - 0.26 * (z - 0.05), z)))
    for k in range(9):
        part.add("steel", lathe([(0.035, 0), (0.03, 0.04), (0, 0.04)], 12).at(move(-1.2 + 0.3 * k, 0.955, 0.52)))
    for k in range(10):
        part.add("rubber", tube(bent([(-1.2 + 0.25 * k, 1.2, -0.45), (-1.2 + 0.25 * k, 1.0, -0.62), (-1.2 + 0.25 * k, 0.03, -0.66)], 0.15, 6), 0.025, 10))
    return part


def machine():
    """A generator: a finned drum on a bed between two heads, with pipes up to the roof."""
    part = Part("machine")
    part.add("dark", box(3.0, 0.4, 5.2, 0.06, (0, 0.2, 0)), box(2.6, 0.3, 4.8, 0.05, (0, 0.55, 0)))
    for sx in (-1, 1):
        for k in range(9):
            part.add("steel", bolt(0.06).at(move(sx * 1.38, 0.4, -2.3 + 0.575 * k)))
    fins = []
    for k in range(34):
        z = -1.7 + 0.1 * k
        fins += [(0.92, z), (1.06, z + 0.015), (1.06, z + 0.045), (0.92, z + 0.06)]
    drum = lathe([(0, -1.75)] + fins + [(0, 1.75)], 56).at(turn("x", 90), move(0, 1.75, 0))
    part.add("accent", drum)
    for s in (-1, 1):
        head = lathe([(1.2, 0), (1.25, 0.05), (1.25, 0.3), (1.1, 0.4), (0.6, 0.55), (0.3, 0.58), (0.3, 0.9), (0.2, 0.92), (0, 0.92)], 48)
        part.add("hull", head.at(turn("x", 90 * s), move(0, 1.75, s * 1.72)))
        for k in range(20):
            a = math.radians(18 * k)
            part.add("steel", bolt(0.045).at(turn("x", 90 * s), move(1.12 * math.sin(a), 1.75 + 1.12 * math.cos(a), s * 2.07)))
        for x in (-0.7, 0.7):
            part.add("hull", prism([(-0.4, 0), (0.4, 0), (0.28, 1.1), (-0.28, 1.1)], 0.3, 0.03).at(move(x, 0.65, s * 1.7)))
    for s in (-1, 1):
        add_all(part, pipe([(s * 0.5, 2.6, 0.6 * s), (s * 0.5, 4.2, 0.6 * s), (s * 0.9, 5.2, 0.6 * s), (s * 0.9, 9.0, 0.6 * s)], 0.26, "pipe", 28, 1.4))
        add_all(part, pipe([(s * 1.1, 1.6, 1.2), (s * 1.7, 1.6, 1.2), (s * 1.7, 0.2, 1.2)], 0.12, "copper", 24, 0.7))
        wheel = [(0.24 * math.cos(t), 0.24 * math.sin(t), 0) for t in np.linspace(0, 2 * math.pi, 33)]
        part.add("yellow", *[m.at(turn("y", 90), move(s * 1.95, 1.6, 1.2)) for m in
                             [tube(wheel, 0.022, 8, closed=True)] + [box(0.46, 0.02, 0.02).at(turn("z", 60 * k)) for k in range(3)]])
        part.add("steel", tube([(s * 1.7, 1.6, 1.2), (s * 1.97, 1.6, 1.2)], 0.03, 10))
    return part


def door_part():
    """A bulkhead door in a side wall, its front at x = 0 facing -X; with its frame, wheel and number."""
    part = Part("door")
    shape = [(-1.0, 0.1), (-0.75, 0), (0.75, 0), (1.0, 0.1), (1.0, 2.3), (0.7, 2.75), (-0.7, 2.75), (-1.0, 2.3)]
    path = on_path(shape + shape[:1])
    bar = np.array([(-0.16, -0.1), (0.16, -0.1), (0.16, 0.06), (0.08, 0.16), (-0.16, 0.16), (-0.16, -0.1)])
    pieces = [("accent", sweep(bar, path, (0, 0, 1), closed=True)), ("hull", prism(shape, 0.14, 0.03))]
    for x in (-0.5, 0.5):
        pieces.append(("pale", prism([(x - 0.4, 0.3), (x + 0.4, 0.3), (x + 0.4, 1.9), (x - 0.4, 1.9)], 0.2, 0.04)))
    for y in (0.5, 1.1, 1.7):
        pieces.append(("steel", box(1.9, 0.08, 0.24, 0.02, (0, y, 0))))
    ring = [(0.3 * math.cos(t), 1.3 + 0.3 * math.sin(t), 0.22) for t in np.linspace(0, 2 * math.pi, 41)]
    pieces += [("yellow", tube(ring, 0.03, 10, closed=True)), ("steel", tube([(0, 1.3, 0.05), (0, 1.3, 0.24)], 0.05, 12))]
    pieces += [("yellow", box(0.58, 0.03, 0.03, 0.006).at(turn("z", 45 + 90 * k), move(0, 1.3, 0.22))) for k in range(2)]
    pieces.append(("hazard", box(2.6, 0.22, 0.04, 0.01, (0, 2.98, 0.06))))
    for k in range(24):
        a, b = np.asarray(shape)[k % 8], np.asarray(shape)[(k + 1) % 8]
        p = a + (b - a) * ((k // 8 + 0.5) / 3)
        pieces.append(("steel", bolt(0.025).at(turn("x", 90), move(p[0], p[1], 0.15))))
    add_all(part, pieces, turn("y", -90))
    return part


def stairs():
    """From the side floor up to the catwalk, along Z: treads between stringers, with railings."""
    part = Part("stairs")
    steps, rise, run = 20, (WALK - 0.1) / 20, 0.27
    for k in range(steps):
        y, z = 0.1 + rise * (k + 1), -run * (k + 0.5)
        part.add("tread", box(1.0, 0.03, run + 0.02, 0.006, (0, y - 0.015, z)))
        part.add("hazard", box(1.0, 0.035, 0.04, 0, (0, y - 0.016, z + run / 2)))
    top = np.array([0, WALK, -run * steps])
    for s in (-1, 1):
        x = s * 0.53
        part.add("accent", sweep(beam(0.1, 0.3, 0.03), [(x, 0.1, 0.1), (x, WALK - 0.05, -run * steps + 0.1)]))
        part.add("rail", tube([(x, 1.1, 0), (x, 1.1 + WALK - 0.1, top[2])], 0.034, 12), tube([(x, 0.7, 0), (x, 0.7 + WALK - 0.1, top[2])], 0.02, 10))
        for k in range(0, steps + 1, 4):
            y, z = 0.1 + rise * k, -run * k
            part.add("rail", tube([(x, y, z), (x, y + 1.02, z)], 0.026, 10))
    return part


def hose(seed):
    """A hose that lies about on the floor."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 1, 100)
    x = 0.9 * np.sin(7 * t + rng.uniform(0, 6)) * (0.4 + t) + 0.4 * np.sin(17 * t)
    z = -3.4 * t + 0.5 * np.cos(9 * t)
    path = np.stack([x, np.full_like(t, 0.05), z], axis=1)
    part = Part("hose %d" % seed)
    ribs = 0.046
    part.add("rubber", tube(path, ribs, 12))
    for end in (path[0], path[-1]):
        part.add("copper", lathe([(0.05, -0.08), (0.065, -0.06), (0.065, 0.06), (0.05, 0.08)], 16).at(turn("x", 90), move(*end)))
    return part


def bulkhead(number, least=0.8):
    """The wall at an end of the hall, facing +Z, with a great gate; its panels are at least so wide."""
    part = Part("bulkhead %d" % number)
    add_all(part, quilt(HALF - 4.2, 9.6, 31, least, 0.1), move(4.2, 0.1, 0))
    add_all(part, [(m, mesh.at(MIRROR)) for m, mesh in quilt(HALF - 4.2, 9.6, 31, least, 0.1)], move(-4.2, 0.1, 0))
    add_all(part, quilt(8.4, 2.6, 37, least, 0.1), move(-4.2, 7.4, 0))
    part.add("dark", faceted([[(-12, -0.8, -0.1), (12, -0.8, -0.1), (12, 10.4, -0.1), (-12, 10.4, -0.1)]]))
    gate = [(-3.9, 0), (3.9, 0), (3.9, 5.6), (2.6, 7.1), (-2.6, 7.1), (-3.9, 5.6)]
    bar = np.array([(-0.3, -0.2), (0.3, -0.2), (0.3, 0.2), (0.15, 0.4), (-0.3, 0.4), (-0.3, -0.2)])
    part.add("accent", sweep(bar, on_path(gate[1:] + gate[:1]), (0, 0, 1)))
    for s in (-1, 1):
        for k in range(7):
            y = 0.05 + k
            w = 3.6 if y < 5 else 3.6 - 1.2 * (y - 4.7) / 2.3
            part.add("hull" if k % 2 else "pale", box(w, 0.94, 0.2, 0.05, (s * (w / 2 + 0.03), y + 0.48, 0.1)))
            for x in np.arange(0.3, w, 0.55):
                part.add("steel", bolt(0.04).at(turn("x", 90), move(s * x, y + 0.2, 0.2)), bolt(0.04).at(turn("x", 90), move(s * x, y + 0.78, 0.2)))
        part.add("hazard", box(0.3, 7.0, 0.24, 0.02, (s * 0.17, 3.5, 0.12)))
    part.add("sign %d" % number, rectangle(1.7, 1.7).at(move(-1.9, 2.4, 0.22)))
    part.add("dark", box(1.8, 0.5, 0.3, 0.05, (0, 7.9, 0.1)))
    return part


# ---- The level


def materials():
    paint = lambda r, g, b, seed, **more: surfaces.hull(from_srgb(r, g, b), seed=seed, **more)
    return {
        "hull": paint(0.60, 0.63, 0.65, 101),
        "pale": paint(0.74, 0.74, 0.71, 103, depth=3),
        "dark": paint(0.32, 0.34, 0.37, 105, depth=3),
        "accent": paint(0.72, 0.38, 0.13, 107, n=256, depth=1, wear=0.5),
        "yellow": paint(0.86, 0.66, 0.12, 109, n=256, depth=1, wear=0.5),
        "rail": paint(0.84, 0.64, 0.14, 111, n=256, depth=0, tile=1.0, wear=0.2),
        "green": paint(0.24, 0.40, 0.32, 113, n=256, depth=2),
        "blue": paint(0.16, 0.30, 0.48, 115, n=256, depth=2),
        "red": paint(0.56, 0.17, 0.13, 117, n=256, depth=2),
        "tread": surfaces.tread(from_srgb(0.48, 0.49, 0.50), seed=119),
        "steel": surfaces.metal((0.55, 0.55, 0.56), seed=121, gloss=0.46),
        "pipe": surfaces.metal((0.62, 0.63, 0.66), seed=123, gloss=0.52),
        "copper": surfaces.metal((0.78, 0.44, 0.28), seed=125, gloss=0.5),
        "rubber": surfaces.stone(from_srgb(0.10, 0.10, 0.11), 128, seed=127, gloss=0.35, relief=0.0004),
        "hazard": surfaces.hazard(seed=129),
        "tube": surfaces.glow((0.92, 0.97, 1.0)),
        "screen a": surfaces.screen(seed=0), "screen b": surfaces.screen(seed=1), "screen c": surfaces.screen(seed=2),
        "sign 7": surfaces.sign(7, from_srgb(0.86, 0.84, 0.78)), "sign 16": surfaces.sign(16, from_srgb(0.86, 0.84, 0.78)),
    }


class _Kit:
    """The parts, made once."""

    def __init__(self):
        self.frame, self.floor, self.roof = frame_half(), floor_half(), roof_half()
        self.walls = [wall_half(200), wall_half(210)]
        self.crates = [crate(c) for c in ("green", "blue", "red")]
        self.barrel, self.console = barrel(), console(["screen a", "screen b", "screen c"])
        self.machine, self.door, self.stairs = machine(), door_part(), stairs()
        self.hoses = [hose(1), hose(2)]


def shell(level, kit, index):
    """Floor, walls and roof of a section, and the frame at its near end."""
    at = move(0, 0, -LENGTH * index)
    for k, side in enumerate((np.eye(4), MIRROR)):
        level.place(kit.floor, side, at)
        level.place(kit.roof, side, at)
        level.place(kit.walls[(index + k) % 2], side, at)
        level.place(kit.frame, side, at)


def furnish(level, kit, index, kind):
    """What stands in a section; kinds differ in what and where."""
    z = -LENGTH * index
    side = 1 if index % 2 else -1
    put = lambda part, x, y, dz, angle=0.0: level.place(part, turn("y", angle), move(side * x, y, z - dz))
    if kind == "cargo":
        put(kit.crates[index % 3], 7.2, 0.12, 2.2, 4)
        put(kit.crates[(index + 1) % 3], 7.1, 0.12, 5.9, -3)
        put(kit.crates[(index + 2) % 3], -7.2, 0.12, 3.2, 182)
        put(kit.crates[index % 3], -3.0, 0.0, 6.4, 24)
        for x, dz in ((-5.9, 6.2), (-6.6, 6.4), (-6.2, 6.9), (-7.0, 7.1), (-5.5, 1.0), (9.3, 0.9)):
            put(kit.barrel, x, 0.12, dz, 40 * dz)
    elif kind == "power":
        put(kit.machine, 7.6, 0.12, 4.0)
        put(kit.machine, -7.6, 0.12, 4.0, 180)
        put(kit.hoses[0], 4.0, 0.0, 2.4)
        put(kit.hoses[1], -3.2, 0.0, 2.0)
    elif kind == "watch":
        put(kit.console, 7.0, 0.12, 2.4, -90 * side)
        put(kit.console, 7.0, 0.12, 5.8, -90 * side)
        level.place(kit.stairs, move(side * -7.5, 0, z - 1.2))
        put(kit.barrel, -9.6, 0.12, 2.0)
        put(kit.barrel, -9.0, 0.12, 1.5)
    elif kind == "post":
        put(kit.console, 7.0, 0.12, 4.6, -90 * side)
        level.place(kit.stairs, move(side * -7.5, 0, z - 1.2))
        put(kit.barrel, -9.6, 0.12, 2.0)
    elif kind == "gate":
        for s in (-1, 1):
            level.place(kit.door, size(s, 1, 1), move(s * 10.86, 0.12, z - LENGTH / 2))
        put(kit.crates[index % 3], 7.0, 0.12, 1.9, 88)
        put(kit.hoses[1], -3.0, 0.0, 3.0)
        for x, dz in ((-8.4, 1.5), (-8.9, 2.1), (-7.8, 1.8), (8.4, 6.9)):
            put(kit.barrel, x, 0.12, dz, 30 * dz)


KINDS = ("watch", "power", "gate", "cargo")
SUN = ((-2.6, 10.0, 2.2), (0, 0, 0))


def build():
    level = Level("Deck", materials())
    kit = _Kit()
    for index in range(SECTIONS):
        shell(level, kit, index)
        furnish(level, kit, index, KINDS[index % 4])
    for side in (np.eye(4), MIRROR):
        level.place(kit.frame, side, move(0, 0, -LENGTH * SECTIONS))
    level.place(bulkhead(16), move(0, 0, -LENGTH * SECTIONS - 0.3))
    level.place(bulkhead(7), turn("y", 180), move(0, 0, 0.3))

    cool, warm, teal = (0.86, 0.94, 1.0), (1.0, 0.62, 0.30), (0.35, 0.85, 1.0)
    for index in range(SECTIONS):
        z = -LENGTH * index
        level.light("point", cool, 110.0, move(8.0, 7.2, z - 2.0), 13.0)
        level.light("point", cool, 110.0, move(-8.0, 7.2, z - 6.0), 13.0)
        side = 1 if index % 2 else -1
        level.light("point", warm if index % 4 else teal, 36.0, move(side * 9.0, 2.9, z - 2.2), 9.0)
    level.light("point", warm, 160.0, move(0, 7.6, -LENGTH * SECTIONS + 1.2), 16.0)
    level.light("directional", (1.0, 0.92, 0.80), 16.0, looking(*SUN))
    fill(level, TRIANGLES, SECTIONS)

    level.camera("hall", (2.2, 1.9, -1.2), (-0.6, 3.2, -40), 62, 16 / 9)
    level.camera("catwalk", (9.4, WALK + 1.7, -17.5), (-3.0, 2.2, -36), 62, 16 / 9)
    level.camera("machine", (2.4, 1.9, -8.6), (8.2, 2.3, -13.4), 60, 16 / 9)
    level.camera("console", (-3.4, 1.75, -1.6), (-8.0, 1.5, -5.0), 55, 16 / 9)
    level.camera("gate", (-1.5, 2.2, -113), (0.6, 3.6, -128), 60, 16 / 9)
    return level


def fill(level, triangles, sections):
    """Cables along the roof take what is left."""
    left = triangles - level.triangle_count()
    each = max(left // sections, 0)
    part = Part("cables")
    rng = np.random.default_rng(17)
    count = 24
    around = 10
    steps = max(each // (count * 2 * around), 1)
    for k in range(count):
        x = rng.uniform(-2.9, 2.9)
        low = rng.uniform(8.9, 9.3)
        part.add("rubber", tube(hanging((x, low, 0), (x + rng.uniform(-0.3, 0.3), low, -LENGTH), rng.uniform(0.1, 0.6), steps), 0.025, around))
    for index in range(sections):
        level.place(part, move(0, 0, -LENGTH * index))


def build_small(lights):
    """One section between two bulkheads, lit by many small lamps on its surfaces and by the sun."""
    level = Level("Deck, 1/16, %d lights" % lights, materials())
    kit = _Kit()
    shell(level, kit, 0)
    for side in (np.eye(4), MIRROR):
        level.place(kit.frame, side, move(0, 0, -LENGTH))
    level.place(bulkhead(16, 2.0), move(0, 0, -LENGTH - 0.3))
    level.place(bulkhead(7, 2.0), turn("y", 180), move(0, 0, 0.3))
    furnish(level, kit, 0, "post")
    fill(level, TRIANGLES // 16, 1)
    scatter(level, lights)
    level.light("directional", (1.0, 0.92, 0.80), 16.0, looking(*SUN))
    level.camera("section", (9.4, WALK + 1.75, -0.7), (-6.0, 1.6, -6.2), 72, 16 / 9)
    level.camera("floor", (-1.2, 1.8, -0.5), (4.0, 3.2, -8), 75, 16 / 9)
    return level


PALETTE = [(1.0, 0.62, 0.30), (0.86, 0.94, 1.0), (0.35, 0.85, 1.0), (1.0, 0.25, 0.15), (0.45, 1.0, 0.55), (1.0, 0.86, 0.6)]


def scatter(level, count):
    """Point lights a few centimetres above the surfaces that look into the hall. All together send the same
    for any count, and each point of the hall is in reach of about as many."""
    points, normals, areas = [], [], []
    for part, matrix in level.placed:
        for name, meshes in part.pieces.items():
            if name not in ("hull", "pale", "accent", "tread"):
                continue
            for mesh in meshes:
                moved = mesh.at(matrix)
                corner = moved.points[moved.faces]
                cross = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
                points.append(corner)
                normals.append(cross)
                areas.append(0.5 * np.linalg.norm(cross, axis=1))
    points, normals, areas = np.concatenate(points), np.concatenate(normals), np.concatenate(areas)
    normals /= np.maximum(2 * areas, 1e-12)[:, None]
    middle = points.mean(axis=1)
    inward = ((np.array([0, 4.0, -LENGTH / 2]) - middle) * normals).sum(axis=1) > 0
    inside = (np.abs(middle[:, 0]) < HALF + 0.5) & (middle[:, 1] > 0) & (middle[:, 1] < HEIGHT - 0.3)
    weight = np.where(inward & inside, areas, 0)
    rng = np.random.default_rng(23)
    chosen = rng.choice(len(weight), count, p=weight / weight.sum())
    u, v = rng.random(count), rng.random(count)
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    a, b, c = points[chosen, 0], points[chosen, 1], points[chosen, 2]
    reach = min(8.0, 14.0 * (100 / count) ** (1 / 2.3))
    where = a + u[:, None] * (b - a) + v[:, None] * (c - a) + min(0.25, 0.1 * reach) * normals[chosen]
    color = rng.integers(0, len(PALETTE), count)
    for k in range(count):
        level.light("point", PALETTE[color[k]], 600.0 / count, move(*where[k]), reach)
