"""Trousers: waistband with belt loops, fly, back pockets, front and back creases of the legs.

A tube of rows runs from the waist to the crotch; there the seam between the legs divides it in
two tubes, one for each leg."""
import numpy as np

from .form import Form, joint
from .mesh import Garment, between

HALF = 14           # columns of one side, from the centre front to the centre back
CROTCH = 4          # columns of a leg along the seam between the legs
HIPS, LEG = 7, 14   # rows
WAIST, FORK, HEM = 101.0, 80.0, 6.5     # heights


def drape(p):
    """Folds where the cloth breaks over the foot and behind the knee."""
    x = np.where(p[:, 0] > 0, p[:, 0] - 12, p[:, 0] + 12)
    angle = np.arctan2(x, p[:, 2])
    ankle = np.exp(-((p[:, 1] - 15) / 8) ** 2)
    knee = np.exp(-((p[:, 1] - 48) / 9) ** 2) * np.clip(-np.cos(angle), 0, 1)
    return (ankle * 0.55 * np.sin(0.75 * p[:, 1] + 1.2 * np.cos(angle))
            + knee * 0.5 * np.sin(0.6 * p[:, 1]))


def form():
    torso = [(74, 17.0, 10.0, 11.0, -0.5), (80, 18.4, 11.0, 12.4, -0.6),
             (87, 18.9, 11.5, 13.2, -0.6), (93, 18.1, 11.3, 12.0, -0.4),
             (98, 16.7, 10.9, 10.6, -0.2), (102, 15.9, 10.6, 10.0, 0.0),
             (108, 15.6, 10.4, 9.8, 0.0)]
    limbs = []
    for side in (1, -1):
        k, a = joint("knee", side), joint("ankle", side)
        limbs.append([((9.2 * side, 88, -0.6), 9.6), ((9.9 * side, 72, -0.4), 9.3),
                      (k, 8.0), (a + (0, -6, 1.5), 8.6)])
    return _LegsBelow(torso, limbs, power=2.25, blend=2.5, drape=drape)


class _LegsBelow(Form):
    """The torso ends at the fork; only legs below."""

    def value(self, p):
        f = super().value(p)
        legs = self._limb(p, self.limbs[0]), self._limb(p, self.limbs[1])
        legs = np.where(p[:, 0] > 0, legs[0], legs[1])
        # Between the legs the two capsules must not merge.
        t = np.clip((FORK + 4 - p[:, 1]) / 10, 0, 1)
        t = t * t * (3 - 2 * t)
        return f * (1 - t) + (legs - drape(p)) * t


def build():
    g = Garment("Trousers", form())
    hips = _hips(g)
    legs = {s: _leg(g, hips[-1], s) for s in (1, -1)}
    g.relax(150)
    _even_centre(g, hips)
    band = _waistband(g, hips[0])
    _marks(g, hips, legs)
    _details(g, band)
    return g


def _hips(g):
    """Rings from the waist down to the fork, from the centre front to the left."""
    angles = np.arange(2 * HALF) / (2 * HALF) * 2 * np.pi
    rows = []
    for t in np.linspace(0, 1, HIPS + 1):
        y = WAIST + (FORK + 3 - WAIST) * t + 0 * angles
        # The front dips at the waist; front and back dip into the crotch.
        y -= (1 - t) * 1.2 * (1 + np.cos(angles))
        y -= 2.6 * t * np.abs(np.cos(angles)) ** 3
        p = np.stack([16 * np.sin(angles), y, 11 * np.cos(angles)], 1)
        rows.append(g.add(g.form.project(p), fixed=t == 0))
        y0 = np.array(g.points)[rows[-1]]
        if t == 0:
            y0[:, 1] = y
            g.move(rows[-1], y0)

    def panel(_, c):
        half = HALF // 2
        return ("front_left" if c < half else "back_left" if c < 2 * half
                else "back_right" if c < 3 * half else "front_right")
    g.grid(rows[::-1], panel, closed=True)
    return rows


