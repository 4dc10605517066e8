//! The way from the components of a scan to whatever holds them: faces, solids or shells.

use std::collections::BTreeSet;

use super::body::{BodyConversion, convert_body, joined_bodies};
use super::components::{convert_components, joined};
use super::shape::{TargetShape, shape};
use super::{Conversion, Options, Stage};
use crate::error::{Error, Result};
use crate::mesh::{Choice, Components, Nested};
use crate::stages::parameterize::CompressedRegion;

/// What components of a scan became.
#[derive(Debug)]
pub enum Converted {
    /// A face for each component.
    Faces(Vec<Conversion>),
    /// A solid, a void or a shell for each component. A void follows its solid.
    Bodies(Vec<BodyConversion>),
}

/// The result of [`convert_scan`].
#[derive(Debug)]
#[non_exhaustive]
pub struct ScanConversion {
    /// What the components became.
    pub made: Converted,
    /// Why this is not the shape that was tried first.
    pub fallback: Option<String>,
}

/// A callback that sees the position of a component and each [`Stage`] of its conversion. An error of its own
/// stops the conversion.
pub type ScanObserver<'a> = dyn FnMut(usize, Stage) -> Result<()> + Send + 'a;

impl Converted {
    /// All faces, solids and shells in one B-rep.
    ///
    /// # Errors
    /// Those of [`joined_bodies`].
    pub fn joined(&self, name: impl Into<String>) -> Result<formats::Brep> {
        match self {
            Converted::Faces(faces) => Ok(joined(name, faces)),
            Converted::Bodies(bodies) => joined_bodies(name, bodies),
        }
    }
}

/// Converts components of a scan to the shape that the options name, or to the one that suits them: solids if
/// they are closed or nearly so, shells if they have handles or are pipes, and faces otherwise. If one face
/// does not hold a sheet well, a shell is tried. If there is no sound shell, a face has to do.
///
/// `watch` is shown [`Stage::Begin`] before each try, and after it what each stage makes.
///
/// # Errors
/// What stops a stage, or what `watch` answers.
pub fn convert_scan(
    scan: &Components,
    components: &[Choice],
    options: &Options,
    watch: &mut ScanObserver,
) -> Result<ScanConversion> {
    let shapes = shapes(scan, components, options.shape)?;
    let done = |made| Ok(ScanConversion { made, fallback: None });
    if !shapes.is_empty() {
        let why = options.shape.is_none().then(|| why(&shapes));
        return bodies(scan, &shapes, options, why, watch).and_then(done);
    }
    if options.shape.is_some() {
        return faces(scan, components, options, None, watch).and_then(done);
    }
    let mut compressed = None;
    let tried = faces(scan, components, options, None, &mut |number, stage| {
        let Stage::Parameterize(map, found) = stage else { return watch(number, stage) };
        compressed = found;
        watch(number, Stage::Parameterize(map, None))?;
        found.map_or(Ok(()), |_| Err(Error::Stopped))
    });
    let unsuited = match tried {
        Ok(made) => return done(made),
        Err(error) => unsuited(error, compressed)?,
    };
    let fallback = format!("one face does not hold the scan: {unsuited}");
    let shells: Vec<_> = components.iter().map(|&c| (c, TargetShape::Shell)).collect();
    let why = format!("as {fallback}");
    match bodies(scan, &shells, options, Some(&why), watch) {
        Ok(made) => Ok(ScanConversion { made, fallback: Some(fallback) }),
        Err(Error::Stopped) => Err(Error::Stopped),
        Err(error) => {
            let fallback = format!("no sound shell was found: {error}");
            let made = faces(scan, components, options, Some(&format!("as {fallback}")), watch)?;
            Ok(ScanConversion { made, fallback: Some(fallback) })
        }
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

/// The components that become solids, voids or shells. There are none if all become faces. If only some
/// would become faces, these become shells, too.
fn shapes(
    scan: &Components,
    components: &[Choice],
    named: Option<TargetShape>,
) -> Result<Vec<(Choice, TargetShape)>> {
    let of =
        |&component: &Choice| Ok((component, named.map_or_else(|| shape(scan, component), Ok)?));
    let mut shapes: Vec<_> = components.iter().map(of).collect::<Result<_>>()?;
    if shapes.iter().all(|of| of.1 == TargetShape::Face) {
        return Ok(Vec::new());
    }
    for of in shapes.iter_mut().filter(|of| of.1 == TargetShape::Face) {
        of.1 = TargetShape::Shell;
    }
    with_voids(scan, shapes)
}

/// The same with the voids of each solid after it. The solid of a void is the nearest component around it, and a
/// component in a void is a solid again.
fn with_voids(
    scan: &Components,
    shapes: Vec<(Choice, TargetShape)>,
) -> Result<Vec<(Choice, TargetShape)>> {
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

fn faces(
    scan: &Components,
    components: &[Choice],
    options: &Options,
    why: Option<&str>,
    watch: &mut ScanObserver,
) -> Result<Converted> {
    watch(0, Stage::Begin { shape: TargetShape::Face, components: components.len(), why })?;
    convert_components(scan, components, options, watch).map(Converted::Faces)
}

fn bodies(
    scan: &Components,
    shapes: &[(Choice, TargetShape)],
    options: &Options,
    why: Option<&str>,
    watch: &mut ScanObserver,
) -> Result<Converted> {
    let is_shell = shapes.iter().any(|of| of.1 == TargetShape::Shell);
    let shape = if is_shell { TargetShape::Shell } else { TargetShape::Solid };
    watch(0, Stage::Begin { shape, components: shapes.len(), why })?;
    let one = |(number, &(component, shape)): (usize, &(Choice, TargetShape))| {
        let options = options.of_component(component);
        let body = convert_body(scan, shape, &options, &mut |stage| watch(number, stage))
            .map_err(|error| error.of_component(component.number(), shapes.len()))?;
        watch(number, Stage::BodyDone(&body))?;
        Ok(body)
    };
    shapes.iter().enumerate().map(one).collect::<Result<_>>().map(Converted::Bodies)
}
