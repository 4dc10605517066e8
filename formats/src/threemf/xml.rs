//! The XML of a part, element by element. Nothing is expanded, and nothing outside is read.

use std::borrow::Cow;
use std::io::BufRead;

use quick_xml::NsReader;
use quick_xml::events::{BytesStart, Event};
use quick_xml::name::{NamespaceResolver, ResolveResult};

use super::fault::PackageFault;
use crate::token::excerpt;

/// The greatest depth of elements. Those of 3MF are six deep.
const MOST_DEPTH: usize = 64;

/// The most attributes of an element. Those of 3MF have ten.
const MOST_ATTRIBUTES: usize = 64;

/// The namespaces that the reader knows, by their addresses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Namespace {
    Core,
    Production,
    Materials,
    Beams,
    Slices,
    Relationships,
    Other,
}

pub(super) const PRODUCTION: &str =
    "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";
pub(super) const MATERIALS: &str = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02";
pub(super) const BEAMS: &str = "http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02";
pub(super) const SLICES: &str = "http://schemas.microsoft.com/3dmanufacturing/slice/2015/07";

impl Namespace {
    fn of(address: &str) -> Namespace {
        match address {
            "http://schemas.microsoft.com/3dmanufacturing/core/2015/02" => Namespace::Core,
            "http://schemas.openxmlformats.org/package/2006/relationships" => {
                Namespace::Relationships
            }
            PRODUCTION => Namespace::Production,
            MATERIALS => Namespace::Materials,
            BEAMS => Namespace::Beams,
            SLICES => Namespace::Slices,
            _ => Namespace::Other,
        }
    }
}

/// The beginning of an element.
pub(super) struct XmlElement<'a> {
    pub(super) namespace: Namespace,
    /// The name without the prefix.
    pub(super) name: &'a str,
    start: &'a BytesStart<'a>,
    resolver: &'a NamespaceResolver,
}

impl XmlElement<'_> {
    /// The value of an attribute without a namespace.
    pub(super) fn get(&self, name: &str) -> Result<Option<Cow<'_, str>>, PackageFault> {
        let mut found = None;
        self.each_attribute(|key, value| {
            if key == name {
                found = Some(value);
            }
        })?;
        found.map(unescaped).transpose()
    }

    /// The same for an attribute that must be there.
    pub(super) fn required(&self, name: &str) -> Result<Cow<'_, str>, PackageFault> {
        let missing =
            || PackageFault::new(format!("has <{}> without the attribute {name}", self.name));
        self.get(name)?.ok_or_else(missing)
    }

    /// The value of an attribute in a namespace.
    pub(super) fn get_in(
        &self,
        namespace: Namespace,
        name: &str,
    ) -> Result<Option<Cow<'_, str>>, PackageFault> {
        for attribute in self.start.attributes() {
            let attribute = attribute.map_err(|e| unsound(&e))?;
            let (resolved, local) = self.resolver.resolve_attribute(attribute.key);
            if let ResolveResult::Bound(address) = resolved
                && local.into_inner() == name
                && Namespace::of(address.into_inner()) == namespace
            {
                return unescaped(attribute.value).map(Some);
            }
        }
        Ok(None)
    }

    /// Calls `look` with the key and the value of each attribute as they are in the file. Those with a prefix have it in
    /// their key.
    pub(super) fn each_attribute<'s>(
        &'s self,
        mut look: impl FnMut(&'s str, Cow<'s, str>),
    ) -> Result<(), PackageFault> {
        for (count, attribute) in self.start.attributes().enumerate() {
            if count >= MOST_ATTRIBUTES {
                let name = excerpt(self.name.as_bytes());
                return Err(PackageFault::new(format!(
                    "has <{name}> with more than 64 attributes"
                )));
            }
            let attribute = attribute.map_err(|e| unsound(&e))?;
            look(attribute.key.into_inner(), attribute.value);
        }
        Ok(())
    }

    /// The address of the namespace of a prefix.
    pub(super) fn address_of(&self, prefix: &str) -> Option<&str> {
        let mut bindings = self.resolver.bindings();
        let found = bindings.find(|(of, _)| match of {
            quick_xml::name::PrefixDeclaration::Named(name) => *name == prefix,
            quick_xml::name::PrefixDeclaration::Default => prefix.is_empty(),
        });
        found.map(|(_, address)| address.into_inner())
    }
}

