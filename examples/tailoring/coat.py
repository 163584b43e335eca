"""An open coat: notched lapels turned out, a collar which stands and falls over, turned back
cuffs, facings folded in behind the front edges, patch pockets with flaps, a half belt.

Each front is a patch of rows from the hem to the shoulder; its inner side runs up the front edge
to the break, up the roll line to the collar, and along the neck to the shoulder.  The lapel is
the front's own cloth beyond the roll line, folded over; below the break the same cloth is folded
inwards and is the facing."""
import numpy as np

from .form import Form, joint, smooth_table
from .mesh import Garment, between, ring_about

COLUMNS = 9             # of a front, and of half the back under a shoulder
NECK = 6                # columns of the back at the neck
LOW, ROLL, GORGE = 13, 12, 3    # rows: hem to break, break to collar, collar to shoulder
ARM = 9                 # the uppermost rows end at the armhole
ROWS = LOW + ROLL + GORGE
SLEEVE = 16
HEM, BREAK, TOP, UNDERARM = 54.0, 103.0, 139.5, 123.0
LAPEL, FACING = 4, 2    # columns


def drape(p):
    """Folds of the skirt of the coat, which deepen towards the hem."""
    angle = np.arctan2(p[:, 0], p[:, 2])
    low = np.clip((106 - p[:, 1]) / 52, 0, 1) ** 1.4
    side = np.clip(1 - np.cos(angle), 0, 1)         # flat at the front edges
    fold = np.sin(6 * np.abs(angle) + 0.6) + 0.5 * np.sin(9 * np.abs(angle) + 2.0)
    return 1.15 * low * side * fold * (np.abs(p[:, 0]) < 36)


def form():
    torso = [  # y, half width, front, back, centre z
        (46, 30.0, 20.0, 19.5, 0.0), (56, 29.0, 19.2, 18.8, 0.0), (75, 26.6, 17.6, 17.2, 0.0),
        (90, 23.8, 15.8, 15.4, -0.2), (104, 20.8, 14.2, 13.2, -0.5), (112, 20.6, 14.2, 13.0, -0.7),
        (122, 21.9, 14.8, 13.8, -0.9), (130, 22.8, 14.6, 14.2, -1.2), (137, 22.6, 12.6, 13.4, -1.6),
        (142, 21.0, 10.4, 11.9, -1.9), (145.5, 17.6, 8.9, 10.2, -2.1),
        (148, 12.2, 8.0, 8.8, -2.2), (149.8, 9.3, 7.7, 8.1, -2.3), (152, 8.2, 7.4, 7.6, -2.1),
        (158, 7.8, 7.2, 7.4, -1.8)]
    limbs = []
    for side in (1, -1):
        s, e, w = joint("shoulder", side), joint("elbow", side), joint("wrist", side)
        limbs.append([(s + (0.6 * side, -3.4, 0), 7.8), (e + (0, -1.0, 0), 7.5), (w, 6.6),
                      (w + (6 * side, -8, 3), 6.6)])
    return Form(torso, limbs, power=2.35, blend=3.0, drape=drape)


def armhole(side):
    """Points from the underarm up the front to the shoulder and down the back."""
    count = 2 * ARM
    t = np.arange(count) / count * 2 * np.pi
    low, high = np.array([20.0, UNDERARM, -1.2]), np.array([20.6, 146.0, -1.9])
    p = ((low + high) / 2 - np.cos(t)[:, None] * (high - low) / 2
         + np.sin(t)[:, None] * np.array([-1.3, 0.0, 8.8]))
    return p * np.array([side, 1, 1])


def build():
    g = Garment("Coat", form())
    g.seams = {}
    holes = {s: g.add(g.form.project(armhole(s)), fixed=True) for s in (1, -1)}
    fronts = {s: _front(g, holes[s], s) for s in (1, -1)}
    back = _back(g, fronts, holes)
    wrists = {s: _sleeve(g, holes[s], s) for s in (1, -1)}
    g.relax(300)
    _straight_hem(g, fronts, back)
    edges = {}
    for s in (1, -1):
        _facing(g, fronts[s], s)
        edges[s] = _lapel(g, fronts[s], s)
        _cuff(g, wrists[s], s)
        _pockets(g, s)
    _collar(g, fronts, back, edges)
    _half_belt(g)
    _welt(g)
    _marks(g, fronts, back, holes)
    return g


def word(side):
    return "left" if side == 1 else "right"


