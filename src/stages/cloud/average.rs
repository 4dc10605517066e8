//! Averaging: where points are far denser than their noise lets tell, each mean of the points in a small cell takes
//! their place.
//!
//! A neighbourhood of a hundred points must be wider than their noise. In a denser cloud it is a ball, and no surface is
//! found in it. And where it is wide enough, each point takes time for what its neighbours tell as well. The cells are
//! as wide as the shape allows: the mean of a cell lies off a curved surface by less than its noise.

use formats::Points;
use formats::points::PointScan;
use rayon::prelude::*;

use super::order::Ordered;
use super::outliers::LONELY;
use super::quadric::{PrincipalPlane, QuadricRows, Scatter};
use super::two_layers::TwoLayers;
use super::{LEFT_OUT, Options, Triangulation, layers, noise, rims, sides};
use crate::geometry::{Point, SAMPLE, Vector};
use crate::mesh::Neighbours;
use crate::statistics::{median, quantile};

/// About so many cells are left at least. The face of the relief of four million points is as near to the true surface
/// with 100,000 as with the triangles of all points, and no nearer with 500,000 than with 250,000.
const LEAST_CELLS: f64 = 250_000.0;

/// Averaging is worth its time if a cell has so many points.
const LEAST_POINTS: f64 = 3.0;

/// The same for the vertices of a mesh, whose triangles are known already. With four or five vertices for each mean, the
/// face of a relief of one or two million vertices was 12 to 25 % farther from the true surface than without averaging.
/// With eight it was 4 to 10 % nearer.
const LEAST_VERTICES: f64 = 8.0;

/// The mean of a cell may be off the surface by this share of the standard deviation of its noise.
const HIDDEN: f64 = 0.5;

/// The share of all places at which the mean may be farther off: sharp edges.
const EDGES: f64 = 0.01;

/// Cells are so many standard deviations of the noise wide at least, else there are several above each other.
const LEAST_WIDTH: f64 = 2.0;

/// So many of the largest cubes hold any cloud.
const OCTANTS: usize = 8;

/// The number of points in the cubes with which noise and shape are measured.
const CUBE: f64 = 8.0;

/// Places with more points around them are not looked at. Noise of 11 spacings has so many within five standard
/// deviations.
const MOST_AROUND: usize = 10_000;

/// The ratio of each radius that is tried to the one before.
const STEP: f64 = std::f64::consts::SQRT_2;

/// How often cells are moved to the means of their points. Their borders are upright on the surface then.
const ROUNDS: usize = 3;

/// The cells among which the one of a point is looked for. A cell of an even packing has six neighbours.
const NEARBY: usize = 12;

/// What places in a cloud tell about it, in the lengths of the work.
struct Sampled {
    noise: f64,
    spacing: f64,
    /// The mean curvature that few places exceed.
    curvature: f64,
    /// How far around each place was looked.
    radius: f64,
}

/// How dense points are, in their unit of length.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub(crate) struct Density {
    /// The distance of neighbouring points.
    pub spacing: f64,
    /// The distance of places at which means of the points tell as much as all points do.
    pub width: f64,
}

/// How dense the vertices of a mesh are. `None` if they lie in two layers, or if they are not much denser than their
/// noise lets tell. The latter does not count if `any` density will do.
pub(crate) fn density(points: &[Point], any: bool) -> Option<Density> {
    let count = points.len() as f64;
    if !any && count < LEAST_VERTICES * LEAST_CELLS {
        return None;
    }
    let positions: Vec<[f64; 3]> = points.iter().map(|p| p.coords.into()).collect();
    let ordered = Ordered::new(&positions);
    drop(positions);
    let sampled = Sampled::new(&ordered)?;
    let width = sampled.width(count, f64::INFINITY);
    if !any && width < LEAST_VERTICES.sqrt() * sampled.spacing {
        return None;
    }
    let [spacing, width] = [sampled.spacing, width].map(|length| ordered.frame.length(length));
    Some(Density { spacing, width })
}

