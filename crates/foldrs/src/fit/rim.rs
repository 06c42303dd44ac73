//! Evidence from the picture: the rim of the layer on top, seen as an edge inside the outline.
//!
//! Of two layers one lies on top. If it is the flap, the flap's rim shows wherever it runs inside the seen outline; if it
//! is the kept part, that part's rim shows wherever the flap sticks out below it. Folds that the outline alone cannot
//! tell apart predict different rims. How much an edge says is weighed against chance: what counts is its rank among
//! the edges found in the same way at any place and in any direction within the same cloth, so a print or a creased
//! cloth, full of edges, says little.
//!
//! Where heights are known their steps are weighed in the same way. Cloth that bears another layer lies higher whichever
//! of the two is on top, so both layers' rims show as steps, and they do not tell which one that is.

use super::field::SeenField;
use super::layers::Piece;
use super::picture::Picture;
use crate::fold::Layer;
use crate::parameters::RimParameters;
use crate::{Point, Vector};

/// The edges of a picture prepared for one garment: what chance gives of them within its cloth.
#[derive(Debug)]
pub(super) struct Rims<'a> {
    picture: &'a Picture,
    /// Picture pixels a working unit.
    pixels: f64,
    parameters: &'a RimParameters,
    colours: Edges<'a>,
    steps: Option<Edges<'a>>,
}

/// Edges of one kind, and what chance gives of them within the cloth.
#[derive(Debug)]
struct Edges<'a> {
    tensor: &'a [[f32; 3]],
    /// Edge strengths at chance places, increasing.
    chance: Vec<f32>,
}

impl<'a> Rims<'a> {
    /// `unit` is the number of seen units a working unit. `None` if the cloth is too small for chance to be known.
    pub(super) fn new(
        picture: &'a Picture,
        unit: f64,
        field: &SeenField,
        parameters: &'a RimParameters,
    ) -> Option<Self> {
        let unknown = |tensor| Edges {
            tensor,
            chance: Vec::new(),
        };
        let mut rims = Self {
            picture,
            pixels: unit * picture.scale,
            parameters,
            colours: unknown(&picture.tensor),
            steps: picture.steps.as_deref().map(unknown),
        };
        rims.colours.chance = rims.by_chance(&rims.colours, field);
        if let Some(steps) = &rims.steps {
            let chance = rims.by_chance(steps, field);
            rims.steps = Some(Edges {
                tensor: steps.tensor,
                chance,
            });
        }
        (rims.colours.chance.len() >= 100).then_some(rims)
    }

    /// Strengths of edges of one kind at any place within the cloth and in any direction, increasing.
    fn by_chance(&self, edges: &Edges, field: &SeenField) -> Vec<f32> {
        let directions: Vec<Vector> = (0..4)
            .map(|k| f64::from(k) * std::f64::consts::FRAC_PI_4)
            .map(|a| Vector::new(a.cos(), a.sin()))
            .collect();
        let mut chance = Vec::new();
        for (_, p) in field.nodes_within(self.parameters.inside) {
            for n in &directions {
                chance.push(self.strength(edges, &p, n));
            }
        }
        chance.sort_by(f32::total_cmp);
        chance
    }

    /// How much likelier the edges of colour are if the flap's rims show than by chance, and if the kept part's do.
    pub(super) fn colours(&self, pieces: &[Piece], field: &SeenField) -> [f64; 2] {
        [Layer::Flap, Layer::Kept].map(|layer| self.layer(&self.colours, pieces, layer, field))
    }

    /// The evidence of steps in height, in nats; none where heights are unknown.
    pub(super) fn steps(&self, pieces: &[Piece], field: &SeenField) -> f64 {
        let of = |steps| {
            self.layer(steps, pieces, Layer::Flap, field) + self.layer(steps, pieces, Layer::Kept, field)
        };
        self.steps.as_ref().map_or(0.0, |steps| self.bounded(of(steps)))
    }

    /// However well edges lie along a rim, a seam or a pocket may have made them: that bounds what they can say.
    pub(super) fn bounded(&self, gain: f64) -> f64 {
        let p = self.parameters;
        p.mislead.ln_1p() - ((-p.weight * gain).exp() + p.mislead).ln()
    }

    /// Log likelihood ratio of the rims of one layer by edges of one kind.
    fn layer(&self, edges: &Edges, pieces: &[Piece], layer: Layer, field: &SeenField) -> f64 {
        let p = self.parameters;
        let mut sum = 0.0;
        for piece in pieces.iter().filter(|piece| piece.layer == layer) {
            let visible = piece.length * (piece.share[1] - piece.share[0]);
            // No finer than pixels, and no more places than a line across the picture has: a template in tiny units
            // is as quick as any.
            let spacing = p.spacing.max(1.0 / self.pixels);
            let count = (visible / spacing).ceil().clamp(1.0, self.across());
            let normal = piece.across();
            for k in 0..count as usize {
                let t = piece.share[0] + (piece.share[1] - piece.share[0]) * (k as f64 + 0.5) / count;
                let x = piece.ends[0] + (piece.ends[1] - piece.ends[0]) * t;
                if field.at(&x).0 < -p.inside {
                    sum += visible / count / p.correlation
                        * self.ratio(edges, self.strength(edges, &x, &normal));
                }
            }
        }
        sum
    }

    /// Log of the density of an edge's rank at a true rim over that by chance, which is 1 for every rank.
    fn ratio(&self, edges: &Edges, strength: f32) -> f64 {
        let below = edges.chance.partition_point(|&c| c < strength);
        let rank = (below as f64 + 0.5) / (edges.chance.len() as f64 + 1.0);
        let p = self.parameters;
        ((1.0 - p.shown) + p.shown * p.sharpness * rank.powf(p.sharpness - 1.0)).ln()
    }

    /// More pixels than any straight line across the picture passes.
    fn across(&self) -> f64 {
        (self.picture.width + self.picture.height).max(1) as f64
    }

    /// The strongest edge across a place, within reach along the normal.
    fn strength(&self, edges: &Edges, x: &Point, normal: &Vector) -> f32 {
        let reach = self.parameters.reach * self.pixels;
        let steps = reach.ceil().clamp(1.0, self.across());
        let (a, b) = (normal.x as f32, normal.y as f32);
        let mut most = 0.0f32;
        for k in -(steps as i64)..=steps as i64 {
            let q = x.coords * self.pixels + normal * (k as f64 / steps * reach);
            let (i, j) = (q.x.round(), q.y.round());
            if i < 0.0 || j < 0.0 || i >= self.picture.width as f64 || j >= self.picture.height as f64 {
                continue;
            }
            let Some([xx, xy, yy]) = edges.tensor.get(j as usize * self.picture.width + i as usize) else {
                continue;
            };
            most = most.max(a * a * xx + 2.0 * a * b * xy + b * b * yy);
        }
        most
    }
}
