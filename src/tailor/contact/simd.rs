//! Four points, intervals or boxes at a time, in vector registers (structure of arrays).

use super::bvh::Aabb;
use glam::{Vec3, Vec3A, Vec4, Vec4Swizzles};

/// Elements of a block.
pub const WIDTH: usize = 4;

/// A subset of a block: bit `i` stands for element `i`.
pub type Mask = u32;

/// The mask of the whole block.
pub const ALL: Mask = (1 << WIDTH) - 1;

/// Four points or directions.
#[derive(Clone, Copy, Default)]
pub struct Vec3x4 {
    x: Vec4,
    y: Vec4,
    z: Vec4,
}

impl Vec3x4 {
    #[inline]
    pub fn new([a, b, c, d]: [Vec3; WIDTH]) -> Self {
        Self { x: Vec4::new(a.x, b.x, c.x, d.x), y: Vec4::new(a.y, b.y, c.y, d.y), z: Vec4::new(a.z, b.z, c.z, d.z) }
    }

    /// Four copies of one point.
    #[inline]
    pub const fn splat(point: Vec3) -> Self {
        Self { x: Vec4::splat(point.x), y: Vec4::splat(point.y), z: Vec4::splat(point.z) }
    }

    #[inline]
    pub fn at(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    #[inline]
    pub fn set(&mut self, i: usize, point: Vec3) {
        (self.x[i], self.y[i], self.z[i]) = (point.x, point.y, point.z);
    }

    /// The last element followed by the first three.
    #[inline]
    pub fn rotated(&self) -> Self {
        Self { x: self.x.wxyz(), y: self.y.wxyz(), z: self.z.wxyz() }
    }

    /// The coordinates along three axes.
    #[inline]
    pub fn in_frame(&self, [x, y, z]: &[Vec3; 3]) -> Self {
        Self { x: self.dot(*x), y: self.dot(*y), z: self.dot(*z) }
    }

    /// Dot products with one axis.
    #[inline]
    pub fn dot(&self, axis: Vec3) -> Vec4 {
        self.x * axis.x + self.y * axis.y + self.z * axis.z
    }

    /// Dot products with four axes.
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

    /// Unit vectors, zero for vectors whose length is zero or has no finite inverse.
    #[inline]
    pub fn normalize_or_zero(&self) -> Self {
        let squared = self.dots(self);
        let length = Vec4::new(squared.x.sqrt(), squared.y.sqrt(), squared.z.sqrt(), squared.w.sqrt());
        let scale = Vec4::select(length.cmpgt(Vec4::ZERO), 1.0 / length, Vec4::ZERO);
        let scale = Vec4::select(scale.cmplt(Vec4::INFINITY), scale, Vec4::ZERO);
        Self { x: self.x * scale, y: self.y * scale, z: self.z * scale }
    }

    /// The elements equal to a point.
    #[inline]
    pub fn equal_to(&self, point: Vec3) -> Mask {
        let Self { x, y, z } = Self::splat(point);
        (self.x.cmpeq(x) & self.y.cmpeq(y) & self.z.cmpeq(z)).bitmask()
    }

    #[inline]
    fn zip(&self, other: &Self, f: impl Fn(Vec4, Vec4) -> Vec4) -> Self {
        Self { x: f(self.x, other.x), y: f(self.y, other.y), z: f(self.z, other.z) }
    }

    #[inline]
    fn min(&self, other: &Self) -> Self {
        self.zip(other, Vec4::min)
    }

    #[inline]
    fn max(&self, other: &Self) -> Self {
        self.zip(other, Vec4::max)
    }
}

impl std::ops::Add for Vec3x4 {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        self.zip(&other, |a, b| a + b)
    }
}

impl std::ops::Sub for Vec3x4 {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self.zip(&other, |a, b| a - b)
    }
}

/// Four intervals.
#[derive(Clone, Copy)]
pub struct Intervalx4 {
    pub low: Vec4,
    pub high: Vec4,
}

impl Intervalx4 {
    /// The hulls of four values each.
    #[inline]
    pub fn hull([a, b, c, d]: [Vec4; 4]) -> Self {
        Self { low: a.min(b).min(c.min(d)), high: a.max(b).max(c.max(d)) }
    }

    /// The hulls of each interval with another.
    #[inline]
    pub fn merged(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    #[inline]
    pub fn expanded(&self, by: f32) -> Self {
        Self { low: self.low - by, high: self.high + by }
    }

    /// The hulls of each interval with itself translated.
    #[inline]
    pub fn swept(&self, by: Vec4) -> Self {
        Self { low: self.low + by.min(Vec4::ZERO), high: self.high + by.max(Vec4::ZERO) }
    }

    /// The elements that intersect those of another block.
    #[inline]
    pub fn intersecting(&self, other: &Self) -> Mask {
        (self.low.cmple(other.high) & other.low.cmple(self.high)).bitmask()
    }

    /// The hull of all four.
    #[inline]
    pub fn whole(&self) -> (f32, f32) {
        (self.low.min_element(), self.high.max_element())
    }
}

/// Four axis-aligned bounding boxes.
#[derive(Clone, Copy)]
pub struct Aabbx4 {
    low: Vec3x4,
    high: Vec3x4,
}

impl Aabbx4 {
    pub const EMPTY: Self = Self { low: Vec3x4::splat(Vec3::INFINITY), high: Vec3x4::splat(Vec3::NEG_INFINITY) };

