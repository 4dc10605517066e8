//! The way of a rim over the surfaces of a network.
//!
//! The vertices of a rim go in. The runs of the rim come out: the parameter points on one surface
//! after another, and where the rim crosses the tracks between them.

use super::places::{NetworkPlace, NetworkPlaces};
use super::{MOST_HALVINGS, NetworkRim};
use crate::geometry::{Point, Uv, Vector, segment_distance};
use crate::spline::{Network, SideUse, foot_point};

/// The least distance of a crossing from the ends of a track and from other crossings, as a share of
/// the track. Shorter edges would be slivers. It is less where a rim leaves less room than this.
const LEAST_SHARE: f64 = 0.01;

/// The least distance however little room a rim leaves.
const LEAST_EVER: f64 = 1e-4;

/// The number of places of a track that are compared with a point.
const TRACK_SAMPLES: usize = 64;

/// A part of a rim on one surface.
#[derive(Debug, Clone)]
pub(crate) struct RimRun {
    /// The surface.
    pub face: usize,
    /// The parameter points of the rim's vertices, and the vertices.
    pub points: Vec<(Uv, Point)>,
    /// How the rim leaves the surface. `None` if the whole rim is on it.
    pub leaves: Option<Crossing>,
}

/// A place at which a rim crosses a track.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Crossing {
    /// The track.
    pub track: usize,
    /// The parameter of the track.
    pub at: f64,
    /// The surfaces that the rim leaves and enters.
    pub sides: [SideUse; 2],
}

/// The tracks of a network with the surfaces beside them.
pub(crate) struct NetworkPaths<'a> {
    network: &'a Network,
    uses: Vec<Vec<SideUse>>,
    places: NetworkPlaces<'a>,
    end: f64,
}

/// A vertex of a rim on the network.
#[derive(Debug, Clone, Copy)]
struct PlacedVertex {
    place: NetworkPlace,
    p: Point,
    normal: Vector,
}

/// A step of a rim: a vertex, or a crossing between two vertices.
enum PathStep {
    Vertex(PlacedVertex),
    Crossing(Crossing),
}

impl<'a> NetworkPaths<'a> {
    /// The paths over a network.
    pub(super) fn new(network: &'a Network) -> Self {
        let (uses, places) = (network.uses(), NetworkPlaces::new(network));
        NetworkPaths { network, uses, places, end: network.end() }
    }

    /// The runs of a rim. Parts that cross a track and come back over it without getting farther
    /// than `room` mm from it stay on their side. Returns a vertex for which the network has no place
    /// if there is one.
    pub(super) fn runs(&self, rim: &NetworkRim, room: f64) -> Result<Vec<RimRun>, Point> {
        let place = |(&p, &normal)| {
            let place = self.places.nearest(p, normal).ok_or(p)?;
            Ok(PlacedVertex { place, p, normal })
        };
        let vertices: Vec<PlacedVertex> =
            rim.points.iter().zip(&rim.normals).map(place).collect::<Result<_, Point>>()?;
        let mut steps = Vec::new();
        for (a, b) in vertices.iter().zip(vertices.iter().cycle().skip(1)) {
            steps.push(PathStep::Vertex(*a));
            self.connect(a, b, (room, MOST_HALVINGS), &mut steps).ok_or(a.p)?;
        }
        let mut runs = divided(&steps);
        while self.straighten(&mut runs, room) {}
        Ok(runs)
    }

    /// The surface that is nearest to a point, whichever way it faces.
    pub(crate) fn nearest_surface(&self, p: Point) -> usize {
        self.places.nearest_surface(p)
    }

