//! Places on the scan as the user writes them: vertex indices or points.

use std::str::FromStr;

use scan2step::ScanPlace;

/// A list of places: "3,1,4,15" for vertices, "x,y,z;x,y,z" for points.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Places(pub Vec<ScanPlace>);

/// One place: "3" for a vertex, "x,y,z" for a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place(pub ScanPlace);

/// Where smoothing keeps a corner.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum NamedCorners {
    Auto,
    None,
    At(Places),
}

impl FromStr for Places {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.contains(';') || text.contains('.') {
            return text.split(';').map(point).collect::<Result<_, _>>().map(Places);
        }
        let index = |s: &str| {
            let vertex = s.trim().parse().map(ScanPlace::Vertex);
            vertex.map_err(|_| format!("'{s}' is not the index of a vertex"))
        };
        text.split(',').map(index).collect::<Result<_, _>>().map(Places)
    }
}

impl FromStr for Place {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.contains(',') {
            return point(text).map(Place);
        }
        let wrong = |_| format!("'{text}' is neither the index of a vertex nor a point x,y,z");
        text.trim().parse().map(|vertex| Place(ScanPlace::Vertex(vertex))).map_err(wrong)
    }
}

fn point(text: &str) -> Result<ScanPlace, String> {
    let wrong = || format!("'{text}' is not a point x,y,z");
    let numbers: Vec<f64> =
        text.split(',').map(|s| s.trim().parse().map_err(|_| wrong())).collect::<Result<_, _>>()?;
    let point: [f64; 3] = numbers.try_into().map_err(|_| wrong())?;
    if point.iter().all(|x| x.is_finite()) { Ok(ScanPlace::Point(point)) } else { Err(wrong()) }
}

impl FromStr for NamedCorners {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(NamedCorners::Auto),
            "none" => Ok(NamedCorners::None),
            places => places.parse().map(NamedCorners::At),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_and_points_are_told_apart() {
        let vertices = [3, 1, 4, 15].map(ScanPlace::Vertex);
        assert_eq!("3, 1,4,15".parse(), Ok(Places(vertices.to_vec())));
        let points = [[0.0, 0.0, 1.0], [-1.0, 2e3, 0.5]].map(ScanPlace::Point);
        assert_eq!("0,0,1;-1,2e3,0.5".parse(), Ok(Places(points.to_vec())));
        assert!("1,2;3,4,5".parse::<Places>().is_err());
        assert!("1,x".parse::<Places>().is_err());
        assert!("nan,0.,0".parse::<Places>().is_err());
        assert_eq!("-5,0,0".parse(), Ok(Place(ScanPlace::Point([-5.0, 0.0, 0.0]))));
        assert_eq!("50".parse(), Ok(Place(ScanPlace::Vertex(50))));
        assert!("-5".parse::<Place>().is_err() && "1,2".parse::<Place>().is_err());
    }
}
