"""A level in the making, and its file: glTF 2.0 binary with everything in it."""

import json
import struct

import numpy as np

from . import texture

REPEAT, CLAMP = 10497, 33071


class Part:
    """Meshes by material, placed as one."""

    def __init__(self, name):
        self.name = name
        self.pieces = {}  # material name: meshes

    def add(self, material, *meshes):
        self.pieces.setdefault(material, []).extend(meshes)
        return self

    def __len__(self):
        return sum(len(mesh) for meshes in self.pieces.values() for mesh in meshes)


class Level:
    """Parts placed in space, with lights and cameras. Materials are named by surface.py."""

    def __init__(self, name, materials):
        self.name = name
        self.materials = materials  # name: surface
        self.placed = []            # (part, matrix)
        self.light_kinds = []
        self.lights = []            # (kind, matrix)
        self.cameras = []           # (name, matrix, yfov, aspect)

    def place(self, part, *steps):
        matrix = np.eye(4)
        for step in steps:
            matrix = step @ matrix
        self.placed.append((part, matrix))

    def triangle_count(self):
        return sum(len(part) for part, _ in self.placed)

    def light_count(self, kind):
        return sum(self.light_kinds[i]["type"] == kind for i, _ in self.lights)

    def light(self, kind, color, intensity, matrix, reach=None):
        """A "point" (candela, at the matrix's origin) or "directional" light (lux, along its -Z);
        reach in metres is where it ends."""
        row = {"type": kind, "color": [round(c, 4) for c in color], "intensity": round(intensity, 4)}
        if reach is not None:
            row["range"] = round(reach, 3)
        if row not in self.light_kinds:
            self.light_kinds.append(row)
        self.lights.append((self.light_kinds.index(row), matrix))

    def camera(self, name, eye, target, yfov_degrees, aspect=1.0):
        self.cameras.append((name, looking(eye, target), np.radians(yfov_degrees), aspect))

    def write(self, path):
        with open(path, "wb") as file:
            file.write(_Writer().glb(self))


def looking(eye, target):
    """The place of what looks along its -Z from one point to another."""
    eye, target = np.asarray(eye, float), np.asarray(target, float)
    back = (eye - target) / np.linalg.norm(eye - target)
    helper = (0, 1, 0) if abs(back[1]) < 0.999 else (0, 0, -1)
    right = np.cross(helper, back)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = right, np.cross(back, right), back, eye
    return matrix