/// A cloud of means.
pub(super) struct Averaged {
    /// The means, with the normals and the scanner of one of their points.
    pub means: Points,
    /// The number of points of each mean.
    pub count: Vec<u32>,
    /// The mean of each distinct point in the order of the work, or [`LEFT_OUT`] for points that are alone.
    of: Vec<u32>,
    /// What was found of the points themselves, in the lengths of the work.
    noise: f64,
    /// The distance of neighbouring points.
    spacing: f64,
    /// The distance of neighbouring means.
    width: f64,
}

impl Averaged {
    /// Averages a cloud. `None` if it is not so dense that it should be.
    pub(super) fn new(cloud: &Points, ordered: &Ordered, options: &Options) -> Option<Self> {
        let count = ordered.points.len() as f64;
        let most = options.most_places.map_or(f64::INFINITY, |most| most as f64);
        if count < (LEAST_POINTS * LEAST_CELLS).min(most) {
            return None;
        }
        let sampled = Sampled::new(ordered)?;
        let Sampled { noise: deviation, spacing, .. } = sampled;
        let named = options.spacing.map(|spacing| ordered.frame.work_length(spacing));
        let hidden = sampled.width(count, named.unwrap_or(f64::INFINITY));
        let is_worth = hidden >= LEAST_POINTS.sqrt() * spacing;
        let width = if is_worth { hidden } else { 0.0 }.max(spacing * (count / most).sqrt());
        if width <= spacing {
            return None;
        }
        let cells = Cells::new(ordered, width, noise::LEAST_RADIUS * deviation);
        if cells.join_sides(cloud, ordered) {
            return None;
        }
        let (means, count, of) = cells.cloud(cloud, ordered);
        Some(Averaged { means, count, of, noise: deviation, spacing, width })
    }

    /// The triangles of the means as those of the cloud. Rims are moved to the ends of their points.
    pub(super) fn of_cloud(
        &self,
        made: Triangulation,
        cloud: &Points,
        ordered: &Ordered,
    ) -> Triangulation {
        let Triangulation { mut soup, vertex_of, mut measured, mut report } = made;
        let of_point = |&i: &u32| match self.of[i as usize] {
            LEFT_OUT => LEFT_OUT,
            mean => vertex_of[mean as usize],
        };
        let vertex_of: Vec<u32> = ordered.number.par_iter().map(of_point).collect();
        rims::extend(&mut soup, &mut measured, cloud, &vertex_of);
        report.points = cloud.len();
        report.duplicates = cloud.len() - ordered.points.len();
        report.outliers += self.of.iter().filter(|&&mean| mean == LEFT_OUT).count();
        report.noise = ordered.frame.length(self.noise);
        report.spacing = ordered.frame.length(self.spacing);
        report.averaged = Some(ordered.frame.length(self.width));
        Triangulation { soup, vertex_of, measured, report }
    }
}

impl Sampled {
    /// Looks at some places with growing radii, as long as a wider neighbourhood tells more of the surface under the noise.
    /// `None` if the points lie in two layers, or few places tell anything.
    fn new(ordered: &Ordered) -> Option<Self> {
        let cubes = Cubes::of_points(ordered, CUBE);
        let mut best: Option<(f64, Sampled)> = None;
        let mut radius = 2.0 * cubes.edge;
        while let Some((ratio, sampled)) = cubes.sampled(ordered, radius) {
            let most = best.as_ref().map_or(0.0, |best| best.0);
            if ratio > most {
                best = Some((ratio, sampled));
            }
            // Inside the noise, residuals grow as the radius does. Those of a shape grow much faster.
            if ratio >= noise::LEAST_RADIUS || ratio * STEP < most {
                break;
            }
            radius *= STEP;
        }
        best.map(|best| best.1)
    }

    /// The widest cells whose means are on the surface, and at most so wide. `count` is the number of points.
    fn width(&self, count: f64, most: f64) -> f64 {
        // The mean of a square cell of width w is off a quadric by H w² / 12, and its noise is σ s / w.
        let hidden = (12.0 * HIDDEN * self.noise * self.spacing / self.curvature).cbrt();
        let enough = self.spacing * (count / LEAST_CELLS).sqrt();
        hidden.max(LEAST_WIDTH * self.noise).min(enough).min(self.radius).min(most)
    }
}

