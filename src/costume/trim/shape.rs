//! The shape of a trim: its pieces, how stiff they are, and their places on cloth.

use super::TrimMode;
use crate::binding::{BindSurface, Binding, Triangles};
use glam::Vec3;
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};
use tailor_mesh::connectivity::{Groups, VertexId};

/// Largest piece that is rigid however thin it is. \[sizes of the garment\]
const SMALL: f32 = 0.06;
/// Largest piece that is rigid for its thickness. \[sizes of the garment\]
const LARGEST_RIGID: f32 = 0.25;
/// Least mean thickness of a closed surface that does not bend with cloth. \[sizes of the piece\]
const THICK: f32 = 0.03;

/// The points of a trim and its pieces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrimShape {
    /// Its points.
    pub points: Vec<Vec3>,
    /// Its pieces, which have all points between them.
    pub pieces: Vec<Piece>,
}

/// A connected part of a trim.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Piece {
    /// Numbers of its points.
    pub points: Vec<u32>,
    /// Diagonal of its bounding box. \[mesh units\]
    pub size: f32,
    /// Mean thickness of a closed surface, twice its volume by its area; 0 of an open one. \[mesh units\]
    pub thickness: f32,
}

/// Why a piece is rigid or soft by default.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stiffness {
    /// It is small beside the garment.
    Small,
    /// It is closed and thick.
    Thick,
    /// It is neither.
    Supple,
}

impl Stiffness {
    /// Whether a piece of this kind moves as a whole.
    fn is_rigid(self, mode: TrimMode) -> bool {
        match mode {
            TrimMode::Rigid => true,
            TrimMode::Auto => self != Self::Supple,
            TrimMode::Soft | TrimMode::None => false,
        }
    }

    /// In words.
    fn in_words(self) -> &'static str {
        match self {
            Self::Small => "small",
            Self::Thick => "closed and thick",
            Self::Supple => "large and thin",
        }
    }
}

impl Piece {
    /// Whether it bends with cloth, on a garment of this size. \[mesh units\]
    pub fn stiffness(&self, garment: f32) -> Stiffness {
        if self.size <= SMALL * garment {
            Stiffness::Small
        } else if self.size <= LARGEST_RIGID * garment && self.thickness >= THICK * self.size {
            Stiffness::Thick
        } else {
            Stiffness::Supple
        }
    }

    fn centre(&self, points: &[Vec3]) -> Vec3 {
        let [low, high] = bounds(self.points.iter().map(|&p| points[p as usize]));
        0.5 * low + 0.5 * high
    }
}

impl TrimShape {
    /// The shape of a mesh whose faces have `counts` of `corners`, each a vertex among `points`. Points at one place are of one piece,
    /// as files without shared vertices have several.
    pub fn of_mesh(points: Vec<Vec3>, counts: &[usize], corners: &[u32]) -> Self {
        let surface = Surface { counts, corners, place: places(&points) };
        let mut groups = Groups::<VertexId>::new(points.len());
        surface.place.iter().enumerate().for_each(|(point, &first)| {
            groups.join(VertexId::new(first), VertexId::new(point));
        });
        for pair in faces(counts, corners).flat_map(|face| face.windows(2)) {
            groups.join(VertexId::new(pair[0] as usize), VertexId::new(pair[1] as usize));
        }
        let of: Vec<usize> = (0..points.len()).map(|point| groups.first(VertexId::new(point)).index()).collect();
        let mut shape = Self::grouped(points, of.into_iter());
        let thicknesses = surface.thicknesses(&shape);
        shape.pieces.iter_mut().zip(thicknesses).for_each(|(piece, thickness)| piece.thickness = thickness);
        shape
    }

    /// The shape of parts with so many points each, one after the other: curves, or points by themselves.
    pub fn of_parts(points: Vec<Vec3>, sizes: impl IntoIterator<Item = usize>) -> Self {
        let count = points.len();
        let all = sizes.into_iter().enumerate().flat_map(|(part, size)| std::iter::repeat_n(part, size));
        let of: Vec<usize> = all.take(count).collect();
        // Points beyond the parts are a part each.
        Self::grouped(points, (0..count).map(|i| of.get(i).copied().unwrap_or(count + i)))
    }

    /// The diagonal of its bounding box. \[mesh units\]
    pub fn size(&self) -> f32 {
        let [low, high] = bounds(self.points.iter().copied());
        low.distance(high)
    }

    /// The shape with its points elsewhere, as many times as large.
    #[must_use]
    pub fn with_points(&self, points: Vec<Vec3>, scale: f32) -> Self {
        let scaled = |piece: &Piece| Piece {
            points: piece.points.clone(),
            size: scale * piece.size,
            thickness: scale * piece.thickness,
        };
        Self { points, pieces: self.pieces.iter().map(scaled).collect() }
    }

