//! The unit of length that a comment names, as programs write it into formats without one:
//! "# This file uses centimeters as units for non-parametric coordinates." (Maya),
//! "# File units = inches" (SketchUp), "UNITS=mm" (Materialise).

use crate::token::excerpt;
use crate::{LengthUnit, Soup};

/// Comments longer than this, in bytes, are no sentences about units.
const LONGEST: usize = 400;

/// So many words at most lie between "units" and the name of a unit, as in "units of length are in mm".
const APART: usize = 5;

/// Words that may stand there.
const BETWEEN: [&str; 29] = [
    "is",
    "are",
    "in",
    "of",
    "for",
    "the",
    "this",
    "as",
    "to",
    "set",
    "file",
    "files",
    "model",
    "mesh",
    "length",
    "lengths",
    "linear",
    "measure",
    "measurement",
    "coordinates",
    "all",
    "name",
    "type",
    "system",
    "1",
    "ist",
    "est",
    "en",
    "es",
];

/// Words that announce the unit of what they name, if "in" or a colon follows: "all coordinates in mm".
const MEASURED: [&str; 10] = [
    "coordinates",
    "dimensions",
    "lengths",
    "measurements",
    "positions",
    "vertices",
    "distances",
    "points",
    "values",
    "measured",
];

/// Words that announce a unit, in English, German, French, Italian and Spanish.
const ANNOUNCING: [&str; 16] = [
    "unit",
    "units",
    "lengthunit",
    "lengthunits",
    "unitname",
    "fileunits",
    "einheit",
    "einheiten",
    "längeneinheit",
    "maßeinheit",
    "unité",
    "unités",
    "unità",
    "unidad",
    "unidades",
    "unitsystem",
];

/// What the comments of a file say about its unit.
#[derive(Default)]
pub(crate) struct UnitComments {
    found: Option<(LengthUnit, String)>,
    /// Whether two comments name different units.
    are_at_odds: bool,
}

impl UnitComments {
    /// Looks at one comment.
    pub(crate) fn read(&mut self, comment: &[u8]) {
        let Some(unit) = named(comment) else { return };
        match &self.found {
            Some((before, _)) => self.are_at_odds |= *before != unit,
            None => self.found = Some((unit, excerpt(comment))),
        }
    }

    /// Gives the unit to a mesh whose format has none.
    pub(crate) fn give(self, soup: &mut Soup) {
        if let Some((unit, comment)) = self.unit()
            && soup.unit.is_none()
        {
            soup.unit = Some(unit);
            soup.unit_comment = Some(comment);
        }
    }

    /// The unit, and the comment that names it.
    pub(crate) fn unit(self) -> Option<(LengthUnit, String)> {
        self.found.filter(|_| !self.are_at_odds)
    }
}

/// The unit of length that a comment names.
fn named(comment: &[u8]) -> Option<LengthUnit> {
    if comment.len() > LONGEST {
        return None;
    }
    let text = String::from_utf8_lossy(comment).to_lowercase();
    let is_letter = |c: char| c.is_alphanumeric() || c == '\u{b5}';
    let words: Vec<&str> = text.split(|c| !is_letter(c)).filter(|word| !word.is_empty()).collect();
    words.iter().enumerate().find_map(|(at, word)| {
        if ANNOUNCING.contains(word) {
            return after(&words[at + 1..]).or_else(|| before(&words[..at]));
        }
        let is_measured = MEASURED.contains(word) && words.get(at + 1) == Some(&"in");
        is_measured.then(|| after(&words[at + 1..])).flatten()
    })
}

/// The unit in the words after "units". "in" is one only if no other follows.
fn after(words: &[&str]) -> Option<LengthUnit> {
    for (at, word) in words.iter().take(APART).enumerate() {
        if let Some(unit) = unit(word, &words[..at]).filter(|_| *word != "in") {
            return Some(survey(unit, &words[..at]));
        }
        if *word == "in" && at + 1 == words.len() {
            return Some(LengthUnit::Inch);
        }
        let is_between = BETWEEN.contains(word) || is_one(&words[..=at]);
        if !is_between && !matches!(*word, "us" | "survey" | "international") {
            return None;
        }
    }
    None
}

/// The unit in the words before "units": "centimeters as units", "mm units".
fn before(words: &[&str]) -> Option<LengthUnit> {
    let words = words.strip_suffix(&["as"]).unwrap_or(words);
    let (last, words) = words.split_last()?;
    unit(last, words).filter(|_| *last != "in").map(|unit| survey(unit, words))
}

/// The foot of surveyors, if the word before says so.
fn survey(unit: LengthUnit, before: &[&str]) -> LengthUnit {
    match unit {
        LengthUnit::Foot if before.last() == Some(&"survey") => LengthUnit::UsSurveyFoot,
        unit => unit,
    }
}

