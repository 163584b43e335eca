"""Catmull-Clark subdivision in numpy, written from the rules that OpenUSD and OpenSubdiv publish.

The tests compare what usdtailor writes with this second implementation, which shares no code and no numbering with it.
It covers semi-sharp and infinite creases and corners, the three boundary rules, n-gons, the smooth triangle rule,
non-manifold edges and vertices, varying values and the six face-varying rules.

Faces are numbered as OpenSubdiv does: children of face 0 in the order of its corners, then those of face 1, and so on. The
child at corner j of a quad keeps that corner as its own corner j; children of other faces begin with it. Vertices are
numbered in a way of its own: compare by corners, or by `match_vertices`.
"""

from dataclasses import dataclass, field

import numpy as np

INFINITE = 10.0


@dataclass
class Cage:
    """Topology and sharpness at one level. Boundary edges, and what else the rules pin, are already infinitely sharp."""

    counts: np.ndarray
    verts: np.ndarray  # vertex of each corner
    vertex_count: int
    edge_sharpness: np.ndarray | None = None
    vertex_sharpness: np.ndarray | None = None
    smooth_triangles: bool = False
    linear: bool = False
    # A vertex that becomes sharp as another does, -1 for none, and the sharpness of the cuts that meet there. Only
    # face-varying channels have such.
    dependent: np.ndarray | None = None
    lingering: np.ndarray | None = None

    def __post_init__(self):
        self.counts = np.asarray(self.counts, dtype=np.int64)
        self.verts = np.asarray(self.verts, dtype=np.int64)
        self.offsets = np.concatenate([[0], np.cumsum(self.counts)])
        corners = np.arange(len(self.verts))
        self.corner_face = np.repeat(np.arange(len(self.counts)), self.counts)
        first, last = self.offsets[:-1][self.corner_face], self.offsets[1:][self.corner_face] - 1
        self.next_corner = np.where(corners == last, first, corners + 1)
        self.previous_corner = np.where(corners == first, last, corners - 1)
        ends = np.stack([self.verts, self.verts[self.next_corner]], axis=1)
        self.forward = ends[:, 0] < ends[:, 1]
        # corner c is where edge corner_edge[c] of its face starts
        keys = np.min(ends, axis=1) * max(self.vertex_count, 1) + np.max(ends, axis=1)
        unique, self.corner_edge = np.unique(keys, return_inverse=True)
        self.edges = np.stack(np.divmod(unique, max(self.vertex_count, 1)), axis=1)
        self.edge_faces = np.bincount(self.corner_edge, minlength=len(self.edges))
        if self.edge_sharpness is None:
            self.edge_sharpness = np.zeros(len(self.edges))
        if self.vertex_sharpness is None:
            self.vertex_sharpness = np.zeros(self.vertex_count)
        if self.dependent is None:
            self.dependent = np.full(self.vertex_count, -1)
        if self.lingering is None:
            self.lingering = np.zeros(self.vertex_count)

    @property
    def face_count(self):
        return len(self.counts)

    def edge_ids(self, pairs):
        """The edge of each pair of vertices; -1 where there is none."""
        pairs = np.sort(np.asarray(pairs, dtype=np.int64).reshape(-1, 2), axis=1)
        keys = self.edges[:, 0] * self.vertex_count + self.edges[:, 1]
        wanted = pairs[:, 0] * self.vertex_count + pairs[:, 1]
        at = np.minimum(np.searchsorted(keys, wanted), max(len(keys) - 1, 0))
        return np.where(keys[at] == wanted, at, -1) if len(keys) else np.full(len(pairs), -1)

    def non_manifold_edges(self):
        """Edges of more than two faces, or of two that run along it in the same direction."""
        forward = np.bincount(self.corner_edge, weights=self.forward, minlength=len(self.edges))
        return (self.edge_faces > 2) | ((self.edge_faces == 2) & (forward != 1)) | (self.edges[:, 0] == self.edges[:, 1])

    def fans(self):
        """For each vertex the number of groups of faces that hang together around it by edges."""
        roots = np.unique(self.corner_groups(np.ones(len(self.edges), bool)))
        return np.bincount(self.verts[roots], minlength=self.vertex_count)

    def corner_groups(self, joining):
        """The first of the corners that hang together around a vertex by the edges that join."""
        parent = np.arange(len(self.verts))

        def root(corner):
            while parent[corner] != corner:
                parent[corner] = parent[parent[corner]]
                corner = parent[corner]
            return corner

        order = np.argsort(self.corner_edge, kind="stable")
        starts = np.concatenate([[0], np.cumsum(self.edge_faces)])
        for edge in np.flatnonzero((self.edge_faces >= 2) & joining):
            sides = order[starts[edge] : starts[edge + 1]]
            for other in sides[1:]:
                for a in (sides[0], self.next_corner[sides[0]]):
                    for b in (other, self.next_corner[other]):
                        if self.verts[a] == self.verts[b]:
                            parent[root(a)] = root(b)
        return np.array([root(corner) for corner in range(len(parent))], dtype=int)

    def non_manifold_vertices(self):
        """The ends of non-manifold edges, and vertices where faces meet that share no edge there."""
        found = self.fans() > 1
        found[self.edges[self.non_manifold_edges()].ravel()] = True
        return found

    def inside_a_line_of_fins(self, vertex):
        """Whether two non-manifold edges meet here and each sheet of faces runs from the one to the other."""
        around = np.flatnonzero((self.edges == vertex).any(axis=1))
        odd = around[self.non_manifold_edges()[around]]
        rest = np.setdiff1d(around, odd)
        if len(odd) != 2 or (self.edge_faces[rest] != 2).any() or self.edge_faces[odd[0]] != self.edge_faces[odd[1]]:
            return False
        corners = np.flatnonzero(self.verts == vertex)
        if len(corners) <= len(around):
            return False
        joining = np.zeros(len(self.edges), bool)
        joining[rest] = True
        groups = self.corner_groups(joining)[corners]
        ends = np.stack([self.corner_edge[corners], self.corner_edge[self.previous_corner[corners]]], axis=1)
        return all(sorted(ends[groups == group][np.isin(ends[groups == group], odd)]) == sorted(odd) for group in np.unique(groups))


