//! The perimeter of a face's parameter domain. The domain is cut along u = 0, and on a torus also along one value of v.

use std::cmp::Ordering;
use std::f64::consts::{FRAC_PI_2, TAU};

use formats::brep::BrepSurface;

use super::chart::Chart;
use crate::geometry::{Point, Uv, is_inside};

/// Places on a cut that are so close in their parameter are one: rounding of the angles.
const SAME: f64 = 1e-9;

/// The domain: one period of each parameter that has one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Perimeter {
    /// The lowest and the highest parameters.
    pub cell: [[f64; 2]; 2],
    /// Whether v has a period.
    is_torus: bool,
    /// Whether u goes around, so that the domain is cut.
    pub is_cut: bool,
    /// Whether the sides at the lowest and at the highest v are points of the surface.
    poles: [bool; 2],
}

/// A place on the perimeter: a side, counted counter-clockwise from that at the highest u, and how far along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PerimeterPlace {
    side: usize,
    along: f64,
}

impl PerimeterPlace {
    /// Whether it is on the same side as another place and before that.
    fn is_behind(&self, other: &PerimeterPlace) -> bool {
        let along = other.along;
        self.side == other.side && self.along < along - SAME * along.abs().max(1.0)
    }
}

/// A part of one side.
#[derive(Debug, Clone)]
pub(super) struct Stretch {
    /// 0 on a cut along v, which has a fixed u; 1 on one along u.
    pub line: usize,
    /// The fixed parameter.
    pub at: f64,
    /// The range of the other parameter.
    pub range: [f64; 2],
    /// Whether the loop runs along it in the direction of that parameter.
    pub forward: bool,
}

impl Stretch {
    /// The parameters of a place on it.
    pub(super) fn uv(&self, along: f64) -> [f64; 2] {
        let mut uv = [self.at; 2];
        uv[1 - self.line] = along;
        uv
    }

    /// The parameters of its ends, in the direction of the loop.
    pub(super) fn ends(&self) -> [[f64; 2]; 2] {
        let mut ends = self.range.map(|along| self.uv(along));
        if !self.forward {
            ends.reverse();
        }
        ends
    }
}

impl Perimeter {
    /// The perimeter of a surface. On a torus v begins at `low`.
    pub(super) fn of(surface: &BrepSurface, low: f64) -> Self {
        let infinite = [f64::NEG_INFINITY, f64::INFINITY];
        let v = match *surface {
            BrepSurface::Torus { .. } => [low, low + TAU],
            BrepSurface::Sphere { .. } => [-FRAC_PI_2, FRAC_PI_2],
            BrepSurface::Cone { radius, half_angle, .. } => {
                [-radius / half_angle.tan(), f64::INFINITY]
            }
            _ => infinite,
        };
        Perimeter {
            cell: [[0.0, v[0]], [TAU, v[1]]],
            is_torus: matches!(surface, BrepSurface::Torus { .. }),
            is_cut: surface.periods()[0].is_some(),
            poles: match surface {
                BrepSurface::Sphere { .. } => [true; 2],
                BrepSurface::Cone { .. } => [true, false],
                _ => [false; 2],
            },
        }
    }

    /// Whether a point of the surface is on the cut along v, on that along u, and at a pole. None if it is on neither.
    pub(super) fn lines_at(&self, chart: &Chart, p: Point, limit: f64) -> Option<[bool; 3]> {
        if !self.is_cut {
            return None;
        }
        let is_pole = chart.parameters(p).1;
        let in_u = !is_pole && chart.off_seam(p, 0, 0.0) < limit;
        let in_v = self.is_torus && chart.off_seam(p, 1, self.cell[0][1]) < limit;
        (in_u || in_v || is_pole).then_some([in_u, in_v, is_pole])
    }

    /// The place of parameters on some of the lines that [`Perimeter::lines_at`] names.
    pub(super) fn place(&self, [in_u, _, is_pole]: [bool; 3], uv: [f64; 2]) -> PerimeterPlace {
        let [low, high] = self.cell;
        if is_pole {
            let is_high = self.poles[1] && uv[1] > 0.0;
            return match is_high {
                true => PerimeterPlace { side: 1, along: -uv[0] },
                false => PerimeterPlace { side: 3, along: uv[0] },
            };
        }
        if in_u {
            return match uv[0] > 0.5 * TAU {
                true => PerimeterPlace { side: 0, along: uv[1] },
                false => PerimeterPlace { side: 2, along: -uv[1] },
            };
        }
        match uv[1] > 0.5 * (low[1] + high[1]) {
            true => PerimeterPlace { side: 1, along: -uv[0] },
            false => PerimeterPlace { side: 3, along: uv[0] },
        }
    }

    /// The parameters of a place, exactly on the cuts that it is on.
    pub(super) fn onto(&self, lines: [bool; 3], uv: [f64; 2]) -> [f64; 2] {
        let [low, high] = self.cell;
        let nearest = |k: usize| {
            let is_high = uv[k] > 0.5 * (low[k] + high[k]);
            if is_high { high[k] } else { low[k] }
        };
        [0, 1].map(|k| if lines[k] { nearest(k) } else { uv[k] })
    }