/// A value with its character references resolved. Only XML's own entities are known.
pub(super) fn unescaped(value: Cow<'_, str>) -> Result<Cow<'_, str>, PackageFault> {
    if !value.contains('&') {
        return Ok(value);
    }
    let text = quick_xml::escape::unescape(&value).map_err(|e| unsound(&e))?.into_owned();
    Ok(Cow::Owned(text))
}

/// What looks at the elements of a part.
pub(super) trait Visitor {
    /// An element begins. Returns whether to look into it.
    fn open(&mut self, element: &XmlElement<'_>) -> Result<bool, PackageFault>;

    /// An element that was looked into ends.
    fn close(&mut self, name: &str) -> Result<(), PackageFault>;
}

/// Goes through the elements of a part.
pub(super) fn walk(content: impl BufRead, visitor: &mut impl Visitor) -> Result<(), PackageFault> {
    let mut reader = NsReader::from_reader(content);
    reader.config_mut().expand_empty_elements = true;
    let mut buffer = Vec::new();
    // The depth, and that from which on elements are skipped.
    let (mut depth, mut skipped, mut has_root) = (0, usize::MAX, false);
    loop {
        buffer.clear();
        let (resolved, event) =
            reader.read_resolved_event_into(&mut buffer).map_err(|e| broken(&e))?;
        match event {
            Event::Start(start) => {
                depth += 1;
                if depth > MOST_DEPTH {
                    return Err(PackageFault::new("has elements in each other, more than 64 deep"));
                }
                if depth == 1 && std::mem::replace(&mut has_root, true) {
                    return Err(PackageFault::new("has a part with two root elements"));
                }
                if depth > skipped {
                    continue;
                }
                let namespace = match resolved {
                    ResolveResult::Bound(address) => Namespace::of(address.into_inner()),
                    ResolveResult::Unbound => Namespace::Other,
                    ResolveResult::Unknown(prefix) => {
                        let prefix = excerpt(prefix.as_bytes());
                        return Err(PackageFault::new(format!(
                            "has the prefix {prefix} without a namespace"
                        )));
                    }
                };
                let name = start.local_name().into_inner();
                let resolver = reader.resolver();
                let element = XmlElement { namespace, name, start: &start, resolver };
                if !visitor.open(&element)? {
                    skipped = depth;
                }
            }
            Event::End(end) => {
                if depth < skipped {
                    visitor.close(end.local_name().into_inner())?;
                } else if depth == skipped {
                    skipped = usize::MAX;
                }
                depth = depth.saturating_sub(1);
            }
            Event::DocType(_) => {
                let what = "has a document type declaration, which 3MF forbids";
                return Err(PackageFault::new(what));
            }
            Event::Eof if depth == 0 && has_root => return Ok(()),
            Event::Eof => return Err(PackageFault::new("has a part that is cut short")),
            _ => {}
        }
    }
}

/// What stopped the reader: the archive, or the XML in it.
fn broken(e: &quick_xml::Error) -> PackageFault {
    match e {
        quick_xml::Error::Io(e) => {
            PackageFault::new(format!("has a part that cannot be unpacked: {e}"))
        }
        e => unsound(e),
    }
}

fn unsound(e: &dyn std::fmt::Display) -> PackageFault {
    PackageFault::new(format!(
        "has a part that is not sound XML: {}",
        excerpt(e.to_string().as_bytes())
    ))
}