def cage(
    counts,
    indices,
    vertex_count,
    creases=None,
    corners=None,
    boundary="edgeAndCorner",
    triangles="catmullClark",
    scheme="catmullClark",
):
    """The cage of a mesh: `creases` maps pairs of vertices to sharpness, `corners` maps vertices to sharpness."""
    made = Cage(counts, indices, vertex_count, smooth_triangles=triangles == "smooth", linear=scheme == "bilinear")
    for pair, sharpness in (creases or {}).items():
        made.edge_sharpness[made.edge_ids([pair])] = np.clip(sharpness, 0, INFINITE)
    for vertex, sharpness in (corners or {}).items():
        made.vertex_sharpness[vertex] = np.clip(sharpness, 0, INFINITE)
    odd_edges = made.non_manifold_edges()
    borders = made.edge_faces == 1
    made.edge_sharpness[borders | odd_edges] = INFINITE

    faces = np.bincount(made.verts, minlength=vertex_count)
    edges = np.bincount(made.edges.ravel(), minlength=vertex_count)
    if boundary == "edgeAndCorner":
        made.vertex_sharpness[(faces == 1) & (edges == 2)] = INFINITE
    # Fins that meet in one line keep a smooth line; any other meeting is a fixed point.
    held = [vertex for vertex in np.flatnonzero(made.non_manifold_vertices()) if not made.inside_a_line_of_fins(vertex)]
    made.vertex_sharpness[held] = INFINITE
    return made


def _decay(sharpness):
    """Sharpness one level further."""
    return np.where(sharpness >= INFINITE, INFINITE, np.maximum(sharpness - 1, 0))


SMOOTH, CREASE, CORNER = 0, 2, 3


def _rule(vertex_sharpness, sharp_edges):
    """A vertex with one sharp edge, a dart, is smooth."""
    return np.where((vertex_sharpness > 0) | (sharp_edges > 2), CORNER, np.where(sharp_edges == 2, CREASE, SMOOTH))


def _columns(values):
    values = np.asarray(values, dtype=float)
    return values.reshape(len(values), -1)


