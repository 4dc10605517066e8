//! OBJ: supported features and errors.

use formats::Location;

use crate::support::{polygons, refusal, soup};

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn square(faces: &str) -> String {
    SQUARE.to_owned() + faces
}

#[test]
fn points_stay_in_the_order_of_the_file() {
    let points: String = (0..1000).map(|i| format!("v {i} 0.5 -{i}\n")).collect();
    let soup = soup("order.obj", points + "f 700 3 9\nf 4 1000 700 2 1\n");
    assert_eq!(soup.points.len(), 1000);
    for (i, point) in soup.points.iter().enumerate() {
        assert_eq!(*point, [i as f64, 0.5, -(i as f64)]);
    }
    assert_eq!(polygons(&soup), [vec![699, 2, 8], vec![3, 999, 699, 1, 0]]);
    assert_eq!(soup.unit, None);
}

#[test]
fn polygons_of_any_size_survive() {
    let ring: String = (1..=300).map(|i| format!(" {i}")).collect();
    let points: String = (0..300).map(|i| format!("v {i} 0 0\n")).collect();
    for count in [3, 4, 5, 255, 256, 257, 258, 300] {
        let text: String = points.lines().take(count).map(|l| format!("{l}\n")).collect();
        let face: String = ring.split(' ').skip(1).take(count).map(|i| format!(" {i}")).collect();
        let soup = soup("ring.obj", format!("{text}f{face}\n"));
        assert_eq!(polygons(&soup), [(0..count as u32).collect::<Vec<_>>()]);
    }
}

