//! Faces: their loops with pcurves, and the seams of those that go around.

use std::f64::consts::{FRAC_PI_2, TAU};

use formats::brep::{Brep, BrepCurve, BrepSurface, EdgeId, EdgeUse, Face, Frame, PCurve, VertexId};

use super::chart::{Chart, array};
use super::fallback::SeamFault;
use super::network::{ChainNetwork, ChainUse};
use super::pcurves::pcurve;
use super::winding::{FacePlan, Wrap};
use super::{EXACT, Work};
use crate::geometry::Point;

/// The samples of an edge that follow its parameters around the surface.
const SAMPLES: usize = 25;

/// One loop in the natural orientation of the surface, with the parameters of its uses in that direction.
struct EdgeRun {
    uses: Vec<ChainUse>,
    /// For each use the parameters along it.
    uv: Vec<Vec<[f64; 2]>>,
}

impl EdgeRun {
    fn start(&self) -> [f64; 2] {
        self.uv[0][0]
    }

    fn end(&self) -> [f64; 2] {
        let last = &self.uv[self.uv.len() - 1];
        last[last.len() - 1]
    }

    fn shift(&mut self, by: [f64; 2]) {
        self.uv.iter_mut().flatten().for_each(|uv| *uv = [uv[0] + by[0], uv[1] + by[1]]);
    }

    fn mean(&self, k: usize) -> f64 {
        let all = || self.uv.iter().flatten().map(|uv| uv[k]);
        all().sum::<f64>() / all().count() as f64
    }

    fn area(&self) -> f64 {
        let all: Vec<[f64; 2]> = self.uv.iter().flatten().copied().collect();
        let next = |i: usize| all[(i + 1) % all.len()];
        let of = |i: usize| all[i][0] * next(i)[1] - next(i)[0] * all[i][1];
        0.5 * (0..all.len()).map(of).sum::<f64>()
    }
}

/// What the faces share.
pub(super) struct FaceBuilder<'a> {
    pub work: &'a Work<'a>,
    pub network: &'a ChainNetwork,
    pub brep: &'a mut Brep,
    /// The largest distance between an edge and its pcurves.
    pub gap: f64,
}

