//! The messages of `convert`: what it read, what each stage made, and the result.

use scan2step::mesh::{Bound, Components, FaceOrigin, Patch};
use scan2step::report::{ScanSource, SurfaceCounts, placement_rows};
use scan2step::words::{grouped, mm, plain_mm, plural, repair, tolerance_reason};
use scan2step::{Body, BodyFit, ExactFit, InputReport, Stage, SurfaceFit, TargetShape};

use super::args::{ComponentChoice, Convert};
use super::input::ReadScan;
use super::progress::ProgressDisplay;
use super::{Outcome, cylinders, gaps, streams};

/// Which shape is tried, and why.
pub(super) fn shape(shape: TargetShape, why: &str) -> String {
    format!("shape: a {}, {why} (--shape to change)", shape.word())
}

/// What a stage made, in one line.
pub(crate) fn made(stage: &Stage) -> String {
    match stage {
        Stage::Mesh(disk) => {
            let holes = plural(disk.holes.len(), "hole");
            let mesh = mesh([disk.mesh.points.len(), disk.mesh.triangles.len()]);
            format!("{mesh}, {holes}")
        }
        Stage::Regions(regions) => plural(regions.regions.len(), "region"),
        Stage::Fill(patch) if patch.rims.is_empty() => "nothing to fill".into(),
        Stage::Fill(patch) => {
            let filled = count(patch, |origin| matches!(origin, FaceOrigin::Hole(_)));
            let holes = plural(patch.rims.len(), "hole");
            format!("{holes} filled with {}", plural(filled, "triangle"))
        }
        Stage::Parameterize(map, _) => {
            let bays = match count(&map.patch, |o| *o == FaceOrigin::Bay) {
                0 => None,
                bays => Some(format!("around bays with {}", plural(bays, "triangle"))),
            };
            let is_thinned = map.patch.stand_ins.is_some();
            let left =
                is_thinned.then(|| format!("thinned to {}", plural(map.patch.measured, "vertex")));
            left.into_iter().chain(bays).collect::<Vec<_>>().join(", ")
        }
        Stage::Fit(surface) => {
            let [m, n] = surface.shape();
            format!("{m} × {n} control points")
        }
        Stage::Layout(quads) => {
            let quads_each = plural(quads.side.pow(2), "quad");
            format!("{} with {quads_each} each", plural(quads.blocks(), "block"))
        }
        Stage::Network(network) => plural(network.surfaces.len(), "face"),
        Stage::NetworkTrim(_, cut) => plural(cut.faces.len(), "kept face"),
        Stage::Trim(_, loops) => plural(loops.len(), "trim loop"),
        _ => String::new(),
    }
}

/// The triangles of a patch that have such an origin.
fn count(patch: &Patch, of: impl Fn(&FaceOrigin) -> bool) -> usize {
    patch.origin.iter().filter(|origin| of(origin)).count()
}

/// The scan's file and its counts.
pub(crate) fn came_in(scan: &ReadScan) -> String {
    format!("{}: {}", scan.path.display(), counts(&scan.source))
}

/// The counts of a scan's file.
pub(crate) fn counts(source: &ScanSource) -> String {
    let ScanSource { vertices, triangles, cloud, .. } = source;
    match cloud {
        Some(cloud) if cloud.scans.len() > 1 => {
            format!("{} of {}", plural(*vertices, "point"), plural(cloud.scans.len(), "scan"))
        }
        Some(_) => plural(*vertices, "point"),
        None => mesh([*vertices, *triangles]),
    }
}

/// The counts of a mesh.
pub(super) fn mesh([vertices, triangles]: [usize; 2]) -> String {
    format!("{}, {}", plural(vertices, "vertex"), plural(triangles, "triangle"))
}

/// What a mesh that was made of a cloud has.
pub(crate) fn meshed(components: &Components) -> String {
    let triangles: usize = components.sizes().iter().sum();
    format!("{}, {}", plural(triangles, "triangle"), plural(components.sizeable(), "component"))
}

