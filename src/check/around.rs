//! Loops that go around a surface.
//!
//! The input is loops whose ends are images of each other. The output is one ring: a loop and a pole, or two loops,
//! with lines across the face between them.

use nalgebra::Vector2;

use super::loops::{RingCorner, TracedLoop};
use super::trace::Tracer;
use crate::geometry::uv_bounds;

impl Tracer<'_> {
    /// The ring that loops around the surface bound: one loop and a pole, or two loops.
    pub(super) fn closed(
        &self,
        around: Vec<TracedLoop>,
        forward: Option<bool>,
    ) -> Result<TracedLoop, String> {
        let turns = [0, 1].map(|axis| around.iter().map(|traced| traced.turns[axis]).sum::<i32>());
        let mut around = around.into_iter();
        match (around.next(), around.next(), around.next()) {
            (Some(one), None, _) => self.closed_by_pole(one, forward),
            (Some(one), Some(other), None) if turns == [0; 2] => {
                Ok(self.closed_by_loop(one, &other, forward))
            }
            _ => Err("its loops around the surface do not bound a part of it".into()),
        }
    }

    fn closed_by_pole(
        &self,
        mut one: TracedLoop,
        forward: Option<bool>,
    ) -> Result<TracedLoop, String> {
        let refused = "a loop around the surface bounds no part of it";
        let (axis, turns) = match one.turns {
            [turns @ (1 | -1), 0] => (0, turns),
            [0, turns @ (1 | -1)] => (1, turns),
            _ => return Err(refused.into()),
        };
        let [low, high] = uv_bounds(&one.corners.iter().map(|c| c.at).collect::<Vec<_>>());
        let across = 1 - axis;
        let poles = || self.surface.closure.poles.iter().filter(|pole| pole.axis == across);
        let above = poles().filter(|pole| pole.value >= high[across]);
        let above = above.min_by(|a, b| a.value.total_cmp(&b.value));
        let below = poles().filter(|pole| pole.value <= low[across]);
        let below = below.max_by(|a, b| a.value.total_cmp(&b.value));
        let pole = match (below, above, forward) {
            (Some(pole), None, _) | (None, Some(pole), _) => pole,
            (Some(below), Some(above), Some(forward)) => {
                let is_above = (turns > 0) == (axis == 0);
                if is_above == forward { above } else { below }
            }
            (Some(_), Some(_), None) => {
                return Err("nothing tells on which side of a loop the face is".into());
            }
            (None, None, _) => return Err(refused.into()),
        };
        let Some(&start) = one.corners.first() else { return Err(refused.into()) };
        let Some(end) = one.corners.last_mut() else { return Err(refused.into()) };
        end.is_across = true;
        let at_pole = |mut corner: RingCorner, is_across: bool| {
            corner.at[across] = pole.value;
            RingCorner { point: pole.point, is_middle: false, is_across, ..corner }
        };
        let end = *end;
        one.corners.extend([at_pole(end, false), at_pole(start, true), start]);
        Ok(one)
    }

    fn closed_by_loop(
        &self,
        mut one: TracedLoop,
        other: &TracedLoop,
        forward: Option<bool>,
    ) -> TracedLoop {
        let middle = |traced: &TracedLoop| {
            let sum: Vector2<f64> = traced.corners.iter().map(|c| c.at.coords).sum();
            sum / traced.corners.len() as f64
        };
        let mut shift = Vector2::zeros();
        if let (Some(end), Some(start)) = (one.corners.last(), other.corners.first()) {
            shift = self.surface.image(start.at, end.at) - start.at;
        }
        let axis = usize::from(one.turns[0] == 0);
        // On a torus the face is on the left of both loops.
        if let (Some(period), Some(forward)) = (self.surface.closure.periods[1 - axis], forward) {
            let gap = (middle(other) + shift - middle(&one))[1 - axis];
            let is_above = ((one.turns[axis] > 0) == (axis == 0)) == forward;
            let wanted =
                if is_above { gap.rem_euclid(period) } else { gap.rem_euclid(period) - period };
            shift[1 - axis] += wanted - gap;
        }
        if let Some(end) = one.corners.last_mut() {
            end.is_across = true;
        }
        let start = one.corners.first().copied();
        one.corners.extend(other.corners.iter().map(|c| RingCorner { at: c.at + shift, ..*c }));
        if let Some(end) = one.corners.last_mut() {
            end.is_across = true;
        }
        one.corners.extend(start);
        TracedLoop { turns: [0; 2], ..one }
    }
}
