//! Faces: their loops with pcurves, and the seams of those that go around.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use formats::brep::{Brep, BrepCurve, BrepSurface, EdgeId, EdgeUse, Face, Frame, PCurve, VertexId};
use formats::spline::SplineCurve;

use super::chart::{Chart, array};
use super::domain::FacePlan;
use super::fallback::SeamFault;
use super::free_face::FreeSurface;
use super::network::{ChainNetwork, ChainUse};
use super::pcurves::pcurve;
use super::perimeter::{Perimeter, PerimeterPlace, Stretch};
use super::{EXACT, Work};
use crate::geometry::{Point, Uv, Vector, is_inside};

/// The samples of an edge that follow its parameters around the surface.
const SAMPLES: usize = 25;

/// The pieces of a line that is a B-spline. What readers lose of a face is a wedge of a quarter of a piece.
const POLYLINE: usize = 32;

/// Consecutive uses in the natural orientation of the surface, with the parameters along each of them.
struct EdgeRun {
    uses: Vec<ChainUse>,
    uv: Vec<Vec<[f64; 2]>>,
    /// Where it leaves the perimeter of the domain and where it comes back to it. A closed loop inside does neither.
    ends: Option<[PerimeterPlace; 2]>,
}

impl EdgeRun {
    fn start(&self) -> [f64; 2] {
        self.uv[0][0]
    }

    fn end(&self) -> [f64; 2] {
        let last = &self.uv[self.uv.len() - 1];
        last[last.len() - 1]
    }

    fn set_ends(&mut self, start: [f64; 2], end: [f64; 2]) {
        self.uv[0][0] = start;
        if let Some(last) = self.uv.last_mut().and_then(|uv| uv.last_mut()) {
            *last = end;
        }
    }

    fn shift(&mut self, by: [f64; 2]) {
        self.uv.iter_mut().flatten().for_each(|uv| *uv = [uv[0] + by[0], uv[1] + by[1]]);
    }

    fn polygon(&self) -> Vec<Uv> {
        self.uv.iter().flatten().map(|&uv| Uv::from(uv)).collect()
    }

    fn mean(&self, k: usize) -> f64 {
        let all = || self.uv.iter().flatten().map(|uv| uv[k]);
        all().sum::<f64>() / all().count() as f64
    }
}

/// A part of a loop: a run, or a stretch along the perimeter.
enum LoopPart {
    Run(EdgeRun),
    Seam(Stretch),
}

/// The loops of a face, the outer one first, and the polygon of that in the domain.
struct FaceLoops {
    loops: Vec<Vec<EdgeUse>>,
    outline: Vec<Uv>,
    perimeter: Perimeter,
}

/// Why a face has no loops, and the uses at the place if it is known.
struct UnclosedLoops {
    why: String,
    uses: Vec<ChainUse>,
}

impl From<String> for UnclosedLoops {
    fn from(why: String) -> Self {
        UnclosedLoops { why, uses: Vec::new() }
    }
}

/// What the faces share.
pub(super) struct FaceBuilder<'a> {
    pub work: &'a Work<'a>,
    pub network: &'a ChainNetwork,
    pub brep: &'a mut Brep,
    /// The largest distance between an edge and its pcurves.
    pub gap: f64,
    /// For each face its patch.
    pub patch_of: Vec<usize>,
    /// For each face its triangles.
    pub triangles: Vec<Vec<u32>>,
    /// The surfaces of the free-form faces.
    pub free: BTreeMap<usize, FreeSurface>,
}

/// The seams of one face.
struct FaceSeams<'a> {
    chart: &'a Chart,
    perimeter: Perimeter,
    /// The vertices on the cuts along v and along u, by their parameter there.
    vertices: [Vec<(f64, VertexId)>; 2],
    /// Whether the face has other edges than those of its cuts.
    has_border: bool,
    /// The edges between two neighbouring vertices on a cut.
    edges: BTreeMap<(usize, usize, usize), (EdgeId, [f64; 2])>,
}

