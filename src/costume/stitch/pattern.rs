//! The threads of each kind of stitch, as points of one period.
//!
//! Sources: ISO 4915 (classification of stitches), of which the drawings are simplified to what is seen; sizes are common settings of
//! machines.

use super::options::StitchKind;

/// A point of a thread: along the line \[stitches\], across it \[widths, left is positive\], and above the cloth \[diameters of the
/// thread\].
pub type PatternPoint = [f32; 3];

/// Threads that repeat along a line.
pub struct StitchPattern {
    /// The length of a period. \[stitches\]
    pub period: f32,
    /// The points of each thread in a period.
    pub threads: &'static [&'static [PatternPoint]],
    /// Stitches on a centimetre by default.
    pub per_centimetre: f32,
    /// Width across the line by default. \[m\]
    pub width: f32,
}

/// Depth of a needle's hole below the cloth.
const HOLE: f32 = -1.5;
/// The top of a thread that lies on the cloth.
const TOP: f32 = 0.5;
/// Below the cloth.
const UNDER: f32 = -1.2;

/// A stitch from hole to hole.
const STRAIGHT: &[PatternPoint] =
    &[[0.0, 0.0, HOLE], [0.1, 0.0, 0.2], [0.3, 0.0, TOP], [0.7, 0.0, TOP], [0.9, 0.0, 0.2]];

impl StitchKind {
    /// Its threads.
    pub fn pattern(self) -> StitchPattern {
        let (period, per_centimetre, width, threads): (f32, f32, f32, &'static [&'static [PatternPoint]]) = match self {
            Self::Lockstitch => (1.0, 4.0, 0.0, &[STRAIGHT]),
            Self::Chainstitch => (
                1.0,
                3.0,
                0.0015,
                &[STRAIGHT, &[[0.0, 0.0, UNDER], [0.5, 0.4, UNDER], [1.2, 0.0, UNDER], [0.5, -0.4, UNDER]]],
            ),
            Self::Zigzag => (
                2.0,
                6.0,
                0.003,
                &[&[
                    [0.0, -0.5, HOLE],
                    [0.1, -0.4, 0.2],
                    [0.3, -0.2, TOP],
                    [0.7, 0.2, TOP],
                    [0.9, 0.4, 0.2],
                    [1.0, 0.5, HOLE],
                    [1.1, 0.4, 0.2],
                    [1.3, 0.2, TOP],
                    [1.7, -0.2, TOP],
                    [1.9, -0.4, 0.2],
                ]],
            ),
            Self::Overlock => (
                1.0,
                5.0,
                0.005,
                &[
                    &[[0.0, 0.5, HOLE], [0.1, 0.5, 0.2], [0.5, 0.5, TOP], [0.9, 0.5, 0.2]],
                    &[[0.0, 0.45, TOP], [0.3, 0.0, TOP], [0.55, -0.5, TOP], [0.75, -0.5, 0.2], [0.9, 0.0, TOP]],
                ],
            ),
            Self::Flatlock => (
                1.0,
                5.0,
                0.006,
                &[
                    &[[0.0, -0.5, HOLE], [0.1, -0.5, 0.2], [0.5, -0.5, TOP], [0.9, -0.5, 0.2]],
                    &[[0.0, 0.0, HOLE], [0.1, 0.0, 0.2], [0.5, 0.0, TOP], [0.9, 0.0, 0.2]],
                    &[[0.0, 0.5, HOLE], [0.1, 0.5, 0.2], [0.5, 0.5, TOP], [0.9, 0.5, 0.2]],
                    &[[0.0, -0.5, 1.3], [0.25, 0.0, 1.3], [0.5, 0.5, 1.3], [0.75, 0.0, 1.3]],
                ],
            ),
            Self::Bartack => {
                (2.0, 20.0, 0.003, &[&[[0.0, -0.5, HOLE], [0.5, 0.0, TOP], [1.0, 0.5, HOLE], [1.5, 0.0, TOP]]])
            }
            Self::Blind => (
                1.0,
                1.0,
                0.0,
                &[&[[0.0, 0.0, UNDER], [0.4, 0.0, UNDER], [0.45, 0.0, TOP], [0.55, 0.0, TOP], [0.6, 0.0, UNDER]]],
            ),
            Self::HandSewn => (
                1.0,
                2.0,
                0.0,
                &[&[[0.0, 0.0, HOLE], [0.05, 0.0, TOP], [0.45, 0.0, TOP], [0.5, 0.0, HOLE], [0.75, 0.0, UNDER]]],
            ),
        };
        StitchPattern { period, threads, per_centimetre, width }
    }
}