    /// Adds the steps between two vertices. The line between them is halved where it crosses no track, where
    /// it would be farther than `room` mm from the crossing, and where the straight line between their parameter points is so far
    /// from it, at most so often.
    fn connect(
        &self,
        a: &PlacedVertex,
        b: &PlacedVertex,
        (room, halvings): (f64, usize),
        steps: &mut Vec<PathStep>,
    ) -> Option<()> {
        let p = nalgebra::center(&a.p, &b.p);
        let normal = a.normal + b.normal;
        let face = a.place.face;
        if face == b.place.face {
            let surface = &self.network.surfaces[face];
            let straight = a.place.at + (b.place.at - a.place.at) * 0.5;
            let (at, _) = foot_point(surface, p, straight);
            if halvings > 0 && (surface.point(at) - surface.point(straight)).norm() > room {
                let middle = PlacedVertex { place: NetworkPlace { face, at }, p, normal };
                self.connect(a, &middle, (room, halvings - 1), steps)?;
                steps.push(PathStep::Vertex(middle));
                self.connect(&middle, b, (room, halvings - 1), steps)?;
            }
            return Some(());
        }
        let is_far = |of: &[Crossing]| {
            let off = |of: &Crossing| {
                let at = self.network.tracks[of.track].curve.point(of.at);
                segment_distance(at.into(), a.p, b.p)
            };
            halvings > 0 && of.iter().any(|of| off(of) > room)
        };
        let crossings = match self.over_side(a, b) {
            Some(crossings) => Some(crossings).filter(|crossings| !is_far(crossings)),
            None => self.around_corner(a, b),
        };
        if let Some(crossings) = crossings {
            steps.extend(crossings.into_iter().map(PathStep::Crossing));
            return Some(());
        }
        let middle = PlacedVertex { place: self.places.nearest(p, normal)?, p, normal };
        let halvings = halvings.checked_sub(1)?;
        self.connect(a, &middle, (room, halvings), steps)?;
        steps.push(PathStep::Vertex(middle));
        self.connect(&middle, b, (room, halvings), steps)
    }

    /// The crossing of a straight line over a common side of two surfaces.
    fn over_side(&self, a: &PlacedVertex, b: &PlacedVertex) -> Option<Vec<Crossing>> {
        let crossing = |&track: &usize| {
            let of = |face: usize| self.uses[track].iter().find(|side| side.face == face).copied();
            let sides = [of(a.place.face)?, of(b.place.face)?];
            let (t, depth) = sides[0].along_and_depth(self.end, a.place.at);
            let (u, beyond) = sides[1].along_and_depth(self.end, b.place.at);
            let whole = depth + beyond;
            let share = if whole > 0.0 { depth / whole } else { 0.5 };
            let length = (u - t).hypot(whole);
            Some((length, Crossing { track, at: t + share * (u - t), sides }))
        };
        let tracks = self.network.sides[a.place.face].map(|side| side.track);
        let found = tracks.iter().filter_map(crossing).min_by(|a, b| a.0.total_cmp(&b.0));
        found.map(|found| vec![found.1])
    }

    /// The crossings of a way around a common corner of two surfaces.
    fn around_corner(&self, a: &PlacedVertex, b: &PlacedVertex) -> Option<Vec<Crossing>> {
        let middle = nalgebra::center(&a.p, &b.p);
        let ways = (0..4).flat_map(|k| [true, false].map(|left| (k, left)));
        let way = |(k, left)| self.fan(a.place.face, k, left, b.place.face);
        let tracks = ways.filter_map(way).min_by_key(Vec::len)?;
        let crossing = |(track, sides)| Crossing { track, at: self.beside(track, middle), sides };
        Some(tracks.into_iter().map(crossing).collect())
    }

    /// The tracks from one surface to another one around corner `k`, counter-clockwise if `left`.
    fn fan(
        &self,
        from: usize,
        k: usize,
        left: bool,
        to: usize,
    ) -> Option<Vec<(usize, [SideUse; 2])>> {
        let (mut face, mut k) = (from, k);
        let mut tracks = Vec::new();
        loop {
            // The side that arrives at the corner is counter-clockwise from the surface.
            let side = if left { (k + 3) % 4 } else { k };
            let track = self.network.sides[face][side].track;
            let own = |of: &&SideUse| of.face == face && of.k == side;
            let here = *self.uses[track].iter().find(own)?;
            let there = *self.uses[track].iter().find(|of| !own(of))?;
            tracks.push((track, [here, there]));
            face = there.face;
            k = if left { there.k } else { (there.k + 1) % 4 };
            if face == to {
                return Some(tracks);
            }
            if face == from {
                return None;
            }
        }
    }

    /// The parameter of a track's place near a point.
    fn beside(&self, track: usize, p: Point) -> f64 {
        let curve = &self.network.tracks[track].curve;
        let at = |i: usize| self.end * i as f64 / TRACK_SAMPLES as f64;
        let off = |i: &usize| (curve.point(at(*i)) - p.coords).norm_squared();
        let nearest = (0..=TRACK_SAMPLES).min_by(|a, b| off(a).total_cmp(&off(b)));
        at(nearest.unwrap_or(0))
    }

