//! The way from a cloud of points to the components of a mesh, which go on as those of a meshed
//! scan do: cloud → mesh.

use std::borrow::Cow;

use formats::soup::Polygons;
use formats::{Points, Soup};

use super::Options;
use crate::error::{Error, Result};
use crate::geometry::Point;
use crate::mesh::{self, Components, FileRounding, RawPoints};
use crate::progress::Progress;
use crate::stages::cloud::{self, Report};
use crate::stages::crop;
use crate::threads;

/// Makes a mesh of a cloud of points, and tells what was found. The points stay with the mesh
/// ([`Components::raw_points`]). The report has the lengths of the cloud's unit.
///
/// # Errors
/// Those of [`cloud::triangulate`] and of [`mesh::from_soup`], or what `progress` answers.
pub fn cloud_components(
    cloud: Points,
    options: &Options,
    progress: &mut Progress,
) -> Result<(Components, Report)> {
    threads::run(options.threads, || components_of(cloud, options, progress))?
}

/// Makes the components of a mesh, without what the options leave out of it. A mesh with coordinates beyond a
/// kilometre is measured from a round origin ([`Soup::round_origin`]).
///
/// # Errors
/// Those of [`crop::kept`](crate::stages::crop::kept) and of [`mesh::from_soup`], and [`Error::Coarse`] if the numbers tell
/// most neighbours not apart.
pub fn mesh_components(soup: &Soup, options: &Options) -> Result<Components> {
    let crop = &options.cloud.crop;
    let unit = options.unit_of(soup.unit);
    let origin = soup.round_origin(unit);
    let mut soup = Cow::Borrowed(soup);
    if !crop.keeps_all() {
        let kept = crop::kept(&soup.points, [0.0; 3], crop)?;
        let mut polygons = Polygons::default();
        let is_kept = |corners: &&[u32]| corners.iter().all(|&v| kept[v as usize]);
        let left = soup.polygons.iter().filter(is_kept);
        left.for_each(|corners| polygons.push(corners.iter().copied()));
        soup = Cow::Owned(Soup { polygons, ..soup.into_owned() });
    }
    let step = FileRounding::largest_step(&soup);
    if let Some(side) = FileRounding::lost_side(&soup, step) {
        return Err(Error::Coarse { step: unit * step, edge: unit * side });
    }
    if origin != [0.0; 3] {
        soup = Cow::Owned(Soup { points: soup.relative_to(origin), ..soup.into_owned() });
    }
    let build = mesh::from_soup_joined(&soup, unit, options.weld, step)?;
    let components = Components::new(build).measured_from(origin.map(|x| unit * x));
    Ok(components.with_handles(options.handles))
}

/// The same on the thread that calls.
pub(super) fn components_of(
    cloud: Points,
    options: &Options,
    progress: &mut Progress,
) -> Result<(Components, Report)> {
    let unit = options.unit_of(cloud.unit);
    let meshed = cloud::triangulate(&cloud, &options.cloud.in_lengths(unit), progress)?;
    let build = mesh::from_soup(&meshed.soup, unit)?;
    drop(meshed.soup);
    let points = cloud.positions.into_iter().map(Point::from).collect();
    let places = meshed.measured.into_iter().map(Point::from).collect();
    let raw = RawPoints::new(points, meshed.vertex_of, meshed.report.noise)
        .at(cloud.origin)
        .with_measured_vertices(places);
    let components = Components::new(build).with_raw_points(raw, unit);
    Ok((components.with_handles(options.handles), meshed.report))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wavy sheet whose points are 0.2 apart, at a place, in numbers of 32 bits.
    fn sheet(at: [f64; 3]) -> Soup {
        let single = |x: f64| f64::from(x as f32);
        let place = |k: u32| {
            let (x, y) = (0.2 * f64::from(k % 20), 0.2 * f64::from(k / 20));
            [single(at[0] + x), single(at[1] + y), single(at[2] + 0.3 * (x + 0.5 * y).sin())]
        };
        let mut soup = Soup { points: (0..400).map(place).collect(), ..Soup::default() };
        let corners = (0..19 * 19).map(|k| k / 19 * 20 + k % 19);
        corners.for_each(|v| soup.polygons.push([v, v + 1, v + 21, v + 20]));
        soup
    }

    #[test]
    fn numbers_in_steps_longer_than_edges_are_refused() {
        let made = |at| mesh_components(&sheet(at), &Options::default());
        let refused = made([432e3, 5212e3, 600.0]).err();
        let is_coarse = |e| matches!(e, Error::Coarse { step, edge } if step == 0.5 && edge < 0.5);
        assert!(refused.is_some_and(is_coarse));
        assert!(made([0.0, 0.0, 600.0]).is_ok());
        assert!(made([4e3, 5e3, 600.0]).is_ok());
        // Heights in steps are terraces.
        assert!(made([0.0, 0.0, 5e6]).is_ok());
    }
}
