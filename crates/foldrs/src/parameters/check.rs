//! Whether parameters are in the range in which the stages can work with them.

use super::*;
use std::fmt::Display;
use std::ops::RangeInclusive;

/// A parameter that no stage can work with.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{group}.{name} must be {wanted}, not {given}")]
#[non_exhaustive]
pub struct ParameterError {
    /// The stage's group, as the field of [`Parameters`] is called.
    pub group: &'static str,
    /// The parameter in it.
    pub name: &'static str,
    /// What it must be.
    pub wanted: String,
    /// What it is.
    pub given: String,
}

impl Parameters {
    /// Tells whether the stages can work with them: spreads, widths and factors are positive, counts at least as large as
    /// they must be, shares between 0 and 1, all finite. With others stages find nothing, or panic.
    ///
    /// # Errors
    /// The first [`ParameterError`], in the order of the groups.
    ///
    /// ```
    /// let mut parameters = foldrs::Parameters::default();
    /// assert!(parameters.check().is_ok());
    /// parameters.fit.noise = 0.0;
    /// let told = parameters.check().unwrap_err().to_string();
    /// assert_eq!(told, "fit.noise must be a positive number, not 0");
    /// ```
    pub fn check(&self) -> Result<(), ParameterError> {
        self.side.check(&Group("side"))?;
        self.partial_match.check(&Group("partial_match"))?;
        self.hypothesis.check(&Group("hypothesis"))?;
        let group = Group("shape_context");
        group.count("n_points", self.shape_context.n_points, 3)?;
        group.count("n_dist", self.shape_context.n_dist, 1)?;
        group.count("n_theta", self.shape_context.n_theta, 1)?;
        let group = Group("alignment");
        group.not_negative("skip_penalty", self.alignment.skip_penalty)?;
        group.count("starts", self.alignment.starts, 1)?;
        self.fit.check(&Group("fit"))?;
        self.rim.check(&Group("rim"))?;
        self.region.check(&Group("region"))
    }
}

impl SideParameters {
    fn check(&self, group: &Group) -> Result<(), ParameterError> {
        group.all_positive("tolerances", &self.tolerances)?;
        group.not_negative("shortest", self.shortest)?;
        group.not_negative("in_line", self.in_line)
    }
}

impl PartialMatchParameters {
    fn check(&self, group: &Group) -> Result<(), ParameterError> {
        group.count("points", self.points, LEAST_POINTS)?;
        group.within("delta", self.delta, 1..=self.points / 2)?;
        group.count("shortest", self.shortest, 1)?;
        group.share("longest", self.longest)?;
        group.positive("likeness", self.likeness)?;
        group.positive("length", self.length)?;
        group.not_negative("affinity", self.affinity)?;
        group.all_positive("sizes", &self.sizes)?;
        group.all_positive("scales", &self.scales)
    }
}

impl HypothesisParameters {
    fn check(&self, group: &Group) -> Result<(), ParameterError> {
        group.not_negative("affine_spread", self.affine_spread)?;
        group.positive("stretch", self.stretch)?;
        group.count("angle_bins", self.angle_bins, 1)?;
        group.positive("distance_bin", self.distance_bin)
    }
}

impl FitParameters {
    fn check(&self, group: &Group) -> Result<(), ParameterError> {
        group.count("samples", self.samples, 3)?;
        group.count("nodes", self.nodes, 8)?;
        group.count("iterations", self.iterations, 1)?;
        group.count("directions", self.directions, 1)?;
        for (name, value) in [
            ("shape", self.shape),
            ("edge", self.edge),
            ("edge_floor", self.edge_floor),
            ("asymmetry", self.asymmetry),
            ("growth", self.growth),
            ("free_growth", self.free_growth),
            ("hidden", self.hidden),
            ("turn", self.turn),
            ("offset", self.offset),
            ("shift", self.shift),
            ("skew", self.skew),
            ("earlier_shift", self.earlier_shift),
            ("earlier_skew", self.earlier_skew),
            ("noise", self.noise),
            ("bow", self.bow),
            ("tail", self.tail),
            ("correlation", self.correlation),
            ("coarse_noise", self.coarse_noise),
            ("polish_noise", self.polish_noise),
            ("longest_step", self.longest_step),
            ("way_turn", self.way_turn),
            ("way_shift", self.way_shift),
        ] {
            group.positive(name, value)?;
        }
        for (name, value) in [
            ("simplify", self.simplify),
            ("view", self.view),
            ("first_fold", self.first_fold),
            ("further_fold", self.further_fold),
            ("flap", self.flap),
            ("against", self.against),
            ("bend", self.bend),
            ("bare", self.bare),
            ("alike", self.alike),
            ("draw_variance", self.draw_variance),
        ] {
            group.not_negative(name, value)?;
        }
        group.share("along", self.along)?;
        group.share("across", self.across)?;
        group.share("halves", self.halves)?;
        let told = self.along + self.across + self.halves;
        group.unless(
            told < 1.0,
            "halves",
            "less than 1 together with along and across",
            told,
        )?;
        group.unless(
            self.most_larger >= 1.0,
            "most_larger",
            "1 or more",
            self.most_larger,
        )?;
        group.share("least_turned", self.least_turned)?;
        group.share("covered", self.covered)
    }
}

