"""A courtyard in the sun: two storeys of arcades round a paved court of 12 x 30 m with a fountain, vaulted
galleries behind columns, curtains between them, balustrades, beams and a roof of clay tiles. One directional
light; nothing else shines.

The long side runs along Z. Arcades are built along X, the court on their +Z side, and turned into place.
"""

import math

import numpy as np

from . import statue, surfaces
from .gltf import Level, Part, looking
from .mesh import (arched_wall, bent, box, faceted, ground, lathe, merge, move, on_path, patch, pointed,
                   prism, rectangle, round_arch, size, sweep, tube, turn)
from .texture import from_srgb

TRIANGLES = 376_000
BAY, COUNT = 3.75, 8       # along the long sides
END_BAY, END_COUNT = 4.0, 3  # along the short ones
HALF_X, HALF_Z = 6.0, 15.0
DEPTH = 4.4                # of the galleries
SPRING, FLOOR_2 = 3.5, 6.0
SPRING_2, EAVES = 8.9, 11.2
SWAP_XZ = np.array([[0, 0, 1, 0], [0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1.0]])


def column(radius, height, segments):
    """A round column with an Attic base and a leafy capital, on a square plinth."""
    r = radius
    parts = [box(2.9 * r, 0.5 * r, 2.9 * r, 0.03 * r, (0, 0.25 * r, 0))]
    a = np.radians(np.linspace(-90, 90, 7))
    torus = lambda y, h, reach: [(reach - h / 2 + h / 2 * math.cos(t), y + h / 2 + h / 2 * math.sin(t)) for t in a]
    profile = torus(0.5 * r, 0.34 * r, 1.42 * r) + [(1.12 * r, 0.86 * r), (1.10 * r, 0.98 * r)]
    profile += torus(1.0 * r, 0.22 * r, 1.26 * r) + [(1.05 * r, 1.28 * r)]
    parts.append(lathe(profile, segments))
    top = height - 2.3 * r
    y = np.linspace(1.28 * r, top, 7)
    t = (y - y[0]) / (y[-1] - y[0])
    taper = r * (1.03 - 0.16 * t ** 1.6)
    parts.append(lathe(np.stack([taper, y], axis=1), segments))
    parts.append(lathe([(0.87 * r, top), (1.0 * r, top + 0.04 * r), (1.0 * r, top + 0.16 * r), (0.87 * r, top + 0.2 * r)],
                       segments))
    y = np.linspace(top + 0.2 * r, height - 0.45 * r, 9)
    t = (y - y[0]) / (y[-1] - y[0])
    angles = np.linspace(0, 2 * math.pi, 2 * segments + 1)
    bell = r * (0.86 + 0.55 * t ** 2.5)
    tiers = 0.13 * r * np.maximum(np.sin(2 * math.pi * t * 1.02), 0) ** 0.7
    upper = 0.20 * r * np.maximum(np.sin(math.pi * np.clip(2 * t - 0.9, 0, 1)), 0)
    out = bell + np.outer(np.abs(np.cos(4 * angles)) ** 0.6, tiers) + np.outer(np.abs(np.sin(4 * angles)) ** 0.6, upper)
    parts.append(patch(np.stack([out * np.sin(angles)[:, None], np.broadcast_to(y, out.shape),
                                 out * np.cos(angles)[:, None]], axis=2), closed_u=True))
    for k in range(4):  # scrolls at the corners
        spiral = np.linspace(0, 3.2 * math.pi, 17)
        reach = 0.24 * r * (1 - spiral / (4.4 * math.pi))
        path = np.stack([1.42 * r + reach * np.sin(spiral), height - 0.62 * r + reach * np.cos(spiral),
                         np.zeros_like(spiral)], axis=1)
        parts.append(tube(path, 0.06 * r, 5).at(turn("y", 45 + 90 * k)))
    parts.append(box(2.75 * r, 0.18 * r, 2.75 * r, 0.03 * r, (0, height - 0.36 * r, 0)))
    parts.append(box(2.95 * r, 0.27 * r, 2.95 * r, 0.05 * r, (0, height - 0.135 * r, 0)))
    return parts


