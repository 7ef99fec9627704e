"""Triangle meshes from few numbers: patches, lathes, sweeps, boxes, arched walls.

Metres, Y up, counter-clockwise fronts. Texture coordinates are metres along the surface; a material
says how many metres one repetition of its images takes.
"""

import math

import numpy as np

CREASE_RAD = math.radians(32)  # sharper bends are edges, others are shaded smooth


class Mesh:
    """points [n, 3], normals [n, 3], uvs [n, 2], faces [m, 3]."""

    def __init__(self, points, normals, uvs, faces):
        self.points = np.asarray(points, float).reshape(-1, 3)
        self.normals = np.asarray(normals, float).reshape(-1, 3)
        self.uvs = np.asarray(uvs, float).reshape(-1, 2)
        self.faces = np.asarray(faces, np.int64).reshape(-1, 3)

    def __len__(self):
        return len(self.faces)

    def at(self, *steps):
        """The mesh moved by matrices, the first one first."""
        matrix = np.eye(4)
        for step in steps:
            matrix = step @ matrix
        linear = matrix[:3, :3]
        normals = unit(self.normals @ np.linalg.inv(linear))
        faces = self.faces if np.linalg.det(linear) > 0 else self.faces[:, ::-1]
        return Mesh(self.points @ linear.T + matrix[:3, 3], normals, self.uvs, faces)

    def flipped(self):
        return Mesh(self.points, -self.normals, self.uvs, self.faces[:, ::-1])


def unit(vectors):
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1)


# ---- Placing


def move(x=0.0, y=0.0, z=0.0):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def size(x, y=None, z=None):
    return np.diag([x, x if y is None else y, x if z is None else z, 1.0])