/// Says where a scan far from zero is measured from, and what was found in a cloud of points, of which so many
/// components were made.
pub(super) fn cloud(progress: &ProgressDisplay, scan: &ReadScan, components: usize) {
    if scan.source.origin_mm != [0.0; 3] {
        let [x, y, z] = scan.source.origin_mm;
        progress.say(&format!("origin: coordinates are measured from ({x}, {y}, {z}) mm"));
    }
    let Some(cloud) = &scan.source.cloud else { return };
    let Some(mesh) = &cloud.mesh else { return };
    progress.say(&format!("points: {} apart, noise {}", mm(mesh.spacing_mm), mm(mesh.noise_mm)));
    if let Some(distance) = mesh.layers_mm {
        // One layer may end over the other one, where the mesh goes from one to the other.
        let joined = match components {
            1 => {
                "one surface holds both, and what joins them was not measured: cut one off with --box or --above"
            }
            _ => "they are not joined",
        };
        progress.say(&format!(
            "layers: the points are in two layers {} apart, as the sides of a plate or scans that are not registered; \
             {joined}",
            mm(distance)
        ));
    }
    if let Some(distance) = mesh.averaged_mm {
        progress.say(&format!("points: averaged to places {} apart", mm(distance)));
    }
    if mesh.outliers > 0 {
        progress.say(&format!("points: {} left out", plural(mesh.outliers, "outlier")));
    }
}

/// Says which unit the scan has, if it is not declared as mm.
pub(crate) fn assumed(progress: &ProgressDisplay, scan: &ReadScan) {
    let ScanSource { unit, unit_assumed, .. } = scan.source;
    if unit_assumed {
        let unit = unit.symbol();
        progress.say(&format!("units: the file does not say; assuming {unit} (--units to change)"));
    } else if unit.in_mm() != 1.0 {
        progress.say(&format!("units: {}", unit.symbol()));
    }
}

/// Says what was repaired, and how often.
pub(crate) fn repaired(progress: &ProgressDisplay, (kind, count): (&&str, &usize)) {
    progress.say(&format!("repaired: {}", repair(kind, *count)));
}

/// Says which handles were cut.
pub(super) fn handles(progress: &ProgressDisplay, input: &InputReport) {
    let longest = input.handles.iter().max_by(|a, b| a.length.total_cmp(&b.length));
    if let Some(handle) = longest {
        progress.say(&format!(
            "repaired: {} cut; the loop of the largest is {}, near ({:.3}, {:.3}, {:.3}) (--handles to change)",
            plural(input.handles.len(), "handle"),
            mm(handle.length),
            handle.at.x,
            handle.at.y,
            handle.at.z
        ));
    }
}

/// Says what the conversion left out and kept, and which tolerance it chose.
pub(crate) fn found(progress: &ProgressDisplay, args: &Convert, c: &Body) {
    handles(progress, &c.input);
    if c.input.left_out > 0 && args.how.component != ComponentChoice::All {
        progress.say(&format!(
            "component: one of {}, {}; left out {} in the others (--component to change)",
            grouped(c.input.components),
            plural(c.input.triangles, "triangle"),
            plural(c.input.left_out, "triangle")
        ));
    }
    if c.input.islands > 0 {
        let triangles = plural(c.input.island_triangles, "triangle");
        progress.say(&format!("islands: {} kept, {triangles}", c.input.islands));
    }
    if let Some(distance) = c.thin().and_then(|thin| thin.averaged) {
        progress.say(&format!("vertices: averaged to places {} apart", mm(distance)));
    }
    if c.smooth.outliers > 0 {
        progress
            .say(&format!("smooth: {} left out of the fits", plural(c.smooth.outliers, "outlier")));
    }
    if let Some(step) = c.smooth.height_step {
        progress.say(&format!(
            "steps: the heights along one axis are in steps of {}, which are taken for noise",
            mm(step)
        ));
    }
    if let Some(by) = &c.placement {
        let rows = placement_rows(by).map(|row| row.map(|x| format!("{x:.6}")).join(" "));
        progress.say(&format!(
            "{}aligned: the main plane lies in z = 0; the matrix from the scan is ({})",
            of_piece(args, &c.input),
            rows.join("; ")
        ));
    }
    if let Some(exact) = c.exact() {
        exact_faces(progress, &of_piece(args, &c.input), exact);
    } else if !c.tolerance_named {
        progress.say(&format!(
            "{}tolerance: {}, {} (--tolerance to change)",
            of_piece(args, &c.input),
            mm(c.tolerance),
            tolerance_reason(c.tolerance, c.noise)
        ));
    }
}