ARCHIVOLT = np.array([(0.0, 0.0), (0.04, 0.02), (0.04, 0.10), (0.07, 0.12), (0.07, 0.22), (0.11, 0.26), (0.11, 0.32),
                      (0.0, 0.36)])  # out of the wall, away from the opening


def archivolt(half, spring, z, segments=24):
    """Mouldings round an arch on the face of its wall."""
    rows = []
    for out, away in ARCHIVOLT:
        rows.append(on_path(round_arch(half + away, spring, spring, segments), z + out))
    grid = np.stack(rows)
    parts = []
    for k in range(len(rows) - 1):
        piece = patch(grid[k:k + 2])
        parts.append(piece)
    front = merge(parts)
    return front if front.normals[:, 2].sum() > 0 else front.flipped()


CORNICE = np.array([(0.0, -0.30), (0.06, -0.28), (0.06, -0.20), (0.12, -0.16), (0.20, -0.06), (0.24, -0.04), (0.24, 0.03),
                    (0.30, 0.05), (0.30, 0.10), (0.0, 0.12)])


def cornice(width, y, z, scale=1.0):
    return sweep(CORNICE * scale, [(-width / 2, y, z), (width / 2, y, z)])


def groin(width, length, rise, steps=7):
    """A groined vault of round barrels, springing at y = 0."""
    webs = []
    s = np.linspace(0, 1, steps + 1)
    for k in range(4):
        a, b = (width / 2, length / 2) if k % 2 == 0 else (length / 2, width / 2)
        t, u = np.meshgrid(s, np.concatenate([-s[::-1], s[1:]]), indexing="ij")
        grid = np.stack([a * u * t, rise * pointed(u * t, 1.0), b * t], axis=2)
        web = patch(grid)
        web = web if web.normals[:, 1].sum() < 0 else web.flipped()
        web.uvs = web.points[:, [0, 2]].copy()
        webs.append(web.at(turn("y", 90 * k)))
    return webs


def baluster(height):
    h = height
    y = np.linspace(0.14, 0.84, 9)
    belly = 0.035 + 0.045 * np.exp(-((y - 0.34) / 0.13) ** 2) + 0.015 * np.exp(-((y - 0.78) / 0.06) ** 2)
    profile = [(0.075, 0), (0.075, 0.06 * h), (0.05, 0.08 * h)] + [(b, t * h) for b, t in zip(belly, y)]
    profile += [(0.05, 0.92 * h), (0.075, 0.94 * h), (0.075, h)]
    return lathe(profile, 8)


def bay(width, kind):
    """One bay of both storeys. kind tells what is in the wall behind: "door" or "niche"."""
    part = Part("bay with a " + kind)
    clear = width / 2 - 0.34
    # Ground floor.
    part.add("stone", arched_wall(round_arch(clear, SPRING, SPRING, 24), width, FLOOR_2 - 0.3, 0.64, rows=2))
    for z, way in ((0.32, 0), (-0.32, 180)):
        part.add("trim", archivolt(clear, SPRING, 0.32, 16).at(turn("y", way)))
    part.add("trim", prism([(-0.16, 0), (0.16, 0), (0.22, 0.42), (-0.22, 0.42)], 0.22, 0.03).at(
        move(0, SPRING + clear - 0.06, 0.36)))
    part.add("trim", cornice(width, FLOOR_2 - 0.1, 0.32))
    for k in range(10):
        x = (k + 0.5) * width / 10 - width / 2
        part.add("trim", box(0.14, 0.12, 0.16, 0, (x, FLOOR_2 - 0.36, 0.42)))
    part.add("plaster", *[m.at(move(0, SPRING, -DEPTH / 2 - 0.32)) for m in groin(width, DEPTH, clear)])
    back = -DEPTH - 0.32
    wall(part, width, back, kind)
    # Upper floor.
    clear_2 = width / 2 - 0.24
    part.add("floor", faceted([[(-width / 2, FLOOR_2, 0.4), (width / 2, FLOOR_2, 0.4), (width / 2, FLOOR_2, back),
                                (-width / 2, FLOOR_2, back)]]))
    part.add("stone", arched_wall(round_arch(clear_2, SPRING_2, SPRING_2, 20, rise=1.35), width, EAVES - 0.2, 0.46, rows=2))
    part.add("trim", cornice(width, EAVES, 0.23, 1.2))
    count = round(width / 0.31)
    for k in range(count):
        x = (k + 0.5) * (width - 0.5) / count - (width - 0.5) / 2
        part.add("trim", baluster(0.72).at(move(x, FLOOR_2 + 0.12, 0.12)))
    part.add("trim", box(width, 0.12, 0.26, 0.02, (0, FLOOR_2 + 0.06, 0.12)),
             box(width, 0.12, 0.30, 0.03, (0, FLOOR_2 + 0.9, 0.12)))
    for k in range(5):
        x = (k + 0.5) * width / 5 - width / 2
        part.add("wood", box(0.18, 0.24, DEPTH + 0.2, 0.02, (x, EAVES - 0.62, back / 2)))
    part.add("wood", box(width, 0.16, 0.2, 0.02, (0, EAVES - 0.8, back + 0.1)))
    part.add("planks", faceted([[(-width / 2, EAVES - 0.48, 0), (-width / 2, EAVES - 0.48, back),
                                 (width / 2, EAVES - 0.48, back), (width / 2, EAVES - 0.48, 0)]]))
    part.add("plaster", faceted([[(-width / 2, FLOOR_2, back), (width / 2, FLOOR_2, back),
                                  (width / 2, EAVES, back), (-width / 2, EAVES, back)]]))
    shutters(part, back, FLOOR_2 + 0.9, 1.5)
    # The roof leans over the court.
    tiles(part, width)
    return part


