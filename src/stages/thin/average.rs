//! Averaging before anything else: where the vertices of a mesh are far denser than their noise lets tell, each mean of
//! those around a place takes theirs.
//!
//! Without it, every stage would work on each vertex, and the smoothing would try supports that are no wider than the
//! noise. Vertices are collapsed as in [`thin`](super::thin). What is left moves to the means of the vertices near it.

use rayon::prelude::*;

use super::{MOST_LEFT, ThinnedDisk, coarser, one_rings, target};
use crate::error::Result;
use crate::geometry::{Point, Vector, VertexId};
use crate::mesh::one_rings::OneRings;
use crate::mesh::progressive_mesh::{Collapsing, mean_edge, normal};
use crate::mesh::{Disk, StandIns};
use crate::noise::NoiseField;
use crate::progress::{self, Progress};

/// The slope in radians that noise may leave between neighbouring triangles of the places by which vertices are
/// collapsed. With more, the triangles of a smooth surface look folded.
const SLOPE: f64 = 0.1;

/// How often cells are moved to the means of their vertices, which makes them even.
const ROUNDS: usize = 3;

/// A disk of means.
#[derive(Debug)]
#[non_exhaustive]
pub struct Averaged {
    /// The disk. Its vertices are where the means are, but for those of rims.
    pub disk: Disk,
    /// Which of its vertices stands for each vertex that there was.
    pub stand_ins: StandIns,
}

/// Averages the vertices of a disk that are `spacing` apart around places that are `width` apart. Vertices at which a
/// surface misses more than the noise, as along a sharp edge, stay where they are. `None` if most vertices would stay.
///
/// # Errors
/// Those of `progress`.
pub(crate) fn average(
    disk: &Disk,
    noise: &NoiseField,
    [spacing, width]: [f64; 2],
    progress: &mut Progress,
) -> Result<Option<Averaged>> {
    let measured = disk.mesh.points.as_slice();
    let rings = one_rings(disk);
    let places = blurred(measured, &rings, rounds(noise.deviation, spacing));
    let stays = unexplained(measured, &places, &rings, noise);
    let target = target(&disk.mesh, (&places, &|_| width), &stays);
    if target as f64 > MOST_LEFT * measured.len() as f64 {
        return Ok(None);
    }
    let is_on_rim: Vec<bool> = (0..measured.len()).map(|v| rings.on_boundary(v as u32)).collect();
    progress(0.3)?;
    let loss = |rings: &OneRings, v: u32| mean_edge(&places, rings, v);
    let collapsing = Collapsing { points: &places, kept: &stays, loss };
    let rest = &mut progress::step(progress, 1, 2);
    let ThinnedDisk { mut disk, left, stand_ins } =
        coarser(disk, rings, &collapsing, target, rest)?;
    let rings = one_rings(&disk);
    let mut middles: Vec<Point> = left.iter().map(|&v| places[v as usize]).collect();
    let mut nearest = stand_ins.vertex_of().to_vec();
    let is_fixed: Vec<bool> = left.iter().map(|&v| stays[v as usize]).collect();
    for _ in 0..ROUNDS {
        nearest = nearer(&rings, &left, (&places, &middles, &is_fixed), &nearest);
        let (means, _) = means_of(&places, &nearest, left.len(), |_| true);
        let moves = |v: usize| !is_fixed[v] && !rings.on_boundary(v as u32);
        (0..left.len()).filter(|&v| moves(v)).for_each(|v| middles[v] = means[v]);
    }
    let (means, counts) = means_of(measured, &nearest, left.len(), |_| true);
    let (of_rims, _) = means_of(measured, &nearest, left.len(), |v| is_on_rim[v]);
    disk.mesh.points = means;
    // Half of what is around a rim is missing. So the mean goes back to the rim, along the surface.
    let place =
        |(v, mean): (usize, &Point)| match (stays[left[v] as usize], rings.on_boundary(v as u32)) {
            (true, _) => measured[left[v] as usize],
            (_, true) => {
                let (normal, back) =
                    (normal(&disk.mesh.points, &rings, v as u32), of_rims[v] - mean);
                mean + back - normal * back.dot(&normal)
            }
            _ => *mean,
        };
    disk.mesh.points = disk.mesh.points.par_iter().enumerate().map(place).collect();
    Ok(Some(Averaged { disk, stand_ins: StandIns::new(nearest, counts) }))
}

/// How often places are blurred so that the noise tilts no triangle much. Each round is a step of a random walk to a
/// neighbour or to nowhere. After m of them the slope of independent noise is 0.43 σ / (s m).
fn rounds(noise: f64, spacing: f64) -> usize {
    (0.43 * noise / (spacing * SLOPE)).ceil() as usize
}

/// Each place moved to the mean of itself and its neighbours, so many times.
fn blurred(points: &[Point], rings: &OneRings, rounds: usize) -> Vec<Point> {
    let mut places = points.to_vec();
    for _ in 0..rounds {
        let mean = |(v, place): (usize, &Point)| {
            let ring = rings.ring(v as u32);
            let sum: Vector = ring.iter().map(|&w| places[w as usize] - place).sum();
            place + sum / (ring.len() + 1) as f64
        };
        places = places.par_iter().enumerate().map(mean).collect();
    }
    places
}

/// The vertices where the noise does not explain how far the surface through the places is from them.
fn unexplained(
    measured: &[Point],
    places: &[Point],
    rings: &OneRings,
    noise: &NoiseField,
) -> Vec<bool> {
    let square = |(v, p): (usize, &Point)| {
        let offset = (places[v] - p).dot(&normal(places, rings, v as u32));
        (offset / noise.at(VertexId::from(v))).powi(2)
    };
    let squares: Vec<f64> = measured.par_iter().enumerate().map(square).collect();
    noise.unexplained(&squares, |v| rings.ring(v as u32).iter().map(|&w| w as usize))
}

/// The vertex of the disk whose middle is nearest to the place of each vertex that there was: the one that stands for
/// it, or a neighbour of that. Those that are fixed stand for nobody else, unless nothing else is near.
fn nearer(
    rings: &OneRings,
    left: &[u32],
    (places, middles, is_fixed): (&[Point], &[Point], &[bool]),
    vertex_of: &[u32],
) -> Vec<u32> {
    let of = |(v, &near): (usize, &u32)| {
        if left[near as usize] as usize == v {
            return near;
        }
        let around = std::iter::once(near).chain(rings.ring(near).iter().copied());
        let free = around.filter(|&w| !is_fixed[w as usize]);
        let distance = |w: &u32| (middles[*w as usize] - places[v]).norm_squared();
        free.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(near)
    };
    vertex_of.par_iter().enumerate().map(of).collect()
}

/// The mean of those vertices for which each of `count` stands that are `counted`, and their number.
fn means_of(
    measured: &[Point],
    vertex_of: &[u32],
    count: usize,
    is_counted: impl Fn(usize) -> bool,
) -> (Vec<Point>, Vec<f64>) {
    let mut sums = vec![(Vector::zeros(), 0.0); count];
    let pairs = measured.iter().zip(vertex_of).enumerate();
    for (_, (p, &of)) in pairs.filter(|(v, _)| is_counted(*v)) {
        let (sum, count) = &mut sums[of as usize];
        *sum += p.coords;
        *count += 1.0;
    }
    sums.into_iter().map(|(sum, count)| (Point::from(sum / f64::max(count, 1.0)), count)).unzip()
}
