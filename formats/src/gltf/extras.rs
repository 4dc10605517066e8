//! What the gltf crate does not read: extensions, and the colours of materials.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::value::RawValue;

use super::text::{JsonParts, objects};
use crate::colour::srgb_of_linear;

/// Extensions that change where meshes are or how their data are packed, and the colours of materials.
#[derive(Default)]
pub(super) struct Extras {
    /// The colour of each material (sRGB), if it has one instead of a texture.
    pub(super) colours: Vec<Option<[u8; 3]>>,
    /// Whether there are materials that cannot be read.
    pub(super) has_bad_materials: bool,
    /// The accessors of the instances of nodes, by their node.
    pub(super) instances: BTreeMap<usize, BTreeMap<String, usize>>,
    /// The Draco data of primitives, by the numbers of the mesh and the primitive.
    pub(super) draco: BTreeMap<(usize, usize), DracoData>,
    /// The packed data of buffer views, by their view.
    pub(super) packed: BTreeMap<usize, PackedView>,
}

/// `KHR_draco_mesh_compression` of a primitive.
#[derive(Deserialize, Clone)]
#[serde(rename_all = "camelCase")]
pub(super) struct DracoData {
    pub(super) buffer_view: usize,
    /// The numbers of attributes in the Draco data.
    pub(super) attributes: BTreeMap<String, u32>,
}

/// `EXT_meshopt_compression` of a buffer view.
#[derive(Deserialize, Clone)]
#[serde(rename_all = "camelCase")]
pub(super) struct PackedView {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) byte_length: u64,
    pub(super) byte_stride: usize,
    pub(super) count: usize,
    pub(super) mode: String,
    pub(super) filter: Option<String>,
}

const DRACO: &str = "KHR_draco_mesh_compression";
const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];
const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// Extensions that this module reads.
pub(super) const READ: [&str; 4] = [DRACO, MESHOPT[0], MESHOPT[1], INSTANCING];

/// An object of a list with what its extensions are.
#[derive(Deserialize)]
struct Extended<'a> {
    #[serde(borrow)]
    extensions: Option<&'a RawValue>,
}

#[derive(Deserialize)]
struct MeshJson<'a> {
    #[serde(borrow, default)]
    primitives: Vec<Extended<'a>>,
}

#[derive(Deserialize)]
struct Instancing {
    attributes: BTreeMap<String, usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct MaterialJson {
    pbr_metallic_roughness: Option<BaseColour>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct BaseColour {
    base_color_factor: Option<[f64; 4]>,
    base_color_texture: Option<IgnoredAny>,
}

impl Extras {
    /// Reads the extras of `parts`, whose objects have been counted.
    pub(super) fn read(parts: &JsonParts<'_>) -> serde_json::Result<Extras> {
        let mut extras = Extras::default();
        extras.read_colours(parts.materials);
        let nodes = parts.nodes.filter(|nodes| nodes.get().contains(INSTANCING));
        for (index, node) in list(nodes)?.into_iter().enumerate() {
            if let Some(found) = extension::<Instancing>(&node, &[INSTANCING])? {
                extras.instances.insert(index, found.attributes);
            }
        }
        let meshes = parts.meshes.filter(|meshes| meshes.get().contains(DRACO));
        let meshes: Vec<MeshJson<'_>> =
            meshes.map_or(Ok(Vec::new()), |meshes| serde_json::from_str(meshes.get()))?;
        for (index, mesh) in meshes.iter().enumerate() {
            for (number, primitive) in mesh.primitives.iter().enumerate() {
                if let Some(found) = extension(primitive, &[DRACO])? {
                    extras.draco.insert((index, number), found);
                }
            }
        }
        let is_packed = |views: &&RawValue| MESHOPT.iter().any(|name| views.get().contains(name));
        for (index, view) in list(parts.buffer_views.filter(is_packed))?.into_iter().enumerate() {
            if let Some(found) = extension(&view, &MESHOPT)? {
                extras.packed.insert(index, found);
            }
        }
        Ok(extras)
    }

    fn read_colours(&mut self, materials: Option<&RawValue>) {
        let Some(materials) = materials else { return };
        let most = super::text::MOST_OBJECTS;
        let materials = match objects(materials.get().as_bytes()) <= most {
            true => serde_json::from_str::<Vec<MaterialJson>>(materials.get()).ok(),
            false => None,
        };
        self.has_bad_materials = materials.is_none();
        let colour = |material: MaterialJson| {
            let base = material.pbr_metallic_roughness?;
            let [r, g, b, _] =
                base.base_color_factor.filter(|_| base.base_color_texture.is_none())?;
            srgb_of_linear([r, g, b])
        };
        self.colours = materials.into_iter().flatten().map(colour).collect();
    }
}

/// The objects of a list.
fn list<'a>(part: Option<&'a RawValue>) -> serde_json::Result<Vec<Extended<'a>>> {
    part.map_or(Ok(Vec::new()), |part| serde_json::from_str(part.get()))
}

/// The first of the extensions called `names` that an object has.
fn extension<T: for<'a> Deserialize<'a>>(
    of: &Extended<'_>,
    names: &[&str],
) -> serde_json::Result<Option<T>> {
    let Some(raw) = of.extensions else { return Ok(None) };
    let all: BTreeMap<String, &RawValue> = serde_json::from_str(raw.get())?;
    let found = names.iter().find_map(|name| all.get(*name));
    found.map(|raw| serde_json::from_str(raw.get())).transpose()
}