def wall(part, width, back, kind):
    """The ground floor's wall behind the gallery."""
    half, spring = (0.75, 2.1) if kind == "door" else (0.7, 1.9)
    foot = 0.0 if kind == "door" else 0.8
    edge = round_arch(half, spring, foot, 16)
    part.add("masonry", arched_wall(edge, width, FLOOR_2, 0.4, rows=2, back=False).at(move(0, 0, back - 0.2)))
    if foot > 0:
        part.add("masonry", faceted([[(-width / 2, 0, back), (width / 2, 0, back), (width / 2, foot, back),
                                      (-width / 2, foot, back)]]))
    part.add("trim", archivolt(half, spring, back, 16))
    for s in (-1, 1):
        part.add("trim", box(0.36, spring - foot, 0.10, 0.015, (s * (half + 0.18), (spring + foot) / 2, back + 0.03)))
        part.add("trim", box(0.44, 0.12, 0.16, 0.02, (s * (half + 0.18), spring, back + 0.05)))
    if kind == "door":
        part.add("planks", rectangle(1.6, 3.0).at(move(0, 0, back - 0.36)))
        for s in (-1, 1):
            for low, high in ((0.2, 0.95), (1.1, 2.1)):
                part.add("wood", box(0.52, high - low, 0.05, 0.02, (s * 0.36, (low + high) / 2, back - 0.34)))
            part.add("bronze", lathe([(0.0, 0), (0.05, 0.0), (0.05, 0.02), (0.02, 0.04), (0.035, 0.08), (0, 0.1)], 12).at(
                turn("x", 90), move(s * 0.08, 1.05, back - 0.34)))
    else:
        a = np.linspace(0, math.pi, 13)
        shell = np.stack([np.stack([-half * np.cos(a), np.full(13, y), -0.5 * np.sin(a)], axis=1) for y in (foot, spring)])
        niche = patch(shell)
        niche = niche if niche.normals[:, 2].sum() > 0 else niche.flipped()
        b = np.linspace(0, math.pi / 2, 9)
        dome = np.stack([np.stack([-half * np.cos(a) * math.cos(t), np.full(13, spring + half * math.sin(t)),
                                   -0.5 * np.sin(a) * math.cos(t)], axis=1) for t in b])
        dome = patch(dome)
        dome = dome if dome.normals[:, 2].sum() > 0 else dome.flipped()
        sill = faceted([[(-half, foot, 0.0), (half, foot, 0.0), (half, foot, -0.5), (-half, foot, -0.5)]])
        part.add("plaster", *[m.at(move(0, 0, back - 0.1)) for m in (niche, dome, sill)])
        part.add("trim", box(2 * half + 0.5, 0.14, 0.3, 0.03, (0, foot - 0.06, back + 0.1)))
        part.add("clay", amphora().at(move(0, foot, back - 0.22)))