/// The points of a cloud in the cubes of a grid.
struct Cubes {
    /// The first point of each cube, and the number of all points.
    bounds: Vec<u32>,
    means: Vec<Point>,
    near: Neighbours,
    edge: f64,
}

impl Cubes {
    /// Cubes with so many points in the mean, or up to four times as many.
    fn of_points(ordered: &Ordered, count: f64) -> Self {
        let all = ordered.points.len() as f64;
        let mut edge = (count / all).sqrt();
        loop {
            let (first, found) = ordered.cubes(edge);
            if all >= count * first.len() as f64 || first.len() <= OCTANTS {
                return Cubes::new(ordered, first, found);
            }
            edge = 2.0 * found;
        }
    }

    fn new(ordered: &Ordered, first: Vec<u32>, edge: f64) -> Self {
        let mut bounds = first;
        bounds.push(ordered.points.len() as u32);
        let mean = |range: &[u32]| {
            let points = &ordered.points[range[0] as usize..range[1] as usize];
            let sum: Vector = points.iter().map(|p| p.coords).sum();
            Point::from(sum / points.len() as f64)
        };
        let means: Vec<Point> = bounds.par_windows(2).map(mean).collect();
        Cubes { bounds, near: Neighbours::new(&means), means, edge }
    }

    fn points(&self, cube: usize) -> std::ops::Range<usize> {
        self.bounds[cube] as usize..self.bounds[cube + 1] as usize
    }

    /// What is found around some places, with the radius in standard deviations of the noise, which few places fall
    /// short of. `None` if there are two layers, or if few places tell anything.
    fn sampled(&self, ordered: &Ordered, radius: f64) -> Option<(f64, Sampled)> {
        let points = &ordered.points;
        let at = |(found, rows): &mut (Vec<u32>, QuadricRows), i: usize| {
            let own = points[i];
            self.near.within(own, radius + 3.0_f64.sqrt() * self.edge, found);
            let of_cubes = found.iter().flat_map(|&cube| self.points(cube as usize));
            let others = of_cubes.filter(|&j| j != i).map(|j| j as u32);
            let is_inside = |&j: &u32| (points[j as usize] - own).norm() <= radius;
            let list: Vec<u32> = others.filter(is_inside).take(MOST_AROUND + 1).collect();
            (noise::COUNTS[0]..=MOST_AROUND).contains(&list.len()).then(|| {
                let places: Vec<Point> = list.iter().map(|&j| points[j as usize]).collect();
                let is_double = TwoLayers::new(own, radius, &places).is_some();
                (list.len(), is_double, noise::around(own, points, &list, rows))
            })
        };
        let step = points.len().div_ceil(SAMPLE).max(1);
        let numbers: Vec<usize> = (0..points.len()).step_by(step).collect();
        let all = numbers.len();
        let rows: Vec<_> =
            numbers.into_par_iter().map_init(Default::default, at).flatten_iter().collect();
        let double = rows.iter().filter(|row| row.1).count();
        if 2 * double > all || 2 * rows.len() < all {
            return None;
        }
        let mut counts: Vec<f64> = rows.iter().map(|row| row.0 as f64).collect();
        let found: Vec<(f64, Scatter)> = rows.into_iter().filter_map(|row| row.2).collect();
        let mut ratios: Vec<f64> = found.iter().map(|f| f.0).collect();
        let mut variances: Vec<f64> = found.iter().map(|f| f.1.variance).collect();
        let mut curvatures: Vec<f64> = found.iter().map(|f| f.1.curvature.abs()).collect();
        let ratio = quantile(&mut ratios, noise::NARROW)?;
        let sampled = Sampled {
            noise: median(&mut variances)?.sqrt(),
            spacing: radius * (std::f64::consts::PI / median(&mut counts)?).sqrt(),
            curvature: quantile(&mut curvatures, 1.0 - EDGES)?,
            radius,
        };
        Some((ratio, sampled))
    }
}

