#!/usr/bin/env python3
"""Draw the meshes of a USD stage to a PNG, in software with numpy and Pillow.

    draw.py IN.usd -o out.png [--prim PATH ...] [--view front|back|left|right|top|iso|AZ,EL]
            [--focus x,y,z,radius] [--wire] [--edges] [--flat] [--pattern [UV SET]]
            [--color none|displayColor|subset[:FAMILY]|uv|primvar:NAME] [--size WxH]

The wireframe shows the edges of the authored faces, so a quad has no diagonal.  Each pixel is
shaded by its distance to the edges of the triangle visible there.  Hidden lines therefore need
no second depth test.

As a library, which draws all pictures of this project but screenshots: `load(path, prim_paths)` returns `Mesh` objects,
`Camera.fit(...)` a camera, `render(meshes, camera, ...)` a PIL image, and `sheet(rows)` many of them with words.
"""
import argparse
import colorsys
from dataclasses import dataclass

import numpy as np
from meshes import Mesh, load
from PIL import Image, ImageDraw

VIEWS = {"front": (0, 0), "back": (180, 0), "left": (90, 0), "right": (-90, 0),
         "top": (0, 89.9), "iso": (30, 15)}
BACKGROUND = np.array([0.965, 0.965, 0.955])
CLOTH = np.array([0.70, 0.74, 0.80])
BORDER = np.array([0.80, 0.10, 0.10])
INK, GREY = (25, 28, 38), (105, 110, 122)       # words
# Colour scale of scalar primvars from low to high (dark blue, teal, green, yellow).
RAMP = np.array([[0.16, 0.11, 0.40], [0.13, 0.42, 0.56], [0.20, 0.68, 0.48], [0.98, 0.90, 0.22]])


# ------------------------------------------------------------------------------- camera

@dataclass
class Camera:
    """An orthographic camera: azimuth from +Z towards +X, elevation, centre, half height, and size of its pictures."""
    azimuth: float
    elevation: float
    centre: np.ndarray
    radius: float
    size: tuple

    def axes(self):
        """Rows: right, up, towards the viewer."""
        a, e = np.radians([self.azimuth, self.elevation])
        back = np.array([np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)])
        right = np.array([np.cos(a), 0.0, -np.sin(a)])
        return np.stack([right, np.cross(back, right), back])

    @staticmethod
    def fit(meshes, view="front", size=(1200, 1200), focus=None, margin=1.05):
        """A camera that shows all meshes, or the ball `focus` of x, y, z and radius."""
        azimuth, elevation = VIEWS[view] if view in VIEWS else map(float, view.split(","))
        camera = Camera(azimuth, elevation, np.zeros(3), 1.0, size)
        if focus is not None:
            camera.centre, camera.radius = np.array(focus[:3], float), float(focus[3])
            return camera
        q = np.concatenate([m.points for m in meshes]) @ camera.axes().T
        low, high = q.min(0), q.max(0)
        camera.centre = (low + high) / 2 @ camera.axes()
        half = (high - low) / 2 * margin
        camera.radius = max(half[1], half[0] * size[1] / size[0])
        return camera

    def pixels(self, points, samples):
        """Places of points in a picture with `samples` pixels for one, x to the right, y down, z towards the viewer."""
        width, height = np.array(self.size) * samples
        out = (points - self.centre) @ self.axes().T * (height / 2 / self.radius)
        out[..., 0] += width / 2
        out[..., 1] = height / 2 - out[..., 1]
        return out


@dataclass
class Style:
    """Drawing options; see the command-line options of the same names."""
    color: str = "none"
    wire: bool = False
    edges: bool = False
    flat: bool = False
    line: float = 1.1           # width of the wires, in pixels of the result
    wire_strength: float = 0.62
    samples: int = 2
    checker: float = 0.05       # size of a checker, in UV units
    key: tuple = (-0.45, 0.65, 0.75)    # direction towards the key light: right, up, towards the viewer
    key_strength: float = 0.62
    ambient: float = 0.34


# ------------------------------------------------------------------------------- rasteriser

