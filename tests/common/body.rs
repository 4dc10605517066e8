//! Conversions to one body.

use formats::Brep;
use scan2step::{Body, Options, Result, Scan, Stage, SurfaceFit, TargetShape, convert};

/// Converts a scan to the only body of this shape.
pub fn body_of<'a>(
    scan: impl Into<Scan<'a>>,
    shape: TargetShape,
    options: &Options,
    watch: &mut scan2step::Observer,
) -> Result<Body> {
    let conversion = convert(scan, &options.of_shape(shape), watch)?;
    Ok(conversion.into_body().expect("one body"))
}

/// Converts a scan to one face.
pub fn face_of<'a>(scan: impl Into<Scan<'a>>, options: &Options) -> Result<Body> {
    body_of(scan, TargetShape::Face, options, &mut |_| Ok(()))
}

/// The same, and shows what the stages make.
pub fn face_seen<'a>(
    scan: impl Into<Scan<'a>>,
    options: &Options,
    watch: &mut (dyn FnMut(Stage) -> Result<()> + Send),
) -> Result<Body> {
    body_of(scan, TargetShape::Face, options, watch)
}

/// A body that is one face.
pub trait OneFace {
    /// Its surface, and what was found of it.
    fn one(&self) -> &SurfaceFit;
}

impl OneFace for Body {
    fn one(&self) -> &SurfaceFit {
        self.face().expect("one face")
    }
}

/// A B-rep of a conversion that has one part.
pub fn brep_of(conversion: &scan2step::Conversion) -> &Brep {
    &conversion.parts[0].brep
}
