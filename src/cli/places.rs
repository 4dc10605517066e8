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
        let in_mm = |p: &[f64; 3]| Point::from(p.map(|x| x * unit_mm));
        match self {
            Places::Points(points) => Ok(points.iter().map(in_mm).collect()),
            Places::Vertices(indices) => indices
                .iter()
                .map(|&i| {
                    let count = soup.points.len();
                    let vertex = soup.points.get(i);
                    vertex.map(in_mm).ok_or(format!("there is no vertex {i}; the scan has {count}"))
                })
                .collect(),
        }
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
    }
}
