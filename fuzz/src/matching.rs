//! Alignment, templates, and the whole way from an outline to explanations.

use super::bytes::Bytes;
use foldrs::alignment::{align, alignment_costs, AlignmentParameters};
use foldrs::fit::{explain_jointly, fit_unfolded, FlexibleTemplate, FoldCount, Looks, Picture, SeenField};
use foldrs::matching::{claim_axes, match_folded, Seen};
use foldrs::shape_context::CostMatrix;
use foldrs::{Outline, Parameters, Point};

/// The alignment is the cheapest of all starts, in order, and a bound only leaves out what is not cheaper.
pub fn alignment(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let (rows, columns) = (usize::from(bytes.byte()) % 21, usize::from(bytes.byte()) % 21);
    let mut parameters = AlignmentParameters::default();
    parameters.skip_penalty = f64::from(bytes.byte()) / 100.0;
    parameters.starts = usize::from(bytes.byte()) % 24;
    let bound = Some(f64::from(bytes.byte()) / 100.0).filter(|bound| *bound < 2.0);
    let any = bytes.byte().is_multiple_of(4);
    let values: Vec<f32> = (0..rows * columns)
        .map(|_| {
            if any {
                bytes.single().unwrap_or(0.0)
            } else {
                f32::from(bytes.byte()) / 128.0
            }
        })
        .collect();
    let in_range = values.iter().all(|cost| (0.0..=2.0).contains(cost));
    let cost = CostMatrix {
        rows,
        columns,
        values,
    };
    let found = align(&cost, &parameters, bound);
    let starts: Vec<usize> = (0..columns).collect();
    let costs = alignment_costs(&cost, &parameters, &starts);
    assert_eq!(costs.len(), columns);
    if let Some(alignment) = &found {
        assert!(alignment.start < columns);
        let around = |column: u32| (column as usize + columns - alignment.start) % columns;
        let in_order = |pair: &[(u32, u32)]| pair[0].0 < pair[1].0 && around(pair[0].1) < around(pair[1].1);
        assert!(alignment.pairs.windows(2).all(in_order));
        assert!(alignment
            .pairs
            .iter()
            .all(|&(row, column)| (row as usize) < rows && (column as usize) < columns));
    }
    if in_range && rows > 0 && columns > 0 {
        let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
        match (found, bound) {
            (Some(alignment), _) => assert!(
                (alignment.cost - least).abs() < 1e-4,
                "{} is not {least}",
                alignment.cost
            ),
            (None, Some(bound)) => assert!(least >= bound - 1e-4, "{least} was to be found below {bound}"),
            (None, None) => panic!("no alignment at all"),
        }
    }
}

/// As few iterations and starts as reach every line.
fn brief() -> Parameters {
    let mut brief = Parameters::default();
    let matches = &mut brief.partial_match;
    (matches.points, matches.most) = (40, 12);
    (matches.sizes, matches.scales) = (vec![1.0], vec![1.2]);
    brief.hypothesis.most = 4;
    brief.shape_context.n_points = 24;
    let fit = &mut brief.fit;
    (fit.samples, fit.nodes, fit.directions) = (24, 16, 2);
    (fit.coarse_iterations, fit.iterations, fit.polish_iterations) = (2, 2, 1);
    (fit.starts, fit.refined, fit.polished) = (4, 2, 1);
    brief
}

fn mirror_pairs(bytes: &mut Bytes) -> Vec<[Point; 2]> {
    bytes
        .points(12)
        .chunks_exact(2)
        .map(|pair| [pair[0], pair[1]])
        .collect()
}

/// Whatever outline and mirror pairs a template file holds, a template that can bend comes of it.
pub fn template(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let pairs = mirror_pairs(&mut bytes);
    let Some(outline) = bytes.outline(32) else { return };
    let parameters = brief().fit;
    let template = FlexibleTemplate::new(&outline, &pairs, &parameters);
    assert!(template.centre().coords.iter().all(|x| x.is_finite()));
    let field = SeenField::new(&outline.clone().positive(), parameters.samples, parameters.nodes);
    if let Some(fit) = fit_unfolded(&field, &template, outline.centroid(), 1.0, &parameters) {
        assert!(!fit.surprise.is_nan());
    }
}

/// Whatever is seen, whatever templates there are: explanations are in order and made of numbers.
pub fn explain(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let scale = match bytes.byte() % 8 {
        0 => bytes.number().filter(|scale| scale.is_finite() && *scale > 0.0),
        1..=3 => None,
        _ => Some(1.0),
    };
    let pairs = mirror_pairs(&mut bytes);
    let with_picture = bytes.byte().is_multiple_of(2);
    let (Some(template), Some(outline)) = (bytes.outline(20), bytes.outline(32)) else {
        return;
    };
    let parameters = brief();
    let seen = Seen::new(outline, &parameters);
    let templates: [Outline; 1] = [template];
    let matching = match_folded(&seen, &templates, scale, &parameters);
    assert!(matching
        .candidates
        .iter()
        .all(|candidate| candidate.cost.is_finite()));

    let flexible = [FlexibleTemplate::new(&templates[0], &pairs, &parameters.fit)];
    let claims = claim_axes(&seen, &templates, scale, &parameters);
    let picture = with_picture.then(|| {
        let pixels: Vec<[u8; 3]> = (0..64)
            .map(|_| [bytes.byte(), bytes.byte(), bytes.byte()])
            .collect();
        Picture {
            width: 8,
            height: 8,
            tensor: pixels.iter().map(|pixel| pixel.map(f32::from)).collect(),
            scale: 1.0,
            steps: None,
            looks: Some(Looks {
                width: 8,
                height: 8,
                look: pixels.iter().map(|pixel| pixel[0] % 4).collect(),
                scale: 1.0,
                origin: Point::origin(),
            }),
        }
    });
    let folds = FoldCount::UpTo(usize::from(bytes.byte()) % 3);
    let fits = explain_jointly(
        &seen,
        &flexible,
        &claims,
        scale,
        picture.as_ref(),
        folds,
        &parameters,
    );
    for explanations in &fits.by_folds {
        assert!(explanations
            .windows(2)
            .all(|pair| pair[0].surprise <= pair[1].surprise));
        for one in explanations {
            let lines = one.axes.iter().chain(&one.creases).flatten();
            let all = one.outline.iter().chain(lines);
            assert!(all.into_iter().all(|p| p.coords.iter().all(|x| x.is_finite())));
            assert_eq!(one.outline.len(), templates[0].points().len());
        }
    }
}