    /// Points in pieces: those with one number in `of`.
    fn grouped(points: Vec<Vec3>, of: impl Iterator<Item = usize>) -> Self {
        let mut pieces: Vec<Piece> = Vec::new();
        let mut number_of = HashMap::new();
        for (point, group) in of.take(points.len()).enumerate() {
            let number = *number_of.entry(group).or_insert(pieces.len());
            if number == pieces.len() {
                pieces.push(Piece::default());
            }
            pieces[number].points.push(point as u32);
        }
        for piece in &mut pieces {
            let [low, high] = bounds(piece.points.iter().map(|&p| points[p as usize]));
            piece.size = low.distance(high);
        }
        Self { points, pieces }
    }

    /// The distance of the cloth from its points, on average. \[mesh units\]
    pub fn distance(&self, cloth: &BindSurface) -> f32 {
        let distances: Vec<f32> = self.points.par_iter().map(|&point| cloth.distance(point)).collect();
        distances.iter().sum::<f32>() / distances.len().max(1) as f32
    }

    /// Whether each piece has a point within its own size, or within `reach`, of cloth. \[mesh units\]
    pub fn is_near(&self, cloth: &Triangles, reach: f32) -> bool {
        self.pieces.iter().all(|piece| {
            let reach = piece.size.max(reach);
            piece.points.iter().any(|&point| cloth.distance(self.points[point as usize]) <= reach)
        })
    }

    /// How it rides on a garment of the size `garment`. \[mesh units\]
    pub fn ride(&self, mode: TrimMode, garment: f32) -> Ride {
        let mut ride = Ride { mode, kinds: BTreeMap::new(), gap: 0.0 };
        self.pieces.iter().for_each(|piece| *ride.kinds.entry(piece.stiffness(garment)).or_default() += 1);
        ride
    }

    /// The places of its points on cloth of a garment of the size `garment` \[mesh units\], and how it rides there.
    pub fn bound(&self, mode: TrimMode, cloth: &BindSurface, garment: f32) -> (Binding, Ride) {
        let count = self.points.len();
        let mut binding = Binding { faces: vec![0; count], coords: vec![Vec3::ZERO; count] };
        let place = |piece: &Piece| -> Vec<(u32, Vec3)> {
            let is_rigid = piece.stiffness(garment).is_rigid(mode);
            let centre = is_rigid.then(|| cloth.nearest(piece.centre(&self.points)));
            let of_point = |&point: &u32| {
                let at = self.points[point as usize];
                let (face, weights) = centre.unwrap_or_else(|| cloth.nearest(at));
                (face.index() as u32, cloth.coords(face, weights, at))
            };
            piece.points.par_iter().map(of_point).collect()
        };
        let places: Vec<_> = self.pieces.par_iter().map(place).collect();
        for (piece, places) in self.pieces.iter().zip(places) {
            for (&point, (face, coords)) in piece.points.iter().zip(places) {
                (binding.faces[point as usize], binding.coords[point as usize]) = (face, coords);
            }
        }
        let distance = |&point: &u32| cloth.distance(self.points[point as usize]);
        let gap = |piece: &Piece| piece.points.par_iter().map(distance).reduce(|| f32::INFINITY, f32::min);
        let gap = self.pieces.par_iter().map(gap).reduce(|| 0.0, f32::max);
        (binding, Ride { gap, ..self.ride(mode, garment) })
    }
}

/// How the pieces of a trim ride on cloth.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ride {
    mode: TrimMode,
    /// The number of pieces of each kind.
    kinds: BTreeMap<Stiffness, usize>,
    /// The distance of the cloth from the nearest point of the piece that is farthest away. \[mesh units\]
    pub gap: f32,
}

impl Ride {
    /// The number of pieces.
    pub fn pieces(&self) -> usize {
        self.kinds.values().sum()
    }

    /// The number of pieces that move as a whole.
    pub fn rigid(&self) -> usize {
        self.kinds.iter().filter(|(kind, _)| kind.is_rigid(self.mode)).map(|(_, count)| count).sum()
    }

    /// Pieces, modes and reasons in words, such as `6 rigid pieces (small)`.
    pub fn in_words(&self) -> String {
        let what = |count: usize| if count == 1 { "piece" } else { "pieces" };
        let kind = |(kind, count): (&Stiffness, &usize)| {
            let mode = if kind.is_rigid(self.mode) { "rigid" } else { "soft" };
            format!("{count} {mode} {} ({})", what(*count), kind.in_words())
        };
        let (rigid, all) = (self.rigid(), self.pieces());
        match self.mode {
            TrimMode::Auto => self.kinds.iter().map(kind).collect::<Vec<_>>().join(", "),
            TrimMode::None => "stays where it is".to_owned(),
            TrimMode::Rigid | TrimMode::Soft => {
                format!("{all} {} {}", if rigid > 0 { "rigid" } else { "soft" }, what(all))
            }
        }
    }
}

/// The first point at the place of each point.
fn places(points: &[Vec3]) -> Vec<usize> {
    let mut first_at = HashMap::with_capacity(points.len());
    // Positive and negative zero are one place.
    let key = |point: &Vec3| (*point + Vec3::ZERO).to_array().map(f32::to_bits);
    points.iter().enumerate().map(|(number, point)| *first_at.entry(key(point)).or_insert(number)).collect()
}

