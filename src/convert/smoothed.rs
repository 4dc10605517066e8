//! The smoothed mesh of a scan. A dense scan is averaged and thinned before, as its noise and the supports of the
//! smoothing tell how many of its vertices tell anything.

use std::borrow::Cow;

use super::memory::MemoryBound;
use super::stage::{Observer, within};
use crate::error::Result;
use crate::geometry::Point;
use crate::mesh::{Disk, StandIns};
use crate::progress;
use crate::stages::thin::{Averaged, ThinnedDisk};
use crate::stages::{cloud, smooth, thin};

/// A smoothed mesh, and what was measured of its vertices.
pub(super) struct Smoothed<'a> {
    pub disk: Disk,
    /// Where each vertex was measured: the mean of the points for which it stands.
    pub measured: Cow<'a, [Point]>,
    /// Which vertex stands for each one of the scan, if the mesh was thinned.
    pub stand_ins: Option<StandIns>,
    /// The standard deviation of the noise of the vertices as they were measured.
    pub noise: f64,
    pub thin: thin::Report,
    pub smooth: smooth::Report,
}

/// Which vertices of a dense mesh are smoothed.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Dense {
    /// All of them.
    Every,
    /// Means of them, where they are much denser than their noise lets tell.
    Means,
    /// Those of the means that the support of the smoothing lets differ.
    Thinned,
}

/// Smooths a mesh. With a bound on the memory, it is averaged until no more is needed.
///
/// # Errors
/// Those of the stages, and [`Error::MaxMemory`](crate::error::Error::MaxMemory) if more may be needed nevertheless.
pub(super) fn smoothed<'a>(
    rough: &'a Disk,
    options: &smooth::Options,
    dense: Dense,
    bound: Option<&MemoryBound>,
    watch: &mut Observer,
) -> Result<Smoothed<'a>> {
    let may_average = dense != Dense::Every && options.support == smooth::Support::Auto;
    let averaged = if may_average { averaged(rough, bound, watch)? } else { None };
    let Some(Averaged { disk, stand_ins, noise, width, .. }) = averaged else {
        bound.map_or(Ok(()), MemoryBound::refuse)?;
        return of_vertices(rough, options, dense, watch);
    };
    let of_means = of_vertices(&disk, options, dense, watch)?;
    let stand_ins = match &of_means.stand_ins {
        Some(left) => stand_ins.then(left),
        None => stand_ins,
    };
    let removed = rough.mesh.points.len() - of_means.thin.vertices;
    Ok(Smoothed {
        measured: of_means.measured.into_owned().into(),
        stand_ins: Some(stand_ins),
        noise,
        thin: thin::Report { removed, averaged: Some(width), ..of_means.thin },
        disk: of_means.disk,
        smooth: of_means.smooth,
    })
}

/// The mesh of means, if the vertices of a mesh are much denser than their noise lets tell, or if memory bounds them.
fn averaged(
    rough: &Disk,
    bound: Option<&MemoryBound>,
    watch: &mut Observer,
) -> Result<Option<Averaged>> {
    let points = &rough.mesh.points;
    let Some(cloud::Density { spacing, width, .. }) = cloud::density(points, bound.is_some())
    else {
        return Ok(None);
    };
    let most = bound.map(|bound| bound.most_of(points.len()));
    thin::average(rough, [spacing, width], most, &mut within("smooth", watch))
}

/// Smooths the vertices of a mesh, or some of them.
fn of_vertices<'a>(
    rough: &'a Disk,
    options: &smooth::Options,
    dense: Dense,
    watch: &mut Observer,
) -> Result<Smoothed<'a>> {
    let progress = &mut within("smooth", watch);
    let examined = smooth::examine(rough, options, &mut progress::step(progress, 0, 2))?;
    let rest = &mut progress::step(progress, 1, 2);
    let how = thin::Options::default();
    let count = rough.mesh.points.len();
    let may_thin = dense == Dense::Thinned && how.may_thin(count);
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
            return Ok(Smoothed {
                disk,
                measured,
                stand_ins: Some(stand_ins),
                noise: smooth.noise,
                thin,
                smooth,
            });
        }
    }
    let (disk, smooth) = examined.smoothed(rest)?;
    let measured = rough.mesh.points.as_slice().into();
    let (noise, thin) = (smooth.noise, thin::Report::none(count));
    Ok(Smoothed { disk, measured, stand_ins: None, noise, thin, smooth })
}
