//! The face of a free-form patch: its surface through its border, and whether that is near its triangles.

use std::collections::{BTreeMap, BTreeSet};

use formats::brep::{BrepCurve, BrepSurface, EdgeId, EdgeUse, Face, PCurve};
use formats::spline::SplineCurve;

use super::chords::ChordError;
use super::coons::{Bulging, InnerVertices, PatchSide, coons, spline_of};
use super::faces::FaceBuilder;
use super::free_form::FreeForm;
use super::network::ChainUse;
use super::{FreeForms, Work};
use crate::geometry::{Point, Uv, Vector, VertexId};
use crate::mesh::Triangles;
use crate::spline::{KnotVector, ParametricSurface, Surface, foot_point};

/// A free-form face is at most this share of the mean edge of the mesh off its triangles. A scan does not tell less of a face than that.
const MOST_OFF: f64 = 0.5;

/// A face that passes through the vertices of a clean mesh is off its triangles by their chord error, which is larger where a surface bends
/// unevenly.
const MOST_CHORDS: f64 = 2.0;

/// Vertices inside of such a face are off it by at most this share of the chord error, which is all that the mesh tells of the face.
const MOST_MISSED: f64 = 0.1;

/// At most this share of the area of a free-form face is turned over against its triangles. Triangles between surfaces that hardly miss each other
/// are often turned over themselves.
const MOST_TURNED: f64 = 0.5;

/// In a clean mesh only slivers are, whose normals are rounding errors.
const SLIVERS: f64 = 0.01;

/// The most parts along the side of a triangle that is compared with its face.
const MOST_PARTS: usize = 20;

/// The most places in each direction where the normals of neighbours are compared.
const MOST_COMPARED: usize = 200;

/// The places where an edge is compared with its face.
const SAMPLES: usize = 16;

/// The surface of a free-form face, and the farthest that it is off the middles of its triangles.
pub(super) struct FreeSurface {
    pub surface: Surface,
    pub off: f64,
    /// Within how many mm it passes the vertices of a clean mesh.
    pub passes: f64,
}

/// The parameters of a place on a side, counterclockwise.
fn place_on(side: usize, t: f64) -> Uv {
    match side {
        0 => Uv::new(t, 0.0),
        1 => Uv::new(1.0, t),
        2 => Uv::new(1.0 - t, 1.0),
        _ => Uv::new(0.0, 1.0 - t),
    }
}

/// The pcurve of an edge along a part of a side. It is a line. Programs integrate over a face with as many places as its pcurves have knots, so that
/// it has those of the edge.
fn along_side(side: usize, ends: [f64; 2], curve: &BrepCurve) -> Result<PCurve, String> {
    let (start, end) = curve.range();
    let at = |t: f64| -> [f64; 2] {
        let share = (t - start) / (end - start);
        place_on(side, (ends[0] + share * (ends[1] - ends[0])).clamp(0.0, 1.0)).coords.into()
    };
    let breaks = curve.breaks();
    if breaks.len() < 3 {
        return PCurve::line(at(start), at(end), (start, end));
    }
    let knots = KnotVector::clamped(1, &breaks, 1);
    let places = breaks.iter().map(|&t| at(t)).collect();
    Ok(PCurve::Spline(SplineCurve::new(1, knots.knots().to_vec(), places, None)?))
}

