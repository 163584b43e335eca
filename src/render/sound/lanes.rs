//! Points four at a time, in the lanes of vector registers.

use super::tree::Bounds;
use glam::{Vec3, Vec3A, Vec4, Vec4Swizzles};

/// A set of lanes, one bit each.
pub type Lanes = u32;

/// Four points or directions.
#[derive(Clone, Copy, Default)]
pub struct Four {
    x: Vec4,
    y: Vec4,
    z: Vec4,
}

impl Four {
    #[inline]
    pub fn new([a, b, c, d]: [Vec3; 4]) -> Self {
        Self { x: Vec4::new(a.x, b.x, c.x, d.x), y: Vec4::new(a.y, b.y, c.y, d.y), z: Vec4::new(a.z, b.z, c.z, d.z) }
    }

    /// One number everywhere.
    const fn all(number: f32) -> Self {
        Self { x: Vec4::splat(number), y: Vec4::splat(number), z: Vec4::splat(number) }
    }

    /// The same in all lanes.
    #[inline]
    pub fn splat(point: Vec3) -> Self {
        Self { x: Vec4::splat(point.x), y: Vec4::splat(point.y), z: Vec4::splat(point.z) }
    }

    #[inline]
    pub fn at(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    /// The points with the last one first.
    #[inline]
    pub fn rolled(&self) -> Self {
        Self { x: self.x.wxyz(), y: self.y.wxyz(), z: self.z.wxyz() }
    }

    #[inline]
    pub fn set(&mut self, lane: usize, point: Vec3) {
        (self.x[lane], self.y[lane], self.z[lane]) = (point.x, point.y, point.z);
    }

    #[inline]
    pub fn minus(&self, other: &Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }

    #[inline]
    pub fn plus(&self, other: &Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }

    /// The points in a frame.
    #[inline]
    pub fn within(&self, [x, y, z]: &[Vec3; 3]) -> Self {
        Self { x: self.dot(*x), y: self.dot(*y), z: self.dot(*z) }
    }

    /// Heights along one axis.
    #[inline]
    pub fn dot(&self, axis: Vec3) -> Vec4 {
        self.x * axis.x + self.y * axis.y + self.z * axis.z
    }

    /// Heights along an axis for each.
    #[inline]
    pub fn dots(&self, axes: &Self) -> Vec4 {
        self.x * axes.x + self.y * axes.y + self.z * axes.z
    }

    #[inline]
    pub fn cross(&self, other: &Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    /// Unit vectors, zero where there is no length.
    #[inline]
    pub fn normalize_or_zero(&self) -> Self {
        let squared = self.dots(self);
        let length = Vec4::new(squared.x.sqrt(), squared.y.sqrt(), squared.z.sqrt(), squared.w.sqrt());
        let is_long = length.cmpgt(Vec4::ZERO);
        let scale = Vec4::select(is_long, 1.0 / length, Vec4::ZERO);
        let scale = Vec4::select(scale.cmplt(Vec4::INFINITY), scale, Vec4::ZERO);
        Self { x: self.x * scale, y: self.y * scale, z: self.z * scale }
    }

    /// The lanes that have a point.
    #[inline]
    pub fn that_are(&self, point: Vec3) -> Lanes {
        let Self { x, y, z } = Self::splat(point);
        (self.x.cmpeq(x) & self.y.cmpeq(y) & self.z.cmpeq(z)).bitmask()
    }

    #[inline]
    fn min(&self, other: &Self) -> Self {
        Self { x: self.x.min(other.x), y: self.y.min(other.y), z: self.z.min(other.z) }
    }

    #[inline]
    fn max(&self, other: &Self) -> Self {
        Self { x: self.x.max(other.x), y: self.y.max(other.y), z: self.z.max(other.z) }
    }
}

/// Ranges along one axis, or an axis for each.
#[derive(Clone, Copy)]
pub struct Ranges {
    pub low: Vec4,
    pub high: Vec4,
}

impl Ranges {
    /// The ranges of values, lane by lane.
    #[inline]
    pub fn of([a, b, c, d]: [Vec4; 4]) -> Self {
        Self { low: a.min(b).min(c.min(d)), high: a.max(b).max(c.max(d)) }
    }

    /// The ranges with all that is within a distance of them.
    #[inline]
    pub fn grown(&self, by: f32) -> Self {
        Self { low: self.low - by, high: self.high + by }
    }

    /// The ranges with where moves take them.
    #[inline]
    pub fn swept(&self, by: Vec4) -> Self {
        Self { low: self.low + by.min(Vec4::ZERO), high: self.high + by.max(Vec4::ZERO) }
    }

    /// The lanes whose ranges have a value in common.
    #[inline]
    pub fn that_meet(&self, other: &Self) -> Lanes {
        (self.low.cmple(other.high) & other.low.cmple(self.high)).bitmask()
    }

    /// The range of all.
    #[inline]
    pub fn whole(&self) -> (f32, f32) {
        (self.low.min_element(), self.high.max_element())
    }
}

/// Four boxes.
#[derive(Clone, Copy)]
pub struct Boxes {
    low: Four,
    high: Four,
}

impl Boxes {
    /// Boxes of nothing.
    pub const EMPTY: Self = Self { low: Four::all(f32::INFINITY), high: Four::all(f32::NEG_INFINITY) };

    pub fn set(&mut self, lane: usize, bounds: &Bounds) {
        self.low.set(lane, bounds.low.into());
        self.high.set(lane, bounds.high.into());
    }

    /// The boxes of points, lane by lane.
    #[inline]
    pub fn of([a, b, c, d]: [&Four; 4]) -> Self {
        Self { low: a.min(b).min(&c.min(d)), high: a.max(b).max(&c.max(d)) }
    }

    #[inline]
    pub fn at(&self, lane: usize) -> Bounds {
        Bounds { low: self.low.at(lane).into(), high: self.high.at(lane).into() }
    }

    /// The same box in all lanes.
    #[inline]
    pub fn splat(bounds: &Bounds) -> Self {
        Self { low: Four::splat(bounds.low.into()), high: Four::splat(bounds.high.into()) }
    }

    /// The lanes whose boxes have a place in common with those of another.
    #[inline]
    pub fn that_meet(&self, other: &Self) -> Lanes {
        let of = |a: Vec4, b: Vec4, c: Vec4, d: Vec4| a.cmple(b) & c.cmple(d);
        let x = of(self.low.x, other.high.x, other.low.x, self.high.x);
        let y = of(self.low.y, other.high.y, other.low.y, self.high.y);
        (x & y & of(self.low.z, other.high.z, other.low.z, self.high.z)).bitmask()
    }

    /// The lanes whose boxes have a point over or under them along the last axis.
    #[inline]
    pub fn that_have(&self, point: Vec3) -> Lanes {
        let [x, y] = [point.x, point.y].map(Vec4::splat);
        let (x, y) = (self.low.x.cmple(x) & x.cmple(self.high.x), self.low.y.cmple(y) & y.cmple(self.high.y));
        (x & y).bitmask()
    }

    /// The box of all.
    #[inline]
    pub fn whole(&self) -> Bounds {
        let Self { low, high } = self;
        Bounds {
            low: Vec3A::new(low.x.min_element(), low.y.min_element(), low.z.min_element()),
            high: Vec3A::new(high.x.max_element(), high.y.max_element(), high.z.max_element()),
        }
    }
}

/// The numbers of a set of lanes.
#[inline]
pub fn each(mut lanes: Lanes) -> impl Iterator<Item = usize> + Clone {
    std::iter::from_fn(move || {
        let lane = lanes.trailing_zeros() as usize;
        let is_left = lanes != 0;
        lanes &= lanes.wrapping_sub(1);
        is_left.then_some(lane)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [Vec3; 4] =
        [Vec3::new(1.0, 2.0, 3.0), Vec3::new(-0.5, 0.25, 8.0), Vec3::ZERO, Vec3::new(1e-30, 0.0, 0.0)];

    #[test]
    fn lanes_are_what_single_points_are() {
        let axis = Vec3::new(0.3, -1.7, 0.9);
        let four = Four::new(POINTS);
        let unit = four.normalize_or_zero();
        let cross = four.cross(&Four::splat(axis));
        for (lane, p) in POINTS.into_iter().enumerate() {
            assert_eq!(four.at(lane), p);
            assert_eq!(four.dot(axis)[lane], p.dot(axis));
            assert_eq!(unit.at(lane), p.normalize_or_zero());
            assert_eq!(cross.at(lane), p.cross(axis));
            assert!(each(four.that_are(p)).eq([lane]));
        }
    }

    #[test]
    fn boxes_and_ranges_meet_where_single_ones_do() {
        let (a, b) = (Four::new(POINTS), Four::new(POINTS.map(|p| p + Vec3::new(1.0, 0.5, 0.25))));
        let boxes = Boxes::of([&a, &b, &a, &b]);
        let other = Bounds { low: Vec3A::new(-1.0, 0.5, 0.0), high: Vec3A::new(0.5, 3.0, 8.5) };
        let meets = |p: Vec3| {
            let (low, high) = (Vec3A::from(p), Vec3A::from(p + Vec3::new(1.0, 0.5, 0.25)));
            low.cmple(other.high).all() && other.low.cmple(high).all()
        };
        let expected = (0..4).filter(|&lane| meets(POINTS[lane]));
        assert!(each(boxes.that_meet(&Boxes::splat(&other))).eq(expected));
        assert!(each(boxes.that_have(Vec3::new(1.5, 2.25, 100.0))).eq([0]));
        let whole = boxes.whole();
        assert_eq!((whole.low.x, whole.high.z), (-0.5, 8.25));
    }
}