impl RimParameters {
    fn check(&self, group: &Group) -> Result<(), ParameterError> {
        group.not_negative("inside", self.inside)?;
        group.positive("spacing", self.spacing)?;
        group.not_negative("reach", self.reach)?;
        group.positive("correlation", self.correlation)?;
        group.share("shown", self.shown)?;
        group.positive("sharpness", self.sharpness)?;
        group.share("mislead", self.mislead)?;
        group.not_negative("weight", self.weight)
    }
}

impl RegionParameters {
    fn check(&self, group: &Group) -> Result<(), ParameterError> {
        group.not_negative("inside", self.inside)?;
        group.positive("patch", self.patch)?;
        group.share("chance", self.chance)?;
        group.share("least", self.least)?;
        group.positive("placement", self.placement)?;
        group.not_negative("open", self.open)?;
        group.positive("step", self.step)?;
        group.not_negative("range", self.range)
    }
}

/// Says of which group a parameter is that is not in its range.
struct Group(&'static str);

impl Group {
    fn unless(
        &self,
        right: bool,
        name: &'static str,
        wanted: &str,
        given: impl Display,
    ) -> Result<(), ParameterError> {
        if right {
            return Ok(());
        }
        Err(ParameterError {
            group: self.0,
            name,
            wanted: wanted.to_owned(),
            given: given.to_string(),
        })
    }

    fn positive(&self, name: &'static str, value: f64) -> Result<(), ParameterError> {
        self.unless(value.is_finite() && value > 0.0, name, "a positive number", value)
    }

    fn not_negative(&self, name: &'static str, value: f64) -> Result<(), ParameterError> {
        self.unless(
            value.is_finite() && value >= 0.0,
            name,
            "0 or a positive number",
            value,
        )
    }

    fn share(&self, name: &'static str, value: f64) -> Result<(), ParameterError> {
        self.unless((0.0..=1.0).contains(&value), name, "between 0 and 1", value)
    }

    fn count(&self, name: &'static str, value: usize, least: usize) -> Result<(), ParameterError> {
        self.unless(value >= least, name, &format!("{least} or more"), value)
    }

    fn within(
        &self,
        name: &'static str,
        value: usize,
        range: RangeInclusive<usize>,
    ) -> Result<(), ParameterError> {
        let wanted = format!("from {} to {}", range.start(), range.end());
        self.unless(range.contains(&value), name, &wanted, value)
    }

    fn all_positive(&self, name: &'static str, values: &[f64]) -> Result<(), ParameterError> {
        let right = !values.is_empty() && values.iter().all(|v| v.is_finite() && *v > 0.0);
        self.unless(
            right,
            name,
            "positive numbers, one at least",
            format!("{values:?}"),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_out_of_range_is_named() {
        type Change = fn(&mut Parameters);
        let changes: [(Change, &str); 14] = [
            (|p| p.side.tolerances = vec![], "side.tolerances"),
            (|p| p.partial_match.points = 4, "partial_match.points"),
            (|p| p.partial_match.delta = usize::MAX, "partial_match.delta"),
            (
                |p| p.partial_match.scales = vec![1.0, -1.0],
                "partial_match.scales",
            ),
            (|p| p.hypothesis.angle_bins = 0, "hypothesis.angle_bins"),
            (|p| p.hypothesis.distance_bin = 0.0, "hypothesis.distance_bin"),
            (|p| p.shape_context.n_theta = 0, "shape_context.n_theta"),
            (|p| p.alignment.skip_penalty = f64::NAN, "alignment.skip_penalty"),
            (|p| p.fit.nodes = 0, "fit.nodes"),
            (|p| p.fit.bow = 0.0, "fit.bow"),
            (|p| p.fit.most_larger = f64::NAN, "fit.most_larger"),
            (|p| p.fit.along = 0.9, "fit.halves"),
            (|p| p.rim.mislead = 2.0, "rim.mislead"),
            (|p| p.region.patch = f64::INFINITY, "region.patch"),
        ];
        for (change, name) in changes {
            let mut parameters = Parameters::default();
            change(&mut parameters);
            let told = parameters.check().unwrap_err().to_string();
            assert!(told.starts_with(name), "{told}");
        }
        assert_eq!(Parameters::default().check(), Ok(()));
    }
}