def amphora():
    y = np.linspace(0, 1, 17)
    r = 0.07 + 0.20 * np.sin(math.pi * np.clip(y / 0.78, 0, 1)) ** 0.8 * (1 - 0.25 * y)
    r = np.where(y > 0.76, 0.075 + 0.9 * (y - 0.82) ** 2 * (y > 0.82), r)
    profile = [(0.0, 0.0)] + [(0.13, 0.0)] + [(max(a, 0.07), 0.02 + b) for a, b in zip(r, y)] + [(0.05, 1.0), (0.05, 0.8)]
    handles = [tube(bent([(s * 0.07, 0.95, 0), (s * 0.26, 0.92, 0), (s * 0.2, 0.62, 0)], 0.12, 6), 0.02, 6) for s in (-1, 1)]
    return merge([lathe(profile, 16)] + handles)


def shutters(part, back, foot, height):
    """A window of the upper floor with louvred shutters."""
    part.add("trim", box(1.5, 0.1, 0.2, 0.02, (0, foot - 0.05, back + 0.08)),
             box(1.5, 0.16, 0.16, 0.03, (0, foot + height + 0.08, back + 0.06)))
    for s in (-1, 1):
        part.add("trim", box(0.14, height, 0.12, 0.02, (s * 0.66, foot + height / 2, back + 0.04)))
        for x in (0.04, 0.56):
            part.add("shutter", box(0.07, height, 0.05, 0.01, (s * x, foot + height / 2, back + 0.05)))
        for y in (0.04, height / 2, height - 0.04):
            part.add("shutter", box(0.52, 0.08, 0.05, 0.01, (s * 0.3, foot + y, back + 0.05)))
        for k in range(18):
            y = foot + 0.12 + (height - 0.24) * k / 17
            part.add("shutter", box(0.46, 0.012, 0.06).at(turn("x", 35), move(s * 0.3, y, back + 0.05)))


def tiles(part, width):
    """Round tiles down a slope of 24 degrees, their lowest row over the eaves."""
    columns, rows = round(width / 0.25), 7
    a = np.radians(np.linspace(0, 180, 5))
    for k in range(columns):
        for upside in (0, 1):
            x = (k + 0.5 * (1 + upside)) * width / columns - width / 2
            for row in range(rows if not upside else 1):
                r0, r1 = (0.085, 0.07) if not upside else (0.075, 0.075)
                length = 0.42 if not upside else 0.36 * rows
                grid = np.stack([np.stack([x + r * np.cos(a), (1 if not upside else -0.6) * r * np.sin(a) + lift,
                                           np.full(5, -s)], axis=1)
                                 for r, s, lift in ((r0, 0, 0.03 * (not upside)), (r1, length, 0.0))])
                mesh = patch(grid)
                mesh = mesh if mesh.normals[:, 1].sum() > 0 else mesh.flipped()
                part.add("roof", mesh.at(move(0, 0.03 * (not upside), -0.36 * row), turn("x", 24), move(0, EAVES + 0.16, 0.75)))


def curtain(width, height, seed, columns=64, rows=36, gather=0.0):
    """Cloth hung from rings, in folds that grow downwards; `gather` ties it towards one side."""
    rng = np.random.default_rng(seed)
    phase = rng.uniform(0, 2 * math.pi, 4)
    u, v = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1), indexing="ij")
    fold = np.sin(2 * math.pi * 7 * u + phase[0] + 0.7 * np.sin(4 * v + phase[1]))
    fold += 0.4 * np.sin(2 * math.pi * 13 * u + phase[2] + 1.3 * v)
    depth = (0.035 + 0.06 * v) * fold
    knot = np.exp(-((v - 0.62) / 0.16) ** 2) * gather + np.clip(v - 0.62, 0, 1) * 0.9 * gather
    x = (u - 0.5) * width * (1 - 0.72 * knot) + 0.36 * width * knot * (1 if seed % 2 else -1)
    sag = 0.03 * np.abs(np.sin(7 * math.pi * u)) * (1 - v)
    y = -height * v * (1 - 0.03 * knot) - sag + 0.012 * np.sin(9 * u + phase[3]) * v
    mesh = patch(np.stack([x, y, depth * (1 + 0.8 * knot)], axis=2))
    mesh.uvs = np.stack([u.reshape(-1) * width * 1.25, v.reshape(-1) * height], axis=1)
    return mesh if mesh.normals[:, 2].sum() > 0 else mesh.flipped()