def rasterise(screen, width, height, budget=3_000_000):
    """The visible triangle at each pixel (-1: none) and its depth, from (T, 3, 3) screen triangles.

    Triangles with bounding boxes of similar size form groups.  All pixels of a group's boxes are
    tested at once, and its fragments are written from far to near."""
    ids = np.full(height * width, -1, np.int32)
    depth = np.full(height * width, -np.inf)
    low = np.floor(screen[:, :, :2].min(1) - 0.5).astype(np.int64) + 0
    high = np.ceil(screen[:, :, :2].max(1) - 0.5).astype(np.int64)
    low = np.clip(low, 0, [width, height])
    high = np.clip(high + 1, 0, [width, height])
    extent = high - low
    a, b, c = screen[:, 0], screen[:, 1], screen[:, 2]
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    usable = (extent.min(1) > 0) & (np.abs(area) > 1e-9)
    bucket = np.ceil(np.log2(np.maximum(extent, 1)) * 2).astype(int)
    keys = bucket[:, 0] * 64 + bucket[:, 1]
    for key in np.unique(keys[usable]):
        members = np.nonzero(usable & (keys == key))[0]
        w, h = extent[members].max(0)
        step = max(1, budget // int(w * h))
        oy, ox = np.divmod(np.arange(w * h), w)
        for s in range(0, len(members), step):
            t = members[s:s + step]
            px = low[t, 0][:, None] + ox
            py = low[t, 1][:, None] + oy
            x, y = px + 0.5, py + 0.5
            bary = _barycentric(a[t], b[t], c[t], area[t], x, y)
            inside = (bary[0] >= 0) & (bary[1] >= 0) & (bary[2] >= 0) & (px < width) & (py < height)
            r, k = np.nonzero(inside)
            tri = t[r]
            z = (bary[0][r, k] * a[tri, 2] + bary[1][r, k] * b[tri, 2]
                 + bary[2][r, k] * c[tri, 2])
            pixel = py[r, k] * width + px[r, k]
            near = z > depth[pixel]
            pixel, z, tri = pixel[near], z[near], tri[near]
            order = np.argsort(z, kind="stable")
            depth[pixel[order]] = z[order]
            ids[pixel[order]] = tri[order]
    return ids.reshape(height, width), depth.reshape(height, width)


def _barycentric(a, b, c, area, x, y):
    def side(p, q):
        return ((q[:, 0] - p[:, 0])[:, None] * (y - p[:, 1][:, None])
                - (q[:, 1] - p[:, 1])[:, None] * (x - p[:, 0][:, None])) / area[:, None]
    u, v = side(b, c), side(c, a)
    return u, v, 1 - u - v


# ------------------------------------------------------------------------------- shading

def palette(n):
    """n distinct, soft colours."""
    out = []
    for i in range(max(n, 1)):
        h = (0.58 + i * 0.381966) % 1
        out.append(colorsys.hls_to_rgb(h, (0.62, 0.74, 0.54)[i % 3], (0.52, 0.60, 0.45)[i % 3]))
    return np.array(out)


def ramp(values):
    """Colours of scalars scaled to their own range."""
    low, high = np.nanmin(values), np.nanmax(values)
    t = (values - low) / (high - low if high > low else 1) * (len(RAMP) - 1)
    i = np.clip(t.astype(int), 0, len(RAMP) - 2)
    return RAMP[i] + (RAMP[i + 1] - RAMP[i]) * (t - i)[..., None]


def corner_colours(mesh, color):
    """(T, 3, 3) colours of the triangle corners."""
    out = np.broadcast_to(CLOTH, mesh.tris.shape + (3,)).copy()
    if color.startswith("subset"):
        family = color.partition(":")[2] or "panels"
        sets = mesh.subsets("face", family)
        per_face = np.broadcast_to(CLOTH, (len(mesh.counts), 3)).copy()
        for (_, faces), rgb in zip(sets, palette(len(sets))):
            per_face[faces] = rgb
        out = np.repeat(per_face[mesh.faces][:, None], 3, 1)
    elif color == "displayColor" or color.startswith("primvar:"):
        values = mesh.primvar_at_corners(color.partition(":")[2] or "displayColor")
        if values is None:
            return out
        if values.dtype.kind in "US":
            _, code = np.unique(values, return_inverse=True)
            return palette(code.max() + 1)[code.reshape(mesh.tris.shape)]
        values = values.astype(float)
        if values.ndim == 3 and values.shape[2] == 3:
            return values.copy()
        out = ramp(values[..., 0] if values.ndim == 3 else values)
    return out


def edge_colours(mesh, style):
    """Colour (T, 3, 3) and line width in pixels (0: no line) of each triangle edge."""
    rgb = np.zeros(mesh.tris.shape + (3,)) + np.array([0.07, 0.08, 0.12])
    width = np.where(mesh.real & style.wire, style.line, 0.0)
    if style.edges:
        count = len(mesh.points)
        ends = np.stack([np.roll(mesh.tris, -1, 1), np.roll(mesh.tris, -2, 1)], 2)
        keys = ends.min(2) * count + ends.max(2)
        coloured = [(mesh.border(), BORDER)]
        sets = mesh.subsets("edge")
        coloured += [(i.reshape(-1, 2), c * 0.85) for (_, i), c in zip(sets, palette(len(sets)))]
        for pairs, colour in coloured:
            wanted = pairs.min(1) * count + pairs.max(1)
            hit = np.isin(keys, wanted) & mesh.real
            rgb[hit] = colour
            width[hit] = style.line * 3.2
    return rgb, width


def render(meshes, camera, marks=(), **style):
    """A PIL image of a mesh or several, with the fields of `Style`.

    Marks lie over it: arrays of points (N, 3) or lines (N, 2, 3), a colour, and a width in pixels."""
    style = Style(**style)
    if isinstance(meshes, Mesh):
        meshes = [meshes]
    ss = style.samples
    width, height = camera.size[0] * ss, camera.size[1] * ss
    axes = camera.axes()

    screen = np.concatenate([camera.pixels(m.points[m.tris], ss) for m in meshes])
    normals = np.concatenate([m.corner_normals(style.flat) for m in meshes])
    colours = np.concatenate([corner_colours(m, style.color) for m in meshes])
    uv = None
    if style.color == "uv":
        uv = np.concatenate([_uv_or_zero(m) for m in meshes])
    ids, depth = rasterise(screen, width, height)

    image = np.empty((height, width, 3))
    image[:] = BACKGROUND
    py, px = np.nonzero(ids >= 0)
    t = ids[py, px]
    a, b, c = screen[t, 0], screen[t, 1], screen[t, 2]
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    u, v, w = _barycentric(a, b, c, area, px[:, None] + 0.5, py[:, None] + 0.5)
    bary = np.concatenate([u, v, w], 1)
    normal = np.einsum("nk,nkd->nd", bary, normals[t])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    colour = np.einsum("nk,nkd->nd", bary, colours[t])
    # Screen y points down, so triangles that face the viewer have negative area.
    behind = area > 0
    normal[behind] *= -1
    if uv is not None:
        colour = _checker(np.einsum("nk,nkd->nd", bary, uv[t]), style.checker)
    colour[behind] = colour[behind] * 0.55 + np.array([0.62, 0.50, 0.40]) * 0.38
    image[py, px] = colour * _light(normal @ axes.T, style)[:, None]
    image *= _occlusion(depth, ids, height / 2 / camera.radius)[..., None]

    if style.wire or style.edges:
        parts = [edge_colours(m, style) for m in meshes]
        rgb, line = (np.concatenate([p[i] for p in parts]) for i in (0, 1))
        _draw_lines(image, (py, px), bary, area, (a, b, c), rgb[t], line[t] * ss / 2, style)

    image = Image.fromarray((np.clip(image, 0, 1) * 255 + 0.5).astype(np.uint8))
    pen = ImageDraw.Draw(image)
    for points, colour, size in marks:
        for at in camera.pixels(points, ss)[..., :2]:
            if at.ndim == 1:
                pen.circle(tuple(at), size * ss / 2, fill=colour)
            else:
                pen.line([tuple(p) for p in at], fill=colour, width=round(size * ss))
    return image.resize(camera.size, Image.BOX)


def _uv_or_zero(mesh):
    values = mesh.primvar_at_corners("st")
    return np.zeros(mesh.tris.shape + (2,)) if values is None else values


def _checker(uv, side):
    cell = np.floor(uv / side).astype(int)
    odd = (cell.sum(1) % 2).astype(bool)
    out = np.where(odd[:, None], [0.92, 0.90, 0.86], [0.36, 0.48, 0.66])
    # Every fifth row has another tint, which shows grain and scale.
    out[(cell[:, 1] % 5 == 0) & ~odd] = [0.72, 0.38, 0.30]
    return out.astype(float)


def _light(n, style):
    """Brightness of normals in camera axes: key light, fill from the right, ambient."""
    key = np.clip(n @ _unit(*style.key), 0, 1)
    fill = np.clip(n @ _unit(0.9, 0.1, 0.5), 0, 1)
    return style.ambient + style.key_strength * key + 0.16 * fill + 0.06 * n[:, 1]


def _unit(*v):
    return np.array(v) / np.linalg.norm(v)


def _occlusion(depth, ids, scale):
    """Darkens pixels behind their screen neighbourhood, such as the cloth under a flap."""
    seen = ids >= 0
    z = np.where(seen, depth, depth[seen].min() if seen.any() else 0) / scale
    span = np.ptp(z) or 1.0
    small = Image.fromarray(((z - z.min()) / span * 255).astype(np.float32), mode="F")
    small = small.resize((max(small.width // 4, 1), max(small.height // 4, 1)), Image.BOX)
    weight = Image.fromarray(seen.astype(np.float32), mode="F").resize(small.size, Image.BOX)
    out = np.zeros(depth.shape)
    for radius, strength in ((3, 0.10), (12, 0.05)):
        num = _blur(np.array(small) * np.array(weight), radius)
        den = np.maximum(_blur(np.array(weight), radius), 1e-3)
        mean = Image.fromarray((num / den).astype(np.float32), mode="F")
        mean = np.array(mean.resize((depth.shape[1], depth.shape[0]), Image.BILINEAR)) / 255 * span
        out += np.clip(mean + z.min() - z, 0, 6) * strength
    return np.where(seen, np.clip(1 - out, 0.45, 1), 1)


def _blur(array, radius):
    """Blurs a float image, which Pillow cannot, by two box filters along each axis."""
    r = int(radius)
    for axis in (0, 1):
        for _ in range(2):
            pad = [(0, 0), (0, 0)]
            pad[axis] = (r + 1, r)
            c = np.cumsum(np.pad(array, pad, mode="edge"), axis=axis)
            n = array.shape[axis]
            array = (np.take(c, np.arange(2 * r + 1, 2 * r + 1 + n), axis)
                     - np.take(c, np.arange(0, n), axis)) / (2 * r + 1)
    return array


def _draw_lines(image, where, bary, area, abc, rgb, half, style):
    py, px = where
    a, b, c = (p[:, :2] for p in abc)
    lengths = [np.linalg.norm(q - p, axis=1) for p, q in ((b, c), (c, a), (a, b))]
    shade = np.zeros(len(px))
    tint = np.zeros((len(px), 3))
    for k in range(3):
        distance = bary[:, k] * np.abs(area) / np.maximum(lengths[k], 1e-9)
        cover = np.clip(half[:, k] + 0.5 - distance, 0, 1) * (half[:, k] > 0)
        marked = half[:, k] > style.line * style.samples
        cover = np.where(marked, cover, cover * style.wire_strength)
        better = cover > shade
        shade[better] = cover[better]
        tint[better] = rgb[better, k]
    image[py, px] = image[py, px] * (1 - shade[:, None]) + tint * shade[:, None]


# ------------------------------------------------------------------------------- sheets

def sheet(rows, font=17, gap=6):
    """Rows of images of one size, each with words below it; further lines of the words are small and grey."""
    lines = 1 + max(words.count("\n") for row in rows for _, words in row)
    label = round(font * (0.6 + lines))
    width = max(sum(image.width + gap for image, _ in row) for row in rows)
    height = sum(row[0][0].height + gap + label for row in rows)
    page = Image.new("RGB", (width, height), tuple(int(c * 255 + 0.5) for c in BACKGROUND))
    pen, y = ImageDraw.Draw(page), 0
    for row in rows:
        for k, (image, words) in enumerate(row):
            x = width * k // len(row)
            page.paste(image, (x + gap // 2, y + gap // 2))
            for i, line in enumerate(words.split("\n")):
                at = (x + gap // 2 + image.width // 2, y + image.height + gap + font * (0.8 + i))
                pen.text(at, line, fill=GREY if i else INK, anchor="mm", font_size=font * 0.67 if i else font)
        y += row[0][0].height + gap + label
    return page


# ------------------------------------------------------------------------------- command line

def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("stage")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--prim", action="append", help="draw only this prim and its descendants")
    parser.add_argument("--view", default="front")
    parser.add_argument("--focus", help="x,y,z,radius")
    parser.add_argument("--wire", action="store_true")
    parser.add_argument("--edges", action="store_true", help="highlight borders and edge subsets")
    parser.add_argument("--flat", action="store_true", help="one normal per face")
    parser.add_argument("--color", default="none")
    parser.add_argument("--checker", type=float, default=0.05, help="size of a checker in UV units")
    parser.add_argument("--size", default="1200x1200")
    parser.add_argument("--pattern", nargs="?", const="st", help="draw the layout of a UV set instead [st]")
    args = parser.parse_args()
    meshes = load(args.stage, args.prim)
    if not meshes:
        raise SystemExit("no meshes to draw")
    if args.pattern:
        meshes = [mesh.unfolded(args.pattern) for mesh in meshes]
    focus = [float(n) for n in args.focus.split(",")] if args.focus else None
    camera = Camera.fit(meshes, args.view, tuple(int(n) for n in args.size.split("x")), focus)
    style = {name: getattr(args, name) for name in ("color", "wire", "edges", "flat", "checker")}
    render(meshes, camera, **style).save(args.output)


if __name__ == "__main__":
    main()
