//! STL: what it may contain, and what is refused.

use formats::Place;

use crate::support::{polygons, refusal, soup};

const TRIANGLE: &str = "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1.5 0 0\n  \
                        vertex 0 1e0 0\n endloop\nendfacet\n";
const CORNERS: [[f64; 3]; 3] = [[0., 0., 0.], [1.5, 0., 0.], [0., 1., 0.]];

fn ascii(facets: &str) -> String {
    format!("solid a name with facet in it\n{facets}endsolid a name\n")
}

fn binary(header: &str, count: u32, triangles: usize) -> Vec<u8> {
    let mut file = header.as_bytes().to_vec();
    file.resize(80, b' ');
    file.extend(count.to_le_bytes());
    for _ in 0..triangles {
        file.extend([0; 12]);
        CORNERS.as_flattened().iter().for_each(|v| file.extend((*v as f32).to_le_bytes()));
        file.extend([0; 2]);
    }
    file
}

#[test]
fn ascii_gives_three_points_for_each_triangle() {
    let soup = soup("two.stl", ascii(&TRIANGLE.repeat(2)));
    assert_eq!(soup.points, [CORNERS, CORNERS].concat());
    assert_eq!(polygons(&soup), [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(soup.unit, None);
}

#[test]
fn several_solids_are_one_mesh() {
    let text = ascii(TRIANGLE) + "\n" + &ascii("") + &ascii(TRIANGLE).to_uppercase();
    assert_eq!(polygons(&soup("solids.stl", text)), [[0, 1, 2], [3, 4, 5]]);
}

#[test]
fn loose_text_is_read() {
    let text = ascii(TRIANGLE);
    let loose = [
        text.replace('\n', "\r\n"),
        text.replace('\n', "\r"),
        text.trim_end().to_owned(),
        "\n  ".to_owned() + &text,
        text.replace("a name", ""),
        ascii(&TRIANGLE.replace('\n', " ")).replace("endsolid", "\nendsolid"),
        text.replace("normal 0 0 1", "normal nan -nan(ind) x"),
    ];
    for text in loose {
        assert_eq!(soup("loose.stl", &text).points, CORNERS, "{text}");
        assert_eq!(soup("loose.txt", &text).points, CORNERS, "{text}");
    }
}

#[test]
fn binary_is_read_whatever_its_header() {
    for header in ["", "solid", "solid in name only", "v 1 2 3", "PK\x03\x04"] {
        for name in ["two.stl", "two.bin"] {
            let soup = soup(name, binary(header, 2, 2));
            assert_eq!(soup.points, [CORNERS, CORNERS].concat());
            assert_eq!(polygons(&soup), [[0, 1, 2], [3, 4, 5]]);
        }
    }
}

#[test]
fn what_follows_a_binary_mesh_is_left_alone() {
    let mut file = binary("made by hand", 1, 1);
    file.extend(b"more");
    assert_eq!(soup("more.stl", file).points, CORNERS);
}

#[test]
fn points_without_a_number_are_kept() {
    let text = ascii(&TRIANGLE.replace("1.5", "nan"));
    assert!(!soup("nan.stl", text).points[1][0].is_finite());
}

#[test]
fn cut_files_are_refused() {
    let error = refusal("cut.stl", binary("", 3, 2), "ends after 2 of its 3");
    assert_eq!(error.place, Some(Place::Face(2)));
    refusal("huge.stl", binary("", u32::MAX, 1), "ends after 1");
    let text = ascii(TRIANGLE);
    let end = text.find("endsolid").expect("an end");
    let start = text.find('\n').expect("a line") + 1;
    for cut in start..end + 8 {
        let error = refusal("cut.stl", &text[..cut], "");
        assert!(matches!(error.place, Some(Place::Line(_))), "{cut}: {error}");
    }
}

#[test]
fn unsound_text_is_refused() {
    let swaps = [
        ("  vertex 0 1e0 0\n", ""),
        ("1e0", "1,0"),
        ("1e0", ""),
        (" endloop\n", ""),
        ("endfacet\n", ""),
        ("facet normal 0 0 1\n", ""),
        ("outer", "inner"),
        ("endsolid", "solid"),
    ];
    for (from, to) in swaps {
        let error = refusal("bad.stl", ascii(TRIANGLE).replacen(from, to, 1), "");
        assert!(matches!(error.place, Some(Place::Line(_))), "{from}: {error}");
    }
}
