//! Files in the styles of other programs: the same faces in other notations.

use formats::cad::{CadSurface, CurveShape};
use formats::iges::Form;

use crate::{check_same, files, iges_file, model, read, step_file};

/// A file of ours with numbers of entities that are far apart and descending, other line breaks in
/// lists, and comments.
fn scattered(step: &str) -> String {
    let (head, rest) = step.split_once("DATA;\n").unwrap();
    let (data, tail) = rest.split_once("ENDSEC;").unwrap();
    let moved = |text: &str| {
        let mut parts = text.split('#');
        let mut out = parts.next().unwrap().to_owned();
        for part in parts {
            let digits = part.chars().take_while(char::is_ascii_digit).count();
            let number: u64 = part[..digits].parse().unwrap();
            out += &format!("#{}{}", 1_000_000 - 7 * number, &part[digits..]);
        }
        out
    };
    let statements: Vec<String> = data.split_terminator(";\n").map(moved).collect();
    let data = statements.join(" ; /* '; #1 */\r\n\t").replace(',', " ,\n ").replace('=', " = ");
    format!("{head}DATA;\n{data};\nENDSEC;{tail}")
}

#[test]
fn numbers_and_blanks_may_be_otherwise() {
    let brep = model::two_faces("pair");
    check_same(&brep, &read(&scattered(&step_file(&brep))).unwrap());
}

#[test]
fn lines_may_end_otherwise() {
    let brep = model::one_face("part");
    for file in files(&brep) {
        check_same(&brep, &read(&file.replace('\n', "\r\n")).unwrap());
        check_same(&brep, &read(&file.replace('\n', "\r")).unwrap());
    }
}

