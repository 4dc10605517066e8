//! Reader of the header. Its size has bounds, and it is checked before other modules use it.

use ply_rs::ply::{ElementDef, Encoding, PropertyDef, PropertyType, ScalarType};

use crate::source::{EXPORT_AGAIN, Source};
use crate::token::excerpt;
use crate::unit_comment::UnitComments;
use crate::{Error, LengthUnit, Result};

/// The largest number of lines of a header. It is far above that of real headers, and it bounds the
/// cost of a hostile one.
const MAX_LINES: u64 = 10_000;
const MAX_LINE: usize = 1 << 16;

/// The content of the header.
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// What its comments say about the unit.
    pub(super) unit: Option<(LengthUnit, String)>,
    /// The numbers of `obj_info` lines such as `num_cols 512`.
    infos: Vec<(String, u64)>,
}

impl Header {
    /// Whether the vertices are those of a compressed Gaussian splat, as SuperSplat writes it.
    pub(super) fn is_packed_splat(&self) -> bool {
        let vertices = self.elements.iter().find(|e| e.name == "vertex");
        vertices.is_some_and(|e| e.property("packed_position").is_some())
    }

    /// Whether the vertices are the centres of Gaussian splats, each with its opacity, axes and turn, as the programs of
    /// Kerbl et al. (2023) write them.
    pub(super) fn has_splats(&self) -> bool {
        let vertices = self.elements.iter().find(|e| e.name == "vertex");
        let names = ["opacity", "scale_0", "rot_0"];
        vertices.is_some_and(|e| names.iter().all(|name| e.property(name).is_some()))
    }

    /// The number of the `obj_info` line called `name`.
    pub(super) fn info(&self, name: &str) -> Option<u64> {
        self.infos.iter().find(|(n, _)| n == name).map(|&(_, number)| number)
    }
}

/// An element that the header declares: a table with named columns.
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<(String, PropertyType)>,
}

impl Element {
    /// The type of the property `name`.
    pub(super) fn property(&self, name: &str) -> Option<&PropertyType> {
        self.properties.iter().find(|(n, _)| n == name).map(|(_, t)| t)
    }

    /// The name of the list of a face's corners.
    pub(super) fn index_list(&self) -> Option<&'static str> {
        let is_list = |name: &&str| matches!(self.property(name), Some(PropertyType::List(..)));
        ["vertex_indices", "vertex_index"].into_iter().find(is_list)
    }

    /// The size in bytes of a binary row, if it has no list.
    pub(super) fn size(&self) -> Option<u64> {
        self.properties
            .iter()
            .map(|(_, kind)| match kind {
                PropertyType::Scalar(s) => Some(bytes(s)),
                PropertyType::List(..) => None,
            })
            .sum()
    }

    /// The definition of the element for ply-rs. In a binary body, unwanted columns are renamed, so
    /// that they are not read. In an ASCII body they are removed, because `ascii` omits them.
    /// There, coordinates are read as doubles for any declared type, because the file has the
    /// digits.
    pub(super) fn definition(&self, code: Encoding, wanted: impl Fn(&str) -> bool) -> ElementDef {
        let ascii = code == Encoding::Ascii;
        let mut def = ElementDef::new(self.name.clone());
        for (i, (name, kind)) in self.properties.iter().enumerate() {
            let keep = wanted(name);
            if ascii && !keep {
                continue;
            }
            let kind = match kind {
                PropertyType::Scalar(_) if ascii => PropertyType::Scalar(ScalarType::Double),
                other => other.clone(),
            };
            let name = if keep { name.clone() } else { i.to_string() };
            def.properties.insert(name.clone(), PropertyDef::new(name, kind));
        }
        def
    }
}