/// The most places of facets that are named in the terminal. A report has all.
const MOST_FALLBACKS: usize = 8;

/// Says why faces are exact, and what was moved or has become facets.
fn exact_faces(progress: &ProgressDisplay, of: &str, exact: &ExactFit) {
    let why = match exact.noise {
        Some(noise) => format!("noise of {} explains how far the vertices are off them", mm(noise)),
        None => format!("the vertices lie on them {}", within_rounding(exact.rounding_factor)),
    };
    progress.say(&format!("{of}surfaces: exact, as {why} (--surfaces spline to change)"));
    gaps::say(progress, of, exact);
    cylinders::say(progress, of, exact);
    if let Some(widest) = exact.risers.iter().max_by_key(|riser| riser.triangles) {
        let (n, p) = (exact.risers.len(), widest.place);
        progress.say(&format!(
            "{of}edges: at {} surfaces do not meet, and other faces join them; {} of them near ({:.3}, {:.3}, {:.3}), where {}",
            plural(n, "place"),
            grouped(widest.triangles),
            p.x,
            p.y,
            p.z,
            widest.why
        ));
    }
    for fallback in exact.fallbacks.iter().take(MOST_FALLBACKS) {
        let (kind, p) = (fallback.kind.name(), fallback.place);
        progress.say(&format!(
            "{of}facets: {} of a {kind} near ({:.3}, {:.3}, {:.3}), as {}",
            plural(fallback.triangles, "triangle"),
            p.x,
            p.y,
            p.z,
            fallback.why
        ));
    }
    if exact.fallbacks.len() > MOST_FALLBACKS {
        let left = exact.fallbacks.len() - MOST_FALLBACKS;
        progress.say(&format!(
            "{of}facets: {} more; --report out.json lists all",
            plural(left, "place")
        ));
    }
    let others = [(exact.free_forms, "free-form face"), (exact.facets, "facet")];
    let others = others.into_iter().filter(|&(count, _)| count > 0);
    let others: Vec<String> = others.map(|(count, what)| plural(count, what)).collect();
    if !others.is_empty() {
        progress.say(&format!(
            "{of}facets: {} where no surface was found; {:.1} % of the area is exact",
            others.join(" and "),
            100.0 * exact.explained
        ));
    }
}

/// How near vertices are to exact faces.
pub(crate) fn within_rounding(factor: f64) -> String {
    if factor > 1.0 {
        format!("within {factor:.0} times the rounding of the file, as if computed in 32 bits")
    } else {
        "within the rounding of the file".into()
    }
}

/// Which of several components a line is about, in front of it.
pub(crate) fn of_piece(args: &Convert, input: &InputReport) -> String {
    match args.how.component {
        ComponentChoice::All if input.components > 1 => format!("component {}: ", input.component),
        _ => String::new(),
    }
}

/// Whether the face is as good as the scan, in a sentence.
fn quality(c: &Body) -> String {
    let all = plural(c.fit_deviation.distances.len(), "point");
    let within = match c.missed.points {
        0 => format!("all {all} are"),
        missed => format!("all but {} of {all} are", grouped(missed)),
    };
    // A point that a loop cuts off does not miss the tolerance, but is farther from the face.
    let at_rims = if c.missed.points == 0 && c.cut_off() > 0 {
        format!("; at rims, which trim loops smooth, up to {}", mm(c.fit_deviation.max))
    } else {
        String::new()
    };
    format!("the face is as good as the scan: {within} within {} of it{at_rims}", mm(c.tolerance))
}

