"""What the places are made of. Every function gives a texture.Surface; n is its images' width."""

import numpy as np

from .texture import (Surface, by_piece, cells, coordinates, courses, from_srgb, mix, noise, plates,
                      smooth)


def plaster(color, n=512, seed=1, tile=2.0, rough=0.004):
    """Painted plaster, a little uneven and a little stained."""
    broad, fine = noise(n, 2.6, seed), noise(n, 1.4, seed + 1, low=8)
    base = np.asarray(color) * (0.86 + 0.16 * broad + 0.06 * fine)[..., None]
    return Surface(base, 0.03, 0.2 + 0.1 * fine, rough * (0.6 * broad + 0.4 * fine), tile)


def masonry(color, rows, columns, n=512, seed=1, tile=2.0, mortar=None, joint=0.006, depth=0.006,
            spread=0.2):
    """Courses of cut stone or brick with mortar between."""
    warp = [(noise(n, 2.5, seed + 5 + i) - 0.5) * 0.006 for i in (0, 1)]
    piece, edge = courses(n, rows, columns, warp=warp)
    stone = smooth(edge, 0.4 * joint, 1.6 * joint)
    tone = by_piece(piece, seed, 1 - spread, 1 + spread)
    warmth = by_piece(piece, seed + 1, -0.04, 0.04)
    grain, stain = noise(n, 1.5, seed + 2, low=6), noise(n, 2.8, seed + 3)
    base = np.asarray(color) * (tone * (0.84 + 0.2 * grain) * (0.82 + 0.24 * stain))[..., None]
    base = base * np.dstack([1 + warmth, np.ones_like(warmth), 1 - warmth])
    filler = np.asarray(color if mortar is None else mortar) * (0.6 + 0.2 * grain)[..., None]
    height = depth * stone + 0.3 * depth * stone * (grain + by_piece(piece, seed + 4))
    gloss = 0.12 + 0.16 * stone * grain
    return Surface(mix(filler, base, stone), mix(0.02, 0.04, stone), gloss, height, tile)


def stone(color, n=512, seed=1, tile=1.0, gloss=0.25, relief=0.002):
    """Dressed stone without joints."""
    grain, stain = noise(n, 1.3, seed, low=6), noise(n, 2.8, seed + 1)
    base = np.asarray(color) * (0.78 + 0.2 * stain + 0.16 * grain)[..., None]
    return Surface(base, 0.04, gloss + 0.12 * grain, relief * (0.5 * grain + stain), tile)


def marble(light, dark, n=512, seed=1, tile=2.0, gloss=0.62):
    """Polished, veined."""
    u, v = coordinates(n)
    folded = np.abs(noise(n, 3.2, seed) - 0.5) * 2
    fine = np.abs(noise(n, 2.6, seed + 1, low=3) - 0.5) * 2
    vein = np.maximum(1 - smooth(folded, 0.0, 0.09), 0.6 * (1 - smooth(fine, 0.0, 0.08)))
    cloud = noise(n, 3.0, seed + 2)
    base = mix(np.asarray(light) * (0.85 + 0.2 * cloud)[..., None], dark, 0.75 * vein)
    return Surface(base, 0.05, gloss - 0.12 * vein - 0.1 * noise(n, 2, seed + 3), None, tile)


def paving(light, dark, n=1024, seed=1, tiles=4, tile=4.0, gloss=0.62, worn=0.25):
    """Square slabs in two colours, polished by feet, with narrow joints."""
    u, v = coordinates(n)
    column, row = np.floor(u * tiles).astype(int), np.floor(v * tiles).astype(int)
    piece = row * tiles + column
    fu, fv = (u * tiles) % 1, (v * tiles) % 1
    edge = np.minimum(np.minimum(fu, 1 - fu), np.minimum(fv, 1 - fv))
    slab = smooth(edge, 0.004, 0.016)
    vein = 1 - smooth(np.abs(noise(n, 3.0, seed, low=2) - 0.5) * 2, 0.0, 0.1)
    cloud, grain = noise(n, 2.6, seed + 1), noise(n, 1.4, seed + 2, low=8)
    base = mix(light, dark, ((row + column) % 2).astype(float))
    base = base * (by_piece(piece, seed, 0.86, 1.12) * (0.8 + 0.25 * cloud + 0.1 * grain))[..., None]
    base = mix(base, base * 0.6 + 0.04, 0.5 * vein)
    base = mix(np.asarray(dark) * 0.4, base, slab)
    shine = gloss * (1 - worn * cloud) * (0.9 + 0.1 * by_piece(piece, seed + 3)) - 0.05 * grain
    height = 0.002 * slab + 0.0008 * by_piece(piece, seed + 4) * slab
    return Surface(base, 0.045, np.clip(shine * (0.4 + 0.6 * slab), 0, 1), height, tile)