impl FaceBuilder<'_> {
    /// Adds a free-form face. Returns true.
    pub(super) fn free_face(&mut self, i: usize) -> Result<bool, String> {
        let work = self.work;
        let Some(form) = work.patches[i].free_form() else { return Ok(false) };
        let [ring] = &self.network.loops[i][..] else {
            return Err("a free-form face with several loops".into());
        };
        let sides = self.sides_of(form, ring)?;
        let n = ring.len();
        if (0..n).any(|k| self.turns_back(ring[k], ring[(k + 1) % n])) {
            return Err("a border that turns back".into());
        }
        let curve = |&(chain, forward): &ChainUse| (&self.brep.edges[chain].curve, forward);
        let made =
            sides.iter().map(|side| PatchSide::new(&side.iter().map(curve).collect::<Vec<_>>()));
        let made: [PatchSide; 4] = made
            .collect::<Result<Vec<_>, String>>()?
            .try_into()
            .map_err(|_| "a face without four sides")?;
        let places = work.places_of(i, form).ok_or("vertices without parameters")?;
        let on_border: BTreeSet<VertexId> = form.border.iter().copied().collect();
        let inner = places.iter().filter(|(v, _)| !on_border.contains(v));
        let inner: Vec<(Uv, Point)> = inner.map(|(&v, &at)| (at, work.mesh.point(v))).collect();
        let is_clean = matches!(work.free_forms, FreeForms::Through { .. });
        let how = if is_clean { Bulging::PassesThrough } else { Bulging::Averages(work.edge) };
        let surface = coons(&made, &inner, how)?;
        let chord = is_clean.then(|| work.chord_error(i));
        if (is_clean || !inner.is_empty()) && is_folded(&surface) {
            return Err("a free-form face that folds".into());
        }
        let off = work.off_triangles(i, &surface, &places, chord.as_ref())?;
        let mut passes = 0.0;
        if let (FreeForms::Through { within, .. }, Some(chord)) = (work.free_forms, chord) {
            passes = within.min(MOST_MISSED * chord.most);
            let miss = |(at, p): &(Uv, Point)| foot_point(&surface, *p, *at).1;
            let missed = inner.iter().map(miss).fold(0.0, f64::max);
            if missed > passes {
                return Err(format!("vertices are {missed:.1e} mm off a free-form face"));
            }
        }
        let spline = spline_of(&surface)?;
        let mut uses = Vec::with_capacity(ring.len());
        for (side, (own, made)) in sides.iter().zip(&made).enumerate() {
            for (&(chain, forward), range) in own.iter().zip(made.breaks.windows(2)) {
                let ends = if forward { [range[0], range[1]] } else { [range[1], range[0]] };
                let curve = &self.brep.edges[chain].curve;
                let pcurve = along_side(side, ends, curve)?;
                let (start, end) = curve.range();
                let off = |k: usize| {
                    let t = start + (end - start) * k as f64 / SAMPLES as f64;
                    let [u, v] = pcurve.point(t);
                    (Point::from(spline.point(u, v)) - Point::from(curve.point(t))).norm()
                };
                let gap = (0..=SAMPLES).map(off).fold(0.0, f64::max);
                if gap.is_nan() || gap > work.limit {
                    return Err(format!("an edge is {gap:.1e} mm off its free-form face"));
                }
                self.gap = self.gap.max(gap);
                uses.push(EdgeUse { edge: EdgeId(chain), forward, pcurve });
            }
        }
        let surface_id = self.brep.add_surface(BrepSurface::Spline(spline));
        self.brep.add_face(Face { surface: surface_id, forward: true, loops: vec![uses] });
        self.patch_of.push(i);
        self.triangles.push(work.patches[i].triangles.clone());
        self.free.insert(i, FreeSurface { surface, off, passes });
        Ok(true)
    }

    /// Whether a border leaves the end of an edge along that edge. Readers take such edges for one.
    fn turns_back(&self, before: ChainUse, after: ChainUse) -> bool {
        let curves = [before, after].map(|of| &self.brep.edges[of.0].curve);
        let long = curves.map(|curve| curve.range().1 - curve.range().0);
        let half = 0.5 * long[0].min(long[1]);
        // The parameter is the length, or nearly.
        let at = |k: usize, is_from_start: bool| {
            let (start, end) = curves[k].range();
            Point::from(curves[k].point(if is_from_start { start + half } else { end - half }))
        };
        (at(0, !before.1) - at(1, after.1)).norm() <= self.work.limit
    }

    /// The uses of each side of a free-form face.
    fn sides_of(&self, form: &FreeForm, ring: &[ChainUse]) -> Result<[Vec<ChainUse>; 4], String> {
        let start = |&(chain, forward): &ChainUse| {
            let ends = self.network.chains[chain].ends.unwrap_or_default();
            ends[usize::from(!forward)]
        };
        let place = |k: usize| {
            let number = self.network.junctions.binary_search(&form.border[k].0).ok()?;
            ring.iter().position(|of| start(of) == number)
        };
        let [a, b, c, d] = form.corners.map(place);
        let (Some(a), Some(b), Some(c), Some(d)) = (a, b, c, d) else {
            return Err("a border without its corners".into());
        };
        let n = ring.len();
        let [b, c, d] = [b, c, d].map(|k| (k + n - a) % n);
        if !(0 < b && b < c && c < d) {
            return Err("corners in the wrong order".into());
        }
        let side = |from: usize, to: usize| (from..to).map(|k| ring[(a + k) % n]).collect();
        Ok([side(0, b), side(b, c), side(c, d), side(d, n)])
    }
}

