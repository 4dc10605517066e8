//! Reader of a part with objects.

use std::collections::{BTreeMap, BTreeSet};
use std::io::BufRead;

use super::fault::PackageFault;
use super::model::{Model, Object, ObjectKey, ObjectType, ObjectUse, Shaped};
use super::package::resolve;
use super::properties::{Irregularities, Properties, Srgb};
use super::shape::MeshDraft;
use super::value;
use super::xml::{self, Namespace, Visitor, XmlElement};
use crate::scene::{Placement, clean_name};
use crate::token::excerpt;
use crate::{LengthUnit, Location};

/// The most items of the build and components of all objects of a part.
const MOST_USES: usize = 1 << 20;

/// Extensions that a file may require, because the reader knows what they mean for shapes, or because they mean nothing for
/// them.
const UNDERSTOOD: [&str; 6] = [
    xml::PRODUCTION,
    xml::MATERIALS,
    xml::BEAMS,
    xml::SLICES,
    "http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07",
    "http://schemas.microsoft.com/3dmanufacturing/core/2015/02",
];

/// Reads a part. Only the build of the root counts.
pub(super) fn read(content: impl BufRead, is_root: bool) -> Result<Model, PackageFault> {
    let mut reader = ModelReader { is_root, ..ModelReader::default() };
    xml::walk(content, &mut reader)?;
    let Some(unit) = reader.unit else {
        return Err(PackageFault::new("has a part that is no 3D model"));
    };
    if !reader.has_resources {
        return Err(PackageFault::new("has a 3D model without resources"));
    }
    let ModelReader { objects, items, paths, odd, .. } = reader;
    Ok(Model { unit, objects, items, paths, odd })
}

/// An object while it is read.
struct Draft {
    id: u32,
    name: Option<String>,
    kind: ObjectType,
    colour: Option<Srgb>,
    shape: Option<Shaped>,
    unread: Option<&'static str>,
}

#[derive(Default)]
struct ModelReader {
    is_root: bool,
    unit: Option<LengthUnit>,
    has_resources: bool,
    /// The names of the elements that are open.
    open: Vec<&'static str>,
    ids: BTreeSet<u32>,
    properties: Properties,
    draft: Option<Draft>,
    mesh: Option<MeshDraft>,
    objects: BTreeMap<u32, Object>,
    items: Vec<ObjectUse>,
    uses: usize,
    paths: Vec<String>,
    odd: Irregularities,
}

/// The elements that are looked into, with the one around them.
const KNOWN: [(&str, &str, Namespace); 21] = [
    ("", "model", Namespace::Core),
    ("model", "resources", Namespace::Core),
    ("model", "build", Namespace::Core),
    ("model", "metadata", Namespace::Core),
    ("resources", "object", Namespace::Core),
    ("resources", "basematerials", Namespace::Core),
    ("resources", "colorgroup", Namespace::Materials),
    ("resources", "texture2d", Namespace::Materials),
    ("resources", "texture2dgroup", Namespace::Materials),
    ("resources", "compositematerials", Namespace::Materials),
    ("resources", "multiproperties", Namespace::Materials),
    ("build", "item", Namespace::Core),
    ("object", "mesh", Namespace::Core),
    ("object", "components", Namespace::Core),
    ("components", "component", Namespace::Core),
    ("mesh", "vertices", Namespace::Core),
    ("mesh", "triangles", Namespace::Core),
    ("mesh", "beamlattice", Namespace::Beams),
    ("vertices", "vertex", Namespace::Core),
    ("triangles", "triangle", Namespace::Core),
    ("resources", "slicestack", Namespace::Slices),
];

const GROUPS: [&str; 5] =
    ["basematerials", "colorgroup", "texture2dgroup", "compositematerials", "multiproperties"];

impl Visitor for ModelReader {
    fn open(&mut self, element: &XmlElement<'_>) -> Result<bool, PackageFault> {
        let around = self.open.last().copied().unwrap_or_default();
        if GROUPS.contains(&around) {
            self.properties.member(element, &mut self.odd)?;
            return Ok(false);
        }
        let known = KNOWN.iter().find(|(outer, name, namespace)| {
            *outer == around && *name == element.name && *namespace == element.namespace
        });
        let Some(&(_, name, _)) = known else { return self.unknown(element, around) };
        let place = self.place(name);
        let descend = self.enter(element, name).map_err(|fault| fault.at(place))?;
        if descend {
            self.open.push(name);
        }
        Ok(descend)
    }