/// The result in one line, and whether the face is as good as the scan.
pub(crate) fn result(progress: &ProgressDisplay, args: &Convert, c: &Body) {
    let files = args.out.iter().map(|f| &f.path).chain(args.report.iter().map(|f| &f.path));
    let files: Vec<_> = files.map(|path| streams::shown(path)).collect();
    let of = of_piece(args, &c.input);
    progress.result(&format!("{of}{} → {}", summary(c), files.join(", ")));
    let is_as_good = c.tolerance_met(args.how.outliers / 100.0) && c.lost_by_means().is_none();
    if c.face().is_some() && !c.tolerance_named && is_as_good {
        progress.say(&(of + &quality(c)));
    }
}

/// What a body is and how near to the scan, in one line.
pub(crate) fn summary(c: &Body) -> String {
    let (made, holes) = match &c.fit {
        BodyFit::Face(face) => made_face(c, face),
        BodyFit::Network(_) => made_body(c),
        BodyFit::Exact(fit) => {
            let farthest = |is_free: bool| {
                let own = fit.faces.iter().filter(|face| face.is_free == is_free);
                own.map(|face| face.max).fold(0.0, f64::max)
            };
            let [exact, free] = [false, true].map(farthest);
            let free = if free > exact {
                format!(", and free-form faces within {}", mm(free))
            } else {
                String::new()
            };
            return format!(
                "{}{}: {}; exact within {}{free}",
                made_body(c).0,
                gaps::edges_and_gaps(c),
                kinds(SurfaceCounts::of(&c.brep).named()),
                mm(exact)
            );
        }
    };
    let [rms, max] = [c.fit_deviation.rms, c.fit_deviation.max].map(mm);
    format!("{made}, rms {rms}, max {max}{holes}")
}

/// What a face is, and what became of the holes.
fn made_face(c: &Body, face: &SurfaceFit) -> (String, String) {
    let [m, n] = face.surface.shape();
    let filled = match c.trimmed.iter().filter(|is_cut| !**is_cut).count() {
        0 => String::new(),
        filled => format!(", {} kept filled", grouped(filled)),
    };
    let cut = face.loops.iter().filter(|l| matches!(l.of, Bound::Hole(_))).count();
    let holes = format!(", {} cut out{filled}", plural(cut, "hole"));
    (format!("{m} × {n} control points"), holes)
}

/// Counts of kinds in words: "3 planes, a cone and a torus".
pub(crate) fn kinds<'a>(counts: impl IntoIterator<Item = (&'a str, usize)>) -> String {
    let counts = counts.into_iter().filter(|(_, count)| *count > 0);
    let of_kind: Vec<String> = counts
        .map(|(kind, count)| match count {
            1 => format!("a {kind}"),
            _ => plural(count, kind),
        })
        .collect();
    match of_kind.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{} and {last}", rest.join(", ")),
        None => String::new(),
    }
}

/// What a body of several faces is, and what became of its gaps.
fn made_body(body: &Body) -> (String, String) {
    let open = body.trimmed.iter().filter(|is_cut| **is_cut).count();
    let gaps = match (body.fill.holes.len() - open, body.volume()) {
        (0, Some(_)) => String::new(),
        (filled, Some(_)) => format!(", {} filled", plural(filled, "gap")),
        (0, None) => format!(", {} open", plural(open, "boundary loop")),
        (filled, None) => {
            format!(", {} open, {} kept filled", plural(open, "boundary loop"), grouped(filled))
        }
    };
    let volume =
        body.volume().map_or(String::new(), |volume| format!(", {} mm³", plain_mm(volume)));
    let faces = plural(body.brep.faces.len(), "face");
    (format!("a {} of {faces}{volume}", body.shape.word()), gaps)
}

/// Says so if the body misses a tolerance that the user named. A loop that is not there keeps no distance from its rim.
pub(crate) fn verdict(args: &Convert, c: &Body) -> Outcome {
    let how = &args.how;
    let misses = how.tolerance.is_some() && !c.tolerance_met(how.outliers / 100.0);
    if !misses && (how.rim_tolerance.is_none() || c.left_filled().is_empty()) {
        return Outcome::Done;
    }
    let of = of_piece(args, &c.input);
    streams::say(format_args!("tolerance not met: {of}{}", c.beyond()));
    Outcome::Missed
}
