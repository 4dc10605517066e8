//! Places on the scan that a user names: vertex indices or points.

use std::str::FromStr;

use formats::Soup;
use scan2step::geometry::Point;

/// Places on the scan.
#[derive(Debug, Clone, PartialEq)]
pub enum Places {
    /// Vertices as the file counts them, from 0.
    Vertices(Vec<usize>),
    /// Points in the scan's numbers.
    Points(Vec<[f64; 3]>),
}

/// One place on the scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// A vertex as the file counts them, from 0.
    Vertex(usize),
    /// A point in the scan's numbers.
    Point([f64; 3]),
}

/// Where smoothing keeps a corner.
#[derive(Debug, Clone, PartialEq)]
pub enum Corners {
    Auto,
    None,
    At(Places),
}

impl FromStr for Places {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.contains(';') || text.contains('.') {
            return text.split(';').map(point).collect::<Result<_, _>>().map(Places::Points);
        }
        let index =
            |s: &str| s.trim().parse().map_err(|_| format!("'{s}' is not the index of a vertex"));
        text.split(',').map(index).collect::<Result<_, _>>().map(Places::Vertices)
    }
}

impl FromStr for Place {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.contains(',') {
            return point(text).map(Place::Point);
        }
        let wrong = |_| format!("'{text}' is neither the index of a vertex nor a point x,y,z");
        text.trim().parse().map(Place::Vertex).map_err(wrong)
    }
}

fn point(text: &str) -> Result<[f64; 3], String> {
    let wrong = || format!("'{text}' is not a point x,y,z");
    let numbers: Vec<f64> =
        text.split(',').map(|s| s.trim().parse().map_err(|_| wrong())).collect::<Result<_, _>>()?;
    let point: [f64; 3] = numbers.try_into().map_err(|_| wrong())?;
    if point.iter().all(|x| x.is_finite()) { Ok(point) } else { Err(wrong()) }
}

impl FromStr for Corners {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Corners::Auto),
            "none" => Ok(Corners::None),
            places => places.parse().map(Corners::At),
        }
    }
}

impl Places {
    /// The places as points in mm.
    pub fn resolve(&self, soup: &Soup, unit_mm: f64) -> Result<Vec<Point>, String> {
        let resolved = |place: Place| place.resolve(soup, unit_mm);
        match self {
            Places::Points(points) => points.iter().map(|&p| resolved(Place::Point(p))).collect(),
            Places::Vertices(all) => all.iter().map(|&v| resolved(Place::Vertex(v))).collect(),
        }
    }
}

impl Place {
    /// The place as a point in mm.
    pub fn resolve(self, soup: &Soup, unit_mm: f64) -> Result<Point, String> {
        let missing = |v| format!("there is no vertex {v}; the scan has {}", soup.points.len());
        let point = match self {
            Place::Point(point) => point,
            Place::Vertex(v) => *soup.points.get(v).ok_or_else(|| missing(v))?,
        };
        Ok(Point::from(point.map(|x| x * unit_mm)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_and_points_are_told_apart() {
        assert_eq!("3, 1,4,15".parse(), Ok(Places::Vertices(vec![3, 1, 4, 15])));
        let points = "0,0,1;-1,2e3,0.5".parse();
        assert_eq!(points, Ok(Places::Points(vec![[0.0, 0.0, 1.0], [-1.0, 2e3, 0.5]])));
        assert!("1,2;3,4,5".parse::<Places>().is_err());
        assert!("1,x".parse::<Places>().is_err());
        assert!("nan,0.,0".parse::<Places>().is_err());
        assert_eq!("-5,0,0".parse(), Ok(Place::Point([-5.0, 0.0, 0.0])));
        assert_eq!("50".parse(), Ok(Place::Vertex(50)));
        assert!("-5".parse::<Place>().is_err() && "1,2".parse::<Place>().is_err());
    }
}
