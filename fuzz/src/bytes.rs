//! Bytes to points: the degenerate is not rare here, it is what most bytes mean.

use foldrs::{Outline, Point};

/// What is left of the input.
pub struct Bytes<'a>(&'a [u8]);

/// How coordinates are written in the bytes.
#[derive(Clone, Copy)]
enum Coordinates {
    /// A grid of 8 by 8: duplicates, spikes, collinear runs, touching and crossing edges.
    Grid,
    /// The grid, its points moved by a few of the last bits.
    NearlyGrid,
    /// Whole numbers as of pixels, times a power of ten.
    Pixels(f64),
    /// Any number there is, NaN and the infinite ones, too.
    Any,
}

impl<'a> Bytes<'a> {
    pub fn new(data: &'a [u8]) -> Self {
        Self(data)
    }

    /// The next byte; 0 where there is none.
    pub fn byte(&mut self) -> u8 {
        self.take::<1>().map_or(0, |[byte]| byte)
    }

    /// The next number, of any kind.
    pub fn number(&mut self) -> Option<f64> {
        self.take().map(f64::from_le_bytes)
    }

    /// The next number in single precision, of any kind.
    pub fn single(&mut self) -> Option<f32> {
        self.take().map(f32::from_le_bytes)
    }

    /// At most `most` points, all written in the same way; as many as there are bytes for.
    pub fn points(&mut self, most: usize) -> Vec<Point> {
        let count = usize::from(self.byte()) % (most + 1);
        let kind = match self.byte() % 4 {
            0 => Coordinates::Grid,
            1 => Coordinates::NearlyGrid,
            2 => Coordinates::Pixels(10_f64.powi((i32::from(self.byte() as i8)) * 5 / 2)),
            _ => Coordinates::Any,
        };
        (0..count)
            .map_while(|_| Some(Point::new(self.coordinate(kind)?, self.coordinate(kind)?)))
            .collect()
    }

    /// The outline of at most `most` points, if they are one.
    pub fn outline(&mut self, most: usize) -> Option<Outline> {
        Outline::new(self.points(most)).ok()
    }

    fn coordinate(&mut self, kind: Coordinates) -> Option<f64> {
        match kind {
            Coordinates::Grid => self.take().map(|[byte]| f64::from(byte % 8)),
            Coordinates::NearlyGrid => self
                .take()
                .map(|[byte]| f64::from(byte % 8) + f64::from(byte / 8) * f64::EPSILON),
            Coordinates::Pixels(scale) => self.take().map(|two| f64::from(i16::from_le_bytes(two)) * scale),
            Coordinates::Any => self.number(),
        }
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*first)
    }
}