def wood(color, n=512, seed=1, boards=4, tile=1.0, gloss=0.45):
    """Boards along the image's rows."""
    u, v = coordinates(n)
    row = np.floor(v * boards).astype(int)
    fv = (v * boards) % 1
    edge = np.minimum(fv, 1 - fv) / boards
    bent = noise(n, 3.0, seed, stretch=(1.0, 6.0)) + by_piece(row, seed, 0, 7)
    ring = 0.5 + 0.5 * np.sin(2 * np.pi * (bent * 5 + fv * 2))
    fiber = noise(n, 1.2, seed + 1, low=4, stretch=(0.25, 8.0))
    tone = by_piece(row, seed + 2, 0.8, 1.15) * (0.62 + 0.3 * ring + 0.25 * fiber)
    plank = smooth(edge, 0.001, 0.005)
    base = np.asarray(color) * (tone * (0.3 + 0.7 * plank))[..., None]
    return Surface(base, 0.04, gloss * (0.75 + 0.25 * fiber) * (0.5 + 0.5 * plank),
                   0.002 * plank + 0.0006 * fiber, tile)


def metal(color, n=256, seed=1, tile=1.0, gloss=0.5, brushed=3.0):
    """Bare metal: no diffuse colour, all in the specular map."""
    streak = noise(n, 1.0, seed, low=4, stretch=(0.4, brushed))
    stain = noise(n, 2.6, seed + 1)
    specular = np.asarray(color) * (0.7 + 0.2 * stain + 0.12 * streak)[..., None]
    return Surface(np.asarray(color) * 0.06, specular, gloss + 0.06 * stain - 0.1 * streak,
                   0.0003 * streak, tile)


def cloth(color, thread, n=512, seed=1, tile=1.2):
    """Woven stuff with a damask figure."""
    u, v = coordinates(n)
    x, y = np.abs((u * 2) % 1 - 0.5) * 2, (v * 2 + np.floor(u * 2) * 0.5) % 1
    radius = np.hypot(x, (y - 0.5) * 2)
    angle = np.arctan2((y - 0.5) * 2, x + 1e-6)
    leaf = 0.62 + 0.2 * np.cos(6 * angle)
    figure = smooth(leaf - radius, -0.02, 0.03) * (1 - smooth(0.26 - radius, -0.02, 0.02))
    figure = np.maximum(figure, smooth(0.13 - radius, -0.02, 0.02))
    figure = np.maximum(figure, 1 - smooth(np.abs(radius - 0.9), 0.015, 0.035))
    weave = 0.5 + 0.25 * (np.sin(2 * np.pi * u * 96) + np.sin(2 * np.pi * v * 96))
    stain = noise(n, 2.4, seed)
    base = mix(color, thread, 0.8 * figure) * (0.75 + 0.2 * stain + 0.12 * weave)[..., None]
    return Surface(base, 0.03, 0.15 + 0.2 * figure, 0.0006 * weave + 0.0012 * figure, tile,
                   double_sided=True)


def leaves(color, n=256, seed=1, tile=0.3):
    """Green with veins."""
    u, v = coordinates(n)
    vein = 1 - smooth(np.abs((v * 6 + np.abs(u - 0.5) * 4) % 1 - 0.5), 0.02, 0.1)
    tone = 0.6 + 0.5 * noise(n, 2.2, seed) - 0.15 * vein
    return Surface(np.asarray(color) * tone[..., None], 0.04, 0.35 + 0.15 * vein, 0.001 * vein, tile,
                   double_sided=True)