def curtain_part(color, width, height, seed, gather):
    part = Part(color + " curtain")
    part.add(color, curtain(width, height, seed, gather=gather))
    part.add("bronze", tube([(-width / 2 - 0.12, 0.05, 0), (width / 2 + 0.12, 0.05, 0)], 0.028, 8))
    for k in range(15):
        x = (k / 14 - 0.5) * width
        ring = [(x, 0.05 + 0.05 * math.cos(t), 0.05 * math.sin(t)) for t in np.linspace(0, 2 * math.pi, 9)]
        part.add("bronze", tube(ring, 0.007, 4, closed=True))
    return part


def banner(color, seed):
    """A long cloth over the balustrade."""
    part = Part(color + " banner")
    cloth = curtain(1.5, 2.6, seed, 24, 34)
    cloth.points[:, 2] *= 0.35
    part.add(color, cloth)
    part.add("bronze", tube([(-0.85, -2.62, 0), (0.85, -2.62, 0)], 0.02, 8))
    return part


def agave(seed):
    """A pot with a rosette of long leaves."""
    part = Part("agave")
    part.add("clay", lathe([(0.0, 0), (0.26, 0), (0.36, 0.42), (0.42, 0.44), (0.42, 0.54), (0.35, 0.54), (0.33, 0.46)], 28))
    part.add("soil", lathe([(0.34, 0.46), (0.0, 0.5)], 20))
    rng = np.random.default_rng(seed)
    for k in range(46):
        lift = math.radians(14 + 66 * (k / 46) ** 0.8 + rng.uniform(-5, 5))
        length = 0.95 * (0.7 + 0.3 * rng.random()) * (0.75 + 0.25 * math.cos(lift))
        t, w = np.meshgrid(np.linspace(0, 1, 8), np.array([-1, -0.5, 0, 0.5, 1]), indexing="ij")
        width = 0.075 * np.sin(math.pi * np.clip(0.12 + 0.88 * t, 0, 1)) ** 0.8
        bend = lift - 0.9 * t * math.cos(lift)
        x = length * t * np.cos(bend)
        y = 0.48 + length * t * np.sin(bend) + 0.5 * np.abs(w) * width
        mesh = patch(np.stack([x, y, width * w], axis=2))
        mesh = mesh if mesh.normals[:, 1].sum() > 0 else mesh.flipped()
        part.add("leaf", mesh.at(turn("y", 137.508 * k)))
    return part


def fountain():
    part = Part("fountain")
    part.add("trim", lathe([(2.5, 0), (2.5, 0.16), (2.36, 0.2), (2.36, 0.24), (2.24, 0.34), (2.24, 0.62), (2.38, 0.70),
                            (2.42, 0.78), (2.36, 0.84), (2.02, 0.84), (1.98, 0.78), (1.98, 0.22), (0, 0.22)], 8).at(turn("y", 22.5)))
    for k in range(8):
        part.add("trim", box(1.2, 0.2, 0.05, 0.02, (0, 0.48, 2.06)).at(turn("y", 45 * k)))
    a, r = np.meshgrid(np.linspace(0, 2 * math.pi, 73), np.linspace(0.02, 2.1, 22), indexing="ij")
    ripple = 0.012 * np.sin(22 * r - 1.2 * np.cos(3 * a)) * np.exp(-0.6 * r) + 0.004 * np.sin(31 * r * np.cos(a) + 9 * r * np.sin(a))
    pool = patch(np.stack([r * np.sin(a), 0.66 + ripple, r * np.cos(a)], axis=2), closed_u=True)
    part.add("water", pool if pool.normals[:, 1].sum() > 0 else pool.flipped())
    part.add("marble", lathe([(0.5, 0.2), (0.5, 0.7), (0.42, 0.76), (0.30, 0.86), (0.22, 1.1), (0.26, 1.3), (0.36, 1.36), (0.22, 1.42),
                              (0.3, 1.5), (0.8, 1.62), (1.15, 1.8), (1.24, 1.9), (1.2, 1.94), (1.05, 1.86), (0.3, 1.72)], 64,
                             lambda t: 1 + 0.02 * np.abs(np.cos(10 * t))))
    part.add("marble", lathe([(0.26, 1.7), (0.2, 1.86), (0.14, 2.0), (0.2, 2.16), (0.12, 2.22), (0.3, 2.3), (0.56, 2.42), (0.62, 2.5),
                              (0.58, 2.53), (0.2, 2.42)], 48, lambda t: 1 + 0.03 * np.abs(np.cos(8 * t))))
    part.add("marble", lathe([(0.16, 2.40), (0.12, 2.55), (0.18, 2.68), (0.08, 2.8), (0.12, 2.92), (0.02, 3.1), (0, 3.12)], 32))
    return part