/// Cells of a surface: each point is in that of the nearest middle.
struct Cells {
    /// The cell of each point.
    of: Vec<u32>,
    /// The mean of the points of each cell.
    means: Vec<Point>,
    count: Vec<u32>,
}

impl Cells {
    /// Makes cells whose middles are about `width` apart.
    fn new(ordered: &Ordered, width: f64, upright: f64) -> Self {
        let (first, edge) = ordered.cubes(width);
        let cubes = Cubes::new(ordered, first, edge);
        let mut cells = Cells::around_full_cubes(&cubes, width);
        for _ in 0..ROUNDS {
            cells.assign(ordered, upright);
        }
        cells
    }

    /// Cells around places that are at least `width` apart: the means of the fullest cubes, which are in the middle of
    /// the noise.
    fn around_full_cubes(cubes: &Cubes, width: f64) -> Self {
        let mut order: Vec<usize> = (0..cubes.means.len()).collect();
        order.sort_by_key(|&cube| std::cmp::Reverse(cubes.points(cube).len()));
        let (mut middle_of, mut middles) = (vec![LEFT_OUT; order.len()], Vec::new());
        let mut found = Vec::new();
        for cube in order {
            if middle_of[cube] == LEFT_OUT {
                middles.push(cube);
                cubes.near.within(cubes.means[cube], width, &mut found);
                for &other in &found {
                    let middle = &mut middle_of[other as usize];
                    *middle = if *middle == LEFT_OUT { cube as u32 } else { *middle };
                }
            }
        }
        // Cells that follow each other are near each other, as points are.
        middles.sort_unstable();
        let mut number = vec![LEFT_OUT; middle_of.len()];
        (0..).zip(&middles).for_each(|(cell, &cube)| number[cube] = cell);
        let points = (0..middle_of.len()).flat_map(|cube| {
            let cell = number[middle_of[cube] as usize];
            cubes.points(cube).map(move |_| cell)
        });
        let of = points.collect();
        let means = middles.into_iter().map(|cube| cubes.means[cube]).collect();
        Cells { of, means, count: Vec::new() }
    }

    /// Puts every point into that of the cells around its own which is nearest, and takes the means of these.
    fn assign(&mut self, ordered: &Ordered, upright: f64) {
        let near = Neighbours::new(&self.means);
        let means = &self.means;
        let around = |found: &mut Vec<(u32, f64)>, cell: usize| {
            near.nearest_n(means[cell], NEARBY, found);
            let list = std::array::from_fn(|k| found.get(k).map_or(cell as u32, |f| f.0));
            let places = found.iter().map(|&(of, _)| (1.0, means[of as usize] - means[cell]));
            (list, PrincipalPlane::fit(places).normal)
        };
        let around: Vec<([u32; NEARBY], Vector)> =
            (0..means.len()).into_par_iter().map_init(Vec::new, around).collect();
        let nearest = |(point, cell): (&Point, &u32)| {
            let squared = |&of: &u32| {
                let (d, normal) = (point - means[of as usize], around[of as usize].1);
                let height = d.dot(&normal);
                let beyond = (height.abs() - upright).max(0.0);
                (d - height * normal).norm_squared() + beyond * beyond
            };
            let distances = around[*cell as usize].0.iter().map(|of| (squared(of), *of));
            distances.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(*cell, |(_, of)| of)
        };
        let of: Vec<u32> = ordered.points.par_iter().zip(&self.of).map(nearest).collect();
        let mut sums = vec![(Vector::zeros(), 0_u32); self.means.len()];
        for (&cell, point) in of.iter().zip(&ordered.points) {
            let (sum, count) = &mut sums[cell as usize];
            *sum += point.coords;
            *count += 1;
        }
        // A cell that lost all of its points stays where it is, and loses its number below.
        let mean = |((sum, count), at): (&(Vector, u32), &Point)| match count {
            0 => *at,
            _ => Point::from(sum / f64::from(*count)),
        };
        self.means = sums.iter().zip(means).map(mean).collect();
        self.count = sums.into_iter().map(|(_, count)| count).collect();
        self.of = of;
    }