def soil(n=256, seed=1):
    rough = noise(n, 1.6, seed, low=4)
    return Surface(from_srgb(0.32, 0.24, 0.18) * (0.4 + 0.8 * rough)[..., None], 0.02, 0.05 + 0.05 * rough,
                   0.01 * rough, 0.4)


def lamp(color, strength):
    """What glows evenly."""
    return Surface((0.0, 0.0, 0.0), lamp=[c * strength for c in color])


def glow(color):
    """What looks bright and lights nothing: a flame or a tube beside the point light that stands for it."""
    return Surface(color, unlit=True)


# ---- Stained glass

JEWELS = from_srgb([0.10, 0.18, 0.62], [0.66, 0.08, 0.10], [0.86, 0.62, 0.16], [0.12, 0.45, 0.26],
                   [0.40, 0.14, 0.52], [0.30, 0.55, 0.80], [0.75, 0.32, 0.10])


def glass_window(n=512, seed=1, strength=6.0):
    """A window's whole image: panes in lead, a medallion, a border. It glows as if in evening light."""
    u, v = coordinates(n)
    piece, edge = cells(n, 260, seed, squeeze=0.4)
    rng = np.random.default_rng(seed)
    palette = rng.choice(len(JEWELS), piece.max() + 1, p=[0.36, 0.2, 0.14, 0.1, 0.07, 0.08, 0.05])
    color = JEWELS[palette[piece]] * by_piece(piece, seed + 1, 0.5, 1.3)[..., None]
    lead = smooth(edge, 0.002, 0.005)
    for k, middle in enumerate((0.3, 0.52, 0.74)):
        radius = np.hypot((u - 0.5), (v - middle) * 2.4)
        ring, core = np.abs(radius - 0.25), radius < 0.19
        spoke = np.abs(np.sin(4 * np.arctan2((v - middle) * 2.4, u - 0.5)))
        inside = radius < 0.25
        star = np.where(spoke[..., None] > 0.55 - radius[..., None] * 1.6, JEWELS[2], JEWELS[1 + k % 2 * 2])
        color = np.where(inside[..., None], star, color)
        color = np.where((ring < 0.022)[..., None], JEWELS[5], color)
        lead = np.where(inside, 1.0, lead)
        lead *= smooth(np.abs(ring - 0.024), 0.002, 0.006)
        lead = np.where(core, smooth(spoke, 0.02, 0.08) * smooth(np.abs(radius - 0.1), 0.003, 0.008), lead)
    side = np.minimum(u, 1 - u)
    bead = (v * 40) % 1
    border = side < 0.055
    color = np.where(border[..., None], np.where((bead < 0.5)[..., None], JEWELS[1], JEWELS[2]), color)
    lead = np.where(border, smooth(np.minimum(bead % 0.5, 0.5 - bead % 0.5), 0.02, 0.08), lead)
    lead *= smooth(np.abs(side - 0.055), 0.002, 0.006)
    bars = np.abs((v * 9) % 1 - 0.5)
    lead *= smooth(bars, 0.015, 0.03)
    glow = color * (lead * (0.75 + 0.4 * noise(n, 2.2, seed + 2)))[..., None]
    base = mix(0.02, color * 0.15, lead)
    return Surface(base, 0.04, 0.4 + 0.4 * lead, None, 1.0, np.clip(glow, 0, 1), strength)