    fn close(&mut self, _: &str) -> Result<(), PackageFault> {
        match self.open.pop() {
            Some("mesh") => {
                if let (Some(draft), Some(mesh)) = (&mut self.draft, self.mesh.take()) {
                    let mesh =
                        mesh.finish().map_err(|fault| fault.at(Some(in_object(draft.id))))?;
                    draft.shape = Some(Shaped::Mesh(Box::new(mesh)));
                }
            }
            Some("object") => self.end_object(),
            Some(name) if GROUPS.contains(&name) => self.properties.close(),
            _ => {}
        }
        Ok(())
    }
}

/// The place of a fault in an object.
fn in_object(id: u32) -> Location {
    Location::Element("object", u64::from(id))
}

impl ModelReader {
    /// Where a fault of the element `name` is.
    fn place(&self, name: &str) -> Option<Location> {
        match &self.draft {
            Some(draft) => Some(in_object(draft.id)),
            None if name == "item" => Some(Location::Element("item", self.items.len() as u64)),
            None => None,
        }
    }

    /// An element that the reader does not know, or not there. It is left out.
    fn unknown(&mut self, element: &XmlElement<'_>, around: &str) -> Result<bool, PackageFault> {
        if around.is_empty() {
            return Err(PackageFault::new("has a part that is no 3D model"));
        }
        if let Some(draft) = self.draft.as_mut().filter(|_| around == "object") {
            let kind = match element.name {
                "booleanshape" => "Boolean operations",
                "displacementmesh" => "displacements",
                "levelset" => "level sets",
                _ => return Ok(false),
            };
            draft.shape.get_or_insert(Shaped::Unread(kind));
        }
        if element.namespace == Namespace::Core
            && around != "object"
            && element.name != "metadatagroup"
        {
            self.odd.add("elements that the core specification does not have there");
        }
        Ok(false)
    }

    /// Reads an element that is in its right place. Returns whether to look into it.
    fn enter(
        &mut self,
        element: &XmlElement<'_>,
        name: &'static str,
    ) -> Result<bool, PackageFault> {
        match name {
            "model" => self.model(element)?,
            "resources" => self.has_resources = true,
            "metadata" => {
                self.metadata(element)?;
                return Ok(false);
            }
            "object" => self.object(element)?,
            "mesh" => self.begin_mesh()?,
            "vertex" => {
                self.mesh.as_mut().map_or(Ok(()), |mesh| mesh.vertex(element))?;
                return Ok(false);
            }
            "triangle" => {
                if let Some(mesh) = &mut self.mesh {
                    mesh.triangle(element, &self.properties, &mut self.odd)?;
                }
                return Ok(false);
            }
            "beamlattice" => {
                self.set_unread("beam lattices");
                return Ok(false);
            }
            "slicestack" => {
                self.take_id(value::resource(&element.required("id")?)?)?;
                return Ok(false);
            }
            "components" => self.begin_components()?,
            "component" => {
                let used = self.used(element)?;
                if let Some(Draft { shape: Some(Shaped::Components(uses)), .. }) = &mut self.draft {
                    uses.push(used);
                }
                return Ok(false);
            }
            "item" => {
                let used = self.used(element)?;
                if self.is_root {
                    self.items.push(used);
                }
                return Ok(false);
            }
            "build" => {}
            _ => {
                let id = self.properties.open(element, &mut self.odd)?;
                id.map_or(Ok(()), |id| self.take_id(id))?;
                return Ok(name != "texture2d");
            }
        }
        Ok(true)
    }

    fn model(&mut self, element: &XmlElement<'_>) -> Result<(), PackageFault> {
        let unit = element.get("unit")?;
        self.unit = Some(match unit.as_deref().unwrap_or("millimeter").trim() {
            "micron" => LengthUnit::Micrometre,
            "millimeter" => LengthUnit::Millimetre,
            "centimeter" => LengthUnit::Centimetre,
            "inch" => LengthUnit::Inch,
            "foot" => LengthUnit::Foot,
            "meter" => LengthUnit::Metre,
            other => {
                let shown = excerpt(other.as_bytes());
                let what =
                    format!("is in the unit \u{201c}{shown}\u{201d}, which 3MF does not have");
                return Err(PackageFault::helped(what, "Export it in millimetres."));
            }
        });
        let required = element.get("requiredextensions")?.unwrap_or_default();
        for prefix in required.split_ascii_whitespace() {
            let address = element.address_of(prefix).unwrap_or(prefix);
            if address.contains("/securecontent/") {
                return Err(PackageFault::encrypted());
            }
            if !UNDERSTOOD.contains(&address) {
                let shown = excerpt(address.as_bytes());
                let help = "Export it as plain meshes, without this extension, or as STL.";
                return Err(PackageFault::helped(format!("requires the extension {shown}"), help));
            }
        }
        Ok(())
    }

