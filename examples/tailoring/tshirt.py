"""A T-shirt: set-in sleeves, ribbed neckband, a chest pocket.

Rings run around the neck and widen into the yoke; below it front and back rows run down to the
hem.  The rays over the shoulder run on into the sleeve."""
import numpy as np

from .form import Form, joint, smooth_table
from .mesh import Garment, blend_rows, ring_about

FRONT, SHOULDER = 12, 6     # columns of the front (and the back), rays over one shoulder
YOKE, ARMHOLE, BODY, SLEEVE = 4, 3, 11, 6       # rows
NECK_CORNER = 60            # degrees from the front to the first ray of the shoulder


def drape(p):
    """Slight folds of the hem and of the waist, and looser cloth under the chest."""
    angle = np.arctan2(p[:, 0], p[:, 2])
    low = np.clip((112 - p[:, 1]) / 30, 0, 1) ** 1.5 * (np.abs(p[:, 0]) < 24)
    return low * (0.75 * np.sin(5 * angle + 0.9 + 0.02 * p[:, 1]) + 0.4 * np.sin(8 * angle + 2.1))


def form():
    torso = [  # y, half width, front, back, centre z
        (78, 21.5, 13.2, 13.0, 0.0), (86, 21.0, 13.0, 12.8, 0.0), (96, 20.0, 12.6, 12.2, -0.3),
        (106, 18.9, 12.2, 11.4, -0.6), (116, 18.9, 12.6, 11.6, -0.8), (125, 19.8, 13.0, 12.2, -1.0),
        (132, 20.4, 12.4, 12.4, -1.3), (138, 20.0, 10.6, 11.6, -1.6), (142, 18.6, 8.9, 10.4, -1.9),
        (145, 15.0, 7.6, 9.0, -2.1), (147, 11.0, 7.0, 8.0, -2.2), (148.6, 8.4, 6.8, 7.2, -2.3),
        (151, 7.4, 6.6, 6.8, -2.0), (156, 7.0, 6.4, 6.6, -1.5)]
    limbs = []
    for side in (1, -1):
        s, e, w = joint("shoulder", side), joint("elbow", side), joint("wrist", side)
        limbs.append([(s + (0, -2.8, 0), 6.2), (e + (0, -1.5, 0), 7.8), (w, 8.0)])
    return Form(torso, limbs, blend=3.5, drape=drape)


def neckline(angle):
    """Points of the neck hole by angle from the front towards the left, before projection."""
    a = np.abs((angle + 180) % 360 - 180)
    y = smooth_table(a, [0, 20, 45, 68, 90, 120, 150, 180],
                     [140.3, 140.9, 143.4, 146.4, 147.7, 147.2, 146.6, 146.4])
    r = np.radians(angle)
    return np.stack([8.8 * np.sin(r), y, -2 + 9 * np.cos(r)], -1)


def armhole(side):
    """Points of an armhole from the underarm up the front, over the shoulder and down the back."""
    count = SHOULDER + 2 * ARMHOLE
    # The rays over the shoulder take the upper part of the loop, more evenly than the angle.
    t = np.radians(np.arange(count) / count * 360)
    up, across = -np.cos(t), np.sin(t)
    low, high = np.array([19.4, 124.8, -1.2]), np.array([18.6, 144.5, -1.8])
    mid = (low + high) / 2
    p = mid + up[:, None] * (high - low) / 2 + across[:, None] * np.array([-1.0, 0.0, 7.6])
    return p * np.array([side, 1, 1])


def build():
    g = Garment("Tshirt", form())
    neck_angles = np.concatenate([
        np.linspace(-NECK_CORNER, NECK_CORNER, FRONT + 1)[:-1],
        np.linspace(NECK_CORNER, 180 - NECK_CORNER, SHOULDER + 1)[:-1],
        np.linspace(180 - NECK_CORNER, 180 + NECK_CORNER, FRONT + 1)[:-1],
        np.linspace(180 + NECK_CORNER, 360 - NECK_CORNER, SHOULDER + 1)[:-1]])
    neck = g.add(g.form.project(neckline(neck_angles)), fixed=True)
    holes = {s: g.add(g.form.project(armhole(s)), fixed=True) for s in (1, -1)}

    rows = _torso(g, neck, holes)
    sleeves = {s: _sleeve(g, holes[s], s) for s in (1, -1)}
    _neckband(g, neck, neck_angles)
    g.relax(200)
    _folds(g, rows, sleeves)
    _pocket(g)
    return g


