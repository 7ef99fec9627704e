"""A robed figure, hooded, hands together: what is found by walking from outside towards the axis until
the body is met, then displaced by the folds of the robe. 1.9 m high, looking along +Z."""

import numpy as np

from .mesh import Mesh, displaced, patch

HEIGHT = 1.9


def _ellipsoid(p, middle, radii):
    q = (p - middle) / radii
    length = np.linalg.norm(q, axis=-1)
    return (length - 1) * min(radii)


def _capsule(p, a, b, ra, rb):
    a, b = np.asarray(a, float), np.asarray(b, float)
    t = np.clip(((p - a) @ (b - a)) / ((b - a) @ (b - a)), 0, 1)
    return np.linalg.norm(p - a - t[..., None] * (b - a), axis=-1) - (ra + (rb - ra) * t)


def _join(a, b, soft):
    """The union of two bodies, its hollow filled (I. Quilez's polynomial smooth minimum)."""
    h = np.maximum(soft - np.abs(a - b), 0) / soft
    return np.minimum(a, b) - 0.25 * h * h * soft


def _body(p):
    """Metres to the surface, roughly; negative inside."""
    mirrored = p * [1, 1, 1]
    mirrored[..., 0] = np.abs(mirrored[..., 0])
    # The robe falls from the shoulders, narrow at the waist.
    y = p[..., 1]
    radius = np.interp(y, [0, 0.08, 0.5, 1.0, 1.2, 1.45, 1.6], [0.40, 0.37, 0.30, 0.23, 0.225, 0.20, 0.1])
    flat = np.hypot(p[..., 0] / 1.12, p[..., 2] / 0.92)
    robe = np.maximum(flat - radius, y - 1.5) * 0.8
    body = _join(robe, _ellipsoid(mirrored, [0.13, 1.40, -0.01], [0.13, 0.10, 0.12]), 0.12)
    # Sleeves: upper arm down, forearm forward and in, wide at the wrist; then the hands.
    body = _join(body, _capsule(mirrored, [0.235, 1.36, 0], [0.27, 1.08, 0.06], 0.085, 0.085), 0.06)
    body = _join(body, _capsule(mirrored, [0.27, 1.07, 0.07], [0.06, 1.17, 0.27], 0.075, 0.085), 0.03)
    body = _join(body, _capsule(mirrored, [0.25, 0.95, 0.08], [0.08, 1.05, 0.25], 0.05, 0.07), 0.06)
    body = _join(body, _capsule(mirrored, [0.028, 1.19, 0.32], [0.018, 1.34, 0.34], 0.030, 0.016), 0.02)
    # Head: skull, jaw, nose, brow, eyes; then the hood, open in front.
    head = _ellipsoid(p, [0, 1.72, 0.01], [0.078, 0.105, 0.095])
    head = _join(head, _ellipsoid(p, [0, 1.645, 0.045], [0.05, 0.055, 0.055]), 0.04)
    head = _join(head, _capsule(p, [0, 1.73, 0.098], [0, 1.685, 0.118], 0.009, 0.015), 0.015)
    head = _join(head, _capsule(mirrored, [0.012, 1.745, 0.092], [0.055, 1.742, 0.072], 0.012, 0.01), 0.015)
    head = -_join(-head, _ellipsoid(mirrored, [0.03, 1.722, 0.108], [0.02, 0.013, 0.016]), 0.012)
    head = _join(head, _ellipsoid(mirrored, [0.03, 1.722, 0.082], [0.015, 0.011, 0.012]), 0.006)
    head = _join(head, _capsule(mirrored, [0, 1.652, 0.099], [0.02, 1.653, 0.09], 0.008, 0.005), 0.008)
    head = _join(head, _capsule(p, [0, 1.42, -0.01], [0, 1.62, 0.01], 0.07, 0.055), 0.04)
    hood = _ellipsoid(p, [0, 1.70, -0.025], [0.118, 0.160, 0.13])
    hood = _join(hood, _capsule(p, [0, 1.72, -0.06], [0, 1.45, -0.07], 0.12, 0.17), 0.12)
    opening = _ellipsoid(p, [0, 1.69, 0.12], [0.088, 0.135, 0.15])
    hood = -_join(-hood, opening, 0.04)
    return _join(_join(body, hood, 0.05), head, 0.012)


def _folds(p):
    """How far the cloth stands out, metres."""
    angle = np.arctan2(p[:, 0], p[:, 2])
    y = p[:, 1]
    skirt = np.clip((1.0 - y) / 0.8, 0, 1) ** 0.8
    wave = np.sin(11 * angle + 1.7 * np.sin(2.3 * y + angle) + 0.9 * np.sin(3 * angle))
    wave += 0.45 * np.sin(23 * angle + 2.5 * np.sin(3.1 * y - 2 * angle))
    hood = np.clip((y - 1.55) / 0.1, 0, 1) * (p[:, 2] < 0.02)
    drape = np.clip(1 - np.abs(y - 1.22) / 0.25, 0, 1) * np.sin(34 * y + 5 * np.cos(angle) ** 2)
    return 0.026 * skirt * wave + 0.004 * drape + 0.003 * hood * np.sin(9 * angle + 12 * y)


def robed_figure(columns, rows):
    """The figure as columns x rows quadrilaterals, less the points at its crown."""
    angles = np.linspace(0, 2 * np.pi, columns + 1)
    # Rows where there is more to see: one third of them in the head.
    y = np.interp(np.linspace(0, 1, rows + 1), [0, 0.1, 0.42, 0.66, 0.97, 1],
                  [0.0, 0.12, 0.95, 1.5, 1.85, 1.868])
    a, h = np.meshgrid(angles, y, indexing="ij")
    radius = np.full(a.shape, 0.62)
    for _ in range(90):
        p = np.stack([radius * np.sin(a), h, radius * np.cos(a)], axis=2)
        radius = np.maximum(radius - 0.7 * np.maximum(_body(p), 0), 0)
    radius[:, -1] = 0
    p = np.stack([radius * np.sin(a), h, radius * np.cos(a)], axis=2)
    mesh = displaced(patch(p, closed_u=True), _folds)
    mesh.uvs = np.stack([a.reshape(-1) * 0.3, h.reshape(-1)], axis=1)
    return Mesh(mesh.points, mesh.normals, mesh.uvs, mesh.faces)


def plinth(width, height):
    """What a figure stands on, as an outline for a lathe of four sides: (radius, y)."""
    w = width / 2
    return [(w, 0), (w, 0.14 * height), (0.9 * w, 0.18 * height), (0.82 * w, 0.26 * height),
            (0.8 * w, 0.8 * height), (0.86 * w, 0.84 * height), (0.97 * w, 0.9 * height), (w, 0.92 * height),
            (w, height), (0, height)]