    fn metadata(&mut self, element: &XmlElement<'_>) -> Result<(), PackageFault> {
        const NAMES: [&str; 9] = [
            "Title",
            "Designer",
            "Description",
            "Copyright",
            "LicenseTerms",
            "Rating",
            "CreationDate",
            "ModificationDate",
            "Application",
        ];
        let name = element.get("name")?;
        // Other names have a prefix.
        if !name.is_some_and(|name| NAMES.contains(&&*name) || name.contains(':')) {
            self.odd.add("metadata without a name that 3MF has");
        }
        Ok(())
    }

    /// Takes the number of a resource, which no other one may have.
    fn take_id(&mut self, id: u32) -> Result<(), PackageFault> {
        match self.ids.insert(id) {
            true => Ok(()),
            false => Err(PackageFault::new(format!("has two resources with the number {id}"))),
        }
    }

    fn object(&mut self, element: &XmlElement<'_>) -> Result<(), PackageFault> {
        let id = value::resource(&element.required("id")?)?;
        self.take_id(id)?;
        let text = |name| element.get(name).map(|text| text.and_then(|text| clean_name(&text)));
        let kind = match element.get("type")?.as_deref().unwrap_or("model").trim() {
            "model" | "surface" => ObjectType::Model,
            "support" | "solidsupport" => ObjectType::Support,
            "other" => ObjectType::Other,
            other => {
                let shown = excerpt(other.as_bytes());
                let what = format!("has an object of the unknown type \u{201c}{shown}\u{201d}");
                return Err(PackageFault::new(what).at(Some(in_object(id))));
            }
        };
        let number = |name| -> Result<Option<u32>, PackageFault> {
            Ok(element.get(name)?.and_then(|text| value::index(&text).ok()))
        };
        let colour = match (number("pid")?, number("pindex")?) {
            (Some(group), Some(index)) => match self.properties.colour(group, index) {
                Ok(colour) => colour,
                Err(()) => {
                    self.odd.add("objects of properties that do not exist");
                    None
                }
            },
            (None, None) => None,
            _ => {
                self.odd.add("objects with half of a property");
                None
            }
        };
        let slices = element.get_in(Namespace::Slices, "slicestackid")?.map(|_| "slices");
        let name = text("name")?.or(text("partnumber")?);
        self.draft = Some(Draft { id, name, kind, colour, shape: None, unread: slices });
        Ok(())
    }

    fn set_unread(&mut self, what: &'static str) {
        if let Some(draft) = &mut self.draft {
            draft.unread = Some(what);
        }
    }

    fn begin_mesh(&mut self) -> Result<(), PackageFault> {
        let Some(draft) = self.draft.as_ref() else { return Ok(()) };
        if draft.shape.is_some() {
            return Err(PackageFault::new("has an object with two shapes"));
        }
        self.mesh = Some(MeshDraft::new(draft.colour));
        Ok(())
    }

    fn begin_components(&mut self) -> Result<(), PackageFault> {
        let Some(draft) = self.draft.as_mut() else { return Ok(()) };
        if draft.shape.replace(Shaped::Components(Vec::new())).is_some() {
            return Err(PackageFault::new("has an object with two shapes"));
        }
        Ok(())
    }

    fn end_object(&mut self) {
        if let Some(Draft { id, name, kind, shape, unread, .. }) = self.draft.take() {
            let shape = shape.unwrap_or(Shaped::Unread("shapes of unknown extensions"));
            self.objects.insert(id, Object { name, kind, shape, unread });
        }
    }

    /// An item or a component.
    fn used(&mut self, element: &XmlElement<'_>) -> Result<ObjectUse, PackageFault> {
        self.uses += 1;
        if self.uses > MOST_USES {
            return Err(PackageFault::new("has more than a million items and components"));
        }
        let id = value::resource(&element.required("objectid")?)?;
        let path = match element.get_in(Namespace::Production, "path")? {
            Some(path) => {
                let shown = || excerpt(path.as_bytes());
                let outside =
                    || PackageFault::new(format!("refers to a part outside of it: {}", shown()));
                let part = resolve("", path.trim()).ok_or_else(outside)?;
                if self.paths.last() != Some(&part) {
                    self.paths.push(part.clone());
                }
                Some(part)
            }
            None => None,
        };
        let placement = match element.get("transform")? {
            Some(text) => value::transform(&text)?,
            None => Placement::IDENTITY,
        };
        let name = element.get("partnumber")?.and_then(|text| clean_name(&text));
        Ok(ObjectUse { object: ObjectKey { path, model: 0, id }, placement, name })
    }
}
