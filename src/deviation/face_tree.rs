//! Several trimmed faces, each at one or more places, and the nearest of them.

use formats::cad::CadPlace;
use rstar::RTree;
use rstar::primitives::{GeomWithData, Rectangle};

use super::TrimmedFace;
use crate::geometry::{Point, Uv, bounds};
use crate::spline::{ParametricSurface, Surface};

/// Several faces, each at one or more places, with a tree of the boxes around them.
pub(crate) struct FaceTree<'a, S> {
    faces: Vec<TrimmedFace<'a, S>>,
    places: Vec<FacePlace>,
    boxes: RTree<GeomWithData<Rectangle<[f64; 3]>, usize>>,
}

/// A face at a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FacePlace {
    /// The number of the face.
    pub face: usize,
    /// Its place. `None` if its coordinates are those of the points that are compared with it.
    pub place: Option<CadPlace>,
}

impl FacePlace {
    /// A point in the coordinates of the face, and the factor from lengths there to lengths here.
    fn back(&self, p: Point) -> (Point, f64) {
        self.place.map_or((p, 1.0), |place| (place.back(p.into()).into(), place.scale()))
    }
}

impl<'a, S: ParametricSurface> FaceTree<'a, S> {
    /// Builds the tree of faces, each at its own place.
    pub(crate) fn new(faces: Vec<TrimmedFace<'a, S>>) -> Self {
        let places = (0..faces.len()).map(|face| FacePlace { face, place: None }).collect();
        FaceTree::placed(faces, places)
    }

    /// Builds the tree of faces at some places.
    pub(crate) fn placed(faces: Vec<TrimmedFace<'a, S>>, places: Vec<FacePlace>) -> Self {
        let of_place = |(number, FacePlace { face, place }): (usize, &FacePlace)| {
            let ends: [Point; 2] = faces[*face].bounds()?;
            let corner = |k: usize| Point::new(ends[k & 1].x, ends[k >> 1 & 1].y, ends[k >> 2].z);
            let [low, high] = match place {
                Some(place) => bounds((0..8).map(|k| Point::from(place.point(corner(k).into())))),
                None => ends,
            };
            let around = Rectangle::from_corners(low.into(), high.into());
            Some(GeomWithData::new(around, number))
        };
        let boxes = RTree::bulk_load(places.iter().enumerate().filter_map(of_place).collect());
        FaceTree { faces, places, boxes }
    }

    /// The distance of `p` from the nearest face, the number of its place, and the place on it. Of faces at
    /// the same distance it is the first. The distance is infinite if there are no faces.
    pub(crate) fn nearest(&self, p: Point) -> (f64, usize, Uv) {
        self.nearest_from(p, None)
    }

    /// The same from a start: the number of a place, and a place on its face that is near the nearest one.
    pub(super) fn nearest_from(&self, p: Point, start: Option<(usize, Uv)>) -> (f64, usize, Uv) {
        let on_face = |number: usize, start: Option<Uv>| {
            let placed = &self.places[number];
            let (local, scale) = placed.back(p);
            let (at, distance) = self.faces[placed.face].nearest(local, start);
            (scale * distance, number, at)
        };
        let start = start.filter(|(number, _)| *number < self.places.len());
        let first = start.map(|(number, at)| on_face(number, Some(at)));
        let mut best = first.unwrap_or((f64::INFINITY, 0, Uv::origin()));
        for (entry, squared) in self.boxes.nearest_neighbor_iter_with_distance_2(p.into()) {
            if squared.sqrt() > best.0 {
                break;
            }
            if first.is_some_and(|(_, number, _)| number == entry.data) {
                continue;
            }
            let other = on_face(entry.data, None);
            if (other.0, other.1) < (best.0, best.1) {
                best = other;
            }
        }
        best
    }
}

impl FaceTree<'_, Surface> {
    /// Whether a point is on the side of the normal of a face, at a place of the face.
    pub(super) fn is_above(&self, p: Point, number: usize, at: Uv) -> bool {
        self.faces[self.places[number].face].is_above(p, at)
    }
}