def turn(axis, degrees):
    """Counter-clockwise about "x", "y" or "z", seen from its tip."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    matrix = np.eye(4)
    a, b = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix[a, a] = matrix[b, b] = c
    matrix[a, b], matrix[b, a] = -s, s
    return matrix


def merge(meshes):
    meshes = list(meshes)
    starts = np.cumsum([0] + [len(m.points) for m in meshes])
    return Mesh(np.concatenate([m.points for m in meshes]),
                np.concatenate([m.normals for m in meshes]),
                np.concatenate([m.uvs for m in meshes]),
                np.concatenate([m.faces + s for m, s in zip(meshes, starts)]))


# ---- Surfaces


def _lengths(points, axis):
    """Metres along one direction of a grid of points, the mean over the other."""
    steps = np.linalg.norm(np.diff(points, axis=axis), axis=2).mean(axis=1 - axis)
    return np.concatenate([[0.0], np.cumsum(steps)])


def patch(points, closed_u=False, closed_v=False):
    """A smooth surface through a grid of points [nu, nv, 3]; u x v points to the front. A closed
    direction repeats its first point at the end."""
    points = np.asarray(points, float)
    nu, nv = points.shape[:2]

    def slope(axis, closed):
        rolled = np.moveaxis(points, axis, 0)
        d = np.gradient(rolled, axis=0)
        if closed:
            d[0] = d[-1] = 0.5 * (rolled[1] - rolled[-2])
        return np.moveaxis(d, 0, axis)

    du, dv = slope(0, closed_u), slope(1, closed_v)
    normals = np.cross(du, dv)
    # At a pole one direction vanishes: the neighbours know better.
    small = np.linalg.norm(normals, axis=2) < 1e-12
    if small.any():
        inner = np.cross(np.roll(du, -1, 0), dv) + np.cross(du, np.roll(dv, -1, 1))
        inner += np.roll(normals, 1, 0) + np.roll(normals, -1, 0)
        inner += np.roll(normals, 1, 1) + np.roll(normals, -1, 1)
        normals[small] = inner[small]
    uv = np.stack(np.meshgrid(_lengths(points, 0), _lengths(points, 1), indexing="ij"), axis=2)
    index = np.arange(nu * nv).reshape(nu, nv)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    faces = np.stack([a, b, c, a, c, d], axis=2).reshape(-1, 3)
    flat = points.reshape(-1, 3)
    e1, e2 = flat[faces[:, 1]] - flat[faces[:, 0]], flat[faces[:, 2]] - flat[faces[:, 0]]
    faces = faces[np.linalg.norm(np.cross(e1, e2), axis=1) > 1e-12]
    return Mesh(flat, unit(normals).reshape(-1, 3), uv.reshape(-1, 2), faces)


def smooth_runs(line, closed=False):
    """Index lists that cut a polyline [n, d] at its edges."""
    line = np.asarray(line, float)
    steps = unit(np.diff(line, axis=0))
    cosines = (steps[1:] * steps[:-1]).sum(axis=1)
    cuts = [0] + [i + 1 for i, c in enumerate(cosines) if c < math.cos(CREASE_RAD)] + [len(line) - 1]
    return [np.arange(a, b + 1) for a, b in zip(cuts, cuts[1:]) if b > a]


def lathe(profile, segments, lobes=None):
    """Turns a profile of (radius, y), from below upwards, about the Y axis. lobes(angle) scales the
    radius round the circle."""
    profile = np.asarray(profile, float)
    angles = np.linspace(0, 2 * math.pi, segments + 1)
    scale = np.ones_like(angles) if lobes is None else lobes(angles)
    parts = []
    for run in smooth_runs(profile):
        r, y = profile[run, 0], profile[run, 1]
        grid = np.stack([np.outer(scale * np.sin(angles), r), np.outer(np.ones_like(angles), y),
                         np.outer(scale * np.cos(angles), r)], axis=2)
        parts.append(patch(grid, closed_u=True))
    return merge(parts)


def sweep(profile, path, up=(0, 1, 0), closed=False):
    """Drags a profile (side, up) [k, 2] along a path [n, 3]. Looking along the path, side is to the
    right; a profile that runs counter-clockwise has its front outside. Corners of the path are mitred.
    up=None carries the first frame along; else up must never lie along the path."""
    profile, path = np.asarray(profile, float), np.asarray(path, float)
    steps = unit(np.diff(path, axis=0))
    if closed:
        before, after = np.roll(steps, 1, 0), steps
        before, after = np.vstack([before, before[:1]]), np.vstack([after, after[:1]])
    else:
        before, after = np.vstack([steps[:1], steps]), np.vstack([steps, steps[-1:]])
    mitres = unit(before + after)

    rings = []
    side = None
    for i, point in enumerate(path):
        t = before[i]
        if up is not None:
            side = unit(np.cross(t, np.asarray(up, float)))
        elif side is None:
            helper = (0, 1, 0) if abs(t[1]) < 0.9 else (1, 0, 0)
            side = unit(np.cross(t, np.asarray(helper, float)))
        else:
            side = unit(side - t * (side @ t))
        over = np.cross(side, t)
        offsets = np.outer(profile[:, 0], side) + np.outer(profile[:, 1], over)
        offsets -= np.outer(offsets @ mitres[i] / (t @ mitres[i]), t)
        rings.append(point + offsets)
    rings = np.stack(rings)  # [n, k, 3]

    parts = []
    for along in smooth_runs(path):
        for across in smooth_runs(profile):
            grid = rings[along][:, across]
            whole = len(across) == len(profile) and np.allclose(profile[0], profile[-1])
            parts.append(patch(grid, closed_u=closed and len(along) == len(path), closed_v=whole))
    return merge(parts)


def circle(radius, segments, start=0.0, end=360.0):
    """Points (x, y) round a circle, counter-clockwise; the last is the first again for a whole one."""
    angles = np.radians(np.linspace(start, end, segments + 1))
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def tube(path, radius, segments=12, closed=False):
    """A pipe along a path."""
    return sweep(circle(radius, segments), path, None, closed)


def bent(points, radius, segments=6):
    """A polyline [n, 3] with its corners rounded."""
    points = np.asarray(points, float)
    out = [points[0]]
    for a, b, c in zip(points, points[1:], points[2:]):
        into, away = unit(b - a), unit(c - b)
        cut = min(radius, 0.49 * np.linalg.norm(b - a), 0.49 * np.linalg.norm(c - b))
        for t in np.linspace(0, 1, segments + 1):
            out.append((1 - t) ** 2 * (b - cut * into) + 2 * t * (1 - t) * b + t * t * (b + cut * away))
    out.append(points[-1])
    return np.array(out)


def faceted(polygons):
    """Flat convex polygons, each a list of points; textured as if by a box around them."""
    points, normals, uvs, faces = [], [], [], []
    for polygon in polygons:
        corners = np.asarray(polygon, float)
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        if not np.linalg.norm(normal) > 1e-12:
            normal = np.cross(corners[2] - corners[0], corners[-1] - corners[0])
        start = len(points)
        points.extend(corners)
        normals.extend([unit(normal)] * len(corners))
        uvs.extend(box_uv(corners, normal))
        faces.extend([start, start + i, start + i + 1] for i in range(1, len(corners) - 1))
    return Mesh(points, normals, uvs, faces)


def box_uv(points, normal):
    """Metres on the side of a box that a normal faces most."""
    axis = int(np.argmax(np.abs(normal)))
    sign = 1.0 if normal[axis] > 0 else -1.0
    if axis == 0:
        return np.stack([-sign * points[:, 2], -points[:, 1]], axis=1)
    if axis == 1:
        return np.stack([points[:, 0], sign * points[:, 2]], axis=1)
    return np.stack([sign * points[:, 0], -points[:, 1]], axis=1)


def box(x, y, z, bevel=0.0, at=(0, 0, 0)):
    """A box of these sizes about a point, its edges cut by a bevel."""
    half = 0.5 * np.array([x, y, z], float)
    middle = np.asarray(at, float)

    def corner(signs, face):
        inset = half - bevel
        inset[face] = half[face]
        return middle + np.asarray(signs) * inset

    polygons = []
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        for s in (-1, 1):
            signs = []
            for sb, sc in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                sign = [0, 0, 0]
                sign[a], sign[b], sign[c] = s, sb, sc
                signs.append(sign)
            polygons.append([corner(sign, a) for sign in (signs if s > 0 else signs[::-1])])
            if bevel <= 0:
                continue
            for t in (-1, 1):
                low, high = [0, 0, 0], [0, 0, 0]
                low[a] = high[a] = s
                low[b] = high[b] = t
                low[c], high[c] = -1, 1
                quad = [corner(low, a), corner(low, b), corner(high, b), corner(high, a)]
                polygons.append(quad if s * t > 0 else quad[::-1])
    if bevel > 0:
        for signs in np.ndindex(2, 2, 2):
            sign = [2 * v - 1 for v in signs]
            three = [corner(sign, 0), corner(sign, 1), corner(sign, 2)]
            polygons.append(three if np.prod(sign) > 0 else three[::-1])
    return faceted(polygons)


def rectangle(width, height, nu=1, nv=1):
    """Upright, in the XY plane, facing +Z, its lower edge in the middle of the origin. Texture
    coordinates run 0 .. 1 right and down over it."""
    x, y = np.meshgrid(np.linspace(-width / 2, width / 2, nu + 1), np.linspace(0, height, nv + 1),
                       indexing="ij")
    mesh = patch(np.stack([x, y, np.zeros_like(x)], axis=2))
    mesh.uvs = np.stack([mesh.points[:, 0] / width + 0.5, 1 - mesh.points[:, 1] / height], axis=1)
    return mesh


def ground(x0, x1, z0, z1, nx=1, nz=1, y=0.0, height=None):
    """Level ground, facing up; height(x, z) lifts it."""
    x, z = np.meshgrid(np.linspace(x0, x1, nx + 1), np.linspace(z1, z0, nz + 1), indexing="ij")
    lift = np.zeros_like(x) if height is None else height(x, z)
    mesh = patch(np.stack([x, y + lift, z], axis=2))
    mesh.uvs = mesh.points[:, [0, 2]].copy()
    return mesh


def prism(outline, depth, bevel=0.0):
    """An outline (x, y), counter-clockwise, made `depth` thick about z = 0; its edges may be cut."""
    outline = np.asarray(outline, float)
    n = len(outline)
    step = np.roll(outline, -1, 0) - outline
    normal = unit(np.stack([step[:, 1], -step[:, 0]], axis=1))
    before = np.roll(normal, 1, 0)
    joint = (normal + before) / (1 + (normal * before).sum(axis=1, keepdims=True))
    inner = outline - bevel * joint
    z = depth / 2
    at = lambda line, i, d: (line[i % n, 0], line[i % n, 1], d)
    polygons = []
    for i in range(n):
        polygons.append([at(outline, i, bevel - z), at(outline, i + 1, bevel - z),
                         at(outline, i + 1, z - bevel), at(outline, i, z - bevel)])
        if bevel > 0:
            polygons.append([at(outline, i, z - bevel), at(outline, i + 1, z - bevel),
                             at(inner, i + 1, z), at(inner, i, z)])
            polygons.append([at(outline, i + 1, bevel - z), at(outline, i, bevel - z),
                             at(inner, i, -z), at(inner, i + 1, -z)])
    for a, b, c in triangulate(inner):
        polygons.append([at(inner, a, z), at(inner, b, z), at(inner, c, z)])
        polygons.append([at(inner, c, -z), at(inner, b, -z), at(inner, a, -z)])
    return faceted(polygons)


def triangulate(outline):
    """Ears cut off a simple counter-clockwise polygon (x, y), one after the other."""
    left = list(range(len(outline)))
    cross = lambda o, a, b: ((a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]))
    triangles = []
    while len(left) > 3:
        for k in range(len(left)):
            a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
            pa, pb, pc = outline[a], outline[b], outline[c]
            if cross(pa, pb, pc) <= 1e-14:
                continue
            inside = (outline[i] for i in left if i not in (a, b, c))
            if not any(cross(pa, pb, p) >= 0 and cross(pb, pc, p) >= 0 and cross(pc, pa, p) >= 0
                       for p in inside):
                break
        triangles.append((left[k - 1], left[k], left[(k + 1) % len(left)]))
        del left[k]
    triangles.append(tuple(left))
    return triangles


# ---- Arches


def round_arch(half_width, spring, foot=0.0, segments=16, rise=None):
    """The edge (x, y) of an arched opening, from its left foot over the top to its right foot."""
    rise = half_width if rise is None else rise
    angles = np.linspace(math.pi, 0, segments + 1)
    arc = np.stack([half_width * np.cos(angles), spring + rise * np.sin(angles)], axis=1)
    return arc if spring <= foot else np.vstack([[[-half_width, foot]], arc, [[half_width, foot]]])


def pointed(u, sharp=2.0):
    """Height of a pointed arch of half width 1 and height 1 at |u| <= 1; its radius is `sharp`."""
    u = np.minimum(np.abs(u), 1.0)
    return np.sqrt(np.maximum(sharp ** 2 - (u + sharp - 1) ** 2, 0)) / math.sqrt(2 * sharp - 1)


def pointed_arch(half_width, spring, foot=0.0, segments=16, rise=None, sharp=2.0):
    """As round_arch(), of two arcs that meet in a point."""
    rise = half_width * math.sqrt(2 * sharp - 1) if rise is None else rise
    # Equal steps along the arc, not along the ground.
    top = math.acos((sharp - 1) / sharp)
    u = sharp * np.cos(np.linspace(0, top, segments // 2 + 1)) - (sharp - 1)
    half = np.stack([u, pointed(u, sharp)], axis=1)
    half[0, 1] = 0.0
    arc = np.vstack([half * [-1, 1], half[-2::-1]]) * [half_width, rise] + [0, spring]
    return arc if spring <= foot else np.vstack([[[-half_width, foot]], arc, [[half_width, foot]]])


def on_path(line, z=0.0):
    """A line (x, y) as a path (x, y, z)."""
    line = np.asarray(line, float)
    return np.column_stack([line, np.full(len(line), z)])


def arched_wall(opening, width, top, depth, rows=2, back=True):
    """A wall with an opening: from the level of the opening's feet up to `top`, `width` wide, `depth`
    thick about z = 0; with the reveal, without its outer sides."""
    opening = np.asarray(opening, float)
    foot = opening[0, 1]
    angles = np.arctan2(opening[:, 1] - foot, opening[:, 0])
    corner = math.atan2(top - foot, width / 2)
    wanted = np.sort(np.unique(np.concatenate([angles, [corner, math.pi - corner]])))[::-1]
    keep = np.concatenate([[True], np.abs(np.diff(wanted)) > 1e-9])
    wanted = wanted[keep]
    inner = np.stack([np.interp(-wanted, -angles, opening[:, i]) for i in (0, 1)], axis=1)
    reach = np.minimum((width / 2) / np.maximum(np.abs(np.cos(wanted)), 1e-9),
                       (top - foot) / np.maximum(np.sin(wanted), 1e-9))
    outer = reach[:, None] * np.stack([np.cos(wanted), np.sin(wanted)], axis=1) + [0, foot]
    t = np.linspace(0, 1, rows + 1)[:, None, None]
    flat = (1 - t) * inner + t * outer  # [rows + 1, k, 2]
    face = np.concatenate([flat, np.full(flat.shape[:2] + (1,), depth / 2)], axis=2)
    front = patch(face.transpose(1, 0, 2)).flipped()
    front = front if front.normals[:, 2].sum() > 0 else front.flipped()
    front.normals[:] = 0, 0, 1
    front.uvs = front.points[:, :2] * [1, -1]
    parts = [front]
    if back:
        parts.append(front.at(turn("y", 180)))
    for run in smooth_runs(opening):
        reveal = np.stack([on_path(opening[run], depth / 2), on_path(opening[run], -depth / 2)])
        parts.append(patch(reveal))
    return merge(parts)


def displaced(mesh, height):
    """A mesh moved along its normals by height(points) and shaded anew; its faces must share points."""
    points = mesh.points + mesh.normals * height(mesh.points)[:, None]
    corner = points[mesh.faces]
    area = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    # Points that lie on one another, as along a seam, share a normal.
    _, same = np.unique(np.round(mesh.points, 6), axis=0, return_inverse=True)
    same = same.reshape(-1)
    normals = np.zeros((same.max() + 1, 3))
    for k in range(3):
        np.add.at(normals, same[mesh.faces[:, k]], area)
    return Mesh(points, unit(normals[same]), mesh.uvs, mesh.faces)