impl FaceBuilder<'_> {
    /// Adds the face of a patch.
    pub fn face(&mut self, i: usize, plan: &FacePlan) -> Result<(), SeamFault> {
        let side = self.work.patches[i].side;
        let chart = &plan.chart;
        let rings = self.network.loops[i].iter();
        let natural: Vec<Vec<ChainUse>> = rings
            .map(|ring| match side > 0.0 {
                true => ring.clone(),
                false => ring.iter().rev().map(|&(chain, forward)| (chain, !forward)).collect(),
            })
            .collect();
        let made = match &plan.wrap {
            Wrap::Not => self.plain(i, chart, &natural),
            Wrap::Whole => self.whole(chart),
            Wrap::U(pair) => self.wrapped_u(i, chart, &natural, pair),
            Wrap::V(pair, seam) => self.wrapped_v(i, chart, &natural, pair, *seam),
        };
        let mut loops = made.map_err(|why| SeamFault::new(&[i], why))?;
        if side < 0.0 {
            for ring in &mut loops {
                ring.reverse();
                ring.iter_mut().for_each(|of| of.forward = !of.forward);
            }
        }
        let surface = self.brep.add_surface(chart.surface.clone());
        self.brep.add_face(Face { surface, forward: side > 0.0, loops });
        Ok(())
    }

    fn run(&self, chart: &Chart, uses: &[ChainUse]) -> EdgeRun {
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
        EdgeRun { uses: uses.to_vec(), uv }
    }

    fn uses(&mut self, chart: &Chart, run: &EdgeRun) -> Result<Vec<EdgeUse>, String> {
        let mut made = Vec::with_capacity(run.uses.len());
        for (&(chain, forward), uv) in run.uses.iter().zip(&run.uv) {
            let near = if forward { uv[0] } else { uv[uv.len() - 1] };
            let (pcurve, gap) = pcurve(chart, &self.brep.edges[chain].curve, near)?;
            if gap.is_nan() || gap > EXACT {
                return Err(format!("an edge is {gap:.1e} mm off its face"));
            }
            self.gap = self.gap.max(gap);
            made.push(EdgeUse { edge: EdgeId(chain), forward, pcurve });
        }
        Ok(made)
    }

    /// The mean direction of the face's points in an angle.
    fn middle(&self, i: usize, chart: &Chart, k: usize) -> f64 {
        let mut sums = [0.0; 2];
        for &t in &self.work.patches[i].triangles {
            let corners = self.work.mesh.triangles[t as usize];
            for p in self.work.mesh.corners(corners) {
                let (sin, cos) = chart.parameters(p).0[k].sin_cos();
                sums = [sums[0] + sin, sums[1] + cos];
            }
        }
        sums[0].atan2(sums[1])
    }

    fn plain(
        &mut self,
        i: usize,
        chart: &Chart,
        natural: &[Vec<ChainUse>],
    ) -> Result<Vec<Vec<EdgeUse>>, String> {
        let periods = chart.surface.periods();
        let mut runs = Vec::new();
        for ring in natural {
            let mut run = self.run(chart, ring);
            let mut by = [0.0; 2];
            if periods[0].is_some() {
                by[0] = -TAU * (run.mean(0) / TAU).floor();
            }
            if periods[1].is_some() {
                by[1] = TAU * ((self.middle(i, chart, 1) - run.mean(1)) / TAU).round();
            }
            run.shift(by);
            runs.push(run);
        }
        let outer = runs.iter().filter(|run| run.area() > 0.0).count();
        if outer != 1 {
            return Err(format!("{outer} outer loops"));
        }
        runs.sort_by_key(|run| run.area() <= 0.0);
        runs.iter().map(|run| self.uses(chart, run)).collect()
    }

    /// A run that starts on the seam.
    fn seam_run(
        &self,
        chart: &Chart,
        ring: &[ChainUse],
        k: usize,
        seam: f64,
    ) -> Result<EdgeRun, String> {
        for first in 0..ring.len() {
            let p = self.place(self.start_of(ring[first]));
            if chart.off_seam(p, k, seam) < EXACT {
                let turned: Vec<ChainUse> =
                    ring[first..].iter().chain(&ring[..first]).copied().collect();
                return Ok(self.run(chart, &turned));
            }
        }
        Err("a loop without a vertex on its seam".into())
    }

    fn start_of(&self, (chain, forward): ChainUse) -> VertexId {
        self.brep.edges[chain].ends[usize::from(!forward)]
    }

    fn place(&self, v: VertexId) -> Point {
        Point::from(self.brep.vertices[v.0])
    }

    fn wrapped_u(
        &mut self,
        i: usize,
        chart: &Chart,
        natural: &[Vec<ChainUse>],
        pair: &[usize],
    ) -> Result<Vec<Vec<EdgeUse>>, String> {
        let (mut lower, mut upper) = (None, None);
        for &number in pair {
            let mut run = self.seam_run(chart, &natural[number], 0, 0.0)?;
            let rises = run.end()[0] > run.start()[0];
            let from = if rises { 0.0 } else { TAU };
            run.shift([TAU * ((from - run.start()[0]) / TAU).round(), 0.0]);
            *(if rises { &mut lower } else { &mut upper }) = Some(run);
        }
        let mut upper = upper.ok_or("loops that go around the same way")?;
        let mut v = [0.0; 2];
        let low = match &mut lower {
            Some(lower) => {
                if chart.surface.periods()[1].is_some() {
                    let middle = self.middle(i, chart, 1);
                    let (low, high) = (lower.start()[1], upper.start()[1]);
                    lower.shift([0.0, TAU * ((middle - low) / TAU).floor()]);
                    upper.shift([0.0, TAU * ((middle - high) / TAU).ceil()]);
                }
                v[0] = lower.start()[1];
                self.start_of(lower.uses[0])
            }
            None => {
                v[0] = match chart.surface {
                    BrepSurface::Cone { radius, half_angle, .. } => -radius / half_angle.tan(),
                    _ => -FRAC_PI_2,
                };
                let pole = chart.surface.point(0.0, v[0]);
                self.brep.add_vertex(pole)
            }
        };
        v[1] = upper.start()[1];
        let high = self.start_of(upper.uses[0]);
        let laps = chart.surface.periods()[1].is_some_and(|period| v[1] - v[0] > period);
        if v[0] >= v[1] || laps {
            return Err("a seam that runs backwards".into());
        }
        let curve = self.meridian(chart, v, [low, high])?;
        let range = curve.range();
        let seam = self.brep.add_edge(curve, [low, high]);
        let at = |u: f64, forward: bool| -> Result<EdgeUse, String> {
            let pcurve = PCurve::line([u, v[0]], [u, v[1]], range)?;
            Ok(EdgeUse { edge: seam, forward, pcurve })
        };
        let mut outer = Vec::new();
        if let Some(lower) = &lower {
            outer.push(at(0.0, false)?);
            outer.extend(self.uses(chart, lower)?);
            outer.push(at(TAU, true)?);
            outer.extend(self.uses(chart, &upper)?);
        } else {
            outer.extend(self.uses(chart, &upper)?);
            outer.push(at(0.0, false)?);
            outer.push(at(TAU, true)?);
        }
        let near = 0.5 * (v[0] + v[1]);
        let mut loops = vec![outer];
        for (_, ring) in natural.iter().enumerate().filter(|(n, _)| !pair.contains(n)) {
            let mut run = self.run(chart, ring);
            let u = -TAU * (run.mean(0) / TAU).floor();
            let turns = ((near - run.mean(1)) / TAU).round();
            let v = if chart.surface.periods()[1].is_some() { TAU * turns } else { 0.0 };
            run.shift([u, v]);
            loops.push(self.uses(chart, &run)?);
        }
        Ok(loops)
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

    fn wrapped_v(
        &mut self,
        i: usize,
        chart: &Chart,
        natural: &[Vec<ChainUse>],
        pair: &[usize],
        seam: f64,
    ) -> Result<Vec<Vec<EdgeUse>>, String> {
        let BrepSurface::Torus { major, minor, .. } = chart.surface else {
            return Err("a seam along u of no torus".into());
        };
        let (mut left, mut right) = (None, None);
        for &number in pair {
            let mut run = self.seam_run(chart, &natural[number], 1, seam)?;
            let rises = run.end()[1] > run.start()[1];
            let from = if rises { seam } else { seam + TAU };
            let v = TAU * ((from - run.start()[1]) / TAU).round();
            run.shift([-TAU * (run.mean(0) / TAU).floor(), v]);
            *(if rises { &mut right } else { &mut left }) = Some(run);
        }
        let (Some(left), Some(right)) = (left, right) else {
            return Err("loops that go around the same way".into());
        };
        let u = [left.start()[0], right.start()[0]];
        if u[0] >= u[1] {
            return Err(format!("a seam that runs backwards on face {i}"));
        }
        let frame = &chart.frame;
        let (sin, cos) = seam.sin_cos();
        let circle = frame.turned(u[0]).at(frame.point([0.0, 0.0, minor * sin]));
        let curve = BrepCurve::arc(&circle, major + minor * cos, u[1] - u[0])?;
        let range = curve.range();
        let ends = [&left, &right].map(|run| self.start_of(run.uses[0]));
        let edge = self.brep.add_edge(curve, ends);
        let at = |v: f64, forward: bool| -> Result<EdgeUse, String> {
            Ok(EdgeUse { edge, forward, pcurve: PCurve::line([u[0], v], [u[1], v], range)? })
        };
        let mut outer = vec![at(seam + TAU, false)?];
        outer.extend(self.uses(chart, &left)?);
        outer.push(at(seam, true)?);
        outer.extend(self.uses(chart, &right)?);
        let mut loops = vec![outer];
        for (_, ring) in natural.iter().enumerate().filter(|(n, _)| !pair.contains(n)) {
            let mut run = self.run(chart, ring);
            let v = -TAU * ((run.mean(1) - seam) / TAU).floor();
            run.shift([-TAU * (run.mean(0) / TAU).floor(), v]);
            loops.push(self.uses(chart, &run)?);
        }
        Ok(loops)
    }

    /// The whole sphere with one seam between its poles, or the whole torus with two.
    fn whole(&mut self, chart: &Chart) -> Result<Vec<Vec<EdgeUse>>, String> {
        let of = |edge: EdgeId, forward: bool, ends: [[f64; 2]; 2], range: (f64, f64)| {
            PCurve::line(ends[0], ends[1], range).map(|pcurve| EdgeUse { edge, forward, pcurve })
        };
        let frame = chart.frame;
        if let BrepSurface::Torus { major, minor, .. } = chart.surface {
            let corner = self.brep.add_vertex(chart.surface.point(0.0, 0.0));
            let around = BrepCurve::circle(&frame, major + minor)?;
            let tube =
                Frame::new(frame.point([major, 0.0, 0.0]), frame.y().map(|e| -e), frame.x())?;
            let tube = BrepCurve::circle(&tube, minor)?;
            let range = (0.0, TAU);
            let [a, b] = [around, tube].map(|curve| self.brep.add_edge(curve, [corner; 2]));
            return Ok(vec![vec![
                of(a, true, [[0.0, 0.0], [TAU, 0.0]], range)?,
                of(b, true, [[TAU, 0.0], [TAU, TAU]], range)?,
                of(a, false, [[0.0, TAU], [TAU, TAU]], range)?,
                of(b, false, [[0.0, 0.0], [0.0, TAU]], range)?,
            ]]);
        }
        let v = [-FRAC_PI_2, FRAC_PI_2];
        let ends = v.map(|v| self.brep.add_vertex(chart.surface.point(0.0, v)));
        let curve = self.meridian(chart, v, ends)?;
        let range = curve.range();
        let seam = self.brep.add_edge(curve, ends);
        Ok(vec![vec![
            of(seam, true, [[TAU, v[0]], [TAU, v[1]]], range)?,
            of(seam, false, [[0.0, v[0]], [0.0, v[1]]], range)?,
        ]])
    }
}
