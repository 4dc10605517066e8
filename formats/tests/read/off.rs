//! OFF: Geomview's keywords, comments, colours and counts.

use crate::support::{polygons, refusal, soup};

const POINTS: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 10.0, 0.0]];
const BODY: &str = "0 0 0\n1 0 0\n1. 1 .5\n0 1e1 0\n3 0 1 2\n4 0 1 2 3\n";

#[test]
fn headers_may_be_written_in_many_ways() {
    for head in [
        "OFF\n4 2 5\n",
        "OFF 4 2 5\n",
        "OFF\n4 2\n",
        "4 2 0\n",
        "# a comment\n\nOFF # another\n\n4 2 0 # counts\n# before the vertices\n",
    ] {
        for text in [format!("{head}{BODY}"), format!("{head}{BODY}").replace('\n', "\r\n")] {
            let soup = soup("scan.off", &text);
            assert_eq!(soup.points, POINTS, "{head}");
            assert_eq!(polygons(&soup), [vec![0, 1, 2], vec![0, 1, 2, 3]], "{head}");
            assert_eq!((soup.unit, soup.colour), (None, None));
        }
    }
    // The keyword tells it under any name, and the name where it is not there.
    assert_eq!(soup("scan.ply", format!("OFF\n4 2 5\n{BODY}")).points, POINTS);
    refusal("scan", format!("4 2 0\n{BODY}"), "not in a known mesh format");
}

#[test]
fn colours_and_normals_are_read_over() {
    let vertices = "0 0 0 9 9 9\n1 0 0 9 9 9\n1 1 .5 9 9 9\n0 10 0 9 9 9\n";
    let faces = "3 0 1 2 255 0 0\n4 0 1 2 3 0.5 0.5 0.5 1\n";
    for keyword in ["OFF", "COFF", "NOFF", "CNOFF", "STCNOFF", "STOFF"] {
        let soup = soup("scan.off", format!("{keyword}\n4 2 0\n{vertices}{faces}"));
        assert_eq!(soup.points, POINTS, "{keyword}");
        assert_eq!(polygons(&soup), [vec![0, 1, 2], vec![0, 1, 2, 3]], "{keyword}");
    }
}

#[test]
fn points_and_lines_bound_no_surface() {
    let soup = soup("scan.off", format!("OFF\n4 5 0\n{BODY}2 0 1\n1 3\n0\n"));
    assert_eq!(polygons(&soup), [vec![0, 1, 2], vec![0, 1, 2, 3]]);
}

#[test]
fn contradictions_are_refused() {
    for (head, body, word) in [
        ("OFF\n4 3 0\n", BODY, "ends after 2 of its 3 faces (face 2)"),
        ("OFF\n9 0 0\n", BODY, "ends after 6 of its 9 vertices (vertex 6)"),
        ("OFF\n4000000000 4000000000 0\n", BODY, "ends after 6 of its 4000000000 vertices"),
        ("OFF\n4 1 0\n", BODY, "more data than its header announces (line 8)"),
        ("OFF\n4\n", BODY, "no numbers of vertices and faces in its header (line 2)"),
        ("OFF\nfour 2 0\n", BODY, "no numbers of vertices and faces"),
        ("OFF\n", "", "no numbers of vertices and faces"),
        ("OFF\n1 0 0\n", "1 2\n", "unreadable vertex \u{201c}1 2\u{201d} (line 3)"),
        ("OFF\n1 0 0\n", "1 2,5 3\n", "unreadable vertex"),
        ("OFF\n1 1 0\n", "1 2 3\n3 0 0\n", "unreadable face \u{201c}3 0 0\u{201d} (line 4)"),
        ("OFF\n1 1 0\n", "1 2 3\n3 0 0 -1\n", "unreadable face"),
        ("OFF\n1 1 0\n", "1 2 3\n4000000000 0 0 0\n", "unreadable face"),
        ("OFF\n1 1 0\n", "1 2 3\n3 0 0 1\n", "vertex 1, but only 1 vertex (line 4)"),
        ("OFF\n1 0 0\n", "1 2 3\n", "points but no faces"),
        ("OFF\n0 0 0\n", "", "neither points nor faces"),
        ("OFF BINARY\n", "", "binary OFF"),
        ("4OFF\n1 0 0\n", "1 2 3 4\n", "four or more dimensions"),
        ("nOFF\n3\n1 0 0\n", "1 2 3\n", "four or more dimensions"),
    ] {
        refusal("scan.off", format!("{head}{body}"), word);
    }
}
