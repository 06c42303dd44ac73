//! A template as a camera may see it that does not look from straight above.

use super::shape::{log_determinant, FlexibleTemplate};
use nalgebra::DMatrix;

impl FlexibleTemplate {
    /// The same template drawn larger where it lies nearer, by the spread given over its own size.
    ///
    /// To first order a camera at an angle also stretches the garment one way. That is left to the corners' own spread:
    /// most folds shorten a garment one way as well, and would be told by nothing else.
    pub(super) fn seen_at_an_angle(mut self, spread: f64) -> Self {
        let unit = self.area.sqrt();
        let mut views = DMatrix::zeros(self.precision.nrows(), 2);
        for (i, corner) in self.corners.iter().enumerate() {
            for k in 0..2 {
                let moved = corner * (spread * corner[k] / unit);
                views[(2 * i, k)] = moved.x;
                views[(2 * i + 1, k)] = moved.y;
            }
        }
        // The covariance grows by the views'; by Woodbury's formula the precision falls by
        let told = &self.precision * &views;
        let inner = DMatrix::identity(2, 2) + views.transpose() * &told;
        if let Some(inner) = inner.cholesky() {
            self.precision -= &told * inner.solve(&told.transpose());
            self.log_det = log_determinant(&self.precision).unwrap_or(self.log_det);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::FitParameters;
    use crate::{Outline, Point};
    use nalgebra::DVector;

    fn towel() -> FlexibleTemplate {
        let p = [(0.0, 0.0), (60.0, 0.0), (60.0, 40.0), (0.0, 40.0)].map(|(x, y)| Point::new(x, y));
        FlexibleTemplate::new(&Outline::new(p.to_vec()).unwrap(), &[], &FitParameters::default())
    }

    #[test]
    fn a_trapezium_costs_less_at_an_angle_and_a_stretch_as_much() {
        let (above, angle) = (towel(), towel().seen_at_an_angle(0.1));
        // The farther side shorter, the nearer one longer, both a little farther away.
        let trapezium = DVector::from_vec(vec![-4.0, -3.0, 4.0, -3.0, -4.0, -3.0, 4.0, -3.0]);
        assert!(angle.cost(&trapezium) < 0.8 * above.cost(&trapezium));
        let stretch = DVector::from_vec(vec![-3.0, 2.0, 3.0, 2.0, 3.0, -2.0, -3.0, -2.0]);
        assert!((angle.cost(&stretch) - above.cost(&stretch)).abs() < 1e-9);
        // What may be anything is told by less.
        assert!(angle.log_det < above.log_det);
        assert_eq!(towel().seen_at_an_angle(0.0).precision, above.precision);
    }
}
