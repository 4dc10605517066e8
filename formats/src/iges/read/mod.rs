//! Reader of IGES files.
//!
//! The input is the content of a file. The output is its trimmed surfaces and the faces of its
//! shells.

mod deck;
mod elementary;
mod faces;
mod geometry;
mod parameters;
mod polynomial;
mod ruled;
mod shape;
mod subfigures;

use std::path::Path;

use crate::Result;
use crate::cad::affine::Affine;
use crate::cad::{CadFace, CadModel, CadSolid};
use deck::Deck;
pub(crate) use deck::is_iges;
use faces::FaceReader;
use subfigures::Subfigures;

/// Reads every visible face in `bytes`, which is the content of the file at `path`.
pub(crate) fn read(path: &Path, bytes: &[u8]) -> Result<CadModel> {
    let deck = Deck::new(path, bytes)?;
    let (sender, unit_mm) = global(&deck)?;
    let unit = Affine::scaling(unit_mm);
    let subfigures = Subfigures::read(&deck, unit_mm)?;
    // The first name of an assembly is that of a part.
    let own = if subfigures.are_there() && !sender.is_empty() { None } else { name(&deck)? };
    let mut model = CadModel { name: own.unwrap_or(sender), ..CadModel::default() };
    let mut faces = FaceReader::new(&deck);
    let entries = || (1..).step_by(2).zip(&deck.directory).filter(|(_, e)| e.visible);
    let mut in_solids = Vec::new();
    for (pointer, entry) in entries() {
        match entry.kind {
            143 | 144 => {
                let places = subfigures.places(pointer);
                if !places.is_empty() {
                    let face = match entry.kind {
                        143 => faces.bounded(pointer, &unit)?,
                        _ => faces.trimmed(pointer, &unit)?,
                    };
                    model.faces.push(CadFace { places, ..face });
                }
            }
            186 => in_solids.extend(faces.shells(pointer)?),
            _ => {}
        }
    }
    for (pointer, entry) in entries() {
        let before = [model.faces.len(), model.shells.len(), model.solids.len()];
        match entry.kind {
            // The matrix of a solid places its shells.
            514 if !in_solids.contains(&pointer) => {
                faces.shell(pointer, &unit, &mut model)?;
            }
            186 => {
                let place = faces.place(pointer, &unit)?;
                let mut shells = Vec::new();
                for shell in faces.shells(pointer)? {
                    shells.push(faces.shell(shell, &place, &mut model)?);
                }
                model.solids.push(CadSolid { outer: shells[0], voids: shells.split_off(1) });
            }
            114 | 118 | 120 | 122 | 128 | 140 if entry.independent || subfigures.has(pointer) => {
                model.faces.push(faces.whole(pointer, &unit)?);
            }
            _ => {}
        }
        let [first, shells, solids] = before;
        if first < model.faces.len() {
            let places = subfigures.places(pointer);
            if places.is_empty() {
                // No instance shows it.
                model.faces.truncate(first);
                model.shells.truncate(shells);
                model.solids.truncate(solids);
            }
            model.faces[first..].iter_mut().for_each(|face| face.places = places.clone());
        }
    }
    // Some programs write faces that belong to no shell.
    for (pointer, _) in entries().filter(|(_, entry)| entry.kind == 510) {
        if !faces.is_read(pointer) {
            model.faces.push(faces.face(pointer, &unit)?);
        }
    }
    Ok(model)
}

/// The first name property (406 form 15).
fn name(deck: &Deck) -> Result<Option<String>> {
    let mut entries = (1..).step_by(2).zip(&deck.directory);
    let Some((pointer, _)) = entries.find(|(_, e)| (e.kind, e.form) == (406, 15)) else {
        return Ok(None);
    };
    let mut p = deck.parameters(pointer)?;
    p.skip(1);
    Ok(Some(p.string()))
}

/// The sender's name of the product, and the unit of length in mm.
fn global(deck: &Deck) -> Result<(String, f64)> {
    let mut p = deck.global()?;
    let name = p.string();
    p.skip(9);
    let scale = p.real()?;
    let flag = p.integer()?;
    let named = p.string().to_ascii_uppercase();
    let known = UNITS.iter().find(|(number, name, _)| match flag {
        3 => *name == named,
        0 => *number == 1, // inches, if nothing is said
        flag => *number == flag,
    });
    let Some((.., mm)) = known else {
        return Err(deck.error(0, format!("is in an unknown unit: {flag} {named}")));
    };
    // Lengths in the file are `scale` times the real lengths.
    Ok((name, if scale > 0.0 { mm / scale } else { *mm }))
}

/// The units: number, name and length in mm (IGES 5.3, clause 2.2.4.3.14).
const UNITS: [(i64, &str, f64); 10] = [
    (1, "IN", 25.4),
    (1, "INCH", 25.4),
    (2, "MM", 1.0),
    (4, "FT", 304.8),
    (5, "MI", 1_609_344.0),
    (6, "M", 1000.0),
    (7, "KM", 1e6),
    (8, "MIL", 0.0254),
    (9, "UM", 1e-3),
    (10, "CM", 10.0),
];
