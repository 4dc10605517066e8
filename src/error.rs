//! Why a scan could not become a face, and what to do about it.

use std::path::PathBuf;

use faer::sparse::CreationError;
use faer::sparse::linalg::{LltError, LuError};

use crate::geometry::{Bound, Point};
use crate::rules;
use crate::words::{self, bytes, grouped, plural};

/// A result of the pipeline.
pub type Result<T> = std::result::Result<T, Error>;

/// What stops a conversion. [`Error::help`] says what the user can do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read or written.
    #[error(transparent)]
    File(#[from] formats::Error),
    /// A scan that was read from a file cannot be converted.
    #[error("{}: {error}", formats::words::printable(&file.to_string_lossy()))]
    Scan {
        /// The file as the user named it.
        file: PathBuf,
        /// Why.
        error: Box<Error>,
    },
    /// One of several components cannot be converted.
    #[error("component {component}: {error}")]
    Piece {
        /// The number of the component, where the largest one is 0.
        component: usize,
        /// Why.
        error: Box<Error>,
    },
    /// Neither the exact faces that were found nor B-spline faces make a body.
    #[error("{error} (it was to get B-spline faces, as {why})")]
    Splines {
        /// Why there are no exact faces.
        why: String,
        /// Why there are no B-spline faces.
        error: Box<Error>,
    },
    /// A part is to be turned to its main plane and axis, but there are none.
    #[error("cannot be aligned, as {0}")]
    Unaligned(String),
    /// The numbers of a mesh are in steps that are longer than its edges, in mm.
    #[error(
        "the coordinates are so far from zero for their digits that they are in steps of {}, which are longer than most \
         edges ({})", words::mm(*step), words::mm(*edge)
    )]
    Coarse {
        /// The distance between a number and the next one.
        step: f64,
        /// The median edge.
        edge: f64,
    },
    /// No triangle is left once unusable ones are dropped.
    #[error("no usable triangle: {0}")]
    Empty(String),
    /// A cloud of points is not the scan of a surface.
    #[error("{0}")]
    Cloud(CloudFault),
    /// Too much of a scan was to be left out, or the plane on which it stands was not found.
    #[error("{0}")]
    Crop(&'static str),
    /// The asked-for component does not exist.
    #[error("there is no component {asked}; the scan has {}", plural(*count, "component"))]
    Component {
        /// The component asked for, counted from 0, largest first.
        asked: usize,
        /// How many there are.
        count: usize,
    },
    /// The scan has no vertex with the number that an option names.
    #[error("there is no vertex {asked}; the scan has {}", plural(*count, "vertex"))]
    Vertex {
        /// The number, counted from 0.
        asked: usize,
        /// How many vertices the file has.
        count: usize,
    },
    /// The conversion may need more memory than the caller allows.
    #[error(
        "may need {} for {}, {} and up to {}{}; --max-memory allows {}",
        bytes(*needed),
        plural(*vertices, "vertex"),
        plural(*triangles, "triangle"),
        plural(*control_points, "control point"),
        averaged.map_or(String::new(), |least| format!(", and {} with means of them", bytes(least))),
        bytes(*allowed)
    )]
    MaxMemory {
        /// Bytes that it may need.
        needed: u64,
        /// Bytes that the caller allows.
        allowed: u64,
        /// Vertices of the scan.
        vertices: usize,
        /// Triangles of the scan.
        triangles: usize,
        /// The largest number of control points.
        control_points: usize,
        /// Bytes that it may need if few means take the place of the points or vertices, if they may.
        averaged: Option<u64>,
    },
    /// The component has one side only.
    #[error("the surface is one-sided (a Möbius strip is in it) and cannot be oriented")]
    NotOrientable,
    /// The component is not a disk with holes.
    #[error("the surface is {}", kind(*genus, *loops))]
    NotADisk {
        /// Handles.
        genus: usize,
        /// Boundary loops.
        loops: usize,
    },
    /// The corners that the user gave cannot be the corners of the patch.
    #[error("corners: {0}")]
    Corners(String),
    /// The outer boundary has too few vertices to be the four sides of a patch.
    #[error("the outer boundary has {}, too few for a face with four sides", plural(*.0, "vertex"))]
    TooSmall(usize),
    /// With the support that was named most points have too few neighbours, in it or,
    /// once these are drawn together, at all.
    #[error("no surface can be fitted with a support of {h} mm")]
    Support {
        /// The support h, in mm.
        h: f64,
        /// The shortest that finds neighbours enough on most of the scan.
        shortest: f64,
        /// The scan's diagonal.
        longest: f64,
    },
    /// A hole could not be filled.
    #[error("hole {hole} cannot be filled, near {}", mm(at))]
    Fill {
        /// The hole, counted from 0 in the report's order.
        hole: usize,
        /// A point of its rim.
        at: Point,
    },
    /// The parameterization has inverted triangles that mending did not remove.
    #[error("the map of the scan to the plane folds at {}, one near {}", plural(*count, "triangle"), mm(at))]
    Folded {
        /// How many triangles are inverted.
        count: usize,
        /// Corner of one of them.
        at: Point,
    },
    /// A linear system could not be solved.
    #[error("{0}: the linear system is singular")]
    Singular(&'static str),
    /// There is no memory for a linear system, or it is too large to be numbered.
    #[error("{0}: there is not enough memory for the linear system")]
    Memory(&'static str),
    /// An option has a value that cannot be.
    #[error("{option}: {fault}")]
    Option {
        /// The option, by the name of its setter in [`Builder`](crate::convert::Builder).
        option: &'static str,
        /// What is wrong with the value.
        fault: rules::Fault,
    },
    /// The caller stopped it: a callback answered so.
    #[error("stopped")]
    Stopped,
    /// The system starts no more threads.
    #[error("the threads cannot be started: {0}")]
    Threads(String),
    /// What a stage was given does not fit together.
    #[error("{0}")]
    Input(&'static str),
    /// No layout of faces was found on a body.
    #[error("no layout of faces was found: {0}")]
    Layout(&'static str),
    /// A body would have far more faces than anyone wants.
    #[error("the scan is so rough that it would become about {}", plural(*.0, "face"))]
    ManyFaces(usize),
    /// The faces of a solid turn over, or go through each other.
    #[error("the faces fold back or go through each other at {}, one near {}", plural(*count, "place"), mm(at))]
    BodyFolds {
        /// The number of places.
        count: usize,
        /// One of them.
        at: Point,
    },
    /// A body encloses no volume, as where a flat sheet is to become a solid.
    #[error(
        "the body would enclose no volume: it is no thicker than its noise or the rounding of its numbers"
    )]
    Flat,
    /// A trim loop crosses itself, another one or the edge of the patch.
    #[error("the trim loop of {of} {fault}, near {}", mm(at))]
    Trim {
        /// Which loop; holes are counted from 0 in the report's order.
        of: Bound,
        /// What is wrong with the loop.
        fault: String,
        /// A point of the rim.
        at: Point,
    },
    /// A face of a CAD file cannot be measured.
    #[error("{entity}: {what}")]
    Cad {
        /// What the file calls the face.
        entity: String,
        /// What is wrong with it.
        what: String,
    },
    /// The boundary representation breaks one of its own rules.
    #[error("boundary representation: {0}")]
    Brep(BrepFault),
}

/// Why a cloud of points is not the scan of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CloudFault {
    /// There are too few points for a surface.
    #[error("the cloud has {}, too few for a surface", plural(*.0, "different point"))]
    Few(usize),
    /// All points are at the same place.
    #[error("all points of the cloud are at the same place")]
    OnePlace,
    /// The cloud has no scan of the number that an option names.
    #[error("the cloud has no scan {asked}; it has {count}")]
    Scan {
        /// The number, counted from 0.
        asked: usize,
        /// The number of scans.
        count: usize,
    },
    /// Most points are on lines.
    #[error("the points of the cloud are on lines and not on a surface")]
    Line,
    /// Many points are not near any surface.
    #[error("{} of {} of the cloud are not near any surface", grouped(*outliers), plural(*points, "point"))]
    Outliers {
        /// The number of points that are not near a surface.
        outliers: usize,
        /// The number of different points.
        points: usize,
    },
    /// Most points are in no triangle.
    #[error(
        "triangles between neighbours hold only {} of {} of the cloud; the others are on no surface",
        grouped(*used),
        plural(*points, "point")
    )]
    Torn {
        /// The number of points in triangles.
        used: usize,
        /// The number of points.
        points: usize,
    },
    /// There are more points than fit into the memory, and their means are on no surface.
    #[error(
        "the cloud has {}; the means at {} fit into the memory that is allowed, but points in two layers are not averaged",
        plural(*points, "different point"),
        plural(*places, "place")
    )]
    Crowded {
        /// The number of different points.
        points: usize,
        /// The number of places that fit.
        places: usize,
    },
    /// Not even one triangle was found.
    #[error("the points of the cloud make no triangle")]
    NoTriangle,
}