class _Writer:
    def __init__(self):
        self.data = bytearray()
        self.views, self.accessors, self.images, self.textures = [], [], [], []
        self.image_of = {}

    def view(self, packed):
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(packed)})
        self.data += packed + bytes(-len(packed) % 4)
        return len(self.views) - 1

    def accessor(self, array, kind, component):
        row = {"bufferView": self.view(array.tobytes()), "componentType": component,
               "count": len(array), "type": kind}
        if kind == "VEC3":
            row["min"], row["max"] = array.min(axis=0).tolist(), array.max(axis=0).tolist()
        self.accessors.append(row)
        return len(self.accessors) - 1

    def texture(self, pixels):
        """The index of a texture that shows an image [rows, columns, channels] of bytes."""
        packed = texture.png(pixels)
        if packed not in self.image_of:
            self.image_of[packed] = len(self.images)
            self.images.append({"bufferView": self.view(packed), "mimeType": "image/png"})
            self.textures.append({"source": len(self.images) - 1, "sampler": 0})
        return {"index": self.image_of[packed]}

    def material(self, name, surface):
        gloss = {"diffuseFactor": [1, 1, 1, 1], "specularFactor": [1, 1, 1], "glossinessFactor": 1}
        rough = {"metallicFactor": 0, "roughnessFactor": round(1 - float(np.mean(surface.gloss)), 4)}
        row = {"name": name, "pbrMetallicRoughness": rough,
               "extensions": {"KHR_materials_pbrSpecularGlossiness": gloss}}
        if surface.color.ndim == 3:
            gloss["diffuseTexture"] = rough["baseColorTexture"] = self.texture(
                texture.to_bytes(texture.to_srgb(surface.color)))
        else:
            gloss["diffuseFactor"] = rough["baseColorFactor"] = [*surface.color.round(4).tolist(), 1]
        if surface.gloss.ndim == 2:
            both = np.dstack([texture.to_srgb(surface.specular), surface.gloss])
            gloss["specularGlossinessTexture"] = self.texture(texture.to_bytes(both))
        else:
            gloss["specularFactor"] = surface.specular.round(4).tolist()
            gloss["glossinessFactor"] = round(float(surface.gloss), 4)
        if surface.height is not None:
            row["normalTexture"] = self.texture(texture.normals(surface.height, surface.tile))
        if surface.emission is not None:
            row["emissiveFactor"] = [1, 1, 1]
            row["emissiveTexture"] = self.texture(texture.to_bytes(texture.to_srgb(surface.emission)))
            row["extensions"]["KHR_materials_emissive_strength"] = {
                "emissiveStrength": surface.emission_strength}
        if surface.lamp is not None:
            strength = max(surface.lamp)
            row["emissiveFactor"] = [round(c / strength, 5) for c in surface.lamp]
            row["extensions"]["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
        if surface.unlit:
            row["extensions"] = {"KHR_materials_unlit": {}}
        if surface.double_sided:
            row["doubleSided"] = True
        return row

    def primitive(self, meshes, material, tile):
        start, rows = 0, {"POSITION": [], "NORMAL": [], "TEXCOORD_0": [], "faces": []}
        for mesh in meshes:
            rows["POSITION"].append(mesh.points)
            rows["NORMAL"].append(mesh.normals)
            rows["TEXCOORD_0"].append(mesh.uvs / tile)
            rows["faces"].append(mesh.faces + start)
            start += len(mesh.points)
        packed = {key: np.concatenate(value) for key, value in rows.items()}
        faces = packed.pop("faces").reshape(-1)
        short = start <= 65535
        return {
            "attributes": {key: self.accessor(value.astype("<f4"), "VEC%d" % value.shape[1], 5126)
                           for key, value in packed.items()},
            "indices": self.accessor(faces.astype("<u2" if short else "<u4"), "SCALAR",
                                     5123 if short else 5125),
            "material": material,
        }

    def glb(self, level):
        used = [name for name in level.materials
                if any(name in part.pieces for part, _ in level.placed)]
        materials = [self.material(name, level.materials[name]) for name in used]
        parts = list(dict.fromkeys(part for part, _ in level.placed))
        meshes = [{"name": part.name, "primitives": [
            self.primitive(part.pieces[name], i, level.materials[name].tile)
            for i, name in enumerate(used) if name in part.pieces]} for part in parts]

        nodes = []
        for part, matrix in level.placed:
            row = {"name": part.name, "mesh": parts.index(part)}
            if not np.allclose(matrix, np.eye(4)):
                row["matrix"] = matrix.T.reshape(-1).round(6).tolist()
            nodes.append(row)
        for kind, matrix in level.lights:
            row = {"extensions": {"KHR_lights_punctual": {"light": kind}}}
            if level.light_kinds[kind]["type"] == "point":
                row["translation"] = matrix[:3, 3].round(3).tolist()
            else:
                row["matrix"] = matrix.T.reshape(-1).round(6).tolist()
            nodes.append(row)
        for i, (name, matrix, _, _) in enumerate(level.cameras):
            nodes.append({"name": name, "camera": i, "matrix": matrix.T.reshape(-1).round(6).tolist()})

        extensions = sorted({name for row in materials for name in row["extensions"]}
                            | ({"KHR_lights_punctual"} if level.lights else set()))
        document = {
            "asset": {"version": "2.0", "generator": "lightkiln scripts/make_scenes"},
            "extensionsUsed": extensions,
            "scene": 0,
            "scenes": [{"name": level.name, "nodes": list(range(len(nodes)))}],
            "nodes": nodes,
            "cameras": [{"name": name, "type": "perspective", "perspective": {
                "yfov": round(float(yfov), 6), "aspectRatio": aspect, "znear": 0.01}}
                for name, _, yfov, aspect in level.cameras],
            "materials": materials,
            "meshes": meshes,
            "accessors": self.accessors,
            "bufferViews": self.views,
        }
        if self.images:
            document["images"], document["textures"] = self.images, self.textures
            document["samplers"] = [{"wrapS": REPEAT, "wrapT": REPEAT}]
        if level.lights:
            document["extensions"] = {"KHR_lights_punctual": {"lights": level.light_kinds}}
        document["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps(document, separators=(",", ":")).encode("ascii")
        text += b" " * (-len(text) % 4)
        total = 12 + 8 + len(text) + 8 + len(self.data)
        return b"".join([struct.pack("<4sIIII", b"glTF", 2, total, len(text), 0x4E4F534A), text,
                         struct.pack("<II", len(self.data), 0x004E4942), bytes(self.data)])