class Refinement:
    """One level: the parent cage, the child cage, and how values and elements pass from the one to the other."""

    def __init__(self, parent):
        self.parent = parent
        p = parent
        self.edge_vertex = p.vertex_count + np.arange(len(p.edges))
        self.face_vertex = p.vertex_count + len(p.edges) + np.arange(p.face_count)
        self.parent_face = p.corner_face
        self._sharpness()
        self.child = self._child()

    def _sharpness(self):
        p = self.parent
        v = p.vertex_count
        now, then = p.edge_sharpness, _decay(p.edge_sharpness)
        vertex_now, vertex_then = p.vertex_sharpness, _decay(p.vertex_sharpness)
        self.child_vertex_sharpness, self.child_edge_sharpness = vertex_then, then

        def around(selected):
            return np.bincount(p.edges.ravel(), weights=np.repeat(selected.astype(float), 2), minlength=v)

        rule_now, rule_then = _rule(vertex_now, around(now > 0)), _rule(vertex_then, around(then > 0))
        ending = (now > 0) & (then == 0)
        count = around(ending) + ((vertex_now > 0) & (vertex_then == 0))
        total = np.bincount(p.edges.ravel(), weights=np.repeat(np.where(ending, now, 0), 2), minlength=v)
        total += np.where((vertex_now > 0) & (vertex_then == 0), vertex_now, 0)
        share = np.minimum(1, np.divide(total, count, out=np.zeros(v), where=count > 0))
        # How much of the mask is the parent's rule; the rest is the child's.
        self.share = np.where((rule_now == rule_then) | (rule_now == SMOOTH), 1.0, share)
        self.rule_now, self.rule_then = rule_now, rule_then
        corner = np.where(rule_now == CORNER, self.share, 0) + np.where(rule_then == CORNER, 1 - self.share, 0)
        self.forced = np.where(p.dependent >= 0, corner[p.dependent], 0)
        # OpenSubdiv keeps such a vertex sharp, when the other is no more, for as long as anything at the point is.
        lingers = (p.dependent >= 0) & (rule_then[p.dependent] != CORNER) & (_decay(p.lingering) > 0)
        self.forced[lingers] = 1
        lonely = np.bincount(p.verts, minlength=v) == 0
        self.forced[lonely] = 1

    def _child(self):
        p = self.parent
        at_edge, at_face = self.edge_vertex[p.corner_edge], self.face_vertex[p.corner_face]
        before = self.edge_vertex[p.corner_edge[p.previous_corner]]
        quads = np.stack([p.verts, at_edge, at_face, before], axis=1)
        turn = np.where(p.counts[p.corner_face] == 4, np.arange(len(p.verts)) - p.offsets[p.corner_face], 0)
        quads = quads[np.arange(len(quads))[:, None], (np.arange(4)[None, :] - turn[:, None]) % 4]
        count = p.vertex_count + len(p.edges) + p.face_count
        child = Cage(
            np.full(len(quads), 4),
            quads.ravel(),
            count,
            vertex_sharpness=np.concatenate([self.child_vertex_sharpness, np.zeros(count - p.vertex_count)]),
            smooth_triangles=p.smooth_triangles,
            linear=p.linear,
            dependent=np.concatenate([p.dependent, np.full(count - p.vertex_count, -1)]),
            lingering=np.concatenate([_decay(p.lingering), np.zeros(count - p.vertex_count)]),
        )
        self.child_edges = np.stack([child.edge_ids(np.stack([p.edges[:, i], self.edge_vertex], axis=1)) for i in (0, 1)], axis=1)
        child.edge_sharpness[self.child_edges] = self.child_edge_sharpness[:, None]
        return child

    def _face_points(self, values):
        p = self.parent
        sums = np.zeros((p.face_count, values.shape[1]))
        np.add.at(sums, p.corner_face, values[p.verts])
        return sums / p.counts[:, None]

    def linear(self, values):
        """Values of the child's vertices by the rule for varying values."""
        values = _columns(values)
        return np.concatenate([values, values[self.parent.edges].mean(axis=1), self._face_points(values)])

    def smooth(self, values):
        """Values of the child's vertices by the rule for points."""
        if self.parent.linear:
            return self.linear(values)
        values = _columns(values)
        faces = self._face_points(values)
        return np.concatenate([self._vertex_points(values, faces), self._edge_points(values, faces), faces])

    def _edge_points(self, values, faces):
        p = self.parent
        weight = np.where((p.counts == 3) & p.smooth_triangles, 0.470, 0.25)
        around = np.zeros((len(p.edges), values.shape[1]))
        np.add.at(around, p.corner_edge, faces[p.corner_face])
        of_faces = np.bincount(p.corner_edge, weights=weight[p.corner_face], minlength=len(p.edges)) / 2
        ends = values[p.edges]
        smooth = of_faces[:, None] * around + (0.5 - of_faces)[:, None] * ends.sum(axis=1)
        sharp = np.clip(p.edge_sharpness, 0, 1)[:, None]
        return (1 - sharp) * smooth + sharp * ends.mean(axis=1)

    def _vertex_points(self, values, faces):
        p = self.parent
        v, width = p.vertex_count, values.shape[1]

        def far_ends(selected):
            sums = np.zeros((v, width))
            for here, there in ((0, 1), (1, 0)):
                np.add.at(sums, p.edges[selected, here], values[p.edges[selected, there]])
            return sums

        valence = np.maximum(np.bincount(p.edges.ravel(), minlength=v), 1)[:, None]
        around = np.zeros((v, width))
        np.add.at(around, p.verts, faces[p.corner_face])
        smooth = values * (valence - 2) / valence + (far_ends(np.ones(len(p.edges), bool)) + around) / valence**2
        masks = {
            "now": 0.75 * values + 0.125 * far_ends(p.edge_sharpness > 0),
            "then": 0.75 * values + 0.125 * far_ends(self.child_edge_sharpness > 0),
        }

        def by(rule, crease):
            return np.where((rule == CORNER)[:, None], values, np.where((rule == CREASE)[:, None], crease, smooth))

        share = self.share[:, None]
        mixed = share * by(self.rule_now, masks["now"]) + (1 - share) * by(self.rule_then, masks["then"])
        forced = self.forced[:, None]
        return (1 - forced) * mixed + forced * values