/// A rule that a boundary representation breaks. Faces, loops and edges are
/// counted from 0; a face's outer loop is its loop 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BrepFault {
    /// A loop is not closed in (u, v), leaves the domain, runs the wrong way
    /// round, crosses another one, or is not in its place.
    #[error("loop {ring} of face {face} {fault}")]
    Loop {
        /// The face.
        face: usize,
        /// The loop.
        ring: usize,
        /// What is wrong with it.
        fault: LoopFault,
    },
    /// A loop has not as many edges as pcurves.
    #[error("loop {ring} of face {face} has not one pcurve for each edge")]
    Pairs {
        /// The face.
        face: usize,
        /// The loop.
        ring: usize,
    },
    /// A curve or a surface is none that a file holds.
    #[error("{0}")]
    Spline(String),
    /// The parts do not suit each other.
    #[error("{0}")]
    Parts(formats::brep::ModelFault),
}

/// What can be wrong with one loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum LoopFault {
    /// It is not made of cubic arcs, each beginning where the last one ends.
    #[error("is not closed")]
    Open,
    /// It turns back on itself.
    #[error("has a cusp")]
    Cusp,
    /// It comes too near the edge of the domain, or runs beyond.
    #[error("leaves the patch")]
    Leaves,
    /// It crosses or touches itself.
    #[error("crosses itself")]
    CrossesItself,
    /// It crosses or touches another one.
    #[error("runs into another one")]
    CrossesAnother,
    /// It runs clockwise where it must not, or the other way round.
    #[error("runs the wrong way round")]
    WrongWay,
    /// It lies in a loop in which it must not, or beside one in which it must.
    #[error("is not in its place among the others")]
    Misplaced,
}