def _front(g, hole, side):
    """Rows of a front from the hem up, each from its inner to its outer side."""
    f = g.form
    break_at = f.front_point(2.2 * side, BREAK)
    # Inner side: front edge, roll line, neck.
    y = np.linspace(HEM, BREAK, LOW + 1)
    edge = f.front_point(side * np.linspace(4.2, 2.2, LOW + 1), y)
    t = np.linspace(0, 1, ROLL + 1)[1:]
    roll = f.front_point(side * (2.2 + 5.2 * t ** 1.15), BREAK + (TOP - BREAK) * t)
    t = np.linspace(0, 1, GORGE + 1)[1:]
    side_neck = np.array([9.6 * side, 148.9, -2.0])
    neck = f.project(roll[-1] * (1 - t[:, None]) + side_neck * t[:, None]
                     + np.sin(np.pi * t)[:, None] * np.array([1.0 * side, 0, 0.6]))
    inner = np.concatenate([edge, roll, neck])
    inner[LOW] = break_at
    inner = g.add(inner, fixed=True)

    # Outer side: side seam up to the underarm, then the front of the armhole.
    low = ROWS - ARM
    y = np.linspace(HEM, g.at(hole[0])[1], low + 1)[:-1]
    seam = np.stack([side * np.interp(y, [HEM, 104, 126], [29, 20.5, 21]), y, -1.0 + 0 * y], 1)
    seam = g.add(f.project(seam))
    g.fix(seam[0])
    outer = np.r_[seam, hole[:ARM + 1]]

    rows = []
    for r in range(ROWS + 1):
        a, b = g.at([inner[r], outer[r]])
        if r < low:
            angles = np.linspace(np.arctan2(a[0], a[2]), np.arctan2(b[0], b[2]), COLUMNS + 1)[1:-1]
            p = np.stack([28 * np.sin(angles), np.linspace(a[1], b[1], COLUMNS + 1)[1:-1],
                          18 * np.cos(angles)], 1)
        else:
            p = between(a, b, COLUMNS)[1:-1]
            p[:, 2] += 2.0 * (1 if r < ROWS else 0)
        rows.append(np.r_[inner[r], g.add(f.project(p), fixed=r in (0, ROWS)), outer[r]])
    g.grid(rows, f"front_{word(side)}", flip=side == -1)
    rows = np.array(rows)
    for c in range(1, COLUMNS):
        g.weaken(rows[:, c])
    return rows


def _back(g, fronts, holes):
    """Rows of the back from the hem up, from the left to the right of the wearer."""
    f = g.form
    low = ROWS - ARM
    left, right = fronts[1][:, -1].copy(), fronts[-1][:, -1].copy()
    for s, side in ((1, left), (-1, right)):
        for k in range(1, ARM + 1):
            side[low + k] = holes[s][-k] if k < ARM else holes[s][ARM]
    count = 2 * COLUMNS + NECK
    rows = []
    for r in range(ROWS):
        a, b = g.at([left[r], right[r]])
        y = np.linspace(a[1], b[1], count + 1)[1:-1]
        if r < low:
            start, end = np.arctan2(a[0], a[2]), np.arctan2(b[0], b[2]) % (2 * np.pi)
            angles = np.linspace(start, end, count + 1)[1:-1]
            p = f.project(np.stack([28 * np.sin(angles), y, 18 * np.cos(angles)], 1))
        else:
            x = np.linspace(a[0], b[0], count + 1)[1:-1]
            # Upper rows rise towards the neck.
            t = (r - low) / ARM
            y = y + t ** 2 * 2.0 * np.clip(1 - np.abs(x) / 20, 0, 1)
            p = f.front_point(x, np.minimum(y, 147.0), back=True)
        rows.append(np.r_[left[r], g.add(p, fixed=r == 0), right[r]])
    # The last row: shoulder, neck, shoulder.
    a, b = g.at([fronts[1][ROWS][0], fronts[-1][ROWS][0]])
    t = np.linspace(0, np.pi, NECK + 1)[1:-1]
    neck = np.stack([a[0] * np.cos(t), a[1] - 0.9 * np.sin(t), a[2] - 7.2 * np.sin(t)], 1)
    neck = g.add(f.project(neck), fixed=True)
    rows.append(np.r_[fronts[1][ROWS][::-1], neck, fronts[-1][ROWS]])
    middle = count // 2
    g.grid(rows, lambda _, c: "back_left" if c < middle else "back_right")
    rows = np.array(rows)
    for c in range(1, count):
        g.weaken(rows[:, c])
    return rows


