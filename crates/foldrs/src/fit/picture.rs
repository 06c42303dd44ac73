//! Evidence from the picture: what is seen within the outline, weighed against chance.
//!
//! Of two layers one lies on top. Its rim shows as an edge ([`rim`](super::rim)), and what it covers looks different from
//! the rest ([`region`](super::region)). Folds that the outline alone cannot tell apart predict different rims and regions.

use super::field::SeenField;
use super::layers::Layers;
use super::region::Regions;
use super::rim::Rims;
use crate::parameters::{Parameters, RegionParameters, RimParameters};
use crate::Point;

/// What was seen within an outline: colour edges, steps in height, and how every place looks.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Structure tensor of the colours (xx, xy, yy) of every pixel, row by row.
    pub tensor: Vec<[f32; 3]>,
    /// The same of the heights above the table, if they are known.
    pub steps: Option<Vec<[f32; 3]>>,
    /// Pixels of this picture a unit of the seen outline (1 unless it was made smaller).
    pub scale: f64,
    /// How every place of the cloth looks, if that is to be weighed.
    pub looks: Option<Looks>,
}

/// How every place of the cloth looks: one of a few looks a pixel, told apart by colour and pattern.
#[derive(Debug, Clone)]
pub struct Looks {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The look of every pixel, row by row: small numbers without order.
    pub look: Vec<u8>,
    /// Pixels a unit of the seen outline.
    pub scale: f64,
    /// Where the first pixel lies, in the seen outline's frame.
    pub origin: Point,
}

impl Looks {
    /// The look of a place of the seen outline's frame; `None` beyond the picture.
    pub(super) fn at(&self, place: &Point) -> Option<u8> {
        let pixel = (place - self.origin) * self.scale;
        let (x, y) = (pixel.x.round(), pixel.y.round());
        let within = x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64;
        let pixel = within.then(|| y as usize * self.width + x as usize)?;
        self.look.get(pixel).copied()
    }
}

/// What the picture says of a fold.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PictureEvidence {
    /// Logarithm of how much more likely the picture is if this fold made it than if chance did, in nats.
    pub gain: f64,
    /// Logarithm of how much more likely the flap lies on top than below.
    pub flap_on_top: f64,
}

/// A picture prepared for one garment.
#[derive(Debug)]
pub(super) struct Sight<'a> {
    rims: Rims<'a>,
    regions: Option<Regions>,
    rim: &'a RimParameters,
    pub(super) region: &'a RegionParameters,
}

impl<'a> Sight<'a> {
    /// `unit` is the number of seen units a working unit. `None` if the cloth is too small for chance to be known.
    pub(super) fn new(
        picture: &'a Picture,
        unit: f64,
        field: &SeenField,
        parameters: &'a Parameters,
    ) -> Option<Self> {
        let looks = picture.looks.as_ref();
        Some(Self {
            rims: Rims::new(picture, unit, field, &parameters.rim)?,
            regions: looks.and_then(|looks| Regions::new(looks, unit, field, &parameters.region)),
            rim: &parameters.rim,
            region: &parameters.region,
        })
    }

    /// The evidence of a folded model.
    pub(super) fn evidence(&self, layers: &Layers, field: &SeenField) -> PictureEvidence {
        let edges = self.rims.colours(&layers.pieces, field);
        let looks = match &self.regions {
            Some(regions) => regions.gains(&layers.cloths, layers.last),
            None => [0.0; 2],
        };
        let [flap, kept] = [0, 1].map(|k| self.rims.bounded(edges[k]) + looks[k]);
        // Either layer may be on top: the mean of both likelihoods.
        let most = flap.max(kept);
        let gain = most + (((flap - most).exp() + (kept - most).exp()) / 2.0).ln();
        PictureEvidence {
            gain: gain + self.rims.steps(&layers.pieces, field),
            flap_on_top: self.rim.weight * (edges[0] - edges[1]) + looks[0] - looks[1],
        }
    }
}
