//! OBJ: unusual notations of exporters and users.

use formats::Location;

use crate::support::{polygons, refusal, soup};

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const POINTS: [[f64; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];

/// The polygons of the square with `faces`. The points must not change.
#[track_caller]
fn faces(faces: &str) -> Vec<Vec<u32>> {
    let soup = soup("odd.obj", SQUARE.to_owned() + faces);
    assert_eq!(soup.points, POINTS, "{faces}");
    polygons(&soup)
}

#[test]
fn spaces_and_tabs_separate() {
    let text = "v   0 0 0   \nv\t1\t0\t0\nv 1\t1    0\t\n \tv 0 1 0\n   \n\t\nf 1  2\t3    4 \t \n";
    let soup = soup("tabs.obj", text);
    assert_eq!(soup.points, POINTS);
    assert_eq!(polygons(&soup), [[0, 1, 2, 3]]);
    assert_eq!(faces("f 1/1/1\t2/2/1\t3/3/1  4/4/1\n"), [[0, 1, 2, 3]]);
}

#[test]
fn numbers_of_every_spelling() {
    for (word, value) in [
        ("2.", 2.),
        ("+2.", 2.),
        ("-2.0", -2.),
        (".5", 0.5),
        ("-.5", -0.5),
        ("+.5", 0.5),
        ("007", 7.),
        ("1e2", 100.),
        ("+1E2", 100.),
        ("2.e1", 20.),
        ("-2.e+1", -20.),
        (".8e-1", 0.08),
        ("-.7e+2", -70.),
        ("3.1E-02", 0.031),
        ("1e-320", 1e-320),
        ("-0", 0.),
        ("5123456.123456789", 5_123_456.123_456_789),
        ("0.1000000000000000055511151231257827021181583404541015625", 0.1),
    ] {
        let text = format!("v 9 {word} 9\n{SQUARE}f 1 2 3\n");
        assert_eq!(soup("number.obj", text).points[0], [9., value, 9.], "{word}");
    }
}

#[test]
fn words_that_are_no_numbers_are_refused() {
    for word in ["3.1+e2", "1,5", "1.2.3", "--1", "1e", "e5", "0x10", "1_000", "1.0f", "1d3", "."] {
        let text = format!("{SQUARE}v 9 {word} 9\nf 1 2 3\n");
        let error = refusal("word.obj", text, &format!("unreadable vertex \u{201c}v 9 {word} 9"));
        assert_eq!(error.place, Some(Location::Line(5)), "{word}");
    }
}

#[test]
fn decimal_commas_are_refused_at_the_first() {
    let error = refusal("commas.obj", "# v 1,5\nv 42,794 -20,6071 -16,566\nf 1 1 1\n", "42,794");
    assert_eq!(error.place, Some(Location::Line(2)));
    assert!(error.help.contains("decimal points"));
}

#[test]
fn corners_of_every_form() {
    for face in [
        "f 1 2 3 4",
        "f 1/1 2/2 3/3 4/4",
        "f 1//1 2//2 3//3 4//4",
        "f 1/1/1 2/2/2 3/3/3 4/4/4",
        "f 1// 2// 3// 4//",
        "f 1/ 2/ 3/ 4/",
        "f 1/9/ 2/9/ 3/9/ 4/9/",
        "f -4 -3 -2 -1",
        "f -4/-9 -3//-9 -2/-9/-9 -1//",
        "f 1 -3 3/1 -1//-1",
        // The numbers of texture points and normals do not matter, and zeros do not, either.
        "f 1/0/0 2/0/0 3/0/0 4/0/0",
        "f 1/x/y 2 3 4",
        "f 01 +2 3 4",
        "f 1 2 3 4 # and a comment",
        "f 1 2 3 4 #",
    ] {
        assert_eq!(faces(&format!("{face}\n")), [[0, 1, 2, 3]], "{face}");
    }
}

#[test]
fn corners_may_repeat() {
    assert_eq!(
        faces("f 1 1 3\nf 1 2 3 4 1 2 3 4\n"),
        [vec![0, 0, 2], vec![0, 1, 2, 3, 0, 1, 2, 3]]
    );
}

/// The statement of releases before 3.0, which readers should treat as `f` according to the
/// specification.
#[test]
fn old_face_outlines_are_faces() {
    assert_eq!(faces("fo 1 2 3\nf 1 3 4\n"), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn points_and_lines_stand_beside_faces() {
    let text = "p 1 2 3 4\nl 1 2 3 4\nf 1 2 3\np 1\nl 1/1 2/2\nf 1 3 4\np -1\n";
    assert_eq!(faces(text), [[0, 1, 2], [0, 2, 3]]);
    for loose in ["p 1 2 3 4\n", "l 1 2 3 4\n", "f 1 2\n", "", "vp 0 0\ncstype bezier\n"] {
        refusal("loose.obj", SQUARE.to_owned() + loose, "has points but no faces");
    }
}

#[test]
fn nothing_is_refused() {
    for text in ["# nothing here\n", "#", "\n", "o Cube\n", "vn 0 0 1\nvt 0 0\n", "\u{feff}"] {
        refusal("nothing.obj", text, "neither points nor faces");
    }
}

#[test]
fn faces_without_vertices_are_refused() {
    for (face, word) in [
        ("f -4 -3 -2", "vertex -4, but only 0 vertices before it"),
        ("f 1 2 3", "vertex 3, but only 0 vertices"),
        ("f 0/0/0 1/1/0 3/3/0", "vertex 0, but OBJ counts from 1"),
    ] {
        // Files with and without a line end are both complete.
        for end in ["", "\n"] {
            let error = refusal("none.obj", format!("{face}{end}"), word);
            assert_eq!(error.place, Some(Location::Line(1)), "{face}");
        }
    }
}

#[test]
fn lines_go_on_after_a_backslash() {
    let (vertex, corners) = ("v 1 \\\n1 \\\n0\n", "f 1 2 \\\n  3 \\\n4\n");
    let text = SQUARE.replace("v 1 1 0\n", vertex) + corners + "f 1 2 3\\\n\n";
    for end in ["\n", "\r\n", "\r"] {
        let soup = soup("lines.obj", text.replace('\n', end));
        assert_eq!(soup.points, POINTS, "{end:?}");
        assert_eq!(polygons(&soup), [vec![0, 1, 2, 3], vec![0, 1, 2]], "{end:?}");
    }
    // Errors name the line where the statement ends.
    let error = refusal("lines.obj", SQUARE.to_owned() + "f 1 \\\n2 \\\n9\n", "vertex 9");
    assert_eq!(error.place, Some(Location::Line(7)));
    refusal("last.obj", SQUARE.to_owned() + "f 1 2 3\nf 1 2 \\", "middle of a face");
}

#[test]
fn lines_of_any_length() {
    let corners = 60_000;
    let long = format!("f{}\n", " 1 2 3".repeat(corners / 3));
    let comment = format!("# {}\n", "x".repeat(100_000));
    let found = faces(&(comment + &long + "f 1 2 3\n"));
    assert_eq!(found.iter().map(Vec::len).collect::<Vec<_>>(), [corners, 3]);
}

#[test]
fn colours_and_weights_are_left_out() {
    for rest in
        ["1", "0.1", "0", "-2", "nan", "1 0 0", "255 0 0 255", "nan nan nan", "#ff0000", "x"]
    {
        let text = SQUARE.replace(" 0\n", &format!(" 0 {rest}\r\n")) + "f 1 2 3 4\r\n";
        assert_eq!(soup("colour.obj", text).points, POINTS, "{rest}");
    }
}

#[test]
fn objects_and_groups_split_nothing() {
    let text = "g a\r\nv 0 0 0\r\nv 1 0 0\r\nf 1 2 3\r\no b\r\nusemtl x\r\nv 1 1 0\r\ng\r\ng c d\r\n\
                vn 0 0 1\r\nv 0 1 0\r\nusemtl x\r\nusemtl\r\nf 1//1 3//1 4//1\r\ns off\r\n";
    let soup = soup("groups.obj", text);
    assert_eq!(soup.points, POINTS);
    assert_eq!(polygons(&soup), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn ends_of_every_kind() {
    for end in ["", "\n", "\r\n", "\n\n\n", " ", "\n\x1a", "\n\0\0", "\n# end"] {
        assert_eq!(faces(&format!("f 1 2 3 4{end}")), [[0, 1, 2, 3]], "{end:?}");
    }
    let marked = format!("\u{feff}{}", SQUARE.replace('\n', "\r\n") + "f 1 2 3 4");
    assert_eq!(soup("mark.obj", marked).points, POINTS);
    let mixed = SQUARE.replacen('\n', "\r\n", 2) + "f 1 2 3\r\nf 1 3 4\n";
    for text in [mixed.clone(), "# head\n".to_owned() + &mixed, "# head\r\n".to_owned() + &mixed] {
        assert_eq!(soup("mixed.obj", text).points, POINTS);
    }
    for cut in ["v 1", "v 1 2", "v 1 2 -"] {
        let error = refusal("cut.obj", format!("{SQUARE}f 1 2 3\n{cut}"), "vertex");
        assert_eq!(error.place, Some(Location::Line(6)), "{cut}");
    }
}

#[test]
fn lines_go_on_after_a_backslash_and_blanks() {
    for blanks in [" ", "\t", " \t  ", "\r"] {
        let text = format!("f 1 2 \\{blanks}\n3 \\{blanks}\n4\n");
        assert_eq!(faces(&text), [[0, 1, 2, 3]], "{blanks:?}");
    }
}

/// A comment ends with its line, and so do names and paths.
#[test]
fn only_vertices_and_faces_go_on() {
    let vertex = "v 1 1 0\n";
    for line in [
        "# C:\\scans\\",
        "#\\",
        "mtllib C:\\scans\\",
        "usemtl a\\ ",
        "g a \\",
        "o \\",
        "\\",
        "vn 0 0 1 \\",
    ] {
        let text = SQUARE.replace(vertex, &format!("{line}\n{vertex}")) + "f 1 2 3 4\n";
        let soup = soup("names.obj", text);
        assert_eq!(soup.points, POINTS, "{line}");
        assert_eq!(polygons(&soup), [[0, 1, 2, 3]], "{line}");
    }
    assert_eq!(faces("f 1 2 3 # last \\\nf 1 3 4\n"), [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(faces("f 1 2 \\\n3 # last \\\nf 1 3 4\n"), [[0, 1, 2], [0, 2, 3]]);
    // The continuation of other statements is ignored.
    assert_eq!(faces("l 1 2 \\\n3 4\nf 1 2 3\n"), [[0, 1, 2]]);
}

/// A file that is joined from several files may have different line ends.
#[test]
fn line_ends_may_change() {
    let text = SQUARE.to_owned() + "f 1 2 3\nf 1 3 4\n";
    let lines: Vec<&str> = text.lines().collect();
    for ends in [["\n", "\r"], ["\r", "\n"], ["\r", "\r\n"], ["\r\n", "\r"], ["\n", "\r\r\n"]] {
        for change in 0..lines.len() {
            let end = |i| ends[usize::from(i >= change)];
            let mixed: String =
                lines.iter().enumerate().map(|(i, line)| format!("{line}{}", end(i))).collect();
            let soup = soup("mixed.obj", &mixed);
            assert_eq!(soup.points, POINTS, "{mixed:?}");
            assert_eq!(polygons(&soup), [[0, 1, 2], [0, 2, 3]], "{mixed:?}");
        }
    }
    let error = refusal("line.obj", SQUARE.to_owned() + "f 1 2 3\rf 1 2 x\rf 1 2 4\n", "x");
    assert_eq!(error.place, Some(Location::Line(6)));
    refusal("cut.obj", SQUARE.to_owned() + "f 1 2 3\rf 1 2", "middle of a face");
}
