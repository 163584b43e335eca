"""The layered suit: a shirt with sleeves and a collar, an overall with a bib over it, straps over both, and buckles, belt loops and a
pocket upon these.  Each layer lies on a level of one form, so that no layer crosses another."""
import numpy as np

from tailoring.form import Form, joint, smooth_table
from tailoring.mesh import Garment, ring_about
from troubles import section

GAP = 0.75                  # between layers: a quarter of an edge
ROUND = 40                  # columns around the body, from the centre of the front to the left
SIDE = ROUND // 4
BELOW_ARM, ARM, ABOVE_ARM = 10, 6, 3        # rows of the shirt
SLEEVE, COLLAR = 16, 3
HIPS, LEG, CROTCH = 7, 23, 4
HEM, NECK, WAIST, FORK, ANKLE = 90.0, 148.8, 104.0, 82.0, 9.0
BIB = 6                     # columns of half of the bib


class Body(Form):
    """The body at a distance: torso and arms above, two legs below the fork."""

    def __init__(self, offset=0.0):
        torso = [
            (70, 18.4, 11.6, 12.4, -0.5), (80, 19.2, 12.2, 13.4, -0.6), (88, 19.6, 12.4, 13.8, -0.6),
            (96, 18.4, 12.0, 12.6, -0.5), (104, 17.2, 11.8, 11.2, -0.4), (112, 17.6, 12.0, 11.0, -0.7),
            (122, 19.0, 12.8, 12.0, -0.9), (131, 20.0, 12.6, 12.4, -1.3), (138, 19.6, 10.8, 11.6, -1.6),
            (142, 18.2, 9.2, 10.4, -1.9), (145.4, 14.8, 7.8, 9.0, -2.1), (147.4, 11.0, 7.2, 8.1, -2.2),
            (149.2, 8.7, 7.0, 7.5, -2.3), (152, 7.9, 6.9, 7.2, -2.0), (158, 7.7, 6.7, 7.0, -1.6)]
        arms, self.legs = [], []
        for side in (1, -1):
            shoulder, elbow, wrist = (joint(name, side) for name in ("shoulder", "elbow", "wrist"))
            arms.append([(shoulder + (0.3 * side, -2.8, 0), 6.6), (elbow, 6.9), (wrist, 5.6)])
            knee, ankle = joint("knee", side), joint("ankle", side)
            self.legs.append([(np.array((9.6 * side, 90, -0.6)), 9.8), (np.array((10.8 * side, 72, -0.4)), 8.6),
                              (knee, 8.2), (ankle + (0, -6, 1.5), 9.0)])
        super().__init__(torso, arms, power=2.3, blend=3.5)
        self.offset = offset

    def value(self, p):
        angle = np.arctan2(p[:, 0], p[:, 2])
        folds = 0.5 * np.sin(5 * angle + 0.07 * p[:, 1]) * np.exp(-((p[:, 1] - 108) / 9) ** 2)
        above = super().value(p) - folds * (np.abs(p[:, 0]) < 24)
        breaks = 0.6 * np.sin(0.7 * p[:, 1]) * np.exp(-((p[:, 1] - 16) / 9) ** 2)
        legs = np.where(p[:, 0] > 0, self._limb(p, self.legs[0]), self._limb(p, self.legs[1])) - breaks
        t = np.clip((FORK + 4 - p[:, 1]) / 10, 0, 1)
        t = t * t * (3 - 2 * t)
        return above * (1 - t) + legs * t - self.offset


def build():
    suit = Garment("LayeredSuit", Body())
    for part in (shirt(), overall()):
        append(suit, part)
    for side in (1, -1):
        strap(suit, side)
        buckle(suit, side)
    for number, angle in enumerate((50, 100, 180, 260, 310)):
        belt_loop(suit, number, np.radians(angle))
    pocket(suit)
    return suit


def append(whole, part):
    """Adds the faces of one garment to another."""
    first = len(whole.points)
    whole.add(part.points)
    for face, panel in zip(part.faces, part.panels):
        whole.face([first + i for i in face], panel)
    whole.cuts.update((first + a, first + b) for a, b in part.cuts)


def rings(g, heights, around=ROUND):
    """Rows of points around the body, each at a height; the first and the last stay where they are."""
    angle = np.arange(around) / around * 2 * np.pi
    rows = []
    for number, y in enumerate(heights):
        p = g.form.project(np.stack([18 * np.sin(angle), y + 0 * angle, 12 * np.cos(angle)], 1))
        is_last = number == len(heights) - 1
        rows.append(g.add(section(g.form, y, angle) if is_last else p, fixed=is_last or number == 0))
    return np.array(rows)