def glass_rose(n=512, seed=1, strength=6.0):
    """A rose window: petals round a middle."""
    u, v = coordinates(n)
    x, y = u - 0.5, v - 0.5
    radius, angle = 2 * np.hypot(x, y), np.arctan2(y, x)
    color, lead = np.zeros((n, n, 3)), np.ones((n, n))
    rings = [(0.0, 0.16, 6), (0.16, 0.42, 12), (0.42, 0.7, 24), (0.7, 0.97, 36)]
    rng = np.random.default_rng(seed)
    for k, (low, high, count) in enumerate(rings):
        turn = (angle / (2 * np.pi) * count) % count
        piece = np.floor(turn).astype(int)
        tint = JEWELS[np.array([[2, 1], [0, 1], [0, 5], [1, 0]])[k][piece % 2]]
        inside = (radius >= low) & (radius < high)
        color = np.where(inside[..., None], tint * rng.uniform(0.7, 1.2, count)[piece][..., None], color)
        f = np.abs(turn % 1 - 0.5)
        middle = (low + high) / 2
        eye = np.hypot(f * radius * 2 * np.pi / count, radius - middle) < 0.3 * (high - low) * 0.6
        color = np.where((inside & eye)[..., None], JEWELS[2 + k % 2], color)
        gap = np.minimum(0.5 - f, 1) * radius * 2 * np.pi / count
        lead = np.where(inside, lead * smooth(gap, 0.004, 0.012), lead)
        lead *= smooth(np.abs(radius - low), 0.006, 0.014)
    color[radius >= 0.97] = 0
    glow = color * (lead * (0.75 + 0.4 * noise(n, 2.2, seed)))[..., None]
    return Surface(mix(0.02, color * 0.15, lead), 0.04, 0.4 + 0.4 * lead, None, 1.0, np.clip(glow, 0, 1),
                   strength)


# ---- A ship's


def hull(color, n=512, seed=1, tile=2.0, depth=4, accent=None, wear=0.35):
    """Painted plates with seams, bolts, scratches and worn edges."""
    piece, edge = plates(n, depth, seed)
    u, v = coordinates(n)
    seam = smooth(edge, 0.002, 0.006)
    scratch = noise(n, 1.1, seed + 1, low=3, stretch=(0.3, 5.0))
    dirt, grain = noise(n, 2.4, seed + 2), noise(n, 1.3, seed + 3, low=8)
    tone = by_piece(piece, seed + 4, 0.82, 1.1)
    paint = np.asarray(color) * (tone * (0.8 + 0.25 * dirt))[..., None]
    if accent is not None:
        chosen = by_piece(piece, seed + 5) > 0.84
        paint = np.where(chosen[..., None], np.asarray(accent) * (0.8 + 0.25 * dirt)[..., None], paint)
    bare = smooth(wear * (1 - smooth(edge, 0.004, 0.022)) + 0.55 * scratch * grain, 0.36, 0.46)
    spot = np.hypot((u * 24) % 1 - 0.5, (v * 24) % 1 - 0.5)
    bolt = (1 - smooth(spot, 0.2, 0.26)) * (edge > 0.008) * (edge < 0.03)
    base = mix(paint, 0.03, bare) * (0.35 + 0.65 * seam)[..., None]
    specular = mix(np.full(3, 0.045), np.full(3, 0.5), bare)
    gloss = np.clip(mix(0.45 - 0.2 * dirt, 0.5, bare) * (0.4 + 0.6 * seam), 0, 1)
    height = 0.004 * seam + 0.003 * bolt + 0.001 * by_piece(piece, seed + 6) * seam - 0.0004 * bare
    return Surface(base, specular, gloss, height, tile)


def tread(color, n=512, seed=1, tile=0.8):
    """Steel floor with raised tears, bright where walked on."""
    u, v = coordinates(n)
    k = 8
    fu, fv = (u * k) % 1 - 0.5, (v * k) % 1 - 0.5
    across = ((np.floor(u * k) + np.floor(v * k)) % 2).astype(bool)
    a, b = np.where(across, fu + fv, fu - fv), np.where(across, fu - fv, fu + fv)
    tear = 1 - smooth(np.hypot(a / 0.52, b / 0.17), 0.75, 1.0)
    dirt, grain = noise(n, 2.2, seed), noise(n, 1.2, seed + 1, low=8)
    bright = np.clip(tear * (0.4 + 0.6 * grain) * (1.1 - 0.6 * dirt), 0, 1)
    base = np.asarray(color) * (0.65 + 0.45 * dirt)[..., None] * mix(1.0, 0.35, bright)[..., None]
    specular = mix(np.full(3, 0.08), np.full(3, 0.55), bright)
    return Surface(base, specular, 0.35 + 0.15 * bright - 0.12 * dirt, 0.003 * tear, tile)


