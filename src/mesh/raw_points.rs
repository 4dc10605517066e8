//! The points that a scanner measured, where the vertices of the mesh are other points.
//!
//! A mesh that was made of a cloud has fewer vertices than the cloud has points, and at smoothed
//! places. Deviations are measured against the points themselves, and the tolerance follows their
//! noise. So both stay with the mesh.

use std::borrow::Cow;

use super::vertices::VertexMap;
use crate::geometry::{NONE, Point};

/// Points of a cloud, each with the vertex of the mesh that stands for it.
#[derive(Debug, Clone)]
pub struct RawPoints {
    points: Vec<Point>,
    vertex_of: Vec<u32>,
    noise: f64,
    origin: [f64; 3],
    /// Where each vertex was measured; empty if that is where it is.
    places: Vec<Point>,
}

/// The points that were measured of one face: those of the cloud, or the vertices of its mesh.
#[derive(Debug)]
pub(crate) struct FacePoints<'a> {
    /// The points, in the unit of the mesh.
    pub(crate) points: Cow<'a, [Point]>,
    /// For each point the vertex of the face's mesh that stands for it. `None` if the points are
    /// these vertices.
    pub(crate) vertex_of: Option<Vec<u32>>,
    /// Which of the points each vertex of the file became.
    pub(crate) map: VertexMap,
}

impl RawPoints {
    /// Points, and for each the vertex of the soup that stands for it, or `u32::MAX` if there is
    /// none, as for an outlier. The standard deviation of the noise has the unit of the points,
    /// which is that of the soup.
    pub fn new(points: Vec<Point>, vertex_of: Vec<u32>, noise: f64) -> Self {
        RawPoints { points, vertex_of, noise, origin: [0.0; 3], places: Vec::new() }
    }

    /// The same with the place of each vertex of the soup where it was measured, noise included.
    /// Without them, vertices were measured where they are.
    #[must_use]
    pub(crate) fn with_measured_vertices(self, places: Vec<Point>) -> Self {
        RawPoints { places, ..self }
    }

    /// Whether vertices were measured elsewhere than they are.
    pub(super) fn has_measured_vertices(&self) -> bool {
        !self.places.is_empty()
    }

    /// The same for points that are measured from such an origin, in the unit of the points.
    #[must_use]
    pub(crate) fn at(self, origin: [f64; 3]) -> Self {
        RawPoints { origin, ..self }
    }

    /// Where the points are measured from, in their unit.
    pub(crate) fn origin(&self) -> [f64; 3] {
        self.origin
    }

    /// The standard deviation of the noise, in the unit of the points.
    pub(crate) fn noise(&self) -> f64 {
        self.noise
    }

    /// All points, each with whether a vertex of the mesh stands for it. None does for an outlier.
    pub fn all(&self) -> impl Iterator<Item = (Point, bool)> {
        let pairs = self.points.iter().zip(&self.vertex_of);
        pairs.map(|(point, vertex)| (*point, *vertex != NONE))
    }

    /// The same with all lengths multiplied by a factor.
    pub(super) fn scaled(mut self, factor: f64) -> Self {
        self.points.iter_mut().chain(&mut self.places).for_each(|p| *p *= factor);
        let origin = self.origin.map(|x| factor * x);
        RawPoints { noise: factor * self.noise, origin, ..self }
    }

    /// Puts the vertices of a mesh where they were measured. `map` tells which vertex of the soup
    /// each of them was.
    pub(super) fn place_measured(&self, map: &VertexMap, vertices: &mut [Point]) {
        for (number, &place) in self.places.iter().enumerate() {
            if let Some(vertex) = map.point_of(number).and_then(|v| vertices.get_mut(v)) {
                *vertex = place;
            }
        }
    }

    /// The number of points of each of `count` vertices that are found in `vertices`. A vertex that a repair of the mesh
    /// has doubled has none of its own. It counts as one.
    pub(super) fn counts(&self, vertices: &VertexMap, count: usize) -> Vec<f64> {
        let mut counts = vec![0.0; count];
        for &vertex in &self.vertex_of {
            if let Some(vertex) = vertices.point_of(vertex as usize) {
                counts[vertex] += 1.0;
            }
        }
        counts.iter_mut().for_each(|count| *count = f64::max(*count, 1.0));
        counts
    }

    /// The points of the face whose vertices are found in `vertices`.
    pub(super) fn of_face(&self, vertices: &VertexMap) -> FacePoints<'static> {
        let (mut points, mut vertex_of) = (Vec::new(), Vec::new());
        let mut map = vec![NONE; self.points.len()];
        for (i, (&point, &vertex)) in self.points.iter().zip(&self.vertex_of).enumerate() {
            if let Some(vertex) = vertices.point_of(vertex as usize) {
                map[i] = points.len() as u32;
                points.push(point);
                vertex_of.push(vertex as u32);
            }
        }
        FacePoints {
            points: points.into(),
            vertex_of: Some(vertex_of),
            map: VertexMap::of_numbers(map),
        }
    }
}

impl FacePoints<'_> {
    /// A value of each point's vertex, for each point.
    pub(crate) fn of_vertices<'b, T: Copy>(&self, values: &'b [T]) -> Cow<'b, [T]> {
        match &self.vertex_of {
            None => values.into(),
            Some(vertex_of) => vertex_of.iter().map(|&v| values[v as usize]).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_face_has_the_points_whose_vertices_it_has() {
        let points = (0..5).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect();
        let raw = RawPoints::new(points, vec![1, 0, NONE, 2, 1], 0.5).scaled(2.0);
        assert_eq!(raw.noise(), 1.0);
        assert_eq!(raw.all().filter(|(_, is_used)| *is_used).count(), 4);
        // Vertex 0 of the soup is not on this face.
        let face = raw.of_face(&VertexMap::of_numbers(vec![NONE, 0, 1]));
        assert_eq!(face.points.iter().map(|p| p.x).collect::<Vec<_>>(), [0.0, 6.0, 8.0]);
        assert_eq!(face.of_vertices(&[10, 20]).as_ref(), [10, 20, 10]);
        let positions: Vec<_> = (0..5).map(|i| face.map.point_of(i)).collect();
        assert_eq!(positions, [Some(0), None, None, Some(1), Some(2)]);
    }
}
