//! The groups of properties of a part: base materials, colours and what is made of them. Only their colours are read.

use std::collections::BTreeMap;

use super::fault::PackageFault;
use super::value;
use super::xml::XmlElement;
use crate::colour::of_hexadecimal;

/// A colour in sRGB.
pub(super) type Srgb = [u8; 3];

/// A kind of group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum GroupKind {
    BaseMaterials,
    Colours,
    Texture,
    Composites,
    Multiple,
}

/// A group of properties, which triangles name by their index.
struct PropertyGroup {
    kind: GroupKind,
    colours: Vec<Option<Srgb>>,
}

/// Rules of the specification that are broken but do not concern shapes, with the number of places.
#[derive(Default)]
pub(super) struct Irregularities(pub(super) BTreeMap<&'static str, u64>);

impl Irregularities {
    pub(super) fn add(&mut self, what: &'static str) {
        *self.0.entry(what).or_default() += 1;
    }
}

/// The groups of a part.
#[derive(Default)]
pub(super) struct Properties {
    groups: BTreeMap<u32, PropertyGroup>,
    textures: Vec<u32>,
    /// The group that is being read.
    current: Option<(u32, PropertyGroup)>,
    /// The groups that the current one is made of.
    sources: Vec<u32>,
    /// The members of base materials that a composite mixes.
    mixed: Vec<Option<Srgb>>,
}

impl Properties {
    /// Begins a group. Returns whether the element is one.
    pub(super) fn open(
        &mut self,
        element: &XmlElement<'_>,
        odd: &mut Irregularities,
    ) -> Result<Option<u32>, PackageFault> {
        let kind = match element.name {
            "basematerials" => GroupKind::BaseMaterials,
            "colorgroup" => GroupKind::Colours,
            "texture2dgroup" => GroupKind::Texture,
            "compositematerials" => GroupKind::Composites,
            "multiproperties" => GroupKind::Multiple,
            "texture2d" => return self.texture(element, odd).map(Some),
            _ => return Ok(None),
        };
        let id = value::resource(&element.required("id")?)?;
        match kind {
            GroupKind::Texture => {
                let texture = element.get("texid")?.and_then(|id| value::index(&id).ok());
                if !texture.is_some_and(|id| self.textures.contains(&id)) {
                    odd.add("groups of texture coordinates without their texture");
                }
            }
            GroupKind::Composites => self.begin_composites(element, odd)?,
            GroupKind::Multiple => self.begin_multiple(element, odd)?,
            GroupKind::BaseMaterials | GroupKind::Colours => {}
        }
        self.current = Some((id, PropertyGroup { kind, colours: Vec::new() }));
        Ok(Some(id))
    }

    fn texture(
        &mut self,
        element: &XmlElement<'_>,
        odd: &mut Irregularities,
    ) -> Result<u32, PackageFault> {
        let id = value::resource(&element.required("id")?)?;
        let kind = element.get("contenttype")?;
        if !kind.is_some_and(|kind| matches!(&*kind, "image/png" | "image/jpeg")) {
            odd.add("textures of an unknown type");
        }
        self.textures.push(id);
        Ok(id)
    }

    fn begin_composites(
        &mut self,
        element: &XmlElement<'_>,
        odd: &mut Irregularities,
    ) -> Result<(), PackageFault> {
        self.mixed.clear();
        let base = element.get("matid")?.and_then(|id| value::index(&id).ok());
        let base = base.and_then(|id| self.groups.get(&id));
        let Some(base) = base.filter(|group| group.kind == GroupKind::BaseMaterials) else {
            odd.add("composites that are not of base materials");
            return Ok(());
        };
        let Some(indices) = element.get("matindices")? else {
            odd.add("composites without their materials");
            return Ok(());
        };
        for index in indices.split_ascii_whitespace() {
            let index = value::index(index).ok().map(|index| index as usize);
            self.mixed.push(index.and_then(|index| *base.colours.get(index)?));
        }
        Ok(())
    }

    fn begin_multiple(
        &mut self,
        element: &XmlElement<'_>,
        odd: &mut Irregularities,
    ) -> Result<(), PackageFault> {
        self.sources.clear();
        let ids = element.get("pids")?.unwrap_or_default();
        self.sources.extend(ids.split_ascii_whitespace().filter_map(|id| value::index(id).ok()));
        let count = |is: fn(GroupKind) -> bool| {
            let groups = self.sources.iter().filter_map(|id| self.groups.get(id));
            groups.filter(|group| is(group.kind)).count()
        };
        let materials =
            count(|kind| matches!(kind, GroupKind::BaseMaterials | GroupKind::Composites));
        let is_sound = !self.sources.is_empty()
            && materials <= 1
            && count(|kind| kind == GroupKind::Multiple) == 0
            && count(|kind| kind == GroupKind::Colours) <= 1;
        if !is_sound {
            odd.add("multiple properties of groups that do not go together");
        }
        Ok(())
    }

    /// Reads a member of the current group.
    pub(super) fn member(
        &mut self,
        element: &XmlElement<'_>,
        odd: &mut Irregularities,
    ) -> Result<(), PackageFault> {
        let Some((_, group)) = &self.current else { return Ok(()) };
        let colour = match (group.kind, element.name) {
            (GroupKind::BaseMaterials, "base") => match element.get("displaycolor")? {
                Some(colour) => read_colour(&colour, odd),
                None => None,
            },
            (GroupKind::Colours, "color") => match element.get("color")? {
                Some(colour) => read_colour(&colour, odd),
                None => {
                    odd.add("colours without a value");
                    None
                }
            },
            (GroupKind::Texture, "tex2coord") => None,
            (GroupKind::Composites, "composite") => {
                mixture(&self.mixed, &element.get("values")?.unwrap_or_default())
            }
            (GroupKind::Multiple, "multi") => {
                let indices = element.get("pindices")?.unwrap_or_default();
                let indices =
                    indices.split_ascii_whitespace().map(|index| value::index(index).ok());
                // A missing index is 0. The last layer is on top.
                let indices = indices.chain(std::iter::repeat(Some(0)));
                let layers = self.sources.iter().zip(indices);
                let colours = layers.filter_map(|(&id, index)| self.colour(id, index?).ok()?);
                colours.last()
            }
            _ => return Ok(()),
        };
        if let Some((_, group)) = &mut self.current {
            group.colours.push(colour);
        }
        Ok(())
    }

    /// Ends the current group.
    pub(super) fn close(&mut self) {
        if let Some((id, group)) = self.current.take() {
            self.groups.insert(id, group);
        }
    }

    /// The colour of a member of a group, if it has one. An error if there is no such member.
    pub(super) fn colour(&self, group: u32, index: u32) -> Result<Option<Srgb>, ()> {
        let group = self.groups.get(&group).ok_or(())?;
        group.colours.get(index as usize).copied().ok_or(())
    }
}

fn read_colour(text: &str, odd: &mut Irregularities) -> Option<Srgb> {
    let colour = of_hexadecimal(text);
    if colour.is_none() {
        odd.add("colours that are none");
    }
    colour
}

/// The mean of colours with these weights, if there are any.
fn mixture(colours: &[Option<Srgb>], weights: &str) -> Option<Srgb> {
    let weights = weights.split_ascii_whitespace().map(|word| value::number(word).unwrap_or(0.0));
    let (mut sum, mut total) = ([0.0; 3], 0.0);
    for (colour, weight) in colours.iter().zip(weights) {
        let weight = weight.max(0.0);
        total += weight;
        let colour = (*colour)?;
        sum = [0, 1, 2].map(|k| sum[k] + weight * f64::from(colour[k]));
    }
    // The result is between 0 and 255, because weights are not negative.
    (total > 0.0).then(|| sum.map(|x| (x / total).round() as u8))
}

/// The mean of the colours of the corners of a triangle. `None` if a corner has none.
pub(super) fn mean(corners: [Option<Srgb>; 3]) -> Option<Srgb> {
    let [a, b, c] = corners;
    let corners = [a?, b?, c?];
    Some([0, 1, 2].map(|k| {
        let sum: u32 = corners.iter().map(|colour| u32::from(colour[k])).sum();
        // The mean of bytes, rounded, is a byte.
        ((2 * sum + 3) / 6) as u8
    }))
}

#[cfg(test)]
mod tests {
    use super::{mean, mixture};

    #[test]
    fn colours_are_mixed() {
        let (red, blue) = (Some([255, 0, 0]), Some([0, 0, 255]));
        assert_eq!(mixture(&[red, blue], "0.2 0.8"), Some([51, 0, 204]));
        assert_eq!(mixture(&[red, None], "1 1"), None);
        assert_eq!(mixture(&[red], ""), None);
        assert_eq!(mean([red, red, red]), red);
        assert_eq!(mean([red, red, blue]), Some([170, 0, 85]));
        assert_eq!(mean([red, None, red]), None);
    }
}
