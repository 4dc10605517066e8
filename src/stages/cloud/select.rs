//! The points of a cloud that are taken: one scan of several, or a number of points that are
//! spread evenly.

use formats::Points;
use formats::points::{PointScan, ScanGrid};
use rayon::prelude::*;

use super::order::CELLS;
use super::{LEFT_OUT, Options, Triangulation};
use crate::error::{CloudFault, Error, Result};
use crate::geometry::Point;
use crate::geometry::bounds;
use crate::stages::crop;

/// A part of a cloud, with the number that each of its points has in the cloud.
pub(super) struct Selection {
    pub points: Points,
    numbers: Vec<u32>,
}

/// The part of a cloud that the options choose; `None` if they choose the whole cloud.
///
/// # Errors
/// [`CloudFault::Scan`] if the cloud has no scan of the number that is named.
pub(super) fn selection(cloud: &Points, options: &Options) -> Result<Option<Selection>> {
    let mut selected = options.scan.map(|scan| one_scan(cloud, scan)).transpose()?;
    if !options.crop.keeps_all() {
        let of = selected.as_ref().map_or(cloud, |part| &part.points);
        selected = Some(cropped(of, &options.crop)?.of_part(selected.as_ref()));
    }
    if let Some(most) = options.max_points {
        let of = selected.as_ref().map_or(cloud, |part| &part.points);
        if of.len() > most {
            selected = Some(evenly(of, most).of_part(selected.as_ref()));
        }
    }
    Ok(selected)
}

/// The points that are kept, with the grids of their scans.
fn cropped(cloud: &Points, options: &crop::Options) -> Result<Selection> {
    let kept = crop::kept(&cloud.positions, cloud.origin, options)?;
    let numbers: Vec<u32> = (0..cloud.len() as u32).filter(|&i| kept[i as usize]).collect();
    let mut new = vec![ScanGrid::EMPTY; cloud.len()];
    (0..).zip(&numbers).for_each(|(i, &old)| new[old as usize] = i);
    let cell = |&cell: &u32| new.get(cell as usize).copied().unwrap_or(ScanGrid::EMPTY);
    let mut selection = part(cloud, numbers);
    for (scan, whole) in selection.points.scans.iter_mut().zip(&cloud.scans) {
        scan.grid = whole
            .grid
            .as_ref()
            .map(|grid| ScanGrid { cells: grid.cells.iter().map(cell).collect(), ..grid.clone() });
    }
    Ok(selection)
}

impl Selection {
    /// The same with the numbers of a whole cloud, of which `part` is what this was selected from.
    fn of_part(self, part: Option<&Selection>) -> Self {
        let Some(part) = part else { return self };
        let numbers = self.numbers.iter().map(|&i| part.numbers[i as usize]).collect();
        Selection { numbers, ..self }
    }

    /// The triangulation of this part as one of the whole cloud, which has `count` points.
    pub(crate) fn of_whole(&self, part: Triangulation, count: usize) -> Triangulation {
        let mut vertex_of = vec![LEFT_OUT; count];
        for (&number, vertex) in self.numbers.iter().zip(part.vertex_of) {
            vertex_of[number as usize] = vertex;
        }
        Triangulation { vertex_of, ..part }
    }
}

/// The points of one scan, with its grid.
fn one_scan(cloud: &Points, asked: usize) -> Result<Selection> {
    let missing = Error::Cloud(CloudFault::Scan { asked, count: cloud.scans.len() });
    let scan = cloud.scans.get(asked).ok_or(missing)?;
    let range = scan.points.clone();
    let first = range.start as u32;
    let cell = |&cell: &u32| if cell == ScanGrid::EMPTY { cell } else { cell - first };
    let grid = scan
        .grid
        .as_ref()
        .map(|grid| ScanGrid { cells: grid.cells.iter().map(cell).collect(), ..grid.clone() });
    let points = Points {
        positions: cloud.positions[range.clone()].to_vec(),
        normals: cloud.normals.as_ref().map(|normals| normals[range.clone()].to_vec()),
        scans: vec![PointScan { points: 0..range.len(), grid, ..scan.clone() }],
        ..bare(cloud)
    };
    Ok(Selection { points, numbers: range.map(|i| i as u32).collect() })
}