@dataclass
class Channel:
    """Face-varying values: a cage of its own, whose vertices are the pairs of a vertex and a value index that occur."""

    cage: Cage
    value_index: np.ndarray  # value of each channel vertex
    mode: str = "cornersPlus1"
    refinements: list = field(default_factory=list)


def channel(base, indices, mode):
    """The channel of face-varying `indices` over the level-0 cage `base`."""
    indices = np.asarray(indices, dtype=np.int64)
    width = indices.max(initial=0) + 1
    unique, first, corners = np.unique(base.verts * width + indices, return_index=True, return_inverse=True)
    vertex_of, value_of = np.divmod(unique, width)
    made = Cage(
        base.counts,
        corners,
        len(unique),
        vertex_sharpness=base.vertex_sharpness[vertex_of].copy(),
        smooth_triangles=base.smooth_triangles,
        linear=base.linear or mode == "all",
    )
    sample = np.zeros(len(made.edges), dtype=np.int64)
    sample[made.corner_edge] = np.arange(len(made.verts))
    base_edge = base.corner_edge[sample]
    inside = base.edge_sharpness[base_edge].copy()
    cut = made.edge_faces < base.edge_faces[base_edge]
    made.edge_sharpness = np.where(cut, INFINITE, inside)
    border = made.edge_faces == 1
    pinned = _pinned(base, made, vertex_of, cut, border, np.where(border, 0, inside), mode)
    made.vertex_sharpness[pinned] = INFINITE
    return Channel(made, value_of, mode)


def _pinned(base, made, vertex_of, cut, border, inside, mode):
    """Which channel vertices the linear-interpolation rule makes corners; sets `made.dependent` on the way."""
    count = made.vertex_count
    borders = np.bincount(made.edges[border].ravel(), minlength=count)
    faces = np.bincount(made.verts, minlength=count)
    siblings = np.bincount(vertex_of, minlength=base.vertex_count)[vertex_of]
    odd, cut_at = base.non_manifold_vertices(), np.zeros(base.vertex_count, bool)
    cut_at[vertex_of[np.unique(made.edges[cut])]] = True
    cut_at |= np.bincount(vertex_of, minlength=base.vertex_count) > 1
    pinned = (odd & cut_at)[vertex_of]
    pinned |= (made.fans() > 1) & ~odd[vertex_of]  # one value in regions that meet in a point only
    if mode == "none":
        return pinned
    pinned |= (faces == 1) & (borders > 0)
    if mode == "boundaries":
        return pinned | (borders > 0)
    if mode in ("cornersPlus1", "cornersPlus2"):
        pinned |= siblings > 2
        _depend(base, made, vertex_of, siblings, inside, pinned, mode)
    if mode == "cornersPlus2":
        on_border = np.zeros(base.vertex_count, bool)
        on_border[base.edges[base.edge_faces == 1].ravel()] = True
        pinned |= (siblings == 1) & (borders > 0) & ~on_border[vertex_of]  # darts
    return pinned