/// Makes an error of what is wrong with an option.
pub(crate) fn of(option: &'static str) -> impl FnOnce(rules::Fault) -> Error {
    move |fault| Error::Option { option, fault }
}

/// Makes an error of why a factorization failed: it is the system's fault only where it is
/// not that of the memory.
pub(crate) fn unsolved(what: &'static str) -> impl Fn(Unsolved) -> Error {
    move |why| match why {
        Unsolved::Memory => Error::Memory(what),
        Unsolved::Singular => Error::Singular(what),
    }
}

/// Why a linear system has no solution.
pub(crate) enum Unsolved {
    /// There is no memory, or there are more entries than can be numbered.
    Memory,
    /// The matrix is singular, or not positive definite.
    Singular,
}

impl From<CreationError> for Unsolved {
    fn from(why: CreationError) -> Self {
        match why {
            CreationError::Generic(_) => Unsolved::Memory,
            CreationError::OutOfBounds { .. } => Unsolved::Singular,
        }
    }
}

impl From<LltError> for Unsolved {
    fn from(why: LltError) -> Self {
        match why {
            LltError::Generic(_) => Unsolved::Memory,
            LltError::Numeric(_) => Unsolved::Singular,
        }
    }
}

impl From<LuError> for Unsolved {
    fn from(why: LuError) -> Self {
        match why {
            LuError::Generic(_) => Unsolved::Memory,
            LuError::SymbolicSingular { .. } => Unsolved::Singular,
        }
    }
}