def _torso(g, neck, holes):
    count = ARMHOLE * 2 + SHOULDER
    left, right = holes[1], holes[-1]
    over = np.arange(ARMHOLE, ARMHOLE + SHOULDER + 1)       # of an armhole, front to back
    front_low = g.at([right[ARMHOLE], left[ARMHOLE]])
    back_low = g.at([left[-ARMHOLE], right[-ARMHOLE]])

    def across(ends, back, bulge=0.0):
        x = np.linspace(ends[0][0], ends[1][0], FRONT + 1)[1:-1]
        y = np.linspace(ends[0][1], ends[1][1], FRONT + 1)[1:-1] - bulge
        return g.add(g.form.front_point(x, y, back=back))

    # The lowest ring of the yoke, in the order of the neck.
    front = np.r_[right[ARMHOLE], across(front_low, False, 1.0), left[ARMHOLE]]
    back = np.r_[left[-ARMHOLE], across(back_low, True, 0.0), right[-ARMHOLE]]
    outer = np.r_[front[:-1], left[over[:-1]], back[:-1], right[over[::-1][:-1]]]
    rings = [outer]
    for t in np.arange(1, YOKE) / YOKE:
        p = g.at(outer) * (1 - t) + g.at(neck) * t
        rings.append(g.add(g.form.project(p)))
    rings.append(neck)
    half = SHOULDER // 2

    def yoke_panel(_, c):
        return "front" if c < FRONT + half or c >= 2 * FRONT + SHOULDER + half else "back"
    g.grid(rings, yoke_panel, closed=True)

    # Front and back between the yoke and the underarm.
    fronts, backs = [front], [back]
    for a in range(1, ARMHOLE):
        ends = g.at([right[ARMHOLE - a], left[ARMHOLE - a]])
        fronts.append(np.r_[right[ARMHOLE - a], across(ends, False), left[ARMHOLE - a]])
        k = count - ARMHOLE + a
        ends = g.at([left[k], right[k]])
        backs.append(np.r_[left[k], across(ends, True), right[k]])
    ends = g.at([right[0], left[0]])
    fronts.append(np.r_[right[0], across(ends, False), left[0]])
    backs.append(np.r_[left[0], across(ends[::-1], True), right[0]])
    g.grid(fronts[::-1], "front")
    g.grid(backs[::-1], "back")

    # Down to the hem, all round; the last row is fixed.
    ring = np.r_[fronts[-1][:-1], backs[-1][:-1]]
    rows = [ring]
    for t in np.arange(1, BODY + 1) / BODY:
        p = g.at(ring).copy()
        angle = np.arctan2(p[:, 0], p[:, 2])
        p[:, 1] += t * (79 - p[:, 1])
        p[:, 0], p[:, 2] = 22 * np.sin(angle), 14 * np.cos(angle)
        rows.append(g.add(g.form.project(p), fixed=t == 1))
    g.grid(rows[::-1], lambda _, c: "front" if c < FRONT else "back", closed=True)

    hem = np.array(g.points)[rows[-1]]
    hem[:, 1] = 79 - 0.5 * np.cos(np.arctan2(hem[:, 0], hem[:, 2]))
    g.move(rows[-1], hem)
    for c in (0, FRONT):
        g.mark("side_seams", [r[c] for r in rows])
    for c in (FRONT + half, 2 * FRONT + SHOULDER + half):
        g.mark("shoulder_seams", [r[c] for r in rings])
    for s in (1, -1):
        g.mark("armholes", holes[s], closed=True)
    g.mark("hem", rows[-1], closed=True)
    g.mark("hem_stitch", rows[-2], closed=True)
    g.mark("chest_line", rings[0][:FRONT + 1])
    return rows


def _sleeve(g, hole, side):
    """Rings along the arm; the last one, the hem, is fixed."""
    s, e = joint("shoulder", side), joint("elbow", side)
    axis = (e - s) / np.linalg.norm(e - s)
    end = s + (0, -3.6, 0) + axis * 22.5
    start = g.at(hole)[0] - g.at(hole).mean(0)
    ring = ring_about(s, end, 8.1, start, len(hole))
    # Front first, as the armhole runs: reverse where the circle starts towards the back.
    if (ring[1] - ring[-1])[2] < 0:
        ring = np.roll(ring[::-1], 1, axis=0)
    # Slanted hem: the underside is shorter.
    rows = [hole]
    for t in np.arange(1, SLEEVE + 1) / SLEEVE:
        p = g.at(hole) * (1 - t) + ring * t
        rows.append(g.add(g.form.project(p), fixed=t == 1))
    name = "sleeve_left" if side == 1 else "sleeve_right"
    g.grid(rows[::-1], name, closed=True, flip=side == -1)
    for r in rows[1:-1]:
        g.weaken(np.r_[r, r[0]])
    g.cut([r[0] for r in rows])
    g.mark("sleeve_seams", [r[0] for r in rows])
    g.mark("cuff_hem", rows[-1], closed=True)
    return rows


def _neckband(g, neck, angles):
    r = np.radians(angles)
    rows = [neck]
    for rise, inward in ((1.0, 0.75), (1.75, 1.75)):
        p = g.at(neck) * 1.0
        front = np.clip(np.cos(r), 0, 1)
        p[:, 0] -= inward * np.sin(r) * 0.8
        p[:, 2] -= inward * np.cos(r) * (0.75 - 0.35 * front)
        p[:, 1] += rise * (1 + 0.25 * front)
        rows.append(g.add(p, fixed=True))
    g.grid(rows, "neckband", closed=True)
    back = FRONT + SHOULDER + FRONT // 2
    g.cut([row[back] for row in rows])
    g.mark("neck_seam", neck, closed=True)
    g.mark("neckband_edge", rows[-1], closed=True)
    g.crease(neck, 2.0, closed=True)


def _folds(g, rows, sleeves):
    g.crease(rows[-1], 3.0, closed=True)
    for s in (1, -1):
        g.crease(sleeves[s][-1], 3.0, closed=True)


def _pocket(g):
    """A patch pocket on the left breast, with a pointed lower edge."""
    columns, rows = 4, 4
    x = np.linspace(4.6, 14.6, columns + 1)
    grid = []
    for t in np.linspace(0, 1, rows + 1):
        y = 118.5 + 11.5 * t - (1 - t) * 1.3 * (1 - np.abs(np.linspace(-1, 1, columns + 1)))
        grid.append(g.add(g.form.front_point(x, y, 0.75), fixed=True))
    g.grid(grid, "pocket")
    g.mark("pocket_outline", np.r_[grid[0], [r[-1] for r in grid[1:]], grid[-1][-2::-1],
                                   [r[0] for r in grid[-2:0:-1]]], closed=True)
    g.mark("pocket_hem", grid[-2])
    g.crease(grid[-1], 2.5)
    g.corners.append((int(grid[0][columns // 2]), 2.0))
    g.pins.append(int(grid[-2][columns // 2]))