def _depend(base, made, vertex_of, siblings, inside, pinned, mode):
    """Of two values at a vertex, what sharpens one sharpens the other."""
    infinite = np.bincount(made.edges[inside >= INFINITE].ravel(), minlength=made.vertex_count) > 0
    semi = np.bincount(made.edges[(inside > 0) & (inside < INFINITE)].ravel(), minlength=made.vertex_count) > 0
    finite = np.where(base.edge_sharpness < INFINITE, base.edge_sharpness, 0)
    sharpest = np.zeros(base.vertex_count)
    np.maximum.at(sharpest, base.edges, finite[:, None])
    faces = np.bincount(made.verts, minlength=made.vertex_count)
    disjoint = pinned & (made.fans() > 1)
    for a in np.flatnonzero(siblings == 2):
        (b,) = (x for x in np.flatnonzero(vertex_of == vertex_of[a]) if x != a)
        if infinite[a] or infinite[b] or disjoint[a] or disjoint[b]:
            pinned[a] = True
        elif mode == "cornersPlus2" and (faces[a] == 1 or faces[b] == 1):
            pinned[a] = True
        elif semi[b] and not semi[a] and base.vertex_sharpness[vertex_of[a]] == 0:
            made.dependent[a], made.lingering[a] = b, sharpest[vertex_of[a]]


class Subdivision:
    """A cage refined `levels` times."""

    def __init__(self, base, levels):
        self.base = base
        self.refinements = _chain(base, levels)
        self.cage = self.refinements[-1].child if levels else base

    @property
    def levels(self):
        return len(self.refinements)

    def vertex(self, values):
        """Points and vertex primvars; values of several numbers are flattened to rows."""
        values = _columns(values)
        for refinement in self.refinements:
            values = refinement.smooth(values)
        return values

    def varying(self, values):
        values = _columns(values)
        for refinement in self.refinements:
            values = refinement.linear(values)
        return values

    def face_varying(self, values, indices, mode):
        """A row for each corner, and the index of its channel vertex, by which cuts are reported."""
        values = _columns(values)
        own = channel(self.base, indices, mode)
        values = values[own.value_index]
        last = own.cage
        for refinement in _chain(own.cage, self.levels):
            values, last = refinement.smooth(values), refinement.child
        return values[last.verts], last.verts

    def parent_face(self):
        """The face of the base that each face came from."""
        parents = np.arange(self.base.face_count)
        for refinement in self.refinements:
            parents = parents[refinement.parent_face]
        return parents

    def edge_children(self, edges):
        """The edges that edges of the base became."""
        edges = np.asarray(edges, dtype=np.int64).ravel()
        for refinement in self.refinements:
            edges = refinement.child_edges[edges].ravel()
        return edges

    def parent_edge(self):
        """The edge of the base that each edge came from, -1 for edges inside faces."""
        parents = np.arange(len(self.base.edges))
        for refinement in self.refinements:
            child = np.full(len(refinement.child.edges), -1)
            child[refinement.child_edges] = parents[:, None]
            parents = child
        return parents

    def remaining(self, sharpness):
        """Sharpness after all levels."""
        for _ in self.refinements:
            sharpness = float(_decay(np.float64(sharpness)))
        return sharpness


def _chain(base, levels):
    chain = []
    for _ in range(levels):
        chain.append(Refinement(chain[-1].child if chain else base))
    return chain


def match_vertices(ours, theirs):
    """For each of our vertices the vertex that another mesh of the same faces and corners has there; -1 if unused.

    Fails when the two disagree on which corners share a vertex.
    """
    ours, theirs = np.asarray(ours), np.asarray(theirs)
    assert len(ours) == len(theirs), f"{len(theirs)} face vertices, expected {len(ours)}"
    forth = np.full(ours.max(initial=-1) + 1, -1)
    forth[ours] = theirs
    back = np.full(theirs.max(initial=-1) + 1, -1)
    back[theirs] = ours
    split, joined = np.flatnonzero(forth[ours] != theirs), np.flatnonzero(back[theirs] != ours)
    assert len(split) == 0, f"{len(split)} corners are cut from their vertex, first face vertex {split[0]}"
    assert len(joined) == 0, f"{len(joined)} corners are joined to another vertex, first face vertex {joined[0]}"
    return forth