def _sleeve(g, hole, side):
    """Rings along the bent arm to the wrist, in two pieces: upper and under sleeve."""
    s, e, w = joint("shoulder", side), joint("elbow", side), joint("wrist", side)
    start = g.at(hole)[0] - g.at(hole).mean(0)
    path = np.stack([s + (0.6 * side, -3.4, 0), e + (0, -1.0, 0), w + (0.9 * side, -1.2, 0.4)])
    lengths = np.r_[0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))]
    rows = [hole]
    for k in range(1, SLEEVE + 1):
        t = k / SLEEVE
        d = lengths[-1] * (0.10 + 0.90 * t)
        centre = np.array([np.interp(d, lengths, path[:, i]) for i in range(3)])
        ahead = np.array([np.interp(d + 8, lengths, path[:, i]) for i in range(3)])
        behind = np.array([np.interp(d - 8, lengths, path[:, i]) for i in range(3)])
        axis = ahead - behind
        ring = ring_about(centre - axis, centre, 8.0, start, len(hole))
        if (ring[1] - ring[-1])[2] < 0:
            ring = np.roll(ring[::-1], 1, axis=0)
        m = np.clip(1 - t * 3.2, 0, 1)
        p = ring * (1 - m) + (g.at(hole) + centre - path[0] + (0, 0, 0)) * m
        rows.append(g.add(g.form.project(p), fixed=k == SLEEVE))
    under = {c for c in range(len(hole)) if c < 3 or c >= len(hole) - 3}

    def panel(_, c):
        return f"sleeve_{'under' if c in under else 'upper'}_{word(side)}"
    g.grid(rows[::-1], panel, closed=True, flip=side == -1)
    for c in (3, len(hole) - 3):
        g.mark("sleeve_seams", [r[c] for r in rows])
    for r in rows[1:5]:
        g.weaken(np.r_[r, r[0]])
    g.mark("elbow_line", rows[SLEEVE // 2 + 1], closed=True)
    return np.array(rows)


def _straight_hem(g, fronts, back):
    ids = np.unique(np.r_[fronts[1][0], fronts[-1][0], back[0]])
    p = g.at(ids)
    p[:, 1] = HEM
    g.move(ids, p)


def _facing(g, front, side):
    """The cloth folded in behind the front edge, below the break."""
    rows = []
    for r in range(LOW):
        ids = front[r, 1:FACING + 1]
        p = g.at(ids) - g.form.normal(g.at(ids)) * np.array([[0.75], [0.85]])
        rows.append(np.r_[front[r, 0], g.add(p, fixed=True)])
    rows.append(np.full(FACING + 1, front[LOW, 0]))
    g.grid(rows, f"front_{word(side)}", flip=side == 1)
    fold = front[:LOW + 1, 0]
    g.mark("placket", fold)
    g.mark("placket_stitch", front[:LOW + 1, FACING])
    g.mark("facing_edge", [r[-1] for r in rows])
    g.crease(fold, 10.0)
    if side == 1:
        for r in (3, 7, 11):
            g.pins.append(int(front[r, 1]))
    g.edge_sets.setdefault("hem", []).extend(
        (int(a), int(b)) for a, b in zip(rows[0], rows[0][1:]))


def _lapel(g, front, side):
    """The cloth beyond the roll line, folded over the front.  Returns the row at the gorge."""
    f = g.form
    top = LOW + ROLL
    roll = front[LOW:top + 1, 0]
    p = g.at(roll)
    rows = [np.full(LAPEL + 1, roll[0])]
    for k in range(1, ROLL + 1):
        t = k / ROLL
        width = 9.8 * t ** 0.8 * (1 + 0.06 * np.sin(np.pi * t))
        out = np.linspace(0, 1, LAPEL + 1)[1:]
        # The lapel leaves the roll line square to it and swings up at its point.
        rise = out * (-0.16 - 0.06 * t) * width
        x = p[k, 0] + side * out * width
        y = p[k, 1] + rise
        lift = 0.95 * (1 - np.exp(-out * width / 0.9)) + 0.15 * t
        q = f.project(f.front_point(x, y), lift)
        rows.append(np.r_[roll[k], g.add(q, fixed=True)])
    g.grid(rows, f"front_{word(side)}", flip=side == 1)
    g.mark("roll_line", roll)
    g.mark("lapel_edge", [r[-1] for r in rows])
    g.mark("lapel_edge", rows[-1][2:])
    g.mark("gorge", rows[-1][:3])
    g.crease(roll, 2.5)
    g.corners.append((int(rows[-1][-1]), 4.0))
    return rows[-1]


def _collar(g, fronts, back, gorge):
    """Stand and fall, from the left end of the neck round the back to the right end."""
    f = g.form
    top = LOW + ROLL
    neck = np.r_[fronts[1][top:, 0], back[ROWS][COLUMNS + 1:COLUMNS + NECK],
                 fronts[-1][top:, 0][::-1]]
    n = len(neck)
    base = g.at(neck)
    u = np.linspace(-1, 1, n)
    # Inwards to the neck, level.
    centre = np.array([0, 0, -2.2])
    inward = (centre - base) * (1, 0, 1)
    inward /= np.linalg.norm(inward, axis=1, keepdims=True)
    round_back = smooth_table(np.abs(u), [0, 0.25, 0.5, 0.75, 1], [1, 0.97, 0.86, 0.55, 0])
    height = 4.0 * round_back
    fold = base + inward * (0.55 * round_back)[:, None]
    fold[:, 1] += height
    fold_ids = np.r_[neck[0], g.add(fold[1:-1], fixed=True), neck[-1]]
    half = base + inward * (0.1 * round_back)[:, None]
    half[:, 1] += height * 0.5
    half_ids = np.r_[neck[0], g.add(half[1:-1], fixed=True), neck[-1]]
    g.grid([neck, half_ids, fold_ids], "collar")

    # The fall: from the fold out and down to its edge, which lies on the shoulders.
    rows = 4
    first = [_collar_end(g, gorge[1], k, rows) for k in range(1, rows + 1)]
    last = [_collar_end(g, gorge[-1], k, rows) for k in range(1, rows + 1)]
    edge = _fall_edge(g, n, first[-1])
    grid = [fold_ids]
    for k in range(1, rows + 1):
        t = k / rows
        out = -inward
        b = fold + out * 1.7 + np.array([0, 0.5, 0])
        m = edge + np.array([0, 0.5, 0]) * height[:, None] + out * 0.3
        q = fold * (1 - t) ** 3 + 3 * b * t * (1 - t) ** 2 + 3 * m * t * t * (1 - t) + edge * t ** 3
        q = _clear(f, q, 0.85 + 0.35 * t)
        grid.append(np.r_[first[k - 1], g.add(q[1:-1], fixed=True), last[k - 1]])
    g.grid(grid, "collar")
    g.mark("neck_seam", neck)
    g.mark("collar_fold", fold_ids)
    g.mark("collar_edge", np.r_[[r[0] for r in grid[2:]], grid[-1][1:-1],
                                [r[-1] for r in grid[2:]][::-1]])
    g.crease(fold_ids, 3.0)
    for r in (grid[-1][0], grid[-1][-1]):
        g.corners.append((int(r), 3.0))


def _collar_end(g, gorge, k, rows):
    """The end of the collar: sewn to the lapel along the gorge, then free beside the notch."""
    if k <= 2:
        return int(gorge[k])
    p = g.at(gorge)
    along = p[2] - p[0]
    along /= np.linalg.norm(along)
    turned = along + np.array([0, 0.8, -0.1])
    turned /= np.linalg.norm(turned)
    q = p[2] + turned * 2.1 * (k - 2)
    return int(g.add(g.form.project(q, 1.2)[0], fixed=True))


def _fall_edge(g, n, tip):
    """The outer edge of the collar, a curve through its points, tip to tip."""
    tip = g.at(tip)
    half = np.array([tip, [15.2, 146.0, -1.5], [9.6, 146.5, -10.0], [0, 145.2, -14.0]])
    keys = np.array([0, GORGE + 0.2, GORGE + 1.6, (n - 1) / 2])
    points = np.concatenate([half, (half * (-1, 1, 1))[-2::-1]])
    keys = np.r_[keys, (n - 1 - keys)[-2::-1]]
    slopes = np.gradient(points, keys, axis=0)
    slopes[0], slopes[-1] = (points[1] - points[0]) / keys[1], (points[-1] - points[-2]) / keys[1]
    x = np.arange(n)
    i = np.clip(np.searchsorted(keys, x, side="right") - 1, 0, len(keys) - 2)
    h = (keys[i + 1] - keys[i])[:, None]
    t = ((x - keys[i])[:, None]) / h
    curve = ((1 + 2 * t) * (1 - t) ** 2 * points[i] + t * (1 - t) ** 2 * h * slopes[i]
             + t * t * (3 - 2 * t) * points[i + 1] + t * t * (t - 1) * h * slopes[i + 1])
    return g.form.project(curve, 1.2)


def _clear(form, p, distance):
    """Points no nearer to the form than a distance."""
    near = form.value(p) < distance
    q = p.copy()
    if near.any():
        q[near] = form.project(p[near], distance)
    return q


def _cuff(g, rings, side):
    """A cuff sewn to the end of the sleeve and turned back over it."""
    wrist = rings[-1]
    rows = [wrist]
    end = g.at(wrist)
    centre = end.mean(0)
    up = g.at(rings[-4]).mean(0) - centre
    up /= np.linalg.norm(up)
    for along, lift in ((-0.25, 0.75), (2.6, 1.05), (5.2, 1.15), (7.4, 1.25)):
        p = end + up * along
        out = end - centre - ((end - centre) @ up)[:, None] * up
        out /= np.linalg.norm(out, axis=1, keepdims=True)
        if along > 0:
            p = g.form.project(p)
            out = g.form.normal(p)
        rows.append(g.add(p + out * lift, fixed=True))
    g.grid(rows, f"cuff_{word(side)}", closed=True, flip=side == 1)
    g.cut([r[0] for r in rows])
    g.mark("cuff_hem", wrist, closed=True)
    g.mark("cuff_edge", rows[-1], closed=True)
    g.mark("cuff_fold", rows[1], closed=True)
    g.crease(wrist, 3.0, closed=True)
    g.crease(rows[1], 3.0, closed=True)


def _patch(g, name, start, width, y, lift, side, columns, back=False, point=0.0, corner=0.0):
    """A piece lying on the body, of a width measured along the body from x = start; y: heights
    of its rows, lowest first; corner: by how much the lowest row is narrower at each end."""
    u = np.linspace(0, 1, columns + 1)
    ends = (u == 0) | (u == 1)
    fine = np.linspace(start, start + 1.2 * width, 120)
    grid = []
    for k, level in enumerate(y):
        track = g.form.front_point(fine, level + 0 * fine, back=back)
        length = np.r_[0, np.cumsum(np.linalg.norm(np.diff(track, axis=0), axis=1))]
        along = width * u + (k == 0) * corner * ((u == 0) * 1.0 - (u == 1))
        if start < 0:       # a piece about the middle
            along = along + np.interp(0, fine, length) - width / 2
        px = np.interp(along, length, fine)
        py = level - (k == 0) * (point * (1 - np.abs(2 * u - 1)) - 0.5 * corner * ends)
        p = g.form.front_point(px * side, py, lift[k] if np.ndim(lift) else lift, back=back)
        grid.append(g.add(p, fixed=True))
    g.grid(grid, name, flip=(side == -1) != back)
    return np.array(grid)


def outline(grid):
    return np.r_[grid[0], grid[1:, -1], grid[-1, -2::-1], grid[-2:0:-1, 0]]


def _pockets(g, side):
    pocket = _patch(g, f"pocket_{word(side)}", 8.3, 15.5, np.linspace(70, 87.5, 6), 0.85, side, 5,
                    corner=0.8)
    flap = _patch(g, f"flap_{word(side)}", 7.8, 16.5, (85.0, 87.2, 89.4), (1.75, 1.6, 0.9), side, 5,
                  point=0.8, corner=0.3)
    g.mark("pocket_outline", outline(pocket), closed=True)
    g.mark("flap_edge", np.r_[flap[:0:-1, 0], flap[0], flap[1:, -1]])
    g.mark("flap_hinge", flap[-1])
    g.mark("pocket_hem", pocket[-2])
    g.crease(pocket[-1], 2.0)
    g.crease(flap[-1], 2.5)
    g.pins.append(int(flap[1, 2]))


def _half_belt(g):
    belt = _patch(g, "half_belt", -14.0, 28.0, (102.0, 104.2, 106.4), 0.9, 1, 8, back=True)
    g.mark("belt_edge", outline(belt), closed=True)
    g.pins.extend([int(belt[1, 1]), int(belt[1, -2])])


def _welt(g):
    welt = _patch(g, "welt", 12.2, 7.5, (118.6, 121.0), 0.9, 1, 3)
    g.mark("pocket_outline", outline(welt), closed=True)


def _marks(g, fronts, back, holes):
    low = ROWS - ARM
    for s in (1, -1):
        g.mark("side_seams", fronts[s][:low + 1, -1])
        g.mark("shoulder_seams", fronts[s][ROWS])
        g.mark("armholes", holes[s], closed=True)
        g.mark("hem", fronts[s][0])
    g.mark("hem", back[0])
    g.mark("centre_back", back[:, COLUMNS + NECK // 2])
    g.mark("waist_line", np.r_[fronts[1][LOW], []])
    g.mark("waist_line", fronts[-1][LOW])
    g.mark("waist_line", back[LOW])
