//! A surface that keeps to the mesh between its vertices.
//!
//! Where a triangle spans several knot cells, a fit to the vertices leaves it free. Places in
//! such a triangle then hold the surface, too, and it is mended around them rather than fitted
//! anew, which would bring folds back that have been taken out.

use super::places::{AIM, Maker};
use super::search::{Attempt, LEAST_AREA, Search};
use crate::deviation::Left;
use crate::fit::{self, STIFFNESSES};
use crate::geometry::Uv;

/// The share of the tolerance at which more weight is given to a vertex: most have enough.
const AIM_OF_VERTICES: f64 = 0.97;

/// Mends in a row that may leave as much as those before, and how often at the most there are
/// new knots. Most scans need less than six mends; the others have too few knots somewhere.
const PATIENCE: usize = 5;
const ROUNDS: usize = 4;

/// The share of points beyond the tolerance that mends, which are local, may still bring back.
const MOST_BEYOND: f64 = 0.01;

/// The same of triangles that the surface leaves. Of real scans it leaves 2 % at the most, of
/// crumpled needles most.
const MOST_LEFT: f64 = 0.1;

/// A triangle with so many knot cells in the mean is one of a needle that the map has drawn out
/// beyond all use: looking at all of them takes longer than all the fits.
const MOST_CELLS: f64 = 256.0;

/// Misses of an attempt.
struct Misses {
    /// Triangles that it leaves by more than the aim.
    left: Vec<Left>,
    /// Vertices and triangles beyond the tolerance that are more than may be.
    count: usize,
}

impl Search<'_> {
    /// Holds the surface in triangles that it leaves by more than a named tolerance, as places
    /// on them do: it is mended around these, and gets knots where that is not enough.
    /// Takes and returns how many places are turned over, too.
    pub fn hold(&mut self, start: Attempt, turned: usize) -> (Attempt, usize) {
        if !self.goal.named || self.cells_a_triangle(&start) > MOST_CELLS {
            return (start, turned);
        }
        let mut misses = self.misses(&start);
        let triangles = self.target.measured_triangles.len();
        let is_hopeless = start.beyond.0 > self.spared() + self.share(MOST_BEYOND)
            || misses.left.len() as f64 > MOST_LEFT * triangles as f64;
        if misses.count == 0 || is_hopeless {
            return (start, turned);
        }
        let (mut best, mut least, mut now) = (None, misses.count, start.clone());
        for round in 0..ROUNDS {
            let mut idle = 0;
            while least > 0 && idle < PATIENCE {
                self.hold_places(&now, &misses.left);
                let Some(next) = self.mended(&now, &misses.left) else { break };
                (misses, now, idle) = (self.misses(&next), next, idle + 1);
                if misses.count < least {
                    (best, least, idle) = (Some(now.clone()), misses.count, 0);
                }
            }
            if least == 0 {
                break;
            }
            match self.refined(&now, &misses.left) {
                Some(finer) if round + 1 < ROUNDS => now = finer,
                _ => break,
            }
        }
        match best {
            Some(best) => {
                let turned = self.turned(&best);
                (best, turned)
            }
            None => (start, turned),
        }
    }

    /// How many knot cells, the narrowest ones, a measured triangle has in the mean.
    fn cells_a_triangle(&self, of: &Attempt) -> f64 {
        let maker = self.maker(of);
        let measured = &self.target.measured_triangles;
        let all: f64 = measured.iter().map(|&t| maker.spanned(t).powi(2)).sum();
        all / measured.len().max(1) as f64
    }

    /// What makes places on the triangles over an attempt's surface.
    fn maker<'m>(&'m self, of: &'m Attempt) -> Maker<'m> {
        Maker::new(&self.target.map.patch.mesh, &self.holds, &of.uv, &of.surface)
    }

    /// How many places of an attempt are turned over.
    fn turned(&mut self, of: &Attempt) -> usize {
        self.take_up(of, LEAST_AREA);
        let (samples, holds) = self.target.vertices(&self.holds);
        fit::inverted_samples(&of.surface, &samples, holds)
    }

    /// What an attempt misses.
    fn misses(&self, of: &Attempt) -> Misses {
        let target = &self.target;
        let left = target.left(&of.surface, &self.corrected(of), self.goal.tolerance, AIM);
        let beyond = left.iter().filter(|left| left.ratio > 1.0).count();
        let spared = self.goal.outliers * target.measured_triangles.len() as f64;
        let count =
            beyond.saturating_sub(spared as usize) + of.beyond.0.saturating_sub(self.spared());
        Misses { left, count }
    }

    /// Puts places where an attempt leaves triangles.
    fn hold_places(&mut self, of: &Attempt, left: &[Left]) {
        let mut places = std::mem::take(&mut self.target.places);
        places.hold(left, &self.maker(of), &self.target.measured_triangles);
        self.holds.truncate(self.target.uv().len());
        self.holds.extend(places.all.iter().map(|place| place.hold));
        self.target.take(places);
    }

    /// An attempt's surface brought nearer to the vertices and the triangles that it misses.
    fn mended(&mut self, from: &Attempt, left: &[Left]) -> Option<Attempt> {
        self.take_up(from, LEAST_AREA);
        let limit = AIM_OF_VERTICES * self.goal.tolerance;
        self.target.press(&from.feet, limit);
        let missed = self.target.misses(&from.feet, limit).into_iter().map(|(at, _)| at);
        let around: Vec<Uv> = missed.chain(self.around(left)).collect();
        let (target, holds) = (&self.target, &self.holds);
        let slide = |now: Vec<Uv>, wanted: Vec<Uv>| target.slid(now, wanted, LEAST_AREA);
        let (vertices, _) = target.vertices(holds);
        let task = fit::Mending {
            surface: &from.surface,
            samples: &target.samples,
            vertices: &vertices,
            holds,
            slide: &slide,
            around: &around,
        };
        let mend = |&stiffness: &f64| fit::mend(&task, stiffness);
        let found = STIFFNESSES.iter().rev().find_map(mend)?;
        Some(self.attempted(found.surface, found.uv, from.fit))
    }

    /// Where on the map the places of triangles are.
    fn around(&self, left: &[Left]) -> impl Iterator<Item = Uv> {
        let places = left.iter().flat_map(|left| self.target.places.of(left.triangle));
        places.map(|at| self.target.samples.uv[self.target.uv().len() + at])
    }

    /// The same surface over knots that vertices and triangles that it misses call for; `None`
    /// if there are none, or the user has named them.
    fn refined(&self, of: &Attempt, left: &[Left]) -> Option<Attempt> {
        if !self.options.knots.are_searched() {
            return None;
        }
        let places = self.around(left).map(|at| (at, 1.0));
        let knots = self.finer_with(of, places);
        let surface = of.surface.over(knots);
        let is_finer = surface.net.len() > of.surface.net.len();
        is_finer.then(|| Attempt { surface, ..of.clone() })
    }
}