impl FaceBuilder<'_> {
    /// Adds the face of a patch, or its faces if cuts divide it.
    pub(super) fn face(&mut self, i: usize, plan: &FacePlan) -> Result<(), SeamFault> {
        let is_made = if self.work.is_free(i) { self.free_face(i) } else { self.bent_face(i) };
        if is_made.map_err(|why| SeamFault::new(&[i], why))? {
            return Ok(());
        }
        let side = self.work.patches[i].side;
        let chart = &plan.chart;
        let rings = self.network.loops[i].iter();
        let natural: Vec<Vec<ChainUse>> = rings
            .map(|ring| match side > 0.0 {
                true => ring.clone(),
                false => ring.iter().rev().map(|&(chain, forward)| (chain, !forward)).collect(),
            })
            .collect();
        let made = self.loops(plan, &natural);
        let made = made.map_err(|UnclosedLoops { why, uses }| {
            let chains = uses.iter().map(|of| &self.network.chains[of.0]);
            let vertices: Vec<u32> = chains.flat_map(|of| of.mesh_vertices.clone()).collect();
            SeamFault::near(&[i], &vertices, why)
        })?;
        let triangles = self.divided(i, chart, &made);
        for (face, triangles) in made.into_iter().zip(triangles) {
            let mut loops = face.loops;
            if side < 0.0 {
                for ring in &mut loops {
                    ring.reverse();
                    ring.iter_mut().for_each(|of| of.forward = !of.forward);
                }
            }
            let surface = self.brep.add_surface(chart.surface.clone());
            self.brep.add_face(Face { surface, forward: side > 0.0, loops });
            self.patch_of.push(i);
            self.triangles.push(triangles);
        }
        Ok(())
    }

    /// The triangles of each face of a patch: those whose middle it holds.
    fn divided(&self, i: usize, chart: &Chart, faces: &[FaceLoops]) -> Vec<Vec<u32>> {
        let all = &self.work.patches[i].triangles;
        if faces.len() == 1 {
            return vec![all.clone()];
        }
        let mut divided = vec![Vec::new(); faces.len()];
        for &t in all {
            let corners = self.work.mesh.corners(self.work.mesh.triangles[t as usize]);
            let middle = corners.iter().map(|p| p.coords).sum::<Vector>() / 3.0;
            let uv = chart.parameters(Point::from(middle)).0;
            let is_in =
                |face: &FaceLoops| is_inside(Uv::from(face.perimeter.in_cell(uv)), &face.outline);
            let home = faces.iter().position(is_in);
            divided[home.unwrap_or(0)].push(t);
        }
        divided
    }

    /// The faces of a patch, in the natural orientation of its surface.
    fn loops(
        &mut self,
        plan: &FacePlan,
        natural: &[Vec<ChainUse>],
    ) -> Result<Vec<FaceLoops>, UnclosedLoops> {
        let chart = &plan.chart;
        let perimeter = Perimeter::of(&chart.surface, plan.v);
        let mut seams = FaceSeams {
            chart,
            perimeter,
            vertices: [Vec::new(), Vec::new()],
            has_border: !natural.is_empty(),
            edges: BTreeMap::new(),
        };
        let mut runs = Vec::new();
        for ring in natural {
            runs.extend(self.runs(&mut seams, ring)?);
        }
        let (open, closed): (Vec<EdgeRun>, Vec<EdgeRun>) =
            runs.into_iter().partition(|run| run.ends.is_some());
        let mut outer = traced(open, &perimeter)?;
        let (around, holes): (Vec<EdgeRun>, Vec<EdgeRun>) =
            closed.into_iter().partition(|run| area(&run.polygon()) > 0.0);
        outer.extend(around.into_iter().map(|run| vec![LoopPart::Run(run)]));
        let mut holes: Vec<Vec<LoopPart>> =
            holes.into_iter().map(|run| vec![LoopPart::Run(run)]).collect();
        // A loop that only touches the perimeter may be a hole.
        let touching = outer.extract_if(.., |ring| area(&outline(ring)) <= 0.0);
        holes.extend(touching);
        let by_size = |a: &&Vec<LoopPart>, b: &&Vec<LoopPart>| {
            area(&outline(a)).abs().total_cmp(&area(&outline(b)).abs())
        };
        if outer.is_empty() {
            // The largest loop should be the outer one.
            let uses = holes.iter().max_by(by_size).map(|ring| uses_of(ring)).unwrap_or_default();
            let whole = perimeter.whole().map_err(|why| UnclosedLoops { why, uses })?;
            outer.push(whole.into_iter().map(LoopPart::Seam).collect());
        }
        if outer.len() > 1 && !perimeter.is_cut {
            let why = format!("{} outer loops", outer.len());
            // The others should be holes.
            outer.sort_by(|a, b| by_size(&a, &b));
            outer.pop();
            let uses = outer.iter().flat_map(|ring| uses_of(ring)).collect();
            return Err(UnclosedLoops { why, uses });
        }
        let mut made = Vec::new();
        for ring in outer {
            let uses = self.ring(&mut seams, &ring)?;
            made.push(FaceLoops { loops: vec![uses], outline: outline(&ring), perimeter });
        }
        let outlines: Vec<Vec<Uv>> = holes.iter().map(|ring| outline(ring)).collect();
        for (k, ring) in holes.iter().enumerate() {
            let start = outlines[k].first().copied().unwrap_or_default();
            let home = made.iter().position(|face| perimeter.holds(&face.outline, start));
            let is_in_hole = || (0..holes.len()).any(|j| j != k && is_inside(start, &outlines[j]));
            if home.is_none() || !perimeter.is_cut && is_in_hole() {
                let why = "a hole that is not in its face".into();
                return Err(UnclosedLoops { why, uses: uses_of(ring) });
            }
            let uses = self.ring(&mut seams, ring)?;
            made[home.unwrap_or(0)].loops.push(uses);
        }
        Ok(made)
    }

    /// The uses of all parts of a loop.
    fn ring(&mut self, seams: &mut FaceSeams, ring: &[LoopPart]) -> Result<Vec<EdgeUse>, String> {
        let mut uses = Vec::new();
        for part in ring {
            match part {
                LoopPart::Run(run) => uses.extend(self.uses(seams.chart, run)?),
                LoopPart::Seam(stretch) => uses.extend(self.stretch(seams, stretch)?),
            }
        }
        Ok(uses)
    }

    /// The runs of a loop between its vertices on the perimeter, or the whole loop if it has none.
    fn runs(&self, seams: &mut FaceSeams, ring: &[ChainUse]) -> Result<Vec<EdgeRun>, String> {
        let chart = seams.chart;
        let on = |of: &ChainUse| {
            let vertex = self.start_of(*of);
            seams
                .perimeter
                .lines_at(chart, self.place(vertex), self.work.limit)
                .map(|lines| (vertex, lines))
        };
        let at: Vec<Option<(VertexId, [bool; 3])>> = ring.iter().map(on).collect();
        let Some(first) = at.iter().position(Option::is_some) else {
            return Ok(vec![self.run(seams, ring)]);
        };
        let mut runs = Vec::new();
        let n = ring.len();
        let mut from = first;
        while from < first + n {
            let next = (from + 1..=first + n).find(|k| at[k % n].is_some()).unwrap_or(first + n);
            let uses: Vec<ChainUse> = (from..next).map(|k| ring[k % n]).collect();
            let mut run = self.run(seams, &uses);
            let ends = [(from, run.start()), (next, run.end())].map(|(k, uv)| {
                let (vertex, lines) = at[k % n]?;
                let uv = seams.perimeter.onto(lines, uv);
                // All meridians meet at a pole.
                for (line, is_on) in [(0, lines[0] || lines[2]), (1, lines[1])] {
                    if is_on {
                        seams.vertices[line].push((uv[1 - line], vertex));
                    }
                }
                Some((seams.perimeter.place(lines, uv), uv))
            });
            let [Some(start), Some(end)] = ends else {
                return Err("a loop that breaks off".into());
            };
            run.set_ends(start.1, end.1);
            run.ends = Some([start.0, end.0]);
            runs.push(run);
            from = next;
        }
        Ok(runs)
    }

    /// The run of some uses, in the domain.
    fn run(&self, seams: &FaceSeams, uses: &[ChainUse]) -> EdgeRun {
        let chart = seams.chart;
        let mut near = None;
        let mut uv = Vec::new();
        for &(chain, forward) in uses {
            let curve = &self.brep.edges[chain].curve;
            let (start, end) = curve.range();
            let n = if self.network.chains[chain].is_closed() { 3 * SAMPLES } else { SAMPLES };
            let share = |k: usize| (if forward { k } else { n - k }) as f64 / n as f64;
            let at = |k: usize| Point::from(curve.point(start + (end - start) * share(k)));
            let points: Vec<Point> = (0..=n).map(at).collect();
            let along = chart.unwrapped(&points, near);
            near = along.last().copied();
            uv.push(along);
        }
        let mut run = EdgeRun { uses: uses.to_vec(), uv, ends: None };
        let mean = [run.mean(0), run.mean(1)];
        let into = seams.perimeter.in_cell(mean);
        run.shift([into[0] - mean[0], into[1] - mean[1]]);
        run
    }

    fn uses(&mut self, chart: &Chart, run: &EdgeRun) -> Result<Vec<EdgeUse>, String> {
        let mut made = Vec::with_capacity(run.uses.len());
        for (&(chain, forward), uv) in run.uses.iter().zip(&run.uv) {
            let (first, last) = (uv[0], uv[uv.len() - 1]);
            let ends = if forward { [first, last] } else { [last, first] };
            let (pcurve, gap) = {
                let is_led = self.work.pair(&self.network.chains[chain]).is_led();
                pcurve(chart, &self.brep.edges[chain].curve, ends, is_led)?
            };
            let is_plane = matches!(chart.surface, BrepSurface::Plane { .. });
            let loose = self.work.limit_at(self.network.chains[chain].error);
            let limit = if is_plane { EXACT } else { loose };
            if gap.is_nan() || gap > limit {
                return Err(format!("an edge is {gap:.1e} mm off its face"));
            }
            self.gap = self.gap.max(gap);
            made.push(EdgeUse { edge: EdgeId(chain), forward, pcurve });
        }
        Ok(made)
    }

    fn start_of(&self, (chain, forward): ChainUse) -> VertexId {
        self.brep.edges[chain].ends[usize::from(!forward)]
    }

    fn place(&self, v: VertexId) -> Point {
        Point::from(self.brep.vertices[v.0])
    }

    /// The vertices on a cut in the order of their parameter, with those at the ends of a stretch.
    fn vertices_of(&mut self, seams: &mut FaceSeams, stretch: &Stretch) -> Vec<(f64, VertexId)> {
        let line = stretch.line;
        for end in stretch.range {
            let is_there = |of: &&(f64, VertexId)| seams.perimeter.is_same(of.0, end, line);
            if seams.vertices[line].iter().any(|of| is_there(&of)) {
                continue;
            }
            let mut uv = [0.0, seams.perimeter.cell[0][1]];
            uv[1 - line] = end;
            let point = seams.chart.point(uv);
            // A corner of the domain is on both cuts.
            let all = seams.vertices.iter().flatten().map(|of| of.1);
            let there = all.into_iter().find(|v| (self.place(*v) - point).norm() < self.work.limit);
            let vertex = there.unwrap_or_else(|| self.brep.add_vertex(array(point)));
            seams.vertices[line].push((end, vertex));
        }
        let mut all = seams.vertices[line].clone();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.retain(|of| {
            of.0 > stretch.range[0] || seams.perimeter.is_same(of.0, stretch.range[0], line)
        });
        all.retain(|of| {
            of.0 < stretch.range[1] || seams.perimeter.is_same(of.0, stretch.range[1], line)
        });
        // Two loops that pass a vertex may differ in its parameter, but not by half a turn.
        all.dedup_by(|a, b| {
            seams.perimeter.is_same(a.0, b.0, line) || a.1 == b.1 && (a.0 - b.0).abs() < PI
        });
        all
    }

    /// The uses of the edges along a stretch of the perimeter.
    fn stretch(
        &mut self,
        seams: &mut FaceSeams,
        stretch: &Stretch,
    ) -> Result<Vec<EdgeUse>, String> {
        let line = stretch.line;
        let mut uses = Vec::new();
        for pair in self.vertices_of(seams, stretch).windows(2) {
            let [(from, a), (to, b)] = [pair[0], pair[1]];
            let key = (line, a.0, b.0);
            let (edge, range) = match seams.edges.get(&key) {
                Some(&(edge, range)) => (edge, range),
                None => {
                    let curve = match line {
                        0 => self.meridian(seams.chart, [from, to], [a, b])?,
                        _ => circle_of_latitude(seams, [from, to])?,
                    };
                    let (start, end) = curve.range();
                    let edge = self.brep.add_edge(curve, [a, b]);
                    seams.edges.insert(key, (edge, [start, end]));
                    (edge, [start, end])
                }
            };
            let uv = [stretch.uv(from), stretch.uv(to)];
            let is_at_pole = seams.perimeter.is_pole(uv[0]) || seams.perimeter.is_pole(uv[1]);
            let pcurve = match seams.has_border && is_at_pole {
                true => polyline(uv, range)?,
                false => PCurve::line(uv[0], uv[1], (range[0], range[1]))?,
            };
            uses.push(EdgeUse { edge, forward: stretch.forward, pcurve });
        }
        if !stretch.forward {
            uses.reverse();
        }
        Ok(uses)
    }

    /// The line of the surface at u = 0 between two values of v.
    fn meridian(
        &mut self,
        chart: &Chart,
        v: [f64; 2],
        ends: [VertexId; 2],
    ) -> Result<BrepCurve, String> {
        let frame = &chart.frame;
        let (centre, radius) = match chart.surface {
            BrepSurface::Sphere { radius, .. } => (frame.origin(), radius),
            BrepSurface::Torus { major, minor, .. } => (frame.point([major, 0.0, 0.0]), minor),
            _ => {
                let [from, to] = ends.map(|end| self.place(end));
                let worst = [0, 1].map(|k| (chart.point([0.0, v[k]]) - self.place(ends[k])).norm());
                self.gap = self.gap.max(worst[0]).max(worst[1]);
                return BrepCurve::line(array(from), array(to));
            }
        };
        let (sin, cos) = v[0].sin_cos();
        let towards = frame.vector([cos, 0.0, sin]);
        let frame = Frame::new(centre, frame.y().map(|e| -e), towards)?;
        BrepCurve::arc(&frame, radius, v[1] - v[0])
    }
}