fn bytes(scalar: &ScalarType) -> u64 {
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// Reads up to the end of the line `end_header`, and no further byte.
pub(super) fn read(source: &mut Source) -> Result<Header> {
    let mut encoding = None;
    let mut elements = Vec::new();
    let mut infos = Vec::new();
    let mut comments = UnitComments::default();
    let mut line = Vec::new();
    while next_line(source, &mut line)? {
        // Only comments may contain non-ASCII text, and they are skipped.
        let text = String::from_utf8_lossy(&line);
        let mut words = text.split_ascii_whitespace();
        match words.next() {
            None => {}
            Some("comment") => comments.read(&line),
            Some("obj_info") => {
                comments.read(&line);
                infos.extend(info(words));
            }
            Some("ply") if source.line == 1 => {}
            Some("format") if encoding.is_none() => {
                encoding = Some(format(source, words.next())?);
            }
            Some("element") => elements.push(element(source, words, &elements)?),
            Some("property") => property(source, words, elements.last_mut())?,
            Some("end_header") => {
                let encoding = encoding.ok_or_else(|| bad(source, "no format line"))?;
                return Ok(Header { encoding, elements, unit: comments.unit(), infos });
            }
            Some(_) => {
                let what = format!("the unknown header line \u{201c}{}\u{201d}", excerpt(&line));
                return Err(bad(source, &what));
            }
        }
    }
    Err(bad(source, "no end_header line"))
}

fn info<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<(String, u64)> {
    let name = words.next()?.to_owned();
    Some((name, words.next()?.parse().ok()?))
}

fn next_line(source: &mut Source, line: &mut Vec<u8>) -> Result<bool> {
    let more = source.next_line(line)?;
    if source.line > MAX_LINES || line.len() > MAX_LINE {
        return Err(bad(source, "an endless header"));
    }
    Ok(more)
}

fn bad(source: &Source, what: &str) -> Error {
    source.error(format!("has {what}"), EXPORT_AGAIN)
}

fn format(source: &Source, word: Option<&str>) -> Result<Encoding> {
    match word {
        Some("ascii") => Ok(Encoding::Ascii),
        Some("binary_little_endian") => Ok(Encoding::BinaryLittleEndian),
        Some("binary_big_endian") => Ok(Encoding::BinaryBigEndian),
        _ => Err(bad(source, "an unknown format line")),
    }
}

fn element<'a>(
    source: &Source,
    mut words: impl Iterator<Item = &'a str>,
    before: &[Element],
) -> Result<Element> {
    let name = words.next().unwrap_or_default().to_owned();
    let count = words.next().and_then(|word| word.parse().ok());
    let (Some(count), None) = (count, words.next()) else {
        return Err(bad(source, "an element line without name and count"));
    };
    if before.iter().any(|e| e.name == name) {
        return Err(bad(source, &format!("two elements called {name}")));
    }
    Ok(Element { name, count, properties: Vec::new() })
}

fn property<'a>(
    source: &Source,
    mut words: impl Iterator<Item = &'a str>,
    element: Option<&mut Element>,
) -> Result<()> {
    let Some(element) = element else {
        return Err(bad(source, "a property before the first element"));
    };
    let kind = match words.next() {
        Some("list") => {
            let count = integer(source, words.next())?;
            PropertyType::List(count, scalar(source, words.next())?)
        }
        word => PropertyType::Scalar(scalar(source, word)?),
    };
    let (Some(name), None) = (words.next(), words.next()) else {
        return Err(bad(source, "a property line without a name"));
    };
    if element.property(name).is_some() {
        return Err(bad(source, &format!("two properties called {name}")));
    }
    let corners = matches!(name, "vertex_indices" | "vertex_index");
    if let (true, PropertyType::List(_, ScalarType::Float | ScalarType::Double)) = (corners, &kind)
    {
        return Err(bad(source, "vertex numbers that are not integers"));
    }
    element.properties.push((name.to_owned(), kind));
    Ok(())
}

fn integer(source: &Source, word: Option<&str>) -> Result<ScalarType> {
    match scalar(source, word)? {
        ScalarType::Float | ScalarType::Double => {
            Err(bad(source, "a list whose length is not an integer"))
        }
        integer => Ok(integer),
    }
}

fn scalar(source: &Source, word: Option<&str>) -> Result<ScalarType> {
    match word.unwrap_or_default() {
        "char" | "int8" => Ok(ScalarType::Char),
        "uchar" | "uint8" => Ok(ScalarType::UChar),
        "short" | "int16" => Ok(ScalarType::Short),
        "ushort" | "uint16" => Ok(ScalarType::UShort),
        "int" | "int32" => Ok(ScalarType::Int),
        "uint" | "uint32" => Ok(ScalarType::UInt),
        "float" | "float32" => Ok(ScalarType::Float),
        "double" | "float64" => Ok(ScalarType::Double),
        other => {
            let what =
                format!("a property of unknown type \u{201c}{}\u{201d}", excerpt(other.as_bytes()));
            Err(bad(source, &what))
        }
    }
}