def lantern():
    part = Part("lantern")
    part.add("bronze", tube([(0, 0, 0), (0, 1.1, 0)], 0.012, 6))
    part.add("bronze", lathe([(0, -0.62), (0.05, -0.58), (0.03, -0.54), (0.16, -0.5), (0.16, -0.47), (0.02, -0.46)], 6))
    part.add("bronze", lathe([(0.02, -0.06), (0.2, -0.1), (0.19, -0.06), (0.1, 0.0), (0.04, 0.1), (0.05, 0.14), (0, 0.2)], 6))
    for k in range(6):
        a = math.radians(60 * k)
        part.add("bronze", tube([(0.15 * math.sin(a), -0.48, 0.15 * math.cos(a)), (0.18 * math.sin(a), -0.08, 0.18 * math.cos(a))], 0.012, 5))
    return part


def bench():
    part = Part("bench")
    part.add("trim", box(1.8, 0.12, 0.5, 0.03, (0, 0.46, 0)))
    for s in (-1, 1):
        part.add("trim", prism([(-0.2, 0), (0.2, 0), (0.14, 0.1), (0.1, 0.3), (0.18, 0.4), (-0.18, 0.4), (-0.1, 0.3), (-0.14, 0.1)],
                               0.14, 0.02).at(turn("y", 90), move(s * 0.62, 0, 0)))
    return part


def paving(level):
    """Slabs that have settled a little, each on its own."""
    rng = np.random.default_rng(5)
    part = Part("paving")
    step = 0.75
    for i in range(int(2 * HALF_X / step)):
        for k in range(int(2 * HALF_Z / step)):
            x, z = (i + 0.5) * step - HALF_X, (k + 0.5) * step - HALF_Z
            slab = box(step - 0.014, 0.1, step - 0.014, 0.008)
            slab.faces = slab.faces[slab.normals[slab.faces[:, 0], 1] > -0.5]
            slab = slab.at(turn("x", rng.uniform(-0.25, 0.25)), turn("z", rng.uniform(-0.25, 0.25)),
                           move(x, -0.05 + rng.uniform(-0.004, 0.004), z))
            slab.uvs = slab.points[:, [0, 2]] + rng.uniform(0, 4, 2)
            part.add("slab", slab)
    part.add("soil", ground(-HALF_X, HALF_X, -HALF_Z, HALF_Z, y=-0.08))
    level.place(part)
    around = Part("gallery floor")
    x, z = HALF_X + DEPTH + 0.8, HALF_Z + DEPTH + 0.8
    for x0, x1, z0, z1 in ((-x, -HALF_X, -z, z), (HALF_X, x, -z, z), (-HALF_X, HALF_X, -z, -HALF_Z), (-HALF_X, HALF_X, HALF_Z, z)):
        around.add("floor", ground(x0, x1, z0, z1, y=0.0))
    level.place(around)