fn is_number(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_digit())
}

/// Whether the last words are the number 1, perhaps with zeros after its point.
fn is_one(words: &[&str]) -> bool {
    let start = words.iter().rposition(|word| !is_number(word)).map_or(0, |at| at + 1);
    match &words[start..] {
        ["1"] => true,
        ["1", zeros] => zeros.bytes().all(|byte| byte == b'0'),
        _ => false,
    }
}

/// The unit with this name. A number before it other than 1 makes it another unit.
fn unit(word: &str, before: &[&str]) -> Option<LengthUnit> {
    if before.last().is_some_and(|word| is_number(word)) && !is_one(before) {
        return None;
    }
    Some(match word {
        "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" | "millimètre"
        | "millimètres" | "millimetro" | "millimetri" | "milímetro" | "milímetros" => {
            LengthUnit::Millimetre
        }
        "cm" | "centimeter" | "centimeters" | "centimetre" | "centimetres" | "zentimeter"
        | "centimètre" | "centimètres" | "centimetro" | "centimetri" | "centímetro"
        | "centímetros" => LengthUnit::Centimetre,
        "m" | "meter" | "meters" | "metre" | "metres" | "mètre" | "mètres" | "metro" | "metri"
        | "metros" => LengthUnit::Metre,
        "um" | "\u{b5}m" | "\u{3bc}m" | "micron" | "microns" | "micrometer" | "micrometers"
        | "micrometre" | "micrometres" | "mikrometer" | "micromètre" | "micromètres" => {
            LengthUnit::Micrometre
        }
        "in" | "inch" | "inches" | "zoll" | "pouce" | "pouces" | "pollice" | "pollici"
        | "pulgada" | "pulgadas" => LengthUnit::Inch,
        "ft" | "foot" | "feet" | "fuß" | "fuss" | "pied" | "pieds" | "piede" | "piedi" | "pie"
        | "pies" => LengthUnit::Foot,
        "ftus" => LengthUnit::UsSurveyFoot,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::{UnitComments, named};
    use crate::LengthUnit::{Centimetre, Foot, Inch, Metre, Micrometre, Millimetre, UsSurveyFoot};

    #[test]
    fn units_are_found_in_the_sentences_of_programs() {
        for (comment, unit) in [
            ("# Units: inches", Some(Inch)),
            (
                "# This file uses centimeters as units for non-parametric coordinates.",
                Some(Centimetre),
            ),
            ("# File units = meters", Some(Metre)),
            ("UNITS=mm", Some(Millimetre)),
            ("UNITS=IN", Some(Inch)),
            ("solid part, Unit: Millimeter", Some(Millimetre)),
            ("# units in in", Some(Inch)),
            ("comment units are in mm", Some(Millimetre)),
            ("# Unit of length is \u{b5}m", Some(Micrometre)),
            ("# all coordinates in feet", Some(Foot)),
            ("# Units: US survey feet", Some(UsSurveyFoot)),
            ("# 1 unit = 1 cm", Some(Centimetre)),
            ("# mm units", Some(Millimetre)),
            ("# Rhino 8, unit system: Inches", Some(Inch)),
            ("# Unit: 1 inch", Some(Inch)),
            ("# 1 unit = 1.000 m", Some(Metre)),
            ("# Einheit: Meter", Some(Metre)),
            ("# Die Längeneinheit ist Zoll", Some(Inch)),
            ("# Unités : millimètres", Some(Millimetre)),
            ("# unidades en metros", Some(Metre)),
            // Nothing is said, or nothing that is known.
            ("# 1 unit = 10 mm", None),
            ("# 1 unit = 1.1 m", None),
            ("# 1 unit = 0.1 m", None),
            ("# units per meter: 1000", None),
            ("# Scanned at 5 m distance, 12 in panel", None),
            ("# exported in millimeters, converted from inches", None),
            ("# Genauigkeit: 1 Zoll je Meter", None),
            ("# units: yards", None),
            ("# points in the unit sphere", None),
            ("# exported in m minor", None),
            ("# unit", None),
            ("", None),
        ] {
            assert_eq!(named(comment.as_bytes()), unit, "{comment}");
        }
    }

    #[test]
    fn comments_at_odds_say_nothing() {
        let of = |comments: [&str; 2]| {
            let mut all = UnitComments::default();
            comments.iter().for_each(|comment| all.read(comment.as_bytes()));
            all.unit().map(|(unit, _)| unit)
        };
        assert_eq!(of(["units: mm", "unit = mm"]), Some(Millimetre));
        assert_eq!(of(["units: mm", "units: cm"]), None);
    }
}
