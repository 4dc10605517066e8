//! How the closed components of a mesh lie in each other.

use super::components::{Choice, Component, Components};
use crate::error::Result;
use crate::geometry::Point;

/// A closed component that lies in another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Nested {
    /// The number of the component.
    pub component: usize,
    /// The number of the nearest closed component around it.
    pub around: usize,
    /// Whether one of the two faces outwards and the other one inwards.
    pub is_opposite: bool,
}

struct ClosedComponent {
    number: usize,
    body: Component,
    bounds: [Point; 2],
    is_inside_out: bool,
}

impl ClosedComponent {
    fn encloses(&self, other: &ClosedComponent) -> bool {
        let [[low, high], [from, to]] = [self.bounds, other.bounds];
        let is_around = (0..3).all(|k| low[k] <= from[k] && to[k] <= high[k]);
        self.number != other.number && is_around && self.body.encloses(&other.body)
    }
}

impl Components {
    /// The closed components that lie in other ones, dust left out. Each comes after the one around it.
    pub(crate) fn nested(&self) -> Result<Vec<Nested>> {
        let closed = self.closed()?;
        let around = |inner: &ClosedComponent| {
            (0..closed.len()).filter(|&k| closed[k].encloses(inner)).collect::<Vec<_>>()
        };
        let around: Vec<Vec<usize>> = closed.iter().map(around).collect();
        let depth = |k: usize| around[k].len();
        // The nearest of those around a component is the deepest one. Those that cross may seem to lie in each
        // other, but only one of two can be deeper.
        let nested = |k: usize| {
            let outer = around[k].iter().copied().filter(|&outer| depth(outer) < depth(k));
            let [own, outer] = [k, outer.max_by_key(|&outer| depth(outer))?].map(|k| &closed[k]);
            let is_opposite = own.is_inside_out != outer.is_inside_out;
            Some(Nested { component: own.number, around: outer.number, is_opposite })
        };
        let mut inwards: Vec<usize> = (0..closed.len()).collect();
        inwards.sort_by_key(|&k| depth(k));
        Ok(inwards.into_iter().filter_map(nested).collect())
    }

    /// The closed components besides dust, if there are several.
    fn closed(&self) -> Result<Vec<ClosedComponent>> {
        let numbers = if self.sizeable() > 1 { 0..self.sizeable() } else { 0..0 };
        let mut closed = Vec::new();
        for number in numbers {
            let body = self.take(Choice::Number(number))?;
            if body.topology.orientable && body.topology.loops == 0 {
                let (bounds, is_inside_out) = (body.own_mesh().bounds(), body.is_inside_out());
                closed.push(ClosedComponent { number, body, bounds, is_inside_out });
            }
        }
        Ok(closed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::VertexId;
    use crate::mesh::{Build, Mesh};

    /// Cubes around zero, each with half its width and whether it is turned inside out.
    fn cubes(all: &[(f64, bool)]) -> Components {
        let mut mesh = Mesh { points: Vec::new(), triangles: Vec::new() };
        for &(half, is_inverted) in all {
            let corner = |k: usize| [1, 2, 4].map(|bit| if k & bit > 0 { half } else { -half });
            let sides = [
                [0, 2, 3, 1],
                [4, 5, 7, 6],
                [0, 1, 5, 4],
                [2, 6, 7, 3],
                [0, 4, 6, 2],
                [1, 3, 7, 5],
            ];
            let first = mesh.points.len();
            mesh.points.extend((0..8).map(|k| Point::from(corner(k))));
            for [a, b, c, d] in sides.map(|side| side.map(|k| VertexId::from(first + k))) {
                let halves = [[a, b, c], [a, c, d]];
                mesh.triangles.extend(
                    halves.map(|[a, b, c]| if is_inverted { [a, c, b] } else { [a, b, c] }),
                );
            }
        }
        let places = (0..mesh.points.len() as u32).collect();
        Components::new(Build::new(mesh, places, 1.0))
    }

    fn nested(all: &[(f64, bool)]) -> Vec<[usize; 3]> {
        let nested = cubes(all).nested().unwrap().into_iter();
        nested.map(|of| [of.component, of.around, of.is_opposite.into()]).collect()
    }

    #[test]
    fn the_nearest_component_around_another_one_is_found() {
        let turns = [(4.0, false), (3.0, true), (2.0, false), (1.0, true)];
        assert_eq!(nested(&turns), [[1, 0, 1], [2, 1, 1], [3, 2, 1]]);
        // In any order, and with two that face the same way.
        let mixed = [(1.0, true), (3.0, false), (2.0, true), (4.0, false)];
        assert_eq!(nested(&mixed), [[1, 3, 0], [2, 1, 1], [0, 2, 0]]);
        assert!(nested(&[(1.0, false)]).is_empty());
    }
}
