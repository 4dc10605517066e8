//! Buffer views that are packed by meshoptimizer (`EXT_meshopt_compression`).
//!
//! Each packed view becomes the only view of a buffer of its own, which is unpacked when it is needed. So
//! accessors and the gltf crate see plain data.

use std::collections::BTreeMap;

use ::gltf::json::validation::USize64;
use ::gltf::json::{Buffer, Index, Root};
use meshoptimizer_rs::Workspace;
use meshoptimizer_rs::codec::{Filter, Mode, decode_buffer_view};

use super::extras::PackedView;

/// Gives each packed view its buffer. Returns what is in these buffers, by their number.
pub(super) fn add_buffers(
    root: &mut Root,
    packed: &BTreeMap<usize, PackedView>,
) -> BTreeMap<usize, PackedView> {
    let mut added = BTreeMap::new();
    for (&view, data) in packed {
        let Some(view) = root.buffer_views.get_mut(view) else { continue };
        let buffer = root.buffers.len();
        let length = data.length().unwrap_or(u64::MAX);
        root.buffers.push(Buffer {
            byte_length: USize64(length),
            name: None,
            uri: None,
            extensions: None,
            extras: Default::default(),
        });
        view.buffer = Index::new(buffer as u32);
        view.byte_offset = None;
        added.insert(buffer, data.clone());
    }
    added
}

impl PackedView {
    /// The number of bytes when it is unpacked.
    pub(super) fn length(&self) -> Option<u64> {
        (self.count as u64).checked_mul(self.byte_stride as u64)
    }

    /// Its unpacked bytes.
    pub(super) fn unpack(&self, bytes: &[u8]) -> Result<Vec<u8>, String> {
        let mode = Mode::parse(&self.mode).map_err(|e| e.to_string())?;
        let filter = self.filter.as_deref().unwrap_or("NONE");
        let filter = Filter::parse(filter).map_err(|e| e.to_string())?;
        let mut workspace = Workspace::default();
        decode_buffer_view(mode, filter, self.count, self.byte_stride, bytes, &mut workspace)
            .map_err(|e| e.to_string())
    }
}
