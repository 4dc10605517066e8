//! The terms of one round's equations, cell by cell.

use nalgebra::Matrix3;

use super::places::{ACROSS, LEAST, Spot};
use super::system::{Cell, Strip};
use super::work::Work;
use crate::geometry::Vector;

/// The weight of what a cell spreads too little.
const SPREAD: f64 = 3.0;

/// What the equations of a round are made of.
pub struct Terms<'a> {
    pub work: &'a Work<'a>,
    /// The weight of the thin-plate energy.
    pub stiffness: f64,
    /// Where the surface spreads too little, strip by strip.
    pub spots: &'a [Spot],
    /// Which cells move, row by row.
    pub moves: &'a [bool],
    /// The samples in these, strip by strip.
    pub near: &'a [Vec<usize>],
}

impl Terms<'_> {
    /// Adds those of a strip.
    pub fn add(&self, mut strip: Strip) {
        let (p, down) = (strip.number, self.work.cells.counts()[1]);
        self.near[p].iter().for_each(|&i| self.add_sample(&mut strip, i));
        let moves = &self.moves[p * down..(p + 1) * down];
        for q in (0..down).filter(|&q| moves[q]) {
            self.add_plate(&mut strip.cell(q), [p, q]);
        }
        let first = self.spots.partition_point(|spot| spot.cell[0] < p);
        let spots = self.spots[first..].iter().take_while(|spot| spot.cell[0] == p);
        spots.for_each(|spot| self.add_spot(&mut strip.cell(spot.cell[1]), spot));
    }

    fn add_sample(&self, strip: &mut Strip, i: usize) {
        let work = self.work;
        let (at, hold) = (work.uv[i], &work.holds[i]);
        let (p, q) = (strip.number, work.cells.spans[1].find(at.y));
        let [u, v] = [work.surface.u.basis_in(p + 3, at.x), work.surface.v.basis_in(q + 3, at.y)]
            .map(|basis| basis.derivative[0]);
        let values: [f64; 16] = std::array::from_fn(|k| u[k / 4] * v[k % 4]);
        let eased = work.eased[p * work.cells.counts()[1] + q];
        let metric = work.cells.samples.weights[i] * hold.of(work.stuck[i] && !eased);
        let on: Vector = self.net([p, q]).zip(values).map(|(control, x)| control * x).sum();
        let off = metric * (work.cells.samples.points[i].coords - on);
        let mut cell = strip.cell(q);
        for (k, x) in values.into_iter().enumerate() {
            cell.pull(k, off * x);
            let with = metric * x;
            values.iter().enumerate().skip(k).for_each(|(l, y)| cell.couple(k, l, &(with * *y)));
        }
    }

    /// The thin-plate energy of a cell.
    fn add_plate(&self, cell: &mut Cell, [p, q]: [usize; 2]) {
        let work = self.work;
        let (x, y) = (work.halves[0][p], work.halves[1][q]);
        let weight = self.stiffness * work.weight * x.min(y).powi(4);
        let scales = [x.powi(-4), 2.0 / (x * y).powi(2), y.powi(-4)];
        let (u, v) = (&work.energies[0][p], &work.energies[1][q]);
        let value = |k: usize, l: usize| {
            let of = |n: usize| scales[n] * u[2 - n][k / 4][l / 4] * v[n][k % 4][l % 4];
            weight * (of(0) + of(1) + of(2))
        };
        for k in 0..16 {
            let net = self.net([p, q]).enumerate();
            let bend: Vector = net.map(|(l, control)| control * value(k, l)).sum();
            cell.pull(k, -bend);
            (k..16).for_each(|l| cell.couple(k, l, &(Matrix3::identity() * value(k, l))));
        }
    }

    /// What the surface spreads too little at a spot.
    fn add_spot(&self, cell: &mut Cell, spot: &Spot) {
        let weight = SPREAD * self.work.weight * self.work.area() / (ACROSS * ACROSS) as f64;
        let [u, v] = &spot.functions;
        let across = spot.slopes[1].cross(&spot.facing);
        let along = spot.facing.cross(&spot.slopes[0]);
        let gradient: [Vector; 16] = std::array::from_fn(|k| {
            across * (u[1][k / 4] * v[0][k % 4]) + along * (u[0][k / 4] * v[1][k % 4])
        });
        let missing = LEAST - spot.spread;
        for (k, x) in gradient.iter().enumerate() {
            cell.pull(k, weight * missing * x);
            let rest = gradient.iter().enumerate().skip(k);
            rest.for_each(|(l, y)| cell.couple(k, l, &(weight * x * y.transpose())));
        }
    }

    /// The control points of a cell, row by row.
    fn net(&self, [p, q]: [usize; 2]) -> impl Iterator<Item = &Vector> {
        let surface = &self.work.surface;
        let width = surface.v.functions();
        (p..p + 4).flat_map(move |i| &surface.net[i * width + q..][..4])
    }
}
