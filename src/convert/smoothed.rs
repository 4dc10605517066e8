//! The smoothed mesh of a scan. A dense scan is thinned before, as its noise and the supports of the smoothing tell
//! how many of its vertices tell anything.

use std::borrow::Cow;

use super::stage::{Observer, within};
use crate::error::Result;
use crate::geometry::Point;
use crate::mesh::{Disk, StandIns};
use crate::progress;
use crate::stages::thin::ThinnedDisk;
use crate::stages::{smooth, thin};

/// A smoothed mesh, and what was measured of its vertices.
pub(super) struct Smoothed<'a> {
    pub disk: Disk,
    /// Where each vertex was measured: the mean of the points for which it stands.
    pub measured: Cow<'a, [Point]>,
    /// Which vertex stands for each one of the scan, if the mesh was thinned.
    pub stand_ins: Option<StandIns>,
    pub thin: thin::Report,
    pub smooth: smooth::Report,
}

/// Smooths a mesh. Unless each vertex has to be held, a dense one is thinned before.
pub(super) fn smoothed<'a>(
    rough: &'a Disk,
    options: &smooth::Options,
    holds_each: bool,
    watch: &mut Observer,
) -> Result<Smoothed<'a>> {
    let progress = &mut within("smooth", watch);
    let examined = smooth::examine(rough, options, &mut progress::step(progress, 0, 2))?;
    let rest = &mut progress::step(progress, 1, 2);
    let how = thin::Options::default();
    let count = rough.mesh.points.len();
    let may_thin = !holds_each && how.may_thin(count);
    let outlook = if may_thin { examined.outlook() } else { None };
    if let Some(outlook) = outlook {
        let near = (outlook.places.as_slice(), outlook.supports.as_slice());
        let thinned = thin::thin(rough, near, &how, &mut progress::step(rest, 0, 2))?;
        if let Some(thinned) = thinned {
            let thin = thinned.report();
            let ThinnedDisk { disk, left, stand_ins, .. } = thinned;
            let measured = examined.means(&outlook, &left, stand_ins.vertex_of()).into();
            let last = &mut progress::step(rest, 1, 2);
            let (disk, smooth) = examined.smoothed_part(disk, &left, outlook, last)?;
            return Ok(Smoothed { disk, measured, stand_ins: Some(stand_ins), thin, smooth });
        }
    }
    let (disk, smooth) = examined.smoothed(rest)?;
    let measured = rough.mesh.points.as_slice().into();
    Ok(Smoothed { disk, measured, stand_ins: None, thin: thin::Report::none(count), smooth })
}