/// A line as a B-spline. Readers skip the first sample of an edge, as it is the last one of the edge before it. At a pole it is
/// not, and of a line, with its two samples, half of the face would be lost to them, and with it holes or the sense of the loop.
fn polyline(ends: [[f64; 2]; 2], range: [f64; 2]) -> Result<PCurve, String> {
    let at = |k: usize, ends: [f64; 2]| {
        if k == POLYLINE {
            ends[1]
        } else {
            ends[0] + (ends[1] - ends[0]) * k as f64 / POLYLINE as f64
        }
    };
    let poles = (0..=POLYLINE).map(|k| [0, 1].map(|d| at(k, [ends[0][d], ends[1][d]]))).collect();
    let inner = (0..=POLYLINE).map(|k| at(k, range));
    let knots = [range[0]].into_iter().chain(inner).chain([range[1]]).collect();
    SplineCurve::new(1, knots, poles, None).map(PCurve::Spline)
}

/// The chains of a loop.
fn uses_of(ring: &[LoopPart]) -> Vec<ChainUse> {
    let uses = ring.iter().flat_map(|part| match part {
        LoopPart::Run(run) => run.uses.clone(),
        LoopPart::Seam(_) => Vec::new(),
    });
    uses.collect()
}

/// The polygon of a loop.
fn outline(ring: &[LoopPart]) -> Vec<Uv> {
    let points = ring.iter().flat_map(|part| match part {
        LoopPart::Run(run) => run.polygon(),
        LoopPart::Seam(stretch) => stretch.ends().map(Uv::from).to_vec(),
    });
    points.collect()
}