    /// The boxes of four points each.
    #[inline]
    pub fn of([a, b, c, d]: [&Vec3x4; 4]) -> Self {
        Self { low: a.min(b).min(&c.min(d)), high: a.max(b).max(&c.max(d)) }
    }

    /// Four copies of one box.
    #[inline]
    pub fn splat(aabb: &Aabb) -> Self {
        Self { low: Vec3x4::splat(aabb.low.into()), high: Vec3x4::splat(aabb.high.into()) }
    }

    #[inline]
    pub fn at(&self, i: usize) -> Aabb {
        Aabb { low: self.low.at(i).into(), high: self.high.at(i).into() }
    }

    pub fn set(&mut self, i: usize, aabb: &Aabb) {
        self.low.set(i, aabb.low.into());
        self.high.set(i, aabb.high.into());
    }

    /// The elements that intersect those of another block.
    #[inline]
    pub fn intersecting(&self, other: &Self) -> Mask {
        let of = |a: Vec4, b: Vec4, c: Vec4, d: Vec4| a.cmple(b) & c.cmple(d);
        let x = of(self.low.x, other.high.x, other.low.x, self.high.x);
        let y = of(self.low.y, other.high.y, other.low.y, self.high.y);
        (x & y & of(self.low.z, other.high.z, other.low.z, self.high.z)).bitmask()
    }

    /// The elements with a point over or under them along the last axis.
    #[inline]
    pub fn over_or_under(&self, point: Vec3) -> Mask {
        let [x, y] = [point.x, point.y].map(Vec4::splat);
        let (x, y) = (self.low.x.cmple(x) & x.cmple(self.high.x), self.low.y.cmple(y) & y.cmple(self.high.y));
        (x & y).bitmask()
    }

    /// The box of all four.
    #[inline]
    pub fn whole(&self) -> Aabb {
        let Self { low, high } = self;
        Aabb {
            low: Vec3A::new(low.x.min_element(), low.y.min_element(), low.z.min_element()),
            high: Vec3A::new(high.x.max_element(), high.y.max_element(), high.z.max_element()),
        }
    }
}

/// The elements of a mask.
#[inline]
pub fn bits(mut mask: Mask) -> impl Iterator<Item = usize> + Clone {
    std::iter::from_fn(move || {
        let i = mask.trailing_zeros() as usize;
        let is_left = mask != 0;
        mask &= mask.wrapping_sub(1);
        is_left.then_some(i)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [Vec3; 4] =
        [Vec3::new(1.0, 2.0, 3.0), Vec3::new(-0.5, 0.25, 8.0), Vec3::ZERO, Vec3::new(1e-30, 0.0, 0.0)];

    #[test]
    fn blocks_agree_with_single_points() {
        let axis = Vec3::new(0.3, -1.7, 0.9);
        let block = Vec3x4::new(POINTS);
        let unit = block.normalize_or_zero();
        let cross = block.cross(&Vec3x4::splat(axis));
        for (i, p) in POINTS.into_iter().enumerate() {
            assert_eq!(block.at(i), p);
            assert_eq!(block.dot(axis)[i], p.dot(axis));
            assert_eq!(unit.at(i), p.normalize_or_zero());
            assert_eq!(cross.at(i), p.cross(axis));
            assert!(bits(block.equal_to(p)).eq([i]));
        }
    }

    #[test]
    fn boxes_intersect_where_single_ones_do() {
        let (a, b) = (Vec3x4::new(POINTS), Vec3x4::new(POINTS.map(|p| p + Vec3::new(1.0, 0.5, 0.25))));
        let boxes = Aabbx4::of([&a, &b, &a, &b]);
        let other = Aabb { low: Vec3A::new(-1.0, 0.5, 0.0), high: Vec3A::new(0.5, 3.0, 8.5) };
        let intersects = |p: Vec3| {
            let (low, high) = (Vec3A::from(p), Vec3A::from(p + Vec3::new(1.0, 0.5, 0.25)));
            low.cmple(other.high).all() && other.low.cmple(high).all()
        };
        let expected = (0..4).filter(|&i| intersects(POINTS[i]));
        assert!(bits(boxes.intersecting(&Aabbx4::splat(&other))).eq(expected));
        assert!(bits(boxes.over_or_under(Vec3::new(1.5, 2.25, 100.0))).eq([0]));
        let whole = boxes.whole();
        assert_eq!((whole.low.x, whole.high.z), (-0.5, 8.25));
    }
}