def corner():
    """Where two galleries meet, of the corner at -X, -Z seen from the court: vault, walls, roof."""
    part = Part("corner")
    d = DEPTH + 0.32
    part.add("plaster", *[m.at(move(-DEPTH / 2 - 0.32, SPRING, -DEPTH / 2 - 0.32)) for m in groin(DEPTH, DEPTH, BAY / 2 - 0.34)])
    part.add("masonry", faceted([[(-d, 0, -d), (0, 0, -d), (0, FLOOR_2, -d), (-d, FLOOR_2, -d)]]),
             faceted([[(-d, 0, 0), (-d, 0, -d), (-d, FLOOR_2, -d), (-d, FLOOR_2, 0)]]))
    part.add("plaster", faceted([[(-d, FLOOR_2, -d), (0, FLOOR_2, -d), (0, EAVES, -d), (-d, EAVES, -d)]]),
             faceted([[(-d, FLOOR_2, 0), (-d, FLOOR_2, -d), (-d, EAVES, -d), (-d, EAVES, 0)]]))
    part.add("floor", faceted([[(-d, FLOOR_2, 0), (0, FLOOR_2, 0), (0, FLOOR_2, -d), (-d, FLOOR_2, -d)]]))
    part.add("planks", faceted([[(-d, EAVES - 0.48, 0), (-d, EAVES - 0.48, -d), (0, EAVES - 0.48, -d), (0, EAVES - 0.48, 0)]]))
    part.add("stone", box(0.8, FLOOR_2, 0.8, 0.03, (0, FLOOR_2 / 2, 0)), box(0.6, EAVES - FLOOR_2, 0.6, 0.03, (0, (EAVES + FLOOR_2) / 2, 0)))
    part.add("trim", box(0.96, 0.3, 0.96, 0.04, (0, 0.15, 0)), box(0.96, 0.24, 0.96, 0.06, (0, SPRING - 0.12, 0)))
    # The arches between the corner and the galleries.
    for turned in (False, True):
        arch = arched_wall(round_arch(DEPTH / 2 - 0.3, SPRING, SPRING, 16, BAY / 2 - 0.5), DEPTH, FLOOR_2 - 0.3, 0.4, rows=1)
        part.add("stone", arch.at(turn("y", 90), move(0, 0, -DEPTH / 2 - 0.32), SWAP_XZ if turned else np.eye(4)))
    return part