    /// Whether many points face away from the others of their cells, and lie on one side of these.
    fn join_sides(&self, cloud: &Points, ordered: &Ordered) -> bool {
        if !sides::are_known(cloud) {
            return false;
        }
        let facing = |i: usize| {
            let outward = sides::outward(cloud, ordered.first[i] as usize);
            outward.and_then(|to| to.try_normalize(0.0)).unwrap_or_else(Vector::zeros)
        };
        let facing: Vec<Vector> = (0..ordered.points.len()).into_par_iter().map(facing).collect();
        let mut sums = vec![Vector::zeros(); self.means.len()];
        self.of.iter().zip(&facing).for_each(|(&cell, facing)| sums[cell as usize] += facing);
        let (mut far, mut behind) = (0.0, 0.0);
        for ((&cell, facing), point) in self.of.iter().zip(&facing).zip(&ordered.points) {
            let (cell, outward) = (cell as usize, &sums[cell as usize]);
            if facing.dot(outward) < 0.0 {
                far += 1.0;
                behind += f64::from(u8::from((point - self.means[cell]).dot(outward) < 0.0));
            }
        }
        // Normals of noise face any way.
        let is_many = far > (1.0 - layers::ONE_SIDE) * facing.len() as f64;
        is_many && behind.max(far - behind) >= layers::ONE_SIDE * far
    }

    /// The means as a cloud with the number of points of each, and the mean of each point. Cells that are nearly empty
    /// beside their neighbours hold outliers.
    fn cloud(self, cloud: &Points, ordered: &Ordered) -> (Points, Vec<u32>, Vec<u32>) {
        let near = Neighbours::new(&self.means);
        let is_kept = |found: &mut Vec<(u32, f64)>, cell: usize| {
            near.nearest_n(self.means[cell], NEARBY, found);
            let mut around: Vec<f64> =
                found.iter().map(|&(of, _)| f64::from(self.count[of as usize])).collect();
            let least = median(&mut around).map_or(0.0, |middle| middle / (LONELY * LONELY));
            self.count[cell] > 0 && f64::from(self.count[cell]) >= least
        };
        let is_kept: Vec<bool> =
            (0..self.means.len()).into_par_iter().map_init(Vec::new, is_kept).collect();
        // The point that comes first stands for its cell's scanner and normal.
        let mut first = vec![LEFT_OUT; self.means.len()];
        for (i, &cell) in self.of.iter().enumerate().rev() {
            first[cell as usize] = ordered.first[i];
        }
        let scan_of = |cell: &u32| {
            let point = first[*cell as usize] as usize;
            cloud.scans.iter().position(|scan| scan.points.contains(&point))
        };
        let mut kept: Vec<u32> =
            (0..self.means.len() as u32).filter(|&cell| is_kept[cell as usize]).collect();
        kept.sort_by_cached_key(scan_of);
        let mut number = vec![LEFT_OUT; self.means.len()];
        (0..).zip(&kept).for_each(|(new, &cell)| number[cell as usize] = new);
        let mut end = 0;
        let scan = |(k, scan): (usize, &PointScan)| {
            let start = end;
            let is_of = |cell: &&u32| scan_of(cell) == Some(k);
            end += kept[start..].iter().take_while(is_of).count();
            PointScan { points: start..end, grid: None, ..scan.clone() }
        };
        let scans = cloud.scans.iter().enumerate().map(scan).collect();
        let place = |&cell: &u32| ordered.frame.outward(&self.means[cell as usize]);
        let normals = cloud.normals.as_ref().map(|normals| {
            kept.iter().map(|&cell| normals[first[cell as usize] as usize]).collect()
        });
        let means = Points {
            positions: kept.iter().map(place).collect(),
            normals,
            scans,
            origin: cloud.origin,
            unit: cloud.unit,
            ..Points::default()
        };
        let count = kept.iter().map(|&cell| self.count[cell as usize]).collect();
        (means, count, self.of.iter().map(|&cell| number[cell as usize]).collect())
    }
}
