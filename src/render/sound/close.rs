//! Which children of a cage's faces may cross once they are refined again.

use super::cross::{ACROSS, Way, meeting};
use super::lanes::{Boxes, each};
use super::piece::{Cell, LANES, Piece};
use super::skin::Skin;
use super::tree::{Bounds, Tree};
use crate::mesh::FaceId;
use glam::Vec3;
use rayon::prelude::*;

/// Part of its size that a face may move in any case. More looks at more faces.
const LEAST: f32 = 1e-4;

/// A face and the number of one of its children.
pub type ChildOf = (FaceId, usize);

/// How far the next refinement moves a face's children.
struct Step {
    /// How far it moves the centre, and other points no further as a rule.
    centre: Vec3,
    /// How far anything may move in any case.
    least: f32,
}

impl Step {
    /// The box of a face with the way that it may move.
    fn bounds(&self, piece: &Piece) -> Bounds {
        piece.bounds.swept(self.centre).grown(self.least)
    }

    /// How the face may move, seen from another.
    fn way(&self, other: &Self) -> Way {
        // Layers move together: only the difference counts.
        Way { by: self.centre - other.centre, least: self.least + other.least }
    }
}

/// What is near each other on the next refinement.
pub struct Nearness {
    /// How far the next refinement moves each face of a skin.
    steps: Vec<Step>,
    /// The boxes of the faces with the way that they may move.
    tree: Tree,
}

impl Nearness {
    /// What is near each other of a skin.
    pub fn new(skin: &Skin) -> Self {
        let steps: Vec<Step> = skin.pieces.par_iter().map(|piece| skin.next_step(piece)).collect();
        let tree = Tree::new(steps.len(), |place| steps[place].bounds(&skin.pieces[place]));
        Self { steps, tree }
    }

    /// Follows faces of the skin that have moved.
    pub fn update(&mut self, skin: &Skin, moved: &[FaceId]) {
        let mut places: Vec<usize> = moved.iter().map(|&face| skin.place(face)).collect();
        places.sort_unstable();
        places.iter().for_each(|&place| self.steps[place] = skin.next_step(&skin.pieces[place]));
        self.tree.refit(&places, |place| self.steps[place].bounds(&skin.pieces[place]));
    }

    /// Children that may cross on the next refinement, one of each pair in a face that is active.
    pub fn close(&self, skin: &Skin, active: &[FaceId]) -> Vec<[ChildOf; 2]> {
        let (pieces, steps) = (&skin.pieces, &self.steps);
        let active: Vec<usize> = active.iter().map(|&face| skin.place(face)).collect();
        let way = |a: usize, b: usize| steps[a].way(&steps[b]);
        let pairs = self.tree.pairs(&active, |a, b| skin.may_come_close(&pieces[a], &pieces[b], &way(a, b)));
        let children = |&[a, b]: &[usize; 2]| skin.close_children(&pieces[a], &pieces[b], &way(a, b));
        pairs.par_iter().flat_map_iter(children).collect()
    }
}

impl Skin<'_> {
    fn next_step(&self, piece: &Piece) -> Step {
        // Catmull and Clark's mask of a vertex, at the centre of the face.
        let (valence, centre) = (piece.valence as f32, piece.cell.centre);
        let (mut faces, mut edges) = (Vec3::ZERO, Vec3::ZERO);
        for cell in self.cells(piece) {
            for child in each(cell.all()) {
                let [corner, middle, _, before] = cell.quad(child);
                faces += 0.25 * (corner + middle + centre + before);
                edges += 0.5 * (centre + middle);
            }
        }
        let next = ((faces + 2.0 * edges) / valence + (valence - 3.0) * centre) / valence;
        Step { centre: next - centre, least: LEAST * (piece.bounds.high - piece.bounds.low).max_element() }
    }

    fn may_come_close(&self, f: &Piece, g: &Piece, way: &Way) -> bool {
        if f.face == g.face {
            return self.may_cross_itself(f);
        }
        if self.touch(f, g) {
            return f.is_loose && g.is_loose && f.normal.dot(g.normal) < ACROSS && !self.are_sound_beside(f, g);
        }
        !self.is_apart(f, g, way) && !self.is_apart(g, f, &way.back()) && !self.are_beside(f, g)
    }

    fn close_children(&self, f: &Piece, g: &Piece, way: &Way) -> Vec<[ChildOf; 2]> {
        let boxes: Vec<Boxes> = self.cells(g).map(Cell::boxes).collect();
        let mut found = Vec::new();
        for (m, a) in self.cells(f).enumerate() {
            let of_a = a.boxes();
            for i in each(a.all()) {
                let (own, quad, normal) = ((f.face, LANES * m + i), a.quad(i), a.normals.at(i));
                let there = Boxes::splat(&of_a.at(i).swept(way.by).grown(way.least));
                for (n, b) in self.cells(g).enumerate() {
                    let near = boxes[n].that_meet(&there) & b.all() & meeting(&quad, normal, b, way);
                    found.extend(each(near).map(|j| [own, (g.face, LANES * n + j)]));
                }
            }
        }
        found.retain(|[a, b]| f.face != g.face || a < b);
        found
    }
}