def shirt():
    g = Garment("Shirt", Body())
    y = np.r_[np.linspace(HEM, 124, BELOW_ARM + 1), np.linspace(127, 143, ARM), np.linspace(145, NECK, ABOVE_ARM)]
    rows = rings(g, y)

    def panel(_, c):
        return "front_left" if c < SIDE else "back" if c < 3 * SIDE else "front_right"

    for r in range(len(rows) - 1):
        for c in range(ROUND):
            in_hole = BELOW_ARM <= r < BELOW_ARM + ARM and min(abs(c + 0.5 - SIDE), abs(c + 0.5 - 3 * SIDE)) < ARM / 2
            if not in_hole:
                low, high, n = rows[r], rows[r + 1], (c + 1) % ROUND
                g.face([low[c], low[n], high[n], high[c]], panel(r, c))
    for side in (1, -1):
        sleeve(g, hole(rows, side), side)
    base = rows[-1]
    collar = [base]
    out = g.form.normal(g.at(base)) * (1, 0, 1)
    for k in range(1, COLLAR + 1):
        p = g.at(base) + out * 0.25 * k + (0, 1.3 * k, 0)
        collar.append(g.add(p, fixed=True))
    g.grid(collar, "collar", closed=True)
    g.cut([row[0] for row in collar])
    g.relax(150)
    return g


def hole(rows, side):
    """The border of an armhole from the underarm up the front, over the shoulder and down the back."""
    low, high, half = BELOW_ARM, BELOW_ARM + ARM, ARM // 2
    places = [(low, -c) for c in range(half)] + [(r, -half) for r in range(low, high)]
    places += [(high, c) for c in range(-half, half)] + [(r, half) for r in range(high, low, -1)]
    places += [(low, c) for c in range(half, 0, -1)]
    return np.array([rows[r][(side * (SIDE + c)) % ROUND] for r, c in places])


def sleeve(g, border, side):
    shoulder, elbow, wrist = (joint(name, side) for name in ("shoulder", "elbow", "wrist"))
    path = np.stack([shoulder + (0, -2.5, 0), elbow, wrist])
    along = np.r_[0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))]
    at = lambda d: np.array([np.interp(d, along, path[:, k]) for k in range(3)])
    start = g.at(border)[0] - g.at(border).mean(0)
    rows = [border]
    for t in np.arange(1, SLEEVE + 1) / SLEEVE:
        d = along[-1] * (0.14 + 0.86 * t)
        ring = ring_about(at(d - 8), at(d), 7.0, start, len(border))
        if (ring[1] - ring[-1])[2] < 0:
            ring = np.roll(ring[::-1], 1, axis=0)
        near = np.clip(1 - 3 * t, 0, 1)
        p = ring * (1 - near) + (g.at(border) + at(d) - path[0]) * near
        rows.append(g.add(g.form.project(p), fixed=t == 1))
    g.grid(rows[::-1], f"sleeve_{side}", closed=True, flip=side == -1)
    g.cut([row[0] for row in rows])