#[test]
fn lengths_come_in_millimetres() {
    let brep = model::one_face("part");
    let pole = |file: &str| {
        let model = read(file).unwrap();
        let CadSurface::Spline(surface) = &*model.faces[0].surface else { panic!() };
        surface.poles()[surface.poles().len() - 1]
    };
    let [step, trimmed, shell] = files(&brep);
    let mm = pole(&step);
    let near = |found: [f64; 3], factor: f64| {
        let off = (0..3).map(|i| (found[i] - factor * mm[i]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9 * factor, "{found:?} is not {factor} times {mm:?}");
    };
    let si = "(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))";
    near(pole(&step.replace(".MILLI.,", "$,")), 1000.0);
    near(pole(&step.replace(".MILLI.", ".CENTI.")), 10.0);
    let inch = "(CONVERSION_BASED_UNIT('INCH',#900002)LENGTH_UNIT()NAMED_UNIT(#900001));\n\
        #900001=DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);\n\
        #900002=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#900003);\n\
        #900003=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))";
    near(pole(&step.replace(si, inch)), 25.4);
    for iges in [trimmed, shell] {
        near(pole(&iges.replace(",2,2HMM,", ",1,2HIN,")), 25.4);
        near(pole(&iges.replace(",2,2HMM,", ",6,1HM,,")), 1000.0);
    }
}

#[test]
fn a_weighted_surface_is_read() {
    let brep = model::one_face("part");
    let step = step_file(&brep);
    let start = step.find("B_SPLINE_SURFACE_WITH_KNOTS(").unwrap();
    let end = start + step[start..].find(";\n").unwrap();
    let body = step[start..end].replace('\n', "");
    let body = body.strip_prefix("B_SPLINE_SURFACE_WITH_KNOTS('',").unwrap();
    let (base, rest) = body.split_once(".F.,.F.,.F.,").unwrap();
    let row = format!("({})", (0..8).map(|j| format!("{}.", 1 + j)).collect::<Vec<_>>().join(","));
    let weights = vec![row; 8].join(",");
    let complex = format!(
        "(BOUNDED_SURFACE()\nB_SPLINE_SURFACE({base}.F.,.F.,.F.)\nB_SPLINE_SURFACE_WITH_KNOTS({rest}\n\
         GEOMETRIC_REPRESENTATION_ITEM()\nRATIONAL_B_SPLINE_SURFACE(({weights}))\n\
         REPRESENTATION_ITEM('')SURFACE())"
    );
    let model = read(&format!("{}{complex}{}", &step[..start], &step[end..])).unwrap();
    let CadSurface::Spline(surface) = &*model.faces[0].surface else { panic!() };
    let weights = surface.weights().unwrap();
    assert_eq!(weights.len(), 64);
    assert_eq!(weights[8..16], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
}

#[test]
fn edges_may_be_without_pcurves() {
    let step = step_file(&model::one_face("part"));
    // SURFACE_CURVE('',#1,(#2),.PCURVE_S1.) becomes the curve alone.
    let mut plain = String::new();
    let mut curves = Vec::new();
    for statement in step.split_inclusive(";\n") {
        if let Some((id, rest)) = statement.split_once("=SURFACE_CURVE('',") {
            curves.push((id.to_owned(), rest.split_once(',').unwrap().0.to_owned()));
        } else {
            plain += statement;
        }
    }
    for (surface_curve, curve) in &curves {
        plain = plain.replace(&format!("{surface_curve},.T.)"), &format!("{curve},.T.)"));
    }
    let model = read(&plain).unwrap();
    assert_eq!(curves.len(), 8);
    let edges: Vec<_> = model.faces[0].loops.iter().flatten().collect();
    assert!(edges.iter().all(|e| e.pcurves.is_empty() && e.curve.is_some() && e.ends.is_some()));
}

#[test]
fn iges_may_choose_its_delimiters() {
    let brep = model::one_face("a, b; c");
    for form in [Form::Trimmed, Form::Brep] {
        let file = iges_file(&brep, form);
        let changed: String = file.lines().map(|line| format!("{}\n", redelimited(line))).collect();
        let model = read(&changed).unwrap();
        assert_eq!(model.name, "a, b; c");
        check_same(&brep, &model);
    }
}

/// A line with `#` and `!` instead of comma and semicolon outside of strings.
fn redelimited(line: &str) -> String {
    let section = line.as_bytes()[72];
    if !matches!(section, b'G' | b'P') {
        return line.into();
    }
    let (data, rest) = line.split_at(if section == b'G' { 72 } else { 64 });
    let kept = data.replace("7Ha, b; c", "7Ha@ b% c").replace("1H,,1H;,", "1H##1H!#");
    format!("{}{rest}", kept.replace(',', "#").replace(';', "!"))
        .replace('@', ",")
        .replace('%', ";")
}

#[test]
fn matrices_put_what_they_belong_to() {
    let brep = model::one_face("part");
    let file = iges_file(&brep, Form::Brep);
    let count = file.lines().filter(|l| l.as_bytes()[72] == b'D').count();
    let lines = file.lines().filter(|l| l.as_bytes()[72] == b'P').count();
    // A quarter turn about z and a translation of the shell.
    let pointer = count + 1;
    let directory = format!(
        "{:8}{:8}{:8}{:8}{:8}{:8}{:8}{:8}00010000D{pointer:7}\n{:8}{:8}{:8}{:8}{:8}{:32}D{:7}\n",
        124,
        lines + 1,
        0,
        0,
        0,
        0,
        0,
        0,
        124,
        0,
        0,
        1,
        0,
        "",
        pointer + 1
    );
    let parameters = format!(
        "{:64}{pointer:8}P{:7}\n",
        "124,0.,-1.,0.,10.,1.,0.,0.,20.,0.,0.,1.,30.;",
        lines + 1
    );
    let (mut moved, mut seen) = (String::new(), String::new());
    for line in file.lines() {
        let (kind, section) = (line[..8].trim(), &line[72..73]);
        if section == "P" && !seen.contains('P') {
            moved += &directory;
        } else if section == "T" {
            moved += &parameters;
        }
        if kind == "514" && section == "D" && !seen.contains("514") {
            moved += &format!("{}{pointer:8}{}\n", &line[..48], &line[56..]);
        } else {
            moved += &format!("{line}\n");
        }
        seen += if section == "D" { kind } else { section };
        seen += " ";
    }
    let (here, there) = (read(&file).unwrap(), read(&moved).unwrap());
    let (CadSurface::Spline(here), CadSurface::Spline(there)) =
        (&*here.faces[0].surface, &*there.faces[0].surface)
    else {
        panic!()
    };
    for (p, q) in here.poles().iter().zip(there.poles()) {
        assert_eq!([10.0 - p[1], 20.0 + p[0], 30.0 + p[2]], *q);
    }
}

#[test]
fn lines_and_circles_are_read() {
    let step = "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n\
        #1=CARTESIAN_POINT('',(0.,0.,0.));\n#2=DIRECTION('',(0.,0.,2.));\n\
        #3=AXIS2_PLACEMENT_3D('',#1,#2,$);\n#4=PLANE('',#3);\n\
        #5=CARTESIAN_POINT('',(2.,0.,0.));\n#6=VERTEX_POINT('',#5);\n\
        #7=CIRCLE('',#3,2.);\n#8=EDGE_CURVE('',#6,#6,#7,.T.);\n\
        #9=ORIENTED_EDGE('',*,*,#8,.F.);\n#10=EDGE_LOOP('',(#9));\n\
        #11=FACE_BOUND('',#10,.F.);\n#12=ADVANCED_FACE('',(#11),#4,.T.);\n\
        #13=OPEN_SHELL('',(#12));\n#14=SHELL_BASED_SURFACE_MODEL('',(#13));\n\
        #15=(GEOMETRIC_REPRESENTATION_CONTEXT(3)REPRESENTATION_CONTEXT('',''));\n\
        #16=SHAPE_REPRESENTATION('',(#14,#3),#15);\nENDSEC;\nEND-ISO-10303-21;\n";
    let model = read(step).unwrap();
    let CadSurface::Plane { origin, x, y } = *model.faces[0].surface else { panic!() };
    assert_eq!((origin, x, y), ([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]));
    let edge = &model.faces[0].loops[0][0];
    // The loop runs against the edge, and the bound runs against its loop.
    assert!(edge.forward);
    let CurveShape::Ellipse { centre, x, y } = edge.curve.as_ref().unwrap().shape else { panic!() };
    assert_eq!((centre, x, y), ([0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]));
}

#[test]
fn the_angle_on_an_iges_cylinder_is_in_degrees() {
    // A cylinder in the style of OpenCASCADE: one face with a seam.
    let parameters = [
        (514, 1, "514,1,3,1;"),
        (510, 1, "510,5,1,1,13;"),
        (192, 1, "192,7,9,3.,11;"),
        (116, 0, "116,0.,0.,0.,0;"),
        (123, 0, "123,0.,0.,1.;"),
        (123, 0, "123,1.,0.,0.;"),
        (508, 1, "508,1,0,15,1,1,1,0,25;"),
        (504, 1, "504,1,17,19,1,19,1;"),
        (100, 0, "100,0.,0.,0.,3.,0.,3.,0.;"),
        (502, 1, "502,1,3.,0.,0.;"),
        (0, 0, ""),
        (0, 0, ""),
        (110, 0, "110,0.,0.,0.,360.,0.,0.;"),
    ];
    let model = read(&deck(&parameters)).unwrap();
    let CadSurface::Cylinder { x, z, .. } = *model.faces[0].surface else { panic!() };
    assert_eq!((x, z), ([3.0, 0.0, 0.0], [0.0, 0.0, 1.0]));
    let CurveShape::Line { direction, .. } = model.faces[0].loops[0][0].pcurves[0].shape else {
        panic!()
    };
    assert_eq!(direction, [std::f64::consts::TAU, 0.0]);
}

/// The file of some entities: of each its type, its form and its parameters. Those of type 0 are not independent.
fn deck(parameters: &[(i64, i64, &str)]) -> String {
    let mut lines = vec![format!("{:72}S      1", "")];
    lines.push(format!(
        "{:72}G      1",
        "1H,,1H;,,,,,32,38,6,308,15,,1.,2,2HMM,1,0.1,,1E-7,9.,,,11,0;"
    ));
    let (mut data, mut first) = (Vec::new(), 1);
    for (i, (kind, form, text)) in parameters.iter().enumerate() {
        let n = 2 * i + 1;
        lines.push(format!("{kind:8}{first:8}{:48}00010000D{n:7}", ""));
        let part = text.as_bytes().chunks(64).map(|part| String::from_utf8_lossy(part));
        let part: Vec<_> = part.collect();
        let count = part.len().max(1);
        lines.push(format!("{kind:8}{:16}{count:8}{form:8}{:32}D{:7}", "", "", n + 1));
        for line in part {
            data.push(format!("{line:64}{n:8}P{:7}", data.len() + 1));
        }
        first = data.len() + 1;
    }
    lines.append(&mut data);
    lines.push(format!("{:72}T      1", ""));
    lines.join("\n") + "\n"
}

#[test]
fn cubic_polynomials_are_read() {
    // u + 2 u² over [0, 2], and then from 3 to 10 on a line; the surface has the height (1 + s²) (1 + t³).
    let zeros = "0.,".repeat(16);
    let plane = "0.,1.,0.,0.,".to_owned()
        + &"0.,".repeat(12)
        + "0.,0.,0.,0.,1.,0.,0.,0.,"
        + &"0.,".repeat(8);
    let height = "1.,0.,1.,0.,".to_owned() + &"0.,".repeat(8) + "1.,0.,1.,0.,";
    let surface = format!("114,3,1,1,1,0.,2.,0.,1.,{plane}{height}{}0.;", zeros.repeat(9));
    let curve = "112,3,1,3,2,0.,2.,3.,0.,1.,2.,0.,0.,0.,0.,0.,5.,0.,0.,0.,10.,1.,0.,0.,0.,0.,0.,0.,5.,0.,0.,0.;";
    let line = |x: f64| format!("110,{x:?},0.,5.,{x:?},4.,5.;");
    let (from, to) = (line(0.0), line(11.0));
    let parameters = [
        (143, 0, "143,0,3,1,5;"),
        (114, 0, &*surface),
        (141, 0, "141,0,0,3,4,7,1,0,9,2,0,7,2,0,11,1,0;"),
        (112, 0, curve),
        (110, 0, &from),
        (110, 0, &to),
    ];
    let model = read(&deck(&parameters)).unwrap();
    let CadSurface::Spline(surface) = &*model.faces[0].surface else { panic!() };
    for (u, v) in [(0.0, 0.0), (0.5, 0.25), (2.0, 1.0), (1.5, 0.75)] {
        let expected = [u, v, (1.0 + u * u) * (1.0 + v * v * v)];
        let found = surface.point(u, v);
        assert!((0..3).all(|i| (found[i] - expected[i]).abs() < 1e-12), "{found:?} {expected:?}");
    }
    let edges = &model.faces[0].loops[0];
    assert_eq!(
        edges.iter().map(|edge| edge.forward).collect::<Vec<_>>(),
        [true, false, false, true]
    );
    let CurveShape::Spline(curve) = &edges[0].curve.as_ref().unwrap().shape else { panic!() };
    for (t, x) in [(0.0, 0.0), (1.0, 3.0), (2.0, 10.0), (2.5, 10.5), (3.0, 11.0)] {
        assert!((curve.point(t)[0] - x).abs() < 1e-12);
    }
}

#[test]
fn ruled_surfaces_are_read() {
    let curve = "112,3,1,3,2,0.,2.,4.,0.,1.,0.5,0.,0.,0.,0.,0.,5.,0.,0.,0.,4.,1.,0.,0.,0.,0.,1.,0.,5.,0.,0.,0.;";
    let arc =
        "126,2,2,0,0,0,0,0.,0.,0.,1.,1.,1.,1.,0.7,1.,8.,0.,0.,5.,5.,0.,0.,6.,0.,0.,1.,0.,0.,1.;";
    let parameters = [(118, 1, "118,3,5,1,0;"), (112, 0, curve), (126, 0, arc)];
    let text = deck(&parameters);
    let model = read(&text.replacen("00010000D      1", "00000000D      1", 1)).unwrap();
    let CadSurface::Spline(surface) = &*model.faces[0].surface else { panic!() };
    for t in [0.0, 0.2, 0.5, 0.9, 1.0] {
        let s = 4.0 * t;
        let first = if s <= 2.0 {
            [s + 0.5 * s * s, 0.0, 5.0]
        } else {
            [s + 2.0, (s - 2.0) * (s - 2.0), 5.0]
        };
        // The other curve runs backwards.
        let (a, b, c) = (t * t, 1.4 * t * (1.0 - t), (1.0 - t) * (1.0 - t));
        let w = a + b + c;
        let second = [(8.0 * a + 5.0 * b) / w, (5.0 * b + 6.0 * c) / w, 0.0];
        for v in [0.0, 0.3, 1.0] {
            let found = surface.point(t, v);
            let expected: [f64; 3] = std::array::from_fn(|i| (1.0 - v) * first[i] + v * second[i]);
            assert!(
                (0..3).all(|i| (found[i] - expected[i]).abs() < 1e-12),
                "{found:?} {expected:?}"
            );
        }
    }
    let by_length = deck(&[(118, 0, "118,3,5,1,0;"), parameters[1], parameters[2]]);
    let by_length = read(&by_length.replacen("00010000D      1", "00000000D      1", 1));
    assert!(by_length.unwrap_err().to_string().contains("by the lengths of its curves"));
}
