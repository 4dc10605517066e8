//! What becomes of the components of a scan: faces, solids or shells.

use std::collections::BTreeSet;

use formats::scene::Placement;

use super::conversion::{Body, Part, placed};
use super::exact::{self, Exact};
use super::lengths::Shown;
use super::memory::MemoryBound;
use super::shape::{TargetShape, shape};
use super::{Conversion, Observer, Options, Stage, body, exact_choice, face, hints, scanned};
use crate::error::{Error, Result};
use crate::mesh::{Choice, Components, Nested};
use crate::stages::parameterize::CompressedRegion;

/// Components, each with what becomes of it.
type Shapes = Vec<(Choice, TargetShape)>;

/// Converts the components that the options choose.
pub(super) fn converted(
    scan: &Components,
    options: &Options,
    watch: &mut Observer,
) -> Result<Conversion> {
    let mut fallback = None;
    let may_be_exact = exact::are_wanted(scan, options)
        && !exact::is_noisy(scan, options.component, options.bound.is_some())?;
    if may_be_exact {
        // Only noise hides what means lose.
        options.bound.as_ref().map_or(Ok(()), MemoryBound::refuse)?;
        let chosen = with_voids(scan, exact_choice::chosen(scan, options)?)?;
        let found = match exact::exact(scan, &chosen, options, watch)? {
            Exact::Unsuited => scanned::scanned(scan, &chosen, options, watch)?,
            found => found,
        };
        match found {
            Exact::Bodies(bodies) => {
                let bodies = bodies.into_iter().map(|body| placed_body(body, scan, options));
                return one(bodies.collect(), options, None);
            }
            Exact::Failed(why) => {
                fallback =
                    Some(format!("the exact faces that were found make no valid body: {why}"))
            }
            Exact::NotTried(why) => fallback = Some(why),
            Exact::Unsuited => {}
        }
    }
    if options.align {
        let why = fallback.unwrap_or_else(|| "no exact faces of significance were found".into());
        return Err(Error::Unaligned(why));
    }
    let made = with_splines(scan, options, watch);
    let mut made = made.map_err(|error| error.instead_of_exact(fallback.as_ref()))?;
    if let Some(body) = made.parts.iter_mut().flat_map(|part| &mut part.bodies).next() {
        body.hints.extend(exact::left_for_splines(scan, options)?);
        let as_splines = |why| format!("the faces are B-splines, as {why}");
        body.hints.extend(fallback.as_ref().map(as_splines));
    }
    Ok(Conversion { fallback: made.fallback.or(fallback), ..made })
}

/// Converts the components that the options choose to B-spline faces.
fn with_splines(scan: &Components, options: &Options, watch: &mut Observer) -> Result<Conversion> {
    let chosen = options.chosen(scan);
    let faces = |shape| chosen.iter().map(|&component| (component, shape)).collect::<Shapes>();
    let shapes = shapes(scan, &chosen, options.shape)?;
    if options.shape.is_some() {
        return bodies(scan, &shapes, options, None, watch)
            .and_then(|made| one(made, options, None));
    }
    if shapes.iter().any(|of| of.1 != TargetShape::Face) {
        let made = bodies(scan, &shapes, options, Some(why(&shapes)), watch)?;
        return one(made, options, None);
    }
    let mut compressed = None;
    let tried = bodies(scan, &shapes, options, None, &mut |stage| {
        let Stage::Parameterize(map, found) = stage else { return watch(stage) };
        compressed = found;
        watch(Stage::Parameterize(map, None))?;
        found.map_or(Ok(()), |_| Err(Error::Stopped))
    });
    let unsuited = match tried {
        Ok(made) => return one(made, options, None),
        Err(error) => unsuited(error, compressed)?,
    };
    let fallback = format!("one face does not hold the scan: {unsuited}");
    let why = format!("as {fallback}");
    match bodies(scan, &faces(TargetShape::Shell), options, Some(&why), watch) {
        Ok(made) => one(made, options, Some(fallback)),
        Err(error) if is_final(&error) => Err(error),
        Err(error) => {
            let fallback = format!("no sound shell was found: {error}");
            let why = format!("as {fallback}");
            let made = bodies(scan, &faces(TargetShape::Face), options, Some(&why), watch)?;
            one(made, options, Some(fallback))
        }
    }
}

/// A conversion with one part.
fn one(bodies: Vec<Body>, options: &Options, fallback: Option<String>) -> Result<Conversion> {
    let parts = vec![Part::of(&options.name, bodies)?];
    Ok(Conversion { parts, fallback, colour: None })
}

/// Whether after a shell that failed so a face is not worth trying: the work was stopped, or is too much.
fn is_final(error: &Error) -> bool {
    match error {
        Error::Piece { error, .. } => is_final(error),
        error => matches!(error, Error::Stopped | Error::ManyFaces(_) | Error::MaxMemory { .. }),
    }
}