def _fork(g, low):
    """Points under the body from the centre front to the centre back, ends left out."""
    if not hasattr(g, "fork"):
        a, b = g.at(low[0]), g.at(low[HALF])
        path = between(a, b, CROTCH)[1:-1]
        t = np.linspace(0, 1, CROTCH + 1)[1:-1]
        path[:, 1] = 76.0 + 2.4 * (2 * t - 1) ** 2
        path[:, 0] = 0
        path[:, 2] = [4.2, -0.8, -6.2]
        g.fork = g.add(path, fixed=True)
        g.move(low[0], [0, 79.0, 9.2])
        g.move(low[HALF], [0, 78.6, -11.4])
        g.fix([low[0], low[HALF]])
    return g.fork


def _leg(g, low, side):
    """Rings of a leg, first the fork; they start at the centre front and run to the left."""
    fork = _fork(g, low)
    n = 2 * HALF
    if side == 1:
        ring = np.r_[low[:HALF + 1], fork[::-1]]
    else:
        ring = np.r_[low[HALF:], low[0], fork]
    rows = [ring]
    top = g.at(ring)
    knee, ankle = joint("knee", side), joint("ankle", side)
    middle = np.array([9.8 * side, 0, -0.6])
    angle = np.arctan2(top[:, 0] - middle[0], top[:, 2] - middle[2])
    # Even angles, keeping the first column of the outer seam at the side.
    outer = HALF // 2
    even = np.linspace(0, 2 * np.pi, len(ring), endpoint=False)
    start = angle[outer] - even[outer]
    even = even + np.pi / 2 * side - (np.pi / 2 * side - start)
    for t in np.arange(1, LEG + 1) / LEG:
        y = 76.5 + (HEM - 76.5) * t
        s = np.interp(y, [ankle[1], knee[1], 76.5], [0, 1, 2])
        centre = np.where(s < 1, ankle + (knee - ankle) * s,
                          knee + (middle - knee) * np.clip(s - 1, 0, 1))
        turn = np.angle(np.exp(1j * (even - angle)))
        a = angle + turn * np.clip(t * 3, 0, 1)
        p = np.stack([centre[0] + 9 * np.sin(a), y + 0 * a, centre[2] + 9 * np.cos(a)], 1)
        if t < 0.12:
            p[:, 1] += 0.5 * (top[:, 1] - 80)
        p = g.form.project(p)
        if t == 1:
            p[:, 1] = HEM - 1.2 * np.clip(-np.cos(a), -0.4, 1)
        rows.append(g.add(p, fixed=t == 1))
    word = "left" if side == 1 else "right"
    inseam = HALF + CROTCH // 2

    def panel(_, c):
        if side == 1:
            return f"front_{word}" if c < HALF // 2 or c >= inseam else f"back_{word}"
        return f"back_{word}" if c < HALF // 2 or c >= inseam else f"front_{word}"
    g.grid(rows[::-1], panel, closed=True)
    g.mark("inseam", [r[inseam] for r in rows])
    g.mark("side_seams", [r[HALF // 2] for r in rows])
    g.mark("hem", rows[-1], closed=True)
    g.mark("hem_stitch", rows[-2], closed=True)
    g.crease(rows[-1], 3.0, closed=True)
    return rows


def _even_centre(g, hips):
    """Keeps the seams at the centre in the plane of symmetry."""
    for c in (0, HALF):
        for r in hips:
            p = g.at(r[c])
            g.move(r[c], [0, p[1], p[2]])


def _waistband(g, waist):
    rows = [waist]
    base = g.at(waist)
    out = np.stack([base[:, 0], 0 * base[:, 0], base[:, 2]], 1)
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    for rise in (1.9, 3.8):
        p = base - out * (0.09 * rise)
        p[:, 1] += rise
        rows.append(g.add(p, fixed=True))
    g.grid(rows, "waistband", closed=True)
    g.cut([r[0] for r in rows])
    g.mark("waist_seam", waist, closed=True)
    g.mark("waist_edge", rows[-1], closed=True)
    g.mark("waistband_fold", rows[1], closed=True)
    g.crease(waist, 2.0, closed=True)
    g.crease(rows[-1], 3.0, closed=True)
    return rows


def _marks(g, hips, legs):
    g.mark("fly_seam", [r[0] for r in hips])
    g.mark("centre_back", [r[HALF] for r in hips])
    g.mark("crotch", np.r_[hips[-1][0], g.fork, hips[-1][HALF]])
    for c in (HALF // 2, HALF + HALF // 2):
        g.mark("side_seams", [r[c] for r in hips])
    # The pressed folds down the middle of the front and of the back of each leg.
    quarter = HALF // 4
    for s in (1, -1):
        columns = (quarter, HALF - quarter)
        for c in columns:
            chain = [r[c] for r in legs[s][1:]]
            g.mark("leg_folds", chain)
            g.crease(chain, 2.5)


def _details(g, band):
    _fly(g)
    for side in (1, -1):
        _back_pocket(g, side)
    base = np.array(g.points)
    for k, c in enumerate((3, 8, HALF, 2 * HALF - 8, 2 * HALF - 3)):
        _belt_loop(g, base, band, c, k)
    g.pins.append(int(band[1][0]))


def _fly(g):
    """The fly lies over the centre front: a strip with a curved lower end."""
    grid = []
    for t in np.linspace(0, 1, 6):
        y = 83.5 + 14.4 * t
        width = 3.8 * np.sqrt(np.clip(1 - (1 - min(1, t / 0.38)) ** 2 * 0.93, 0, 1))
        grid.append(g.add(g.form.front_point(np.linspace(-0.25, width, 3), y, 0.65), fixed=True))
    g.grid(grid, "fly")
    g.mark("fly_stitch", np.r_[[r[-1] for r in grid[::-1]], grid[0][-2::-1]])
    g.crease([r[0] for r in grid], 10.0)
    g.corners.append((int(grid[0][0]), 3.0))
    g.pins.append(int(grid[-1][1]))


def _back_pocket(g, side):
    name = "pocket_left" if side == 1 else "pocket_right"
    columns, rows = 4, 4
    grid = []
    for t in np.linspace(0, 1, rows + 1):
        u = np.linspace(-1, 1, columns + 1)
        width = 6.0 + 0.6 * t
        y = 80.6 + 13.0 * t - (1 - t) * 1.6 * (1 - np.abs(u)) + 0.3 * t * np.abs(u)
        x = (8.9 + width * u) * side
        p = g.form.front_point(x, y, 0.7, back=True)
        grid.append(g.add(p, fixed=True))
    g.grid(grid, name, flip=side == 1)
    g.mark("pocket_outline", np.r_[grid[0], [r[-1] for r in grid[1:]], grid[-1][-2::-1],
                                   [r[0] for r in grid[-2:0:-1]]], closed=True)
    g.mark("pocket_hem", grid[-2])
    g.crease(grid[-1], 2.5)
    g.pins.append(int(grid[-2][columns // 2]))


def _belt_loop(g, base, band, column, k):
    """A short strip over the waistband."""
    n = len(band[0])
    low, high = base[band[0][column]], base[band[-1][column]]
    across = base[band[0][(column + 1) % n]] - base[band[0][column - 1]]
    across = across * (1, 0, 1) / np.linalg.norm(across * (1, 0, 1))
    up = high - low
    out = np.cross(across, up)
    out /= np.linalg.norm(out)
    grid = []
    for t, lift in ((-0.22, 0.55), (0.2, 0.9), (0.6, 0.9), (1.0, 0.6)):
        middle = low + up * t + out * lift
        grid.append(g.add(middle + across * np.array([[-0.65], [0.65]]), fixed=True))
    g.grid(grid, f"belt_loop_{k + 1}")