/// At most `most` points, one in each cell of a cubic grid whose cells are as small as that allows.
/// Grids of scans are lost, because most of their cells lose their point.
fn evenly(cloud: &Points, most: usize) -> Selection {
    let [low, high] = bounds(cloud.positions.iter().map(|&p| Point::from(p)));
    let extent = (high - low).amax();
    let key = |cells: f64, p: &[f64; 3]| -> u64 {
        let at = |k: usize| ((p[k] - low[k]) / extent * cells).min(cells - 1.0) as u64;
        (at(0) << 42) | (at(1) << 21) | at(2)
    };
    let occupied = |cells: f64| {
        let mut keys: Vec<u64> = cloud.positions.par_iter().map(|p| key(cells, p)).collect();
        keys.par_sort_unstable();
        keys.dedup();
        keys.len()
    };
    // More cells along an axis mean more occupied ones, but for small exceptions.
    let (mut few, mut many) = (1.0, f64::from(CELLS + 1));
    while extent > 0.0 && many - few > CLOSE * few {
        let middle = 0.5 * (few + many);
        *(if occupied(middle) <= most { &mut few } else { &mut many }) = middle;
    }
    let first_of_cell = || {
        // Of the points of a cell that with the smallest coordinates, whatever their order.
        let place = |i: u32| cloud.positions[i as usize];
        let order = |i: u32, j: u32| {
            let (a, b) = (place(i), place(j));
            let axes = a.iter().zip(&b).map(|(x, y)| x.total_cmp(y));
            axes.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then).then(i.cmp(&j))
        };
        let keyed = |i: u32| (if extent > 0.0 { key(few, &place(i)) } else { 0 }, i);
        let mut all: Vec<(u64, u32)> = (0..cloud.len() as u32).into_par_iter().map(keyed).collect();
        all.par_sort_unstable_by(|a, b| a.0.cmp(&b.0).then_with(|| order(a.1, b.1)));
        all.dedup_by_key(|(key, _)| *key);
        let mut numbers: Vec<u32> = all.into_iter().map(|(_, i)| i).collect();
        numbers.sort_unstable();
        numbers
    };
    part(cloud, first_of_cell())
}

/// How near the number of cells comes to the best one: 1 % of it is 2 % of the points.
const CLOSE: f64 = 0.01;

/// The points of these numbers, which ascend, without grids.
fn part(cloud: &Points, numbers: Vec<u32>) -> Selection {
    let before = |end: usize| numbers.partition_point(|&i| (i as usize) < end);
    let scan = |scan: &PointScan| PointScan {
        points: before(scan.points.start)..before(scan.points.end),
        grid: None,
        ..scan.clone()
    };
    let of = |i: &u32| *i as usize;
    let points = Points {
        positions: numbers.iter().map(|i| cloud.positions[of(i)]).collect(),
        normals: cloud
            .normals
            .as_ref()
            .map(|normals| numbers.iter().map(|i| normals[of(i)]).collect()),
        scans: cloud.scans.iter().map(scan).collect(),
        ..bare(cloud)
    };
    Selection { points, numbers }
}

/// The origin and the unit of a cloud without its points.
fn bare(cloud: &Points) -> Points {
    Points { origin: cloud.origin, unit: cloud.unit, ..Points::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two scans of a plane: one with a grid of 40 × 40 points, one with a corner of it 4 times as
    /// dense.
    fn cloud() -> Points {
        let raster = |n: u32, size: f64| {
            (0..n * n).map(move |k| [size * f64::from(k % n), size * f64::from(k / n), 0.0])
        };
        let positions: Vec<[f64; 3]> = raster(40, 1.0).chain(raster(40, 0.25)).collect();
        let cells = |first: u32| (first..first + 1600).collect();
        let grid = |first| Some(ScanGrid { rows: 40, columns: 40, cells: cells(first) });
        let scans = vec![
            PointScan { points: 0..1600, grid: grid(0), ..PointScan::default() },
            PointScan { points: 1600..3200, grid: grid(1600), ..PointScan::default() },
        ];
        Points { positions, scans, ..Points::default() }
    }

    #[test]
    fn one_scan_keeps_its_grid() {
        let cloud = cloud();
        let options = Options { scan: Some(1), ..Options::default() };
        let part = selection(&cloud, &options).unwrap().unwrap();
        assert_eq!(part.points.positions, cloud.positions[1600..]);
        let grid = part.points.scans[0].grid.as_ref().unwrap();
        assert_eq!((grid.point(0, 1), part.numbers[1]), (Some(1), 1601));
        let missing = Options { scan: Some(2), ..Options::default() };
        assert!(selection(&cloud, &missing).is_err());
    }

    #[test]
    fn points_are_spread_evenly_whatever_their_order() {
        let cloud = cloud();
        let options = Options { max_points: Some(400), ..Options::default() };
        let part = selection(&cloud, &options).unwrap().unwrap();
        let count = part.points.len();
        assert!((300..=400).contains(&count), "{count}");
        // The dense corner has a sixteenth of the area.
        let dense = part.points.positions.iter().filter(|p| p[0] < 9.75 && p[1] < 9.75).count();
        assert!((15..=40).contains(&dense), "{dense}");
        let mut reversed = Points { scans: Vec::new(), ..cloud.clone() };
        reversed.positions.reverse();
        let mut places = selection(&reversed, &options).unwrap().unwrap().points.positions;
        places.reverse();
        let sorted = |mut places: Vec<[f64; 3]>| {
            places.sort_by(|a, b| a.partial_cmp(b).unwrap());
            places
        };
        assert_eq!(sorted(places), sorted(part.points.positions.clone()));
        assert!(selection(&cloud, &Options::default()).unwrap().is_none());
    }
}