def hazard(n=256, seed=1, tile=0.8):
    """Yellow and black, scuffed."""
    u, v = coordinates(n)
    stripe = smooth(np.abs((u + v) * 2 % 1 - 0.5), 0.24, 0.26)
    worn = smooth(noise(n, 1.8, seed), 0.62, 0.78)
    base = mix(from_srgb(0.85, 0.62, 0.08), from_srgb(0.08, 0.08, 0.09), stripe)
    base = mix(base, 0.1, worn) * (0.75 + 0.3 * noise(n, 2.4, seed + 1))[..., None]
    return Surface(base, 0.05 + 0.3 * worn, 0.35 + 0.2 * worn, None, tile)


def screen(n=256, seed=1, strength=8.0):
    """A console's display: a frame, lines of text, a graph, a round scan."""
    rng = np.random.default_rng(seed)
    u, v = coordinates(n)
    ink = np.zeros((n, n))
    side = np.minimum(np.minimum(u, 1 - u), np.minimum(v, 1 - v))
    ink = np.maximum(ink, (np.abs(side - 0.035) < 0.006) * 0.8)
    for row in range(14):  # text
        top = 0.1 + row * 0.028
        x = 0.08
        while x < 0.42:
            width = rng.uniform(0.015, 0.07)
            ink = np.maximum(ink, ((v > top) & (v < top + 0.014) & (u > x) & (u < min(x + width, 0.45))) * 0.7)
            x += width + 0.014
    r = np.hypot(u - 0.72, v - 0.3)  # scan
    for ring in (0.07, 0.14, 0.21):
        ink = np.maximum(ink, (np.abs(r - ring) < 0.004) * 0.8)
    sweep_angle = (np.arctan2(v - 0.3, u - 0.72) / (2 * np.pi) + seed * 0.37) % 1
    ink = np.maximum(ink, (r < 0.21) * sweep_angle ** 4 * 0.8)
    line = 0.78 + 0.1 * (noise(n, 2.0, seed)[0][None, :] - 0.5)  # graph
    ink = np.maximum(ink, ((np.abs(v - line) < 0.006) & (side > 0.06)) * 1.0)
    ink = np.maximum(ink, ((v > line) & (v < 0.92) & (side > 0.06)) * 0.25)
    grid = ((u * 16) % 1 < 0.05) | ((v * 16) % 1 < 0.05)
    ink = np.maximum(ink, (grid & (v > 0.6) & (side > 0.06)) * 0.15)
    tint = from_srgb(*[(0.35, 0.85, 1.0), (1.0, 0.65, 0.2), (0.45, 1.0, 0.55)][seed % 3])
    glow = ink[..., None] * tint + tint * 0.02 * (side > 0.035)[..., None]
    return Surface(np.full(3, 0.01), 0.04, 0.75, None, 1.0, glow, strength)


SEGMENTS = ["abcdef", "bc", "abged", "abgcd", "fgbc", "afgcd", "afgedc", "abc", "abcdefg", "abcfgd"]


def sign(number, color, n=256):
    """A painted number on a plate: two digits of seven strokes and a bar."""
    u, v = coordinates(n)
    ink = np.zeros((n, n), bool)

    def stroke(x0, y0, x1, y1):
        nonlocal ink
        ink |= (u > x0) & (u < x1) & (v > y0) & (v < y1)

    for k, digit in enumerate("%02d" % number):
        x, y, w, h, t = 0.16 + 0.36 * k, 0.14, 0.28, 0.56, 0.07
        for segment in SEGMENTS[int(digit)]:
            stroke(*{"a": (x, y, x + w, y + t), "g": (x, y + h / 2 - t / 2, x + w, y + h / 2 + t / 2),
                     "d": (x, y + h - t, x + w, y + h), "f": (x, y, x + t, y + h / 2),
                     "e": (x, y + h / 2, x + t, y + h), "b": (x + w - t, y, x + w, y + h / 2),
                     "c": (x + w - t, y + h / 2, x + w, y + h)}[segment])
    stroke(0.16, 0.78, 0.8, 0.84)
    worn = smooth(noise(n, 1.7, number), 0.6, 0.75)
    base = mix(np.full(3, 0.06), color, ink.astype(float) * (1 - 0.7 * worn))
    return Surface(base, 0.05 + 0.2 * worn, 0.4 + 0.15 * worn, None, 1.0)