impl Error {
    /// The same as the error of one of `count` components. A caller that stops the conversion gets its own
    /// error back, and a component that does not exist is named already.
    pub(crate) fn of_component(self, component: usize, count: usize) -> Self {
        match self {
            error @ (Error::Stopped | Error::Input(_) | Error::Component { .. }) => error,
            error if count == 1 => error,
            error => Error::Piece { component, error: Box::new(error) },
        }
    }

    /// The same of B-spline faces that were made instead of exact ones.
    pub(crate) fn instead_of_exact(self, why: Option<&String>) -> Self {
        match (self, why) {
            (Error::Stopped, _) => Error::Stopped,
            (error, None) => error,
            (error, Some(why)) => Error::Splines { why: why.clone(), error: Box::new(error) },
        }
    }

    /// The same with all lengths times a factor. Boundary representations are in mm anyway.
    pub(crate) fn scaled(mut self, factor: f64) -> Self {
        match &mut self {
            Error::Support { h, shortest, longest } => {
                for x in [h, shortest, longest] {
                    *x *= factor;
                }
            }
            Error::Fill { at, .. }
            | Error::Folded { at, .. }
            | Error::BodyFolds { at, .. }
            | Error::Trim { at, .. } => {
                *at *= factor;
            }
            _ => {}
        }
        self
    }

