//! Places on the scan that a user names by a vertex or by coordinates.

use formats::{Points, Soup};

use super::Options;
use crate::error::{Error, Result};
use crate::geometry::{Point, Vector};
use crate::mesh::Outer;
use crate::stages::smooth;

/// A place on the scan, in the terms of its file.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(untagged))]
pub enum ScanPlace {
    /// A vertex of a mesh or a point of a cloud. The file counts them from 0 ([`Soup::points`],
    /// [`Points::positions`]).
    Vertex(usize),
    /// A point, in the scan's own numbers.
    Point([f64; 3]),
}

impl ScanPlace {
    /// The place in mm from the mesh's origin ([`Soup::round_origin`]), for a mesh whose numbers are so many `mm`.
    ///
    /// # Errors
    /// [`Error::Vertex`]: the scan has no such vertex.
    pub fn resolve(self, soup: &Soup, mm: f64) -> Result<Point> {
        let origin = soup.round_origin(mm);
        let in_file = |place: Point| place - mm * Vector::from(origin);
        self.among(&soup.points, [0.0; 3], mm).map(in_file)
    }

    /// The place in mm from the cloud's origin, for a cloud whose numbers are so many `mm`. Its
    /// vertices are its points.
    ///
    /// # Errors
    /// [`Error::Vertex`]: the cloud has no such point.
    pub fn resolve_in_cloud(self, cloud: &Points, mm: f64) -> Result<Point> {
        self.among(&cloud.positions, cloud.origin, mm)
    }

    fn among(self, points: &[[f64; 3]], origin: [f64; 3], mm: f64) -> Result<Point> {
        let point = match self {
            ScanPlace::Point(point) => [0, 1, 2].map(|k| point[k] - origin[k]),
            ScanPlace::Vertex(asked) => {
                let count = points.len();
                *points.get(asked).ok_or(Error::Vertex { asked, count })?
            }
        };
        Ok(Point::from(point.map(|x| x * mm)))
    }
}

/// The places that options name in the terms of the scan's file. They become points in mm once
/// the scan is known.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct NamedPlaces {
    pub(crate) outer: Option<ScanPlace>,
    pub(crate) corners: Option<Vec<ScanPlace>>,
    pub(crate) boundary_corners: Option<Vec<ScanPlace>>,
    /// Whether the other options have the points of these places.
    pub(crate) resolved: bool,
}

impl NamedPlaces {
    /// Checks that the points of all places are known.
    pub(crate) fn check(&self) -> Result<()> {
        let any = self.outer.is_some() || self.corners.is_some() || self.boundary_corners.is_some();
        match any && !self.resolved {
            true => {
                Err(Error::Input("resolve the places of the options with the scan's soup first"))
            }
            false => Ok(()),
        }
    }
}

impl Options {
    /// The same with the points of all places that were named in the terms of the scan's file:
    /// [`Builder::outer_place`](crate::convert::Builder::outer_place) and the like.
    /// [`convert`](crate::convert) does this by itself;
    /// [`Components`](crate::mesh::Components) have no soup to look the places up in.
    ///
    /// # Errors
    /// [`Error::Vertex`]: the scan has no such vertex.
    pub fn resolved(&self, soup: &Soup) -> Result<Options> {
        let mm = self.unit_of(soup.unit);
        self.resolved_by(&|place| place.resolve(soup, mm))
    }

    /// The same for a cloud.
    ///
    /// # Errors
    /// [`Error::Vertex`]: the cloud has no such point.
    pub fn resolved_in_cloud(&self, cloud: &Points) -> Result<Options> {
        let mm = self.unit_of(cloud.unit);
        self.resolved_by(&|place| place.resolve_in_cloud(cloud, mm))
    }

    fn resolved_by(&self, resolve: &dyn Fn(ScanPlace) -> Result<Point>) -> Result<Options> {
        let all = |places: &Vec<ScanPlace>| -> Result<Vec<Point>> {
            places.iter().map(|&place| resolve(place)).collect()
        };
        let mut options = self.clone();
        options.places.resolved = true;
        if let Some(place) = self.places.outer {
            options.outer = Outer::Near(resolve(place)?);
        }
        if let Some(places) = &self.places.corners {
            let wrong = |_| Error::Corners("not four places".into());
            options.parameterize.corners = Some(all(places)?.try_into().map_err(wrong)?);
        }
        if let Some(places) = &self.places.boundary_corners {
            options.smooth.corners = smooth::Corners::At(all(places)?);
        }
        Ok(options)
    }
}
