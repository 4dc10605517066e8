//! What could be better of a conversion, and what the user can do about it.

use super::{Body, Cut, LeftFilled, Options, SurfaceFit, TargetShape};
use crate::geometry::{Point, bounds};
use crate::stages::adapt::Folds;
use crate::stages::smooth::Support;
use crate::statistics::{SIGNIFICANT, outlying};
use crate::words::{grouped, mm, plural};

/// One sentence for each thing that could be better, with what the user can do. Options
/// have the names that they have on the command line.
pub(super) fn of(body: &Body, options: &Options) -> Vec<String> {
    let found = missed(options, body).or_else(|| lost(body));
    let of_face = body.face().map(|face| of_face(body, face, options));
    let all = found.into_iter().chain(of_face.into_iter().flatten());
    all.chain(body.left_filled().iter().map(left_filled)).collect()
}

/// What fills a hole was not measured.
fn left_filled(LeftFilled { hole, fault, at: [x, y, z] }: &LeftFilled) -> String {
    format!(
        "hole {hole} stays filled, as its trim loop {fault}, near ({x:.3}, {y:.3}, {z:.3}); what fills it was not measured"
    )
}

fn of_face(body: &Body, face: &SurfaceFit, options: &Options) -> Vec<String> {
    let hints = [
        hindered(body, face),
        spent(body, face, options),
        flattened(options, body),
        strayed_corner(options, face),
        face.crushed.map(|crushed| crushed.to_string()),
        stretched(face),
        folded(face),
        astray(body),
        loose(options, body, across(face)),
        large(face),
        small_holes(options, body),
    ];
    hints.into_iter().flatten().collect()
}

/// The diagonal of the box around the face, in mm.
fn across(face: &SurfaceFit) -> f64 {
    let [low, high] = bounds(face.surface.net.iter().map(|&p| p.into()));
    (high - low).norm()
}

/// A tolerance of the program's own that does not hold is no failure.
fn missed(options: &Options, body: &Body) -> Option<String> {
    let held = body.tolerance_named || body.tolerance_met(options.outliers);
    let more = match body.shape {
        TargetShape::Face => "",
        _ => "; --faces asks for more faces",
    };
    (!held).then(|| {
        let (shape, beyond) = (body.shape.word(), body.beyond());
        format!("the {shape} is not as good as the scan: {beyond}{more}")
    })
}

/// Means hide what is smaller than their cells.
fn lost(body: &Body) -> Option<String> {
    let lost = body.lost_by_means()?;
    Some(format!(
        "{} of {} are farther from the {} than its tolerance and the noise together, {}: outliers, or details that means have lost; a named --tolerance keeps these, and where --max-memory is set, more of it",
        grouped(lost),
        plural(body.deviation.distances.len(), "measured point"),
        body.shape.word(),
        mm(body.tolerance + SIGNIFICANT * body.noise),
    ))
}

/// No surface keeps to noisy points unless it follows the noise.
fn hindered(c: &Body, face: &SurfaceFit) -> Option<String> {
    let noise = face.adapted.hindrance?;
    Some(format!(
        "the points scatter by {} (standard deviation) around a face that follows the shape, so that one within {} of them all would have to follow the noise; a --tolerance of {} or more, or --smooth auto, leaves that out",
        mm(noise),
        mm(c.tolerance),
        mm(outlying(c.deviation.distances.len()) * noise)
    ))
}

/// Finer nets gain too little for the work that they take.
fn spent(body: &Body, face: &SurfaceFit, options: &Options) -> Option<String> {
    let is_left = face.adapted.is_spent && !body.tolerance_met(options.outliers);
    is_left.then(|| {
        format!(
            "finer nets gain little: the search for {} ended after three times the work of a conversion without --tolerance; the face that was found holds a --tolerance of {}",
            mm(body.tolerance),
            mm(body.missed.worst.max(body.face_to_scan.max))
        )
    })
}

/// Fewer points do not tell noise from shape.
const FEW_POINTS: usize = 1000;

/// A support that moves points by so many times the noise is too long.
const MOVED: f64 = 2.0;

/// The tolerance is held against smoothed points.
fn flattened(options: &Options, c: &Body) -> Option<String> {
    let (points, [off, noise]) = (c.deviation.distances.len(), [c.deviation.max, c.noise]);
    let what = match options.smooth.support {
        _ if off <= c.tolerance || c.smooth.moved_max == 0.0 => return None,
        Support::Auto if points < FEW_POINTS => format!(
            "of so few points ({points}) what is taken for noise, {}, may be shape; if the scan is clean, --smooth off keeps to them",
            mm(noise)
        ),
        Support::Fixed(h) if !c.smooth.is_noisy => format!(
            "--smooth {h} moves them by up to {}, though the scan shows no noise; auto leaves them alone",
            mm(c.smooth.moved_max)
        ),
        Support::Fixed(h) if c.smooth.moved_rms > MOVED * noise => format!(
            "--smooth {h} moves them by {:.0} times the noise; a smaller one, or auto, keeps the shape",
            c.smooth.moved_rms / noise
        ),
        _ => return None,
    };
    let named = if options.tolerance.is_some() { "named" } else { "derived" };
    Some(format!(
        "measured points are up to {} from the face, while the tolerance {named}, {}, holds for smoothed ones: {what}",
        mm(off),
        mm(c.tolerance)
    ))
}