def build():
    sand = from_srgb(0.91, 0.83, 0.69)
    level = Level("Atrium", {
        "stone": surfaces.masonry(sand, 7, 4, seed=61, tile=2.8, spread=0.1, depth=0.004),
        "trim": surfaces.stone(from_srgb(0.93, 0.88, 0.78), seed=63, tile=1.3),
        "masonry": surfaces.masonry(from_srgb(0.84, 0.71, 0.56), 8, 4, seed=65, tile=2.6, spread=0.18, depth=0.008),
        "plaster": surfaces.plaster(from_srgb(0.95, 0.89, 0.77), seed=67),
        "floor": surfaces.paving(from_srgb(0.72, 0.58, 0.44), from_srgb(0.48, 0.26, 0.18), 512, seed=69, tiles=6, tile=3.0, gloss=0.5),
        "slab": surfaces.stone(from_srgb(0.88, 0.83, 0.74), seed=71, tile=2.0, gloss=0.4),
        "wood": surfaces.wood(from_srgb(0.40, 0.25, 0.15), seed=73, boards=2, gloss=0.35),
        "planks": surfaces.wood(from_srgb(0.46, 0.30, 0.19), seed=75, boards=6, tile=1.2, gloss=0.35),
        "shutter": surfaces.wood(from_srgb(0.20, 0.38, 0.36), 256, seed=77, boards=1, tile=0.8, gloss=0.4),
        "roof": surfaces.masonry(from_srgb(0.72, 0.36, 0.22), 4, 8, 256, seed=79, tile=2.0, joint=0.001, spread=0.3),
        "clay": surfaces.stone(from_srgb(0.70, 0.40, 0.27), 256, seed=81, tile=0.8),
        "soil": surfaces.soil(seed=83),
        "leaf": surfaces.leaves(from_srgb(0.36, 0.52, 0.30), seed=85),
        "bronze": surfaces.metal((0.62, 0.44, 0.24), seed=87),
        "marble": surfaces.marble(from_srgb(0.92, 0.90, 0.86), from_srgb(0.60, 0.56, 0.54), seed=89, gloss=0.6),
        "water": surfaces.marble(from_srgb(0.10, 0.26, 0.28), from_srgb(0.14, 0.32, 0.32), 256, seed=91, gloss=0.8),
        "red": surfaces.cloth(from_srgb(0.68, 0.10, 0.10), from_srgb(0.86, 0.62, 0.26), seed=93),
        "green": surfaces.cloth(from_srgb(0.12, 0.40, 0.20), from_srgb(0.80, 0.66, 0.30), seed=95),
        "blue": surfaces.cloth(from_srgb(0.12, 0.24, 0.55), from_srgb(0.82, 0.68, 0.36), seed=97),
    })
    low = Part("column")
    low.add("trim", *column(0.30, SPRING, segments=20))
    high = Part("upper column")
    high.add("trim", *column(0.20, SPRING_2 - FLOOR_2, segments=12))
    colors = ("red", "green", "blue")
    curtains = {c: curtain_part(c, BAY - 1.1, 3.35, k, 0.0 if k != 1 else 0.75) for k, c in enumerate(colors)}
    banners = [banner(c, k) for k, c in enumerate(colors)]
    long_bays = [bay(BAY, "door"), bay(BAY, "niche")]
    end_bay = bay(END_BAY, "door")
    lamp, pot, seat = lantern(), agave(3), bench()

    sides = [(-90 * s, s * HALF_X, 0, COUNT, BAY) for s in (1, -1)] + [(0, 0, -HALF_Z, END_COUNT, END_BAY),
                                                                     (180, 0, HALF_Z, END_COUNT, END_BAY)]
    for side, (angle, x, z, count, width) in enumerate(sides):
        at = lambda part, *steps: level.place(part, *steps, turn("y", angle), move(x, 0, z))
        for k in range(count):
            along = move((k - (count - 1) / 2) * width, 0, 0)
            at(long_bays[(k + side) % 2] if side < 2 else end_bay, along)
            at(lamp, move(0, SPRING + 0.2, -DEPTH / 2), along)
            if side < 2 and (k + side) % 2 == 0:
                at(curtains[colors[(k // 2 + side) % 3]], move(0, 3.62, -0.05), along)
            if side < 2 and k % 3 == 1:
                at(banners[(k + side) % 3], move(0, FLOOR_2 + 0.98, 0.33), along)
        for k in range(1, count):
            along = move((k - count / 2) * width, 0, 0)
            at(low, along)
            at(high, move(0, FLOOR_2, 0), along)
            if side < 2 and k % 2 == 0:
                at(pot, move(0, 0, 1.1), along)
    quarter = corner()
    for sx in (1, -1):
        for sz in (1, -1):
            level.place(quarter, size(sx, 1, sz), move(-sx * HALF_X, 0, -sz * HALF_Z))
    paving(level)
    level.place(fountain(), move(0, 0, 0))
    for s in (-1, 1):
        for z in (-6.5, 6.5):
            level.place(seat, turn("y", 90), move(s * 3.2, 0, z))

    # Steep, so that most of the paving shines and lights what is under the arches.
    sun = looking((-3.2, 10.0, 3.2), (0, 0, 0))
    level.light("directional", (1.0, 0.95, 0.86), 9.0, sun)

    # Two figures on plinths take what is left.
    stand = Part("plinth")
    stand.add("trim", lathe([(r, y) for r, y in statue.plinth(1.3, 1.1)], 8).at(turn("y", 22.5)))
    for s in (-1, 1):
        level.place(stand, move(0, 0, s * 10.5))
    rows = 112
    columns = (TRIANGLES - level.triangle_count()) // (2 * rows * 2)
    figure = Part("figure")
    figure.add("marble", statue.robed_figure(max(columns, 12), rows))
    for s in (-1, 1):
        level.place(figure, size(1.15), turn("y", 0 if s < 0 else 180), move(0, 1.1, s * 10.5))

    level.camera("court", (-4.3, 1.75, HALF_Z - 1.2), (2.2, 3.3, -HALF_Z + 3), 58, 16 / 9)
    level.camera("gallery", (HALF_X + 3.3, 1.75, HALF_Z - 7.0), (HALF_X + 1.5, 2.3, -HALF_Z), 62, 16 / 9)
    level.camera("upper", (-HALF_X + 0.7, FLOOR_2 + 2.2, 9.6), (4.6, 2.2, -4.0), 58, 16 / 9)
    level.camera("fountain", (3.9, 1.6, 5.2), (-1.0, 2.3, -3.0), 55, 16 / 9)
    level.camera("curtain", (-1.2, 1.7, -2.0), (HALF_X, 2.6, -5.6), 55, 16 / 9)
    return level