def overall():
    g = Garment("Overall", Body(GAP))
    hips = rings(g, np.linspace(FORK + 2, WAIST, HIPS + 1))
    low, half = hips[0], ROUND // 2
    for column, z in ((0, 9.0), (half, -11.4)):
        g.move(low[column], [0, FORK - 2.6, z])
    names = ["front_leg_1", "back_leg_1", "back_leg_-1", "front_leg_-1"]
    g.grid(hips, lambda _, c: names[c // SIDE], closed=True)
    t = np.linspace(0, 1, CROTCH + 1)[1:-1]
    a, b = g.at([low[0], low[half]])
    fork = g.add(a + (b - a) * t[:, None] - np.outer(4 * t * (1 - t), (0, 2.4, 0)), fixed=True)
    leg(g, np.r_[low[:half + 1], fork[::-1]], 1)
    leg(g, np.r_[low[half:], low[0], fork], -1)
    waist = hips[-1]
    bib(g, waist[np.arange(-BIB, BIB + 1)], 126.0, "bib", False)
    bib(g, waist[half + np.arange(-BIB, BIB + 1)], 123.0, "back_bib", True)
    g.relax(150)
    return g


def leg(g, top, side):
    p = g.at(top)
    middle = np.array([10.0 * side, 0, -0.6])
    angle = np.arctan2(p[:, 0] - middle[0], p[:, 2] - middle[2])
    outer = SIDE
    even = angle[outer] + np.linspace(0, 2 * np.pi, len(top), endpoint=False) - 2 * np.pi * outer / len(top)
    turn = np.angle(np.exp(1j * (even - angle)))
    knee, ankle = joint("knee", side), joint("ankle", side)
    rows = [top]
    for t in np.arange(1, LEG + 1) / LEG:
        y = 77 + (ANKLE - 77) * t ** 0.95
        centre = np.array([np.interp(y, [ankle[1], knee[1], 77], [ankle[k], knee[k], middle[k]]) for k in range(3)])
        a = angle + turn * np.clip(3 * t, 0, 1)
        q = np.stack([centre[0] + 9 * np.sin(a), y + 0 * a, centre[2] + 9 * np.cos(a)], 1)
        q[:, 1] += 0.5 * (p[:, 1] - 80) * (t < 0.1)
        rows.append(g.add(g.form.project(q), fixed=t == 1))
    inner = ROUND // 2 + CROTCH // 2

    def panel(_, c):
        first = c < SIDE or c >= inner
        return f"{'front' if first == (side == 1) else 'back'}_leg_{side}"
    g.grid(rows[::-1], panel, closed=True)


def bib(g, waist, top, name, back):
    """A panel that goes up from the waist, a little narrower than it."""
    p = g.at(waist)
    rows = [waist]
    count = round((top - WAIST) / 2.7)
    for t in np.arange(1, count + 1) / count:
        x = p[:, 0] * (1 - 0.25 * t)
        rows.append(g.add(g.form.front_point(x, p[:, 1] * (1 - t) + top * t, back=back), fixed=True))
    g.grid(rows, name)


def traced(x, offset, heights, count):
    """Points from the front over a shoulder to the back in planes of constant x, which differ along the way."""
    turn = np.radians(np.linspace(-60, 240, 400))
    share = np.linspace(0, 1, 400)
    ray = np.stack([0 * turn, np.sin(turn), np.cos(turn)], 1)
    centre = np.stack([x(share), 130 + 0 * turn, -1.5 + 0 * turn], 1)
    inside, outside = np.zeros(400), np.full(400, 40.0)
    form = Body()
    for _ in range(40):
        middle = (inside + outside) / 2
        p = centre + ray * middle[:, None]
        is_in = form.value(p) < offset(p)
        inside, outside = np.where(is_in, middle, inside), np.where(is_in, outside, middle)
    p = centre + ray * inside[:, None]
    front, back = heights
    p = p[np.where(p[:, 2] > -1.5, p[:, 1] >= front, p[:, 1] >= back)]
    along = np.r_[0, np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))]
    wanted = np.linspace(0, along[-1], count + 1)
    return np.stack([np.interp(wanted, along, p[:, k]) for k in range(3)], 1)


def strap(g, side):
    def offset(p):
        top = np.where(p[:, 2] > -1.5, 126, 123)
        return GAP * (2 - smooth_table(p[:, 1] - top, [0.5, 5], [0, 0.9]))

    def column(shift):
        x = lambda share: smooth_table(share, [0.15, 0.5, 0.85], [7.0, 12.4, 6.4]) + shift
        return traced(x, offset, (119.5, 116.5), 25)
    rows = np.stack([column(shift) for shift in (-1.7, 0.0, 1.7)], 1) * (side, 1, 1)
    g.grid(list(g.add(rows, fixed=True)), f"strap_{side}", flip=side == -1)


def upon(g, x, y, offset, name, keep=lambda r, c: True):
    """A grid over the front, at a distance from the body."""
    rows = g.add(g.form.front_point(*np.meshgrid(x, y)), fixed=True)
    points = g.at(rows).reshape(-1, 3)
    g.move(rows, points + g.form.normal(points) * offset)
    for r in range(len(y) - 1):
        for c in range(len(x) - 1):
            if keep(r, c):
                g.face([rows[r][c], rows[r][c + 1], rows[r + 1][c + 1], rows[r + 1][c]], name)


def buckle(g, side):
    """A frame upon the lower end of a strap."""
    is_frame = lambda r, c: r in (0, 3) or c in (0, 3)
    upon(g, 7.0 * side + np.linspace(-2.6, 2.6, 5), np.linspace(119, 124, 5), 3 * GAP, f"buckle_{side}", is_frame)


def belt_loop(g, number, angle):
    y = np.linspace(98.5, 105, 4)
    a = angle + np.array([[-0.055], [0.055]])
    points = np.stack(np.broadcast_arrays(18 * np.sin(a), y, 12 * np.cos(a)), -1)
    rows = g.form.project(points.reshape(-1, 3), 2 * GAP).reshape(2, 4, 3).transpose(1, 0, 2)
    g.grid(list(g.add(rows, fixed=True)), f"loop_{number}")


def pocket(g):
    upon(g, np.linspace(-4.2, 4.2, 5), np.linspace(108, 118, 5), 2 * GAP, "pocket")