    /// Parameters moved by whole periods into the domain.
    pub(super) fn in_cell(&self, uv: [f64; 2]) -> [f64; 2] {
        let low = self.cell[0];
        let moved = |k: usize| uv[k] - TAU * ((uv[k] - low[k]) / TAU).floor();
        let u = if self.is_cut { moved(0) } else { uv[0] };
        [u, if self.is_torus { moved(1) } else { uv[1] }]
    }

    /// Whether a polygon holds a place, whose parameters may be a period off.
    pub(super) fn holds(&self, polygon: &[Uv], place: Uv) -> bool {
        let shifts = |is_periodic: bool| if is_periodic { &[0.0, -TAU, TAU][..] } else { &[0.0] };
        shifts(self.is_cut).iter().any(|u| {
            shifts(self.is_torus)
                .iter()
                .any(|v| is_inside(Uv::new(place.x + u, place.y + v), polygon))
        })
    }

    /// Whether parameters are at a side that is a point.
    pub(super) fn is_pole(&self, uv: [f64; 2]) -> bool {
        (0..2).any(|k| self.poles[k] && self.is_same(uv[1], self.cell[k][1], 0))
    }

    /// Whether two parameters along a cut are one.
    pub(super) fn is_same(&self, a: f64, b: f64, line: usize) -> bool {
        let size = if line == 0 && !self.is_torus { a.abs().max(b.abs()).max(1.0) } else { 1.0 };
        (a - b).abs() < SAME * size
    }

    /// Which of two places comes first counter-clockwise from another one. A place that is the same comes first.
    pub(super) fn order(
        &self,
        from: PerimeterPlace,
        a: PerimeterPlace,
        b: PerimeterPlace,
    ) -> Ordering {
        let rank = |p: PerimeterPlace| {
            let turn = if p.is_behind(&from) { 4 } else { 0 };
            ((p.side + 4 - from.side) % 4 + turn, p.along)
        };
        let (x, y) = (rank(a), rank(b));
        x.0.cmp(&y.0).then(x.1.total_cmp(&y.1))
    }

    /// The stretches of the perimeter from one place to another. Sides that are points have none.
    pub(super) fn between(
        &self,
        from: PerimeterPlace,
        to: PerimeterPlace,
    ) -> Result<Vec<Stretch>, String> {
        let mut all = Vec::new();
        let mut at = from;
        loop {
            let is_last = at.side == to.side && !to.is_behind(&at);
            let end = if is_last { to.along } else { self.ends(at.side)[1] };
            all.extend(self.stretch(at.side, at.along, end)?);
            if is_last {
                return Ok(all);
            }
            if all.len() > 5 {
                return Err("a loop around its whole domain".into());
            }
            let side = (at.side + 1) % 4;
            at = PerimeterPlace { side, along: self.ends(side)[0] };
        }
    }

    /// All of the perimeter, for a face without an outer loop.
    pub(super) fn whole(&self) -> Result<Vec<Stretch>, String> {
        let mut all = Vec::new();
        for side in [3, 0, 1, 2] {
            let [start, end] = self.ends(side);
            all.extend(self.stretch(side, start, end)?);
        }
        Ok(all)
    }

    fn ends(&self, side: usize) -> [f64; 2] {
        let [low, high] = self.cell;
        match side {
            0 => [low[1], high[1]],
            1 => [-high[0], -low[0]],
            2 => [-high[1], -low[1]],
            _ => [low[0], high[0]],
        }
    }

    fn stretch(&self, side: usize, from: f64, to: f64) -> Result<Option<Stretch>, String> {
        let [low, high] = self.cell;
        let is_point = side == 1 && self.poles[1] || side == 3 && self.poles[0];
        if is_point || (to - from).abs() < SAME {
            return Ok(None);
        }
        if !(from.is_finite() && to.is_finite())
            || (side % 2 == 1 && !self.is_torus)
            || !self.is_cut
        {
            return Err("0 outer loops".into());
        }
        let (line, at) = match side {
            0 => (0, high[0]),
            1 => (1, high[1]),
            2 => (0, low[0]),
            _ => (1, low[1]),
        };
        let forward = side == 0 || side == 3;
        let range = if forward { [from, to] } else { [-to, -from] };
        Ok(Some(Stretch { line, at, range, forward }))
    }
}

#[cfg(test)]
mod tests {
    use formats::brep::Frame;

    use super::*;

    #[test]
    fn a_face_holds_places_that_are_a_period_off() {
        let frame = Frame::new([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]).expect("a frame");
        let perimeter = Perimeter::of(&BrepSurface::Cylinder { frame, radius: 2.0 }, 0.0);
        let outline = [[5.0, 0.0], [7.0, 0.0], [7.0, 4.0], [5.0, 4.0]].map(Uv::from);
        assert!(perimeter.holds(&outline, Uv::new(6.5, 1.0)));
        assert!(perimeter.holds(&outline, Uv::new(6.5 - TAU, 1.0)));
        assert!(!perimeter.holds(&outline, Uv::new(3.0, 1.0)));
    }
}
