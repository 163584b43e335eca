"""The form a garment hangs on: a mannequin as an implicit surface, in centimetres, Y up, facing +Z.

A form is a torso (cross sections by height) joined smoothly with limbs (chains of tapered
capsules).  Its value is about the distance to the surface, negative inside, so that points can
be put on the surface, or at an offset from it, by a few Newton steps."""
import numpy as np

# Joints of a person of 178 cm; left is +X.
JOINTS = {
    "hips": (0, 95, 0), "spine": (0, 108, -1), "chest": (0, 124, -1), "neck": (0, 148, -2),
    "head": (0, 160, 0),
    "shoulder": (17.5, 140.5, -1.5), "elbow": (34.2, 116.6, -2.0), "wrist": (46.0, 94.5, 3.0),
    "hand": (51.0, 85.0, 6.0),
    "hip": (9, 90, 0), "knee": (11, 49, 0.5), "ankle": (13, 9, -2), "toe": (15, 3, 12),
}


def joint(name, side=1):
    """The position of a joint, on the left (1) or right (-1)."""
    x, y, z = JOINTS[name]
    return np.array([x * side, y, z], float)


def smooth_table(x, xs, ys):
    """Monotone cubic interpolation of a table, constant beyond its ends."""
    xs, ys = np.asarray(xs, float), np.asarray(ys, float)
    x = np.clip(x, xs[0], xs[-1])
    h = np.diff(xs)
    slope = np.diff(ys) / h
    m = np.zeros(len(xs))
    same = slope[:-1] * slope[1:] > 0
    m[1:-1][same] = 2 * slope[:-1][same] * slope[1:][same] / (slope[:-1] + slope[1:])[same]
    m[0], m[-1] = slope[0], slope[-1]
    i = np.clip(np.searchsorted(xs, x, side="right") - 1, 0, len(xs) - 2)
    t = (x - xs[i]) / h[i]
    return ((1 + 2 * t) * (1 - t) ** 2 * ys[i] + t * (1 - t) ** 2 * h[i] * m[i]
            + t * t * (3 - 2 * t) * ys[i + 1] + t * t * (t - 1) * h[i] * m[i + 1])


def smooth_min(a, b, k):
    h = np.clip(0.5 + 0.5 * (b - a) / k, 0, 1)
    return b + (a - b) * h - k * h * (1 - h)


class Form:
    """torso: rows (y, half width, front depth, back depth, centre z), lowest first;
    limbs: for each, a list of (point, radius); drape: distance added at points, or None."""

    def __init__(self, torso, limbs=(), power=2.3, blend=3.0, drape=None):
        self.torso = np.array(torso, float).T
        self.limbs = [[(np.array(p, float), float(r)) for p, r in limb] for limb in limbs]
        self.power, self.blend, self.drape = power, blend, drape

    def value(self, p):
        y = p[:, 1]
        w, front, back, cz = (smooth_table(y, self.torso[0], row) for row in self.torso[1:])
        z = p[:, 2] - cz
        d = np.where(z > 0, front, back)
        g = (np.abs(p[:, 0] / w) ** self.power + np.abs(z / d) ** self.power) ** (1 / self.power)
        f = (g - 1) * np.sqrt(w * d)
        for limb in self.limbs:
            f = smooth_min(f, self._limb(p, limb), self.blend)
        return f if self.drape is None else f - self.drape(p)

    @staticmethod
    def _limb(p, limb):
        out = None
        for (a, ra), (b, rb) in zip(limb, limb[1:]):
            ab = b - a
            t = np.clip((p - a) @ ab / (ab @ ab), 0, 1)
            d = np.linalg.norm(p - a - t[:, None] * ab, axis=1) - (ra + (rb - ra) * t)
            out = d if out is None else smooth_min(out, d, 2.0)
        return out

    def gradient(self, p, h=0.05):
        g = np.empty_like(p)
        for k in range(3):
            e = np.zeros(3)
            e[k] = h
            g[:, k] = (self.value(p + e) - self.value(p - e)) / (2 * h)
        return g

    def normal(self, p):
        g = self.gradient(np.atleast_2d(np.asarray(p, float)))
        return g / np.maximum(np.linalg.norm(g, axis=1, keepdims=True), 1e-9)

    def project(self, p, offset=0.0, steps=12):
        """Points moved along the gradient onto the surface, then out by an offset."""
        p = np.array(p, float).reshape(-1, 3)
        for _ in range(steps):
            g = self.gradient(p)
            step = self.value(p)[:, None] * g / np.maximum((g * g).sum(1, keepdims=True), 0.05)
            size = np.linalg.norm(step, axis=1, keepdims=True)
            p = p - step * np.minimum(1, 2.0 / np.maximum(size, 1e-9))
        return p + self.normal(p) * np.reshape(offset, (-1, 1)) if np.any(offset) else p

    def front_point(self, x, y, offset=0.0, back=False):
        """The point of the surface in front of (or behind) x, y, found along z."""
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        shape = x.shape
        x, y = x.ravel(), y.ravel()
        inside, outside = np.full(x.shape, -1.5), np.full(x.shape, -40.0 if back else 40.0)
        for _ in range(40):
            mid = (inside + outside) / 2
            f = self.value(np.stack([x, y, mid], 1))
            inside, outside = np.where(f < 0, mid, inside), np.where(f < 0, outside, mid)
        p = np.stack([x, y, inside], 1)
        return (p + self.normal(p) * np.reshape(offset, (-1, 1))).reshape(shape + (3,))