/// Why one face does not hold a sheet. Other errors are returned.
fn unsuited(error: Error, compressed: Option<CompressedRegion>) -> Result<String> {
    let of_piece = match &error {
        Error::Piece { error, .. } => error,
        error => error,
    };
    match (of_piece, compressed) {
        (Error::Stopped, Some(found)) => {
            let p = found.at;
            Ok(format!("the map compresses a part near ({:.3}, {:.3}, {:.3})", p.x, p.y, p.z))
        }
        (Error::Folded { .. } | Error::Trim { .. }, _) => Ok(error.to_string()),
        _ => Err(error),
    }
}

/// What becomes of components. If only some would become faces, these become shells.
fn shapes(scan: &Components, components: &[Choice], named: Option<TargetShape>) -> Result<Shapes> {
    let of =
        |&component: &Choice| Ok((component, named.map_or_else(|| shape(scan, component), Ok)?));
    let mut shapes: Shapes = components.iter().map(of).collect::<Result<_>>()?;
    if shapes.iter().all(|of| of.1 == TargetShape::Face) {
        return Ok(shapes);
    }
    for of in shapes.iter_mut().filter(|of| of.1 == TargetShape::Face) {
        of.1 = TargetShape::Shell;
    }
    with_voids(scan, shapes)
}

/// The same with the voids of each solid after it. The solid of a void is the nearest component around it, and a
/// component in a void is a solid again.
fn with_voids(scan: &Components, shapes: Shapes) -> Result<Shapes> {
    let of_solids = shapes.iter().filter(|of| of.1 == TargetShape::Solid);
    let mut solids: BTreeSet<usize> = of_solids.map(|of| of.0.number()).collect();
    if solids.is_empty() {
        return Ok(shapes);
    }
    let mut voids = BTreeSet::new();
    for Nested { component, around, is_opposite } in scan.nested()? {
        if is_opposite && solids.contains(&around) {
            solids.remove(&component);
            voids.insert((around, component));
        }
    }
    let mut all = Vec::with_capacity(shapes.len() + voids.len());
    for (component, shape) in shapes {
        let number = component.number();
        if shape != TargetShape::Solid {
            all.push((component, shape));
        } else if solids.contains(&number) {
            let own = voids.range((number, 0)..=(number, usize::MAX));
            all.push((component, shape));
            all.extend(own.map(|void| (Choice::Number(void.1), TargetShape::Void)));
        }
    }
    Ok(all)
}

/// Why bodies became what they are, unless a shape was named.
fn why(shapes: &[(Choice, TargetShape)]) -> &'static str {
    match shapes.iter().all(|of| of.1 != TargetShape::Shell) {
        true => "as the scan is closed or nearly so",
        false => "as one face does not hold the scan",
    }
}

/// Converts components one after another.
fn bodies(
    scan: &Components,
    shapes: &[(Choice, TargetShape)],
    options: &Options,
    why: Option<&str>,
    watch: &mut Observer,
) -> Result<Vec<Body>> {
    let is = |wanted| shapes.iter().any(|of| of.1 == wanted);
    let shape = match (is(TargetShape::Face), is(TargetShape::Shell)) {
        (true, _) => TargetShape::Face,
        (_, true) => TargetShape::Shell,
        _ => TargetShape::Solid,
    };
    watch(Stage::Begin { shape, components: shapes.len(), why })?;
    let one = |(number, &(component, shape)): (usize, &(Choice, TargetShape))| {
        watch(Stage::Component(number))?;
        let body = one_body(scan, shape, &options.of_component(component), watch)
            .map_err(|error| error.of_component(component.number(), shapes.len()))?;
        watch(Stage::Done(&body))?;
        Ok(body)
    };
    shapes.iter().enumerate().map(one).collect()
}

/// Converts one component. The stages work in the lengths of its mesh, and callers in mm.
fn one_body(
    scan: &Components,
    shape: TargetShape,
    options: &Options,
    watch: &mut Observer,
) -> Result<Body> {
    let mm = scan.mm();
    let mut shown = Shown::new(watch, mm);
    let own = options.in_lengths(mm);
    let made = match shape {
        TargetShape::Face => face::face(scan, &own, &mut |stage| shown.see(stage)),
        _ => body::body(scan, shape, &own, &mut |stage| shown.see(stage)),
    };
    let body = made.map_err(|error| shown.in_mm(error).with_named(options))?.with_named(options);
    let hints = hints::of(&body, options);
    Ok(Body { hints, ..placed_body(body, scan, options) })
}

/// The body with the place from which the scan is measured.
fn placed_body(body: Body, scan: &Components, options: &Options) -> Body {
    let origin = scan.origin();
    // The places of an aligned body are no longer those of the scan, wherever these are measured from.
    if let Some(own) = body.placement {
        let away = Placement { axes: Placement::IDENTITY.axes, translation: origin.map(|x| -x) };
        return Body { placement: Some(own.after(&away)), ..body };
    }
    Body { brep: placed(body.brep, origin, options.keeps_origin), origin, ..body }
}