/// The area of a polygon, positive if it runs counter-clockwise.
fn area(polygon: &[Uv]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    0.5 * polygon.iter().zip(next).map(|(a, b)| a.x * b.y - b.x * a.y).sum::<f64>()
}

/// The circle of a torus on its cut along u between two values of u.
fn circle_of_latitude(seams: &FaceSeams, u: [f64; 2]) -> Result<BrepCurve, String> {
    let BrepSurface::Torus { major, minor, .. } = seams.chart.surface else {
        return Err("a seam along u of no torus".into());
    };
    let frame = &seams.chart.frame;
    let (sin, cos) = seams.perimeter.cell[0][1].sin_cos();
    let circle = frame.turned(u[0]).at(frame.point([0.0, 0.0, minor * sin]));
    BrepCurve::arc(&circle, major + minor * cos, u[1] - u[0])
}

/// Loops of runs that begin and end on the perimeter, joined along it with the domain on the left.
fn traced(mut left: Vec<EdgeRun>, perimeter: &Perimeter) -> Result<Vec<Vec<LoopPart>>, String> {
    let mut loops = Vec::new();
    while !left.is_empty() {
        let first = left.remove(0);
        let Some([begin, mut at]) = first.ends else { continue };
        let mut ring = vec![LoopPart::Run(first)];
        loop {
            // The next run that begins along the perimeter, or the first one again.
            let start = |run: &EdgeRun| run.ends.map_or(begin, |ends| ends[0]);
            let next = (0..left.len())
                .min_by(|&a, &b| perimeter.order(at, start(&left[a]), start(&left[b])));
            let next = next.filter(|&k| perimeter.order(at, start(&left[k]), begin).is_le());
            let to = next.map_or(begin, |k| start(&left[k]));
            ring.extend(perimeter.between(at, to)?.into_iter().map(LoopPart::Seam));
            let Some(k) = next else { break };
            let run = left.remove(k);
            at = run.ends.map_or(begin, |ends| ends[1]);
            ring.push(LoopPart::Run(run));
        }
        loops.push(in_order(ring));
    }
    Ok(loops)
}

/// Readers take seams for what they are if the loop begins behind the one at the high end of u, or with that at the high
/// end of v.
fn in_order(mut ring: Vec<LoopPart>) -> Vec<LoopPart> {
    let is = |part: &LoopPart, line: usize, forward: bool| matches!(part, LoopPart::Seam(of) if of.line == line && of.forward == forward);
    if let Some(high) = ring.iter().position(|part| is(part, 0, true)) {
        let n = ring.len();
        ring.rotate_left((high + 1) % n);
    } else if let Some(high) = ring.iter().position(|part| is(part, 1, false)) {
        ring.rotate_left(high);
    }
    ring
}