    /// One sentence that says what the user can do. Options stand in backticks, with the names
    /// that they have in [`Builder`](crate::convert::Builder).
    pub fn help(&self) -> String {
        match self {
            Error::File(e) => e.help.clone(),
            Error::Scan { error, .. }
            | Error::Piece { error, .. }
            | Error::Splines { error, .. } => error.help(),
            Error::Unaligned(_) => {
                "leave out `align`, and turn the part in CAD; or let the whole part be scanned".into()
            }
            Error::Coarse { .. } => {
                "export the mesh again with more digits (numbers of 64 bits), or measured from a point near to it".into()
            }
            Error::Empty(_) => {
                "check the export: the scan must be a triangle mesh with finite coordinates".into()
            }
            Error::Cloud(CloudFault::Few(_) | CloudFault::OnePlace) => {
                "export more points: a surface takes at least 100 different ones".into()
            }
            Error::Cloud(CloudFault::Scan { count, .. }) => {
                format!("choose a `scan` from 0 to {}", count.saturating_sub(1))
            }
            Error::Cloud(CloudFault::Line) => {
                "scan the surface with lines that are as close to each other as the points on them".into()
            }
            Error::Cloud(CloudFault::Outliers { .. }) => {
                "remove what is not the surface, such as plants and reflections, from the cloud".into()
            }
            Error::Cloud(CloudFault::Crowded { .. }) => {
                "allow more memory, or take a part of the cloud with `scan`, `within` or `max_points`".into()
            }
            Error::Cloud(CloudFault::Torn { .. }) => {
                "check that x, y and z are the coordinates (`columns` names them) and have one unit: degrees are none".into()
            }
            Error::Cloud(CloudFault::NoTriangle) => {
                "name a smaller `spacing`, or scan the surface with more points".into()
            }
            Error::Crop(_) => "name a `within` or an `above` that suits the scan (inspect prints its size)".into(),
            Error::Component { count: 1, .. } => "leave `component` out, as there is only one".into(),
            Error::Component { count, .. } => {
                format!("choose a `component` from 0 to {}, or the largest", count.saturating_sub(1))
            }
            Error::Vertex { .. } => "count vertices as the file does, from 0".into(),
            Error::MaxMemory { .. } => {
                "allow more, leave out the `tolerance`, bound the net with a smaller `max_net`, or take the points of a mesh alone with `remesh`".into()
            }
            Error::NotOrientable => "cut the strip open, or choose another `component`".into(),
            Error::NotADisk { loops: 0, .. } => {
                "ask for a solid (`shape`), or cut the surface open along a seam".into()
            }
            Error::NotADisk { .. } => {
                "ask for a solid (`shape`), which fills all gaps, or cut the handles open so that one sheet is left".into()
            }
            Error::Corners(_) => {
                "give four different vertices of the outer boundary as `corners`, or leave the option out".into()
            }
            Error::TooSmall(_) => {
                "let the boundary be a trim loop (name neither `outline` nor `corners`), scan it finer, or choose another `component`; if all its triangles are loose (inspect counts the pieces), merge vertices that are close before the export".into()
            }
            Error::Support { shortest, longest, .. } => format!(
                "name a `smooth` between the spacing of the points and a share of the scan, \
                 {shortest:.3} to {:.3} mm say, or leave the option out",
                0.2 * longest
            ),
            Error::Fill { .. } => "repair or remesh the scan around that hole".into(),
            Error::Folded { .. } | Error::BodyFolds { .. } => {
                "repair or remesh the scan around that place".into()
            }
            Error::Flat => "ask for a face or a shell (`shape`)".into(),
            Error::ManyFaces(_) => "name the number of `faces`, thin the scan, convert a part of it, or name the `shape` face with a `tolerance` that passes over its details".into(),
            Error::Layout(_) => {
                "remesh the scan with even triangles, or cut it open and convert the pieces".into()
            }
            Error::Singular(_) => "remesh the scan: it has degenerate triangles".into(),
            Error::Memory(_) => {
                "name a larger `tolerance`, or a smaller `max_net`, or thin the scan".into()
            }
            Error::Option { fault: rules::Fault::LargeNet { .. }, .. } => {
                "name a smaller `net`, or a larger `max_net`".into()
            }
            Error::Option { fault: rules::Fault::LargeLayout { least, .. }, .. } => {
                format!("name a `max_net` of {least} or more, or fewer `faces`")
            }
            Error::Option { option, .. } => {
                format!("give another value for `{option}`, or leave the option out")
            }
            Error::Stopped => "start it again to get a result".into(),
            Error::Threads(_) => "name fewer `threads`".into(),
            Error::Input(_) => "hand on what the stage before made".into(),
            Error::Trim { of: Bound::Outer, .. } => {
                "lay the outer boundary on the sides (`outline`), or name a smaller `tolerance`".into()
            }
            Error::Trim { .. } => {
                "name another `shape`, or a smaller `tolerance`; a face can also keep that hole filled (`cut`)".into()
            }
            Error::Cad { .. } => "repair the face in a CAD program, and export it again".into(),
            Error::Brep(_) => "please report this scan as a bug".into(),
        }
    }
}

fn kind(genus: usize, loops: usize) -> String {
    match loops {
        0 => format!("closed, genus {genus}, no boundary, and not a disk with holes"),
        1 => format!("not a disk with holes: genus {genus}, one boundary loop"),
        n => format!("not a disk with holes: genus {genus}, {n} boundary loops"),
    }
}

fn mm(p: &Point) -> String {
    format!("({:.3}, {:.3}, {:.3}) mm", p.x, p.y, p.z)
}

#[cfg(test)]
mod tests {
    use faer::sparse::FaerError;

    use super::*;

    #[test]
    fn a_lack_of_memory_is_no_degenerate_triangle() {
        for why in [FaerError::OutOfMemory, FaerError::IndexOverflow] {
            let causes: [Unsolved; 3] = [
                CreationError::Generic(why).into(),
                LltError::Generic(why).into(),
                LuError::Generic(why).into(),
            ];
            for error in causes.map(unsolved("fit")) {
                assert!(matches!(error, Error::Memory("fit")), "{error}");
                assert!(!error.help().contains("degenerate"));
            }
        }
        let singular = unsolved("fit")(LuError::SymbolicSingular { index: 0 }.into());
        assert!(matches!(singular, Error::Singular("fit")));
    }
}
