//! The relationships of a part: what belongs to it, and as what.

use super::fault::PackageFault;
use super::package::{Package, folder, resolve};
use super::xml::{self, Namespace, Visitor, XmlElement};
use crate::token::excerpt;

const MODEL: &str = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";
const TICKET: &str = "http://schemas.microsoft.com/3dmanufacturing/2013/01/printticket";
/// Keys and encrypted parts of the secure content extension, in all of its versions.
const SECURE: [&str; 2] = ["/keystore", "/encryptedfile"];

/// The most relationships of a part.
const MOST: usize = 100_000;

/// What a part is for another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    Model,
    PrintTicket,
    /// Keys for encrypted parts.
    Keys,
    Other,
}

pub(super) struct Relationship {
    pub(super) purpose: Purpose,
    /// The name of the part.
    pub(super) target: String,
}

/// The relationships of a part, or of the package if `part` is empty. A part may have none.
pub(super) fn read(package: &mut Package, part: &str) -> Result<Vec<Relationship>, PackageFault> {
    let name = part.rsplit('/').next().unwrap_or_default();
    let of_part = match folder(part) {
        "" => format!("_rels/{name}.rels"),
        folder => format!("{folder}/_rels/{name}.rels"),
    };
    if !package.has(&of_part) {
        return if part.is_empty() { Err(PackageFault::no_model()) } else { Ok(Vec::new()) };
    }
    let mut found = RelationshipReader { folder: folder(part), all: Vec::new() };
    xml::walk(package.part(&of_part)?, &mut found)
        .map_err(|fault| fault.within(&of_part, usize::from(!part.is_empty())))?;
    Ok(found.all)
}

struct RelationshipReader<'a> {
    folder: &'a str,
    all: Vec<Relationship>,
}

impl Visitor for RelationshipReader<'_> {
    fn open(&mut self, element: &XmlElement<'_>) -> Result<bool, PackageFault> {
        if element.namespace != Namespace::Relationships || element.name != "Relationship" {
            return Ok(element.name == "Relationships");
        }
        let target = element.required("Target")?;
        let shown = excerpt(target.as_bytes());
        if element.get("TargetMode")?.is_some_and(|mode| mode.trim() == "External") {
            return Err(PackageFault::new(format!("refers to something outside of it: {shown}")));
        }
        let kind = element.required("Type")?;
        let purpose = match kind.trim() {
            MODEL => Purpose::Model,
            TICKET => Purpose::PrintTicket,
            kind if SECURE.iter().any(|secure| kind.ends_with(secure)) => Purpose::Keys,
            _ => Purpose::Other,
        };
        match resolve(self.folder, target.trim()) {
            Some(target) => self.all.push(Relationship { purpose, target }),
            // A thumbnail or a property that is not there does no harm.
            None if purpose == Purpose::Other => {}
            None => {
                return Err(PackageFault::new(format!(
                    "refers to a part that is outside of it: {shown}"
                )));
            }
        }
        if self.all.len() > MOST {
            return Err(PackageFault::new("has more than 100,000 relationships"));
        }
        Ok(false)
    }

    fn close(&mut self, _: &str) -> Result<(), PackageFault> {
        Ok(())
    }
}