/// The faces with `counts` of `corners`, as far as there are corners.
pub fn faces<'a>(counts: &'a [usize], corners: &'a [u32]) -> impl Iterator<Item = &'a [u32]> {
    let mut rest = corners;
    counts.iter().map_while(move |&count| {
        let (face, behind) = rest.split_at_checked(count)?;
        rest = behind;
        Some(face)
    })
}

/// The faces of a mesh, which may have faults.
struct Surface<'a> {
    counts: &'a [usize],
    corners: &'a [u32],
    /// The first point at the place of each point.
    place: Vec<usize>,
}

impl Surface<'_> {
    /// The mean thickness of each piece; 0 where an edge has other than two faces.
    fn thicknesses(&self, shape: &TrimShape) -> Vec<f32> {
        let TrimShape { points, pieces } = shape;
        let mut piece_of = vec![0; points.len()];
        for (number, piece) in pieces.iter().enumerate() {
            piece.points.iter().for_each(|&point| piece_of[point as usize] = number);
        }
        let mut faces_at = HashMap::<[usize; 2], u32>::new();
        let (mut volumes, mut areas) = (vec![0.0; pieces.len()], vec![0.0; pieces.len()]);
        for face in faces(self.counts, self.corners).filter(|face| !face.is_empty()) {
            for k in 0..face.len() {
                let mut edge = [face[k], face[(k + 1) % face.len()]].map(|v| self.place[v as usize]);
                edge.sort_unstable();
                *faces_at.entry(edge).or_default() += 1;
            }
            let piece = piece_of[face[0] as usize];
            // From a point of the piece, so that far places lose no digits.
            let origin = points[pieces[piece].points[0] as usize];
            let at = |v: u32| (points[v as usize] - origin).as_dvec3();
            for pair in face.windows(2).skip(1) {
                let [a, b, c] = [face[0], pair[0], pair[1]].map(at);
                let normal = (b - a).cross(c - a);
                areas[piece] += 0.5 * normal.length();
                volumes[piece] += a.dot(normal) / 6.0;
            }
        }
        let mut is_open = vec![false; pieces.len()];
        faces_at.into_iter().filter(|(_, count)| *count != 2).for_each(|(edge, _)| is_open[piece_of[edge[0]]] = true);
        let thickness = |i: usize| if areas[i] > 0.0 { (2.0 * volumes[i].abs() / areas[i]) as f32 } else { 0.0 };
        (0..pieces.len()).map(|i| if is_open[i] { 0.0 } else { thickness(i) }).collect()
    }
}

fn bounds(points: impl Iterator<Item = Vec3>) -> [Vec3; 2] {
    let merged = points.map(|p| [p, p]).reduce(|[low, high], [p, _]| [low.min(p), high.max(p)]);
    merged.unwrap_or([Vec3::ZERO; 2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;

    const CUBE: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

    /// A box without shared vertices.
    fn slab(size: Vec3) -> TrimShape {
        let corner = |v: u32| size * vec3((v & 1) as f32, (v >> 1 & 1) as f32, (v >> 2 & 1) as f32);
        let points = CUBE.as_flattened().iter().map(|&v| corner(v)).collect();
        TrimShape::of_mesh(points, &[4; 6], &(0..24).collect::<Vec<_>>())
    }

    #[test]
    fn doubled_points_are_one_piece_and_its_thickness_is_that_of_its_solid() {
        let shape = slab(vec3(10.0, 8.0, 1.0));
        assert_eq!((shape.pieces.len(), shape.pieces[0].points.len()), (1, 24));
        let thickness = 2.0 * 80.0 / (2.0 * (80.0 + 10.0 + 8.0));
        assert!((shape.pieces[0].thickness - thickness).abs() < 1e-5);
        let open = TrimShape::of_mesh(shape.points, &[4; 5], &(0..20).collect::<Vec<_>>());
        assert_eq!(open.pieces[0].thickness, 0.0);
    }

    #[test]
    fn small_and_thick_pieces_are_stiff() {
        let piece = |size, garment| slab(size).pieces[0].stiffness(garment);
        assert_eq!(piece(vec3(1.0, 1.0, 0.2), 100.0), Stiffness::Small);
        assert_eq!(piece(vec3(8.0, 6.0, 1.0), 100.0), Stiffness::Thick);
        assert_eq!(piece(vec3(15.0, 15.0, 0.2), 100.0), Stiffness::Supple);
        assert_eq!(piece(vec3(60.0, 60.0, 30.0), 100.0), Stiffness::Supple);
    }

    #[test]
    fn parts_are_pieces_and_points_beyond_them_too() {
        let shape = TrimShape::of_parts(vec![Vec3::ZERO; 6], [2, 3]);
        let sizes: Vec<usize> = shape.pieces.iter().map(|piece| piece.points.len()).collect();
        assert_eq!(sizes, [2, 3, 1]);
        assert_eq!(TrimShape::of_parts(vec![Vec3::ZERO; 2], [usize::MAX, 3]).pieces.len(), 1);
    }
}