impl Work<'_> {
    /// The parameters of the vertices of a free-form face.
    fn places_of(&self, i: usize, form: &FreeForm) -> Option<BTreeMap<VertexId, Uv>> {
        let n = form.border.len();
        let mut border = BTreeMap::new();
        for side in 0..4 {
            let (from, to) =
                (form.corners[side], if side < 3 { form.corners[side + 1] } else { n });
            let mut along = vec![0.0];
            for k in from..to {
                let [p, q] = [k, k + 1].map(|k| self.mesh.point(form.border[k % n]));
                along.push(along[k - from] + (q - p).norm());
            }
            let whole = along[to - from];
            for k in from..to {
                border.insert(form.border[k], place_on(side, along[k - from] / whole));
            }
        }
        let mut all = InnerVertices { border, inner: BTreeMap::new() };
        for &t in &self.patches[i].triangles {
            let corners = self.mesh.triangles[t as usize];
            for k in 0..3 {
                if !all.border.contains_key(&corners[k]) {
                    let others = [1, 2].map(|j| corners[(k + j) % 3]);
                    let others = others.map(|v| (v, self.mesh.point(v)));
                    all.add_corner(corners[k], self.mesh.point(corners[k]), others);
                }
            }
        }
        all.places()
    }

    /// The farthest that a surface is off the triangles of a free-form face. An error if it is too far or turned over.
    fn off_triangles(
        &self,
        i: usize,
        surface: &Surface,
        places: &BTreeMap<VertexId, Uv>,
        chord: Option<&ChordError>,
    ) -> Result<f64, String> {
        let too_far = |off: f64| Err(format!("a free-form face is {off:.1e} mm off its triangles"));
        let most_chord = self.most_sagitta.unwrap_or(f64::INFINITY);
        let most = chord.map_or(MOST_OFF * self.edge, |of| {
            (MOST_CHORDS * of.most).min(most_chord) + self.limit
        });
        let (mut worst, mut turned, mut whole): (f64, f64, f64) = (0.0, 0.0, 0.0);
        for &t in &self.patches[i].triangles {
            let corners = self.mesh.triangles[t as usize];
            let points = self.mesh.corners(corners).map(|p| p.coords);
            let starts = corners.map(|v| places.get(&v).copied().unwrap_or_default().coords);
            let [a, b, c] = points;
            let area = (b - a).cross(&(c - a));
            let long = (b - a).norm().max((c - b).norm()).max((a - c).norm());
            let parts = ((long / self.edge).ceil() as usize).clamp(1, MOST_PARTS);
            for [x, y, z] in middles(parts) {
                let p = Point::from(x * a + y * b + z * c);
                let start = Uv::from(x * starts[0] + y * starts[1] + z * starts[2]);
                let (at, off) = foot_point(surface, p, start);
                worst = worst.max(off);
                if off > most {
                    return too_far(off);
                }
                let jet = ParametricSurface::jet(surface, at);
                let share = area.norm() / (parts * parts) as f64;
                whole += share;
                if jet.su.cross(&jet.sv).dot(&area) < 0.0 {
                    turned += share;
                }
            }
        }
        let most_turned = if chord.is_some() { SLIVERS } else { MOST_TURNED };
        if turned > most_turned * whole {
            return Err("a free-form face that folds".into());
        }
        if chord.is_some() {
            let own = self.patches[i].triangles.iter().map(|&t| t as usize);
            let triangles = Triangles::some(self.mesh, own);
            for at in places_of(surface) {
                worst = worst.max(triangles.nearest(surface.point(at)).0);
                if worst > most {
                    return too_far(worst);
                }
            }
        }
        Ok(worst)
    }
}

/// The shares of the corners of a triangle in the middles of its parts, of which there are the square of a number.
fn middles(parts: usize) -> impl Iterator<Item = [f64; 3]> {
    let at = move |i: usize, j: usize, third: f64| {
        let [x, y] = [i, j].map(|k| (k as f64 + third) / parts as f64);
        [1.0 - x - y, x, y]
    };
    (0..parts).flat_map(move |i| {
        let upright = (0..parts - i).map(move |j| at(i, j, 1.0 / 3.0));
        upright.chain((0..parts - i - 1).map(move |j| at(i, j, 2.0 / 3.0)))
    })
}

/// Places in the middles of spans.
fn places_of(surface: &Surface) -> impl Iterator<Item = Uv> {
    let [us, vs] = [&surface.u, &surface.v].map(some_middles);
    us.into_iter().flat_map(move |u| vs.clone().into_iter().map(move |v| Uv::new(u, v)))
}

/// The middles of spans, or some of many.
fn some_middles(knots: &KnotVector) -> Vec<f64> {
    let all = knots.middles(1);
    let step = all.len().div_ceil(MOST_COMPARED).max(1);
    all.into_iter().step_by(step).collect()
}

/// Whether the normals of a surface turn by more than a right angle between neighbouring places.
fn is_folded(surface: &Surface) -> bool {
    let places = [&surface.u, &surface.v].map(some_middles);
    let normal = |u: f64, v: f64| {
        let jet = ParametricSurface::jet(surface, Uv::new(u, v));
        jet.su.cross(&jet.sv)
    };
    let rows: Vec<Vec<Vector>> =
        places[0].iter().map(|&u| places[1].iter().map(|&v| normal(u, v)).collect()).collect();
    let turns = |a: &Vector, b: &Vector| a.dot(b) < 0.0;
    let within = |row: &Vec<Vector>| row.windows(2).any(|pair| turns(&pair[0], &pair[1]));
    let between = |rows: &[Vec<Vector>]| rows[0].iter().zip(&rows[1]).any(|(a, b)| turns(a, b));
    rows.iter().any(within) || rows.windows(2).any(between)
}