#[test]
fn negative_numbers_count_back() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 1 0\nf -4//1 -2//2 -1/5/-9\n";
    assert_eq!(polygons(&soup("back.obj", text)), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn faces_may_come_before_their_vertices() {
    let text = "f 1 2 3\n".to_owned() + SQUARE;
    assert_eq!(polygons(&soup("before.obj", text)), [[0, 1, 2]]);
}

#[test]
fn groups_and_materials_split_nothing() {
    let text = "mtllib no such file.mtl\no a\ng a b\nusemtl red\nv 0 0 0\nv 1 0 0\nv 1 1 0\n\
                vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\ng\no b\nusemtl\ns 1\nv 0 1 0\n\
                f 1/999/999 3 4\nl 1 2\np 1\n";
    let soup = soup("groups.obj", text);
    assert_eq!(soup.points.len(), 4);
    assert_eq!(polygons(&soup), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn weights_and_colours_are_left_out() {
    let text = "v 0 0 0 0\nv 1 0 0 2.0\nv 1 1 0 1 0 0\nv 0 1 0 1 nan 0 1\nf 1 2 3 4\n";
    let expected = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
    assert_eq!(soup("weights.obj", text).points, expected);
}

#[test]
fn loose_text_is_read() {
    let text = "# head\n".to_owned() + &square("f 1 2 3\nf 1 3 4\n");
    let loose = [
        text.replace('\n', "\r\n"),
        text.replace('\n', "\r"),
        text.trim_end().to_owned(),
        "\u{feff}".to_owned() + &square("f 1 2 3\nf 1 3 4"),
        text.replace("v ", "  v\t ").replace("f ", "\tf  "),
        text.replace("f 1 2 3", "f 1 \\\n 2 \\\r\n3"),
        text.replace("1 1 0", "1. 1.0e0 .0 # a corner"),
    ];
    for (i, text) in loose.into_iter().enumerate() {
        let soup = soup("loose.obj", &text);
        assert_eq!(soup.points[2], [1., 1., 0.], "{i}: {text}");
        assert_eq!(polygons(&soup), [[0, 1, 2], [0, 2, 3]], "{i}");
    }
    let latin = text.replace("# head", "# M~ller\no B~r\nusemtl Gr~n").into_bytes();
    let latin: Vec<u8> = latin.into_iter().map(|b| if b == b'~' { 0xfc } else { b }).collect();
    assert_eq!(soup("latin.obj", latin).points.len(), 4);
}

#[test]
fn points_without_a_number_are_kept() {
    let text = "v nan 0 0\nv 1.#IND 0 0\nv -inf 0 0\nv 1 1 1\nf 1 2 3\n";
    let soup = soup("nan.obj", text);
    assert!(soup.points[..3].iter().all(|p| !p[0].is_finite()));
    assert_eq!(soup.points[3], [1.; 3]);
}

#[test]
fn small_faces_are_left_out_but_not_at_a_cut() {
    let soup = soup("small.obj", square("f 1\nf 1 2\nf\nf 1 2 3\nf 3 4\n"));
    assert_eq!(polygons(&soup), [[0, 1, 2]]);
    let error = refusal("cut.obj", square("f 1 2 3\nf 3 4"), "middle of a face");
    assert_eq!(error.place, Some(Location::Line(6)));
}

#[test]
fn bad_vertex_numbers_are_refused_by_line() {
    for (face, word) in [
        ("f 1 2 5", "vertex 5, but only 4"),
        ("f 1 2 0", "counts from 1"),
        ("f 1 2 -5", "only 4 vertices before"),
        ("f 1 2 9223372036854775807", "only 4"),
        ("f 1 2 9223372036854775808", "unreadable corner"),
        ("f 1 2 -9223372036854775808", "only 4"),
        ("f 1 2 x", "unreadable corner"),
        ("f 1 2 //3", "unreadable corner"),
    ] {
        let error = refusal("range.obj", square(&format!("f 1 2 3\n{face}\nf 2 3 4\n")), word);
        assert_eq!(error.place, Some(Location::Line(6)), "{face}");
    }
}

#[test]
fn bad_vertices_are_refused_by_line() {
    for (vertex, word) in [
        ("v 1 2", "fewer than three"),
        ("v", "fewer than three"),
        ("v 1 2 three", "unreadable vertex"),
        ("v 3.1+e2 0 0", "unreadable vertex"),
        ("v . 0 0", "unreadable vertex"),
    ] {
        let error = refusal("bad.obj", square(&format!("{vertex}\nf 1 2 3\n")), word);
        assert_eq!(error.place, Some(Location::Line(5)), "{vertex}");
    }
    let comma = refusal("comma.obj", square("v 1,5 0,5 2,0\n"), "unreadable vertex");
    assert!(comma.help.contains("decimal points"));
}

/// Vertices for more than one batch that tobj receives.
fn many() -> String {
    (0..10_000).map(|i| format!("v {i} 0 .5\n")).collect()
}

#[test]
fn many_vertices_keep_order_and_lines() {
    let read = soup("many.obj", "f 9999 2 10000\n".to_owned() + &many() + "f -1 -10000 -2\n");
    assert!(read.points.iter().enumerate().all(|(i, p)| *p == [i as f64, 0.0, 0.5]));
    assert_eq!(read.points.len(), 10_000);
    assert_eq!(polygons(&read), [[9998, 1, 9999], [9999, 0, 9998]]);
    for bad in [1, 4096, 4097, 8192, 9000, 10_000] {
        let many = many();
        let mut lines: Vec<&str> = many.lines().collect();
        lines[bad - 1] = "v 1 2 -";
        let error = refusal("many.obj", lines.join("\n"), "\u{201c}v 1 2 -\u{201d}");
        assert_eq!(error.place, Some(Location::Line(bad as u64)));
    }
}

#[test]
fn the_first_of_two_errors_is_told() {
    for second in ["f 1 2 x", "f 1 2 0", "v 1 2", "v 1 2 4-", "f 1 2"] {
        let text = square(&format!("\nv 1 2 3-\nf 1 2 3\n{second}"));
        let error = refusal("two.obj", text, "v 1 2 3-");
        assert_eq!(error.place, Some(Location::Line(6)), "{second}");
    }
    let error = refusal("two.obj", square("f 1 2 9\nf 1 2 x\n"), "corner \u{201c}x");
    assert_eq!(error.place, Some(Location::Line(6)));
}

#[test]
fn only_ascii_white_space_parts_numbers() {
    for space in ['\u{b}', '\u{85}', '\u{a0}', '\u{2003}'] {
        let text = square(&format!("v 1{space}2 3 4\nf 1 2 3\n"));
        let error = refusal("space.obj", text, "unreadable vertex");
        assert_eq!(error.place, Some(Location::Line(5)), "{space:?}");
        let text = square(&format!("v 1 {space}2 3{space} 4\nf 1 2 3\n"));
        assert_eq!(soup("space.obj", text).points[4], [1., 2., 3.], "{space:?}");
    }
}

#[test]
fn numbers_may_have_any_length() {
    let digits = "0".repeat(3 << 20);
    let text = format!("v 1 2 3\nv 1.{digits} {digits}2 3\nv 1 2 3.{digits}1\nf 1 2 3\n");
    assert_eq!(soup("long.obj", text).points, [[1., 2., 3.]; 3]);
    let error = refusal("long.obj", format!("v 1 2 3\nv 1 {digits}x 3\n"), "\u{201c}v 1 000");
    assert_eq!(error.place, Some(Location::Line(2)));
}
