//! How the command line spells the options that messages of the library name.

/// The names of options in the library, which stand in backticks in its messages, and those
/// on the command line.
const OPTIONS: [(&str, &str); 27] = [
    ("shape", "--shape"),
    ("unit", "--units"),
    ("component", "--component"),
    ("within", "--box"),
    ("above", "--above"),
    ("outer", "--outer"),
    ("scan", "--scan"),
    ("spacing", "--spacing"),
    ("max_points", "--max-points"),
    ("remesh", "--remesh"),
    ("smooth", "--smooth"),
    ("boundary_corners", "--boundary-corners"),
    ("corners", "--corners"),
    ("outline", "--outline"),
    ("map", "--map"),
    ("kappa", "--kappa"),
    ("depth", "--depth"),
    ("net", "--net"),
    ("max_net", "--max-net"),
    ("faces", "--faces"),
    ("fit", "--fit"),
    ("tolerance", "--tolerance"),
    ("outliers", "--outliers"),
    ("handles", "--handles"),
    ("rim_tolerance", "--rim-tolerance"),
    ("cut", "--keep-fills, --fill-only-holes-below"),
    ("threads", "--threads"),
];

/// The same message with the names of the command line: `` `max_net` `` becomes `--max-net`.
pub(crate) fn spelled(message: &str) -> String {
    let option =
        |text: String, (name, spelled): &(&str, &str)| text.replace(&format!("`{name}`"), spelled);
    OPTIONS.iter().fold(message.to_owned(), option)
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;
    use scan2step::error::CloudFault;
    use scan2step::geometry::Bound;
    use scan2step::rules::Fault;
    use scan2step::{Error, Options};

    use super::super::args::Cli;
    use super::*;

    #[test]
    fn the_command_line_has_these_options() {
        let mut command = Cli::command();
        let convert = command.find_subcommand_mut("convert").unwrap();
        let known: Vec<String> =
            convert.get_arguments().filter_map(|a| Some(format!("--{}", a.get_long()?))).collect();
        for option in OPTIONS.iter().flat_map(|(_, spelled)| spelled.split(", ")) {
            assert!(known.iter().any(|known| known == option), "{option}");
        }
    }

    #[test]
    fn every_option_that_help_names_is_spelled() {
        let point = scan2step::geometry::Point::origin();
        let hole = Error::Trim { of: Bound::Hole(0), fault: String::new(), at: point };
        let net = Error::Option { option: "net", fault: Fault::LargeNet { net: [9; 2], most: 16 } };
        let fault = Fault::LargeLayout { faces: 9, least: 99, most: 16 };
        let layout = Error::Option { option: "max_net", fault };
        for (error, option) in [
            (Error::Component { asked: 3, count: 2 }, "--component"),
            (Error::NotOrientable, "--component"),
            (Error::Cloud(CloudFault::Scan { asked: 3, count: 2 }), "--scan"),
            (Error::Cloud(CloudFault::NoTriangle), "--spacing"),
            (Error::NotADisk { genus: 1, loops: 1 }, "--shape"),
            (Error::Corners(String::new()), "--corners"),
            (Error::TooSmall(3), "--outline"),
            (Error::Support { h: 1.0, shortest: 0.1, longest: 9.0 }, "--smooth"),
            (Error::Memory("fit"), "--max-net"),
            (Error::Threads(String::new()), "--threads"),
            (Error::Trim { of: Bound::Outer, fault: String::new(), at: point }, "--outline"),
            (hole, "--keep-fills"),
            (net, "--max-net"),
            (layout, "--faces"),
            (Options::builder().rim_tolerance(-1.0).build().unwrap_err(), "--rim-tolerance"),
        ] {
            let (help, spelled) = (error.help(), spelled(&error.help()));
            assert!(!help.contains("--"), "{help}");
            assert!(spelled.contains(option) && !spelled.contains('`'), "{spelled}");
        }
    }
}
