"""Images made of noise and ruled lines, all of which repeat without a seam.

An image is an array [rows, columns] or [rows, columns, 3] of 0 .. 1; colours are linear. A Surface is
what a material shows: colour, specular colour, gloss, relief and emission.
"""

import struct
import zlib

import numpy as np


class Surface:
    """color and specular: [3] or [n, n, 3]; gloss: a number or [n, n] together with specular. height: [n, n]
    in metres, or None. tile: metres that one repetition takes. emission: [n, n, 3] times
    emission_strength cd/m2, or None. lamp: [3] cd/m2, alone. unlit: shows its colour, lights nothing."""

    def __init__(self, color, specular=0.04, gloss=0.2, height=None, tile=1.0, emission=None,
                 emission_strength=1.0, lamp=None, unlit=False, double_sided=False):
        self.color = np.clip(np.asarray(color, float), 0, 1)
        self.gloss = np.asarray(gloss, float)
        shape = self.gloss.shape + (3,)
        specular = np.asarray(specular, float)
        if specular.ndim == 2 and self.gloss.ndim == 2:
            specular = specular[..., None]
        self.specular = np.broadcast_to(specular, shape)
        self.height, self.tile = height, tile
        self.emission, self.emission_strength = emission, emission_strength
        self.lamp, self.unlit, self.double_sided = lamp, unlit, double_sided


# ---- Noise


def noise(n, beta=2.0, seed=0, low=1.0, stretch=(1.0, 1.0)):
    """Noise whose power falls as frequency^-beta from `low` periods on, 0 .. 1. stretch > 1 draws it out
    down or across."""
    rng = np.random.default_rng(seed)
    fy = np.fft.fftfreq(n, 1 / n)[:, None] * stretch[0]
    fx = np.fft.rfftfreq(n, 1 / n)[None, :] * stretch[1]
    f = np.sqrt(fx * fx + fy * fy)
    with np.errstate(divide="ignore"):
        amplitude = np.where(f >= low, f ** (-beta / 2), 0.0)
    spectrum = np.fft.rfft2(rng.standard_normal((n, n))) * amplitude
    values = np.fft.irfft2(spectrum, (n, n))
    low_end, high_end = np.percentile(values, [1, 99])
    return np.clip((values - low_end) / (high_end - low_end), 0, 1)


def smooth(values, low, high):
    t = np.clip((values - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def mix(a, b, t):
    """From a to b as the image t goes from 0 to 1; a and b are numbers, colours or images."""
    a, b, t = np.asarray(a, float), np.asarray(b, float), np.asarray(t, float)
    if t.ndim == 2 and (a.shape[-1:] == (3,) or b.shape[-1:] == (3,)):
        t = t[..., None]
    return a * (1 - t) + b * t


# ---- Ruled patterns: for each pixel, which piece it is on and how far its edge is (in image widths)


def coordinates(n):
    v, u = np.mgrid[0:n, 0:n] / n
    return u, v


def courses(n, rows, columns, shift=0.5, warp=None):
    """Rows of blocks, every other row shifted by a part of a block."""
    u, v = coordinates(n)
    if warp is not None:
        u, v = u + warp[0], v + warp[1]
    row = np.floor(v * rows).astype(int) % rows
    across = u * columns + (row % 2) * shift
    column = np.floor(across).astype(int) % columns
    fu, fv = across % 1, (v * rows) % 1
    edge = np.minimum(np.minimum(fu, 1 - fu) / columns, np.minimum(fv, 1 - fv) / rows)
    return row * columns + column, edge


def plates(n, depth, seed, least=0.12):
    """A square cut into ever smaller rectangles."""
    rng = np.random.default_rng(seed)
    piece, edge = np.zeros((n, n), int), np.zeros((n, n))
    u, v = coordinates(n)
    pending, count = [(0.0, 0.0, 1.0, 1.0, 0)], 0
    while pending:
        x0, y0, x1, y1, level = pending.pop()
        w, h = x1 - x0, y1 - y0
        if level < depth and max(w, h) > 2 * least and rng.random() < 0.95:
            t = rng.choice([0.3, 0.4, 0.5, 0.6, 0.7])
            if w * rng.uniform(0.7, 1.4) > h:
                pending += [(x0, y0, x0 + t * w, y1, level + 1), (x0 + t * w, y0, x1, y1, level + 1)]
            else:
                pending += [(x0, y0, x1, y0 + t * h, level + 1), (x0, y0 + t * h, x1, y1, level + 1)]
            continue
        inside = (u >= x0) & (u < x1) & (v >= y0) & (v < y1)
        piece[inside] = count
        near = np.minimum(np.minimum(u - x0, x1 - u), np.minimum(v - y0, y1 - v))
        edge[inside] = near[inside]
        count += 1
    return piece, edge


def cells(n, count, seed, squeeze=1.0):
    """Voronoi cells."""
    rng = np.random.default_rng(seed)
    u, v = coordinates(n)
    first, second = np.full((n, n), 9.0), np.full((n, n), 9.0)
    piece = np.zeros((n, n), int)
    for i, (x, y) in enumerate(rng.random((count, 2))):
        dx, dy = np.abs(u - x), np.abs(v - y)
        d = np.hypot(np.minimum(dx, 1 - dx), squeeze * np.minimum(dy, 1 - dy))
        nearer = d < first
        second = np.where(nearer, first, np.minimum(second, d))
        first = np.where(nearer, d, first)
        piece[nearer] = i
    return piece, 0.5 * (second - first)


def by_piece(piece, seed, low=0.0, high=1.0):
    """A random number for each piece."""
    return np.random.default_rng(seed).uniform(low, high, piece.max() + 1)[piece]


# ---- Bytes


def to_srgb(linear):
    linear = np.clip(linear, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def from_srgb(*encoded):
    c = np.asarray(encoded, float)
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def to_bytes(image):
    return np.clip(np.round(image * 255), 0, 255).astype(np.uint8)


def normals(height, tile):
    """The normal map of a relief in metres on a square `tile` metres wide: X right, Y up."""
    step = tile / len(height)
    dx = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) / (2 * step)
    dy = (np.roll(height, -1, 0) - np.roll(height, 1, 0)) / (2 * step)
    normal = np.dstack([-dx, dy, np.ones_like(dx)])
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    return to_bytes(0.5 + 0.5 * normal)


def png(pixels):
    """A PNG file of bytes [rows, columns, 3 or 4], every row filtered by its left neighbour."""
    rows, columns, channels = pixels.shape
    left = pixels.copy()
    left[:, 1:] -= pixels[:, :-1]
    lines = np.concatenate([np.ones((rows, 1), np.uint8), left.reshape(rows, -1)], axis=1)

    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data
                + struct.pack(">I", zlib.crc32(kind + data) & 0xFFFFFFFF))

    head = struct.pack(">IIBBBBB", columns, rows, 8, {3: 2, 4: 6}[channels], 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head)
            + chunk(b"IDAT", zlib.compress(lines.tobytes(), 6)) + chunk(b"IEND", b""))