/// The share of the scan's size that a named corner may be away from the boundary.
const ASIDE: f64 = 0.1;

fn strayed_corner(options: &Options, face: &SurfaceFit) -> Option<String> {
    let named = options.corners()?;
    let [m, n] = face.surface.shape();
    let corners = [(0, 0), (m - 1, 0), (m - 1, n - 1), (0, n - 1)];
    let corners = corners.map(|(i, j)| Point::from(face.surface.control(i, j)));
    let off = |p: &Point| corners.iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min);
    let (at, off) = named.map(|p| (p, off(&p))).into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    (off > ASIDE * across(face)).then(|| {
        format!(
            "the corner named at ({:.3}, {:.3}, {:.3}) is {} from the outer boundary, whose nearest vertex was taken; count vertices from 0, and name points in the scan's own numbers",
            at.x, at.y, at.z, mm(off)
        )
    })
}

/// L² stretch above which control points are spent unevenly; 1 is none.
const STRETCH: f64 = 2.5;

fn stretched(face: &SurfaceFit) -> Option<String> {
    let stretch = face.parameterize.stretch;
    (face.crushed.is_none() && stretch.l2 > STRETCH).then(|| {
        format!(
            "the map onto the square stretches the scan by {:.1} in the mean; --corners at other places, or cutting the scan, saves control points",
            stretch.l2
        )
    })
}

/// Where the face itself folds CAD cannot offset or cut it.
fn folded(face: &SurfaceFit) -> Option<String> {
    let Folds { inverted, samples, .. } = face.adapted.folds.filter(|folds| folds.inverted > 0)?;
    Some(format!(
        "the surface folds back on itself at {} of the {} that were tested, where CAD programs may fail to offset or cut it; a larger --tolerance, or cutting the scan where it is ragged, leaves fewer folds",
        grouped(inverted),
        plural(samples, "place")
    ))
}

/// Where the face leaves the scan between its points, and nobody named a tolerance: at a share
/// of the triangles that is more than noise explains.
fn astray(c: &Body) -> Option<String> {
    let back = &c.face_to_scan;
    let share = back.beyond as f64 / back.places.max(1) as f64;
    let [x, y, z] = back.max_at;
    (!c.tolerance_named && share > c.spared).then(|| {
        format!(
            "between its points the face leaves the scan by up to {}, near ({x:.3}, {y:.3}, {z:.3}), and by more than the tolerance at {} of {}; a --tolerance that is named is held there, too",
            mm(back.max),
            grouped(back.beyond),
            plural(back.places, "triangle"),
        )
    })
}

/// A named tolerance is far from the noise if it is more than so many times as large, or as small.
const FAR_OFF: f64 = 10.0;

/// A tolerance below this share of the scan's size is fine in any case.
const FINE: f64 = 1e-3;

fn loose(options: &Options, c: &Body, across: f64) -> Option<String> {
    let tolerance = options.tolerance?;
    let noise = c.noise;
    if !c.smooth.is_noisy {
        return None;
    }
    let [ours, its] = [tolerance, noise].map(mm);
    match tolerance / noise {
        r if r > FAR_OFF && tolerance > FINE * across => Some(format!(
            "the tolerance, {ours}, is {r:.0} times the noise of the scan, {its}; a smaller --tolerance keeps more of its shape"
        )),
        r if r < 1.0 / FAR_OFF => Some(format!(
            "the tolerance, {ours}, is far below the noise of the scan, {its}; a larger --tolerance needs fewer control points and loses nothing"
        )),
        _ => None,
    }
}

/// Nets above this are slow in CAD programs.
const LARGE: usize = 40_000;

fn large(face: &SurfaceFit) -> Option<String> {
    let net = face.surface.net.len();
    (net > LARGE).then(|| {
        format!(
            "{} are many for a CAD program; a larger --tolerance needs fewer",
            plural(net, "control point")
        )
    })
}

/// So many holes cut out that were better left filled, and the vertices of a rim
/// that is one of them.
const SMALL_HOLES: usize = 10;
const SMALL_RIM: usize = 16;

fn small_holes(options: &Options, c: &Body) -> Option<String> {
    if options.cut != Cut::All {
        return None;
    }
    let holes = c.fill.holes.iter().zip(&c.trimmed);
    let small: Vec<f64> = holes
        .filter(|(hole, cut)| **cut && hole.islands == 0 && hole.rim_vertices <= SMALL_RIM)
        .map(|(hole, _)| hole.rim_length)
        .collect();
    (small.len() >= SMALL_HOLES).then(|| {
        let longest = small.iter().copied().fold(0.0, f64::max);
        format!(
            "{} of the {} holes cut out are small; --fill-only-holes-below {:.3} leaves them filled",
            small.len(),
            c.trimmed.iter().filter(|cut| **cut).count(),
            1.01 * longest
        )
    })
}