    /// The least distance of a crossing from the ends of a track, as a share of the track, if it may be moved by
    /// `room` mm.
    fn least_share(&self, track: usize, room: f64) -> f64 {
        let curve = &self.network.tracks[track].curve;
        let at = |i: usize| curve.point(self.end * i as f64 / TRACK_SAMPLES as f64);
        let length: f64 = (0..TRACK_SAMPLES).map(|i| (at(i + 1) - at(i)).norm()).sum();
        (room / length.max(f64::MIN_POSITIVE)).clamp(LEAST_EVER, LEAST_SHARE)
    }

    /// Pulls one part of a rim back that crosses a track only to return over it. Returns whether
    /// there was one.
    fn straighten(&self, runs: &mut Vec<RimRun>, room: f64) -> bool {
        let n = runs.len();
        let back = (0..n).find(|&i| {
            let (Some(enters), Some(leaves)) = (runs[(i + n - 1) % n].leaves, runs[i].leaves)
            else {
                return false;
            };
            let near = |(at, p): &(Uv, Point)| {
                let (t, _) = leaves.sides[0].along_and_depth(self.end, *at);
                let on_track = self.network.tracks[leaves.track].curve.point(t);
                (on_track - p.coords).norm() <= room
            };
            enters.sides[1] == leaves.sides[0] && runs[i].points.iter().all(near)
        });
        let Some(i) = back else { return false };
        runs.rotate_left(i);
        let away = runs.remove(0);
        let Some(Crossing { sides: [there, here], track, .. }) = away.leaves else { return false };
        let inset = self.least_share(track, room) * self.end;
        let pulled = away.points.iter().map(|&(at, p)| {
            let (t, _) = there.along_and_depth(self.end, at);
            (here.place(self.end, t, inset), p)
        });
        let pulled: Vec<(Uv, Point)> = pulled.collect();
        let Some(mut before) = runs.pop() else { return false };
        before.points.extend(pulled);
        if runs.is_empty() {
            before.leaves = None;
            runs.push(before);
        } else {
            let after = &mut runs[0];
            before.points.append(&mut after.points);
            after.points = before.points;
        }
        true
    }

    /// Keeps crossings away from the ends of their tracks and from each other, and moves none by more than the
    /// room that its rim leaves, in mm, unless that is hardly any.
    pub(crate) fn spread(&self, rims: &mut [Vec<RimRun>], rooms: &[f64]) {
        let tracks = self.network.tracks.iter();
        let mut of_tracks: Vec<(Vec<&mut f64>, f64)> =
            tracks.map(|_| (Vec::new(), f64::INFINITY)).collect();
        for (runs, &room) in rims.iter_mut().zip(rooms) {
            for crossing in runs.iter_mut().filter_map(|run| run.leaves.as_mut()) {
                let (places, least) = &mut of_tracks[crossing.track];
                places.push(&mut crossing.at);
                *least = least.min(room);
            }
        }
        let crossed = of_tracks.iter_mut().enumerate().filter(|(_, of)| !of.0.is_empty());
        for (track, (places, room)) in crossed {
            places.sort_by(|a, b| a.total_cmp(b));
            let least = self.least_share(track, *room) * self.end;
            let least = least.min(self.end / (2 * (places.len() + 1)) as f64);
            let mut low = least;
            for at in places.iter_mut() {
                **at = at.max(low);
                low = **at + least;
            }
            let mut high = self.end - least;
            for at in places.iter_mut().rev() {
                **at = at.min(high);
                high = **at - least;
            }
        }
    }
}

/// Divides the steps of a rim at its crossings.
fn divided(steps: &[PathStep]) -> Vec<RimRun> {
    let mut runs: Vec<RimRun> = Vec::new();
    let mut points = Vec::new();
    let mut first = None;
    for step in steps {
        match step {
            PathStep::Vertex(v) => {
                first.get_or_insert(v.place.face);
                points.push((v.place.at, v.p));
            }
            PathStep::Crossing(crossing) => runs.push(RimRun {
                face: crossing.sides[0].face,
                points: std::mem::take(&mut points),
                leaves: Some(*crossing),
            }),
        }
    }
    match runs.first_mut() {
        // The part after the last crossing belongs before the part up to the first one.
        Some(run) => {
            points.append(&mut run.points);
            run.points = points;
        }
        None => runs.push(RimRun { face: first.unwrap_or(0), points, leaves: None }),
    }
    runs
}
