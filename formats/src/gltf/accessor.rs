//! Accessors. They are checked completely before the readers of the gltf crate use them.

use ::gltf::accessor::{Item, Iter};
use ::gltf::json::Index;
use ::gltf::json::accessor::{Accessor, ComponentType, Type, sparse::Sparse};
use ::gltf::json::buffer::View;
use ::gltf::json::validation::Checked::Valid;

use super::Gear;
use crate::source::EXPORT_AGAIN;
use crate::{Error, Location, Result};

/// The largest number of items of an accessor without a view. All its items are zero, and it takes
/// no space in the file.
const MOST_ZEROS: u64 = 250_000;

/// The positions in accessor `index` as `f64`.
pub(super) fn positions(gear: &mut Gear<'_>, index: usize) -> Result<Vec<[f64; 3]>> {
    let (json, kind) = check(gear, index, Type::Vec3)?;
    let normalized = json.normalized;
    match kind {
        ComponentType::F32 => points(gear, index, |v: f32| f64::from(v)),
        ComponentType::I8 => points(gear, index, scaled::<i8>(normalized, i8::MAX.into())),
        ComponentType::U8 => points(gear, index, scaled::<u8>(normalized, u8::MAX.into())),
        ComponentType::I16 => points(gear, index, scaled::<i16>(normalized, i16::MAX.into())),
        ComponentType::U16 => points(gear, index, scaled::<u16>(normalized, u16::MAX.into())),
        ComponentType::U32 => Err(bad(gear, index, "holds positions of an unknown type")),
    }
}

/// The quaternions in accessor `index`. Integers stand for the range from -1 to 1.
pub(super) fn rotations(gear: &mut Gear<'_>, index: usize) -> Result<Vec<[f64; 4]>> {
    match check(gear, index, Type::Vec4)?.1 {
        ComponentType::F32 => items::<[f32; 4], _>(gear, index, |q| q.map(f64::from)),
        ComponentType::I8 => {
            let number = scaled::<i8>(true, i8::MAX.into());
            items::<[i8; 4], _>(gear, index, |q| q.map(&number))
        }
        ComponentType::I16 => {
            let number = scaled::<i16>(true, i16::MAX.into());
            items::<[i16; 4], _>(gear, index, |q| q.map(&number))
        }
        _ => Err(bad(gear, index, "holds rotations of an unknown type")),
    }
}

/// Converts a quantized coordinate. If it is `normalized`, `most` stands for 1.
fn scaled<T: Into<f64>>(normalized: bool, most: f64) -> impl Fn(T) -> f64 {
    move |v| {
        if normalized { (v.into() / most).max(-1.0) } else { v.into() }
    }
}

fn points<T: Item + Copy>(
    gear: &Gear<'_>,
    index: usize,
    number: impl Fn(T) -> f64,
) -> Result<Vec<[f64; 3]>> {
    items::<[T; 3], _>(gear, index, |xyz| xyz.map(&number))
}

/// The number of items that accessor `index` declares.
pub(super) fn count(gear: &Gear<'_>, index: usize) -> Option<u64> {
    gear.document.as_json().accessors.get(index).map(|json| json.count.0)
}

/// The vertex numbers in accessor `index`.
pub(super) fn indices(gear: &mut Gear<'_>, index: usize) -> Result<Vec<u32>> {
    use ComponentType::{F32, I8, I16};
    // This check comes first, because other checks may fail only for this reason.
    if let Some(json) = gear.document.as_json().accessors.get(index)
        && let (Valid(Type::Scalar), Valid(kind)) = (json.type_, &json.component_type)
        && matches!(kind.0, F32 | I8 | I16)
    {
        return Err(bad(gear, index, "holds vertex numbers that are not unsigned integers"));
    }
    match check(gear, index, Type::Scalar)?.1 {
        ComponentType::U8 => items::<u8, _>(gear, index, u32::from),
        ComponentType::U16 => items::<u16, _>(gear, index, u32::from),
        ComponentType::U32 => items::<u32, _>(gear, index, |i| i),
        I8 | I16 | F32 => Err(bad(gear, index, "cannot be read")),
    }
}

/// Reads the items of a checked accessor with the gltf crate.
fn items<T: Item, U>(gear: &Gear<'_>, index: usize, f: impl Fn(T) -> U) -> Result<Vec<U>> {
    let lost = || bad(gear, index, "cannot be read");
    let accessor = gear.document.accessors().nth(index).ok_or_else(lost)?;
    let count = accessor.count();
    if count == 0 {
        // The crate would subtract one from the count.
        return Ok(Vec::new());
    }
    let buffers = &gear.buffers;
    let items = Iter::<T>::new(accessor, |b| buffers.get(b.index())).ok_or_else(lost)?;
    let items: Vec<U> = items.map(f).collect();
    if items.len() == count { Ok(items) } else { Err(lost()) }
}

/// Checks everything about accessor `index` that the crate trusts.
fn check<'a>(
    gear: &mut Gear<'a>,
    index: usize,
    shape: Type,
) -> Result<(&'a Accessor, ComponentType)> {
    let root = gear.document.as_json();
    let Some(json) = root.accessors.get(index) else {
        return Err(bad(gear, index, "does not exist"));
    };
    let (Valid(found), Valid(kind)) = (json.type_, &json.component_type) else {
        return Err(bad(gear, index, "is of an unknown type"));
    };
    if found != shape {
        return Err(bad(gear, index, "has items of the wrong shape"));
    }
    let kind = kind.0;
    let size = (kind.size() * shape.multiplicity()) as u64;
    let offset = json.byte_offset.unwrap_or_default().0;
    if let Some(view) = json.buffer_view {
        check_span(gear, index, view, ByteRange { offset, count: json.count.0, size })?;
    } else if json.sparse.is_none() {
        return Err(bad(gear, index, "has no data"));
    } else if json.count.0 > MOST_ZEROS {
        return Err(bad(gear, index, "has more than 250,000 items without data"));
    }
    if let Some(sparse) = &json.sparse {
        check_sparse(gear, index, sparse, json.count.0, size)?;
    }
    Ok((json, kind))
}

/// `count` items of `size` bytes that begin at `offset` in their view.
struct ByteRange {
    offset: u64,
    count: u64,
    size: u64,
}

/// Checks that the range is in its view and the view is in its buffer, and loads the buffer.
/// Returns the view and its stride.
fn check_span<'a>(
    gear: &mut Gear<'a>,
    index: usize,
    view: Index<View>,
    span: ByteRange,
) -> Result<(&'a View, u64)> {
    let root = gear.document.as_json();
    let Some(json) = root.buffer_views.get(view.value()) else {
        return Err(bad(gear, index, "is in a buffer view that does not exist"));
    };
    check_view(gear, view.value(), json)?;
    let stride = json.byte_stride.map_or(0, |s| s.0 as u64);
    // A stride of zero means none. The crate does the same.
    let stride = if stride == 0 { span.size } else { stride };
    if stride < span.size {
        return Err(bad(gear, index, "has items that overlap"));
    }
    let last = span.count.saturating_sub(1).checked_mul(stride);
    let end = last.and_then(|n| n.checked_add(span.offset)?.checked_add(span.size));
    if span.count > 0 && end.is_none_or(|end| end > json.byte_length.0) {
        return Err(bad(gear, index, "reaches beyond its buffer view"));
    }
    Ok((json, stride))
}

/// Checks that buffer view `index` is in its buffer, and loads the buffer. Returns where the view begins.
fn check_view(gear: &mut Gear<'_>, index: usize, json: &View) -> Result<u64> {
    let length = gear.buffers.load(json.buffer.value())?;
    let start = json.byte_offset.unwrap_or_default().0;
    if start.checked_add(json.byte_length.0).is_none_or(|end| end > length) {
        let error =
            Error::new(gear.buffers.path, "has a buffer view beyond its buffer", EXPORT_AGAIN);
        return Err(error.at(Location::Element("bufferView", index as u64)));
    }
    Ok(start)
}

/// The bytes of buffer view `index`.
pub(super) fn view(gear: &mut Gear<'_>, index: usize) -> Result<Vec<u8>> {
    let Some(json) = gear.document.as_json().buffer_views.get(index) else {
        return Err(super::scene::bad(gear, "bufferView", index, "does not exist"));
    };
    let start = check_view(gear, index, json)? as usize;
    let bytes = gear.buffers.get(json.buffer.value()).unwrap_or_default();
    Ok(bytes.get(start..start + json.byte_length.0 as usize).unwrap_or_default().to_vec())
}

/// Checks the replacements of a sparse accessor of `total` items. The crate would ignore those out
/// of order.
fn check_sparse(
    gear: &mut Gear<'_>,
    index: usize,
    sparse: &Sparse,
    total: u64,
    size: u64,
) -> Result<()> {
    let count = sparse.count.0;
    let Valid(kind) = &sparse.indices.component_type else {
        return Err(bad(gear, index, "is sparse, with indices of an unknown type"));
    };
    if count == 0 || count > total {
        return Err(bad(gear, index, "is sparse, with a wrong count"));
    }
    let values = ByteRange { offset: sparse.values.byte_offset.0, count, size };
    check_span(gear, index, sparse.values.buffer_view, values)?;
    let (offset, size) = (sparse.indices.byte_offset.0, kind.0.size() as u64);
    let span = ByteRange { offset, count, size };
    let (view, stride) = check_span(gear, index, sparse.indices.buffer_view, span)?;
    let start = view.byte_offset.unwrap_or_default().0 + offset;
    let bytes = gear.buffers.get(view.buffer.value()).unwrap_or_default();
    let mut least = 0;
    for i in 0..count {
        // The index is in range, because the range has been checked.
        let at = (start + i * stride) as usize;
        let item = bytes.get(at..at + size as usize).unwrap_or_default();
        let target = item.iter().rev().fold(0, |n, &byte| n << 8 | u64::from(byte));
        if target < least || target >= total {
            return Err(bad(gear, index, "is sparse, with indices out of order or range"));
        }
        least = target + 1;
    }
    Ok(())
}

fn bad(gear: &Gear<'_>, index: usize, what: &str) -> Error {
    let what = format!("has an accessor that {what}");
    let error = Error::new(gear.buffers.path, what, EXPORT_AGAIN);
    error.at(Location::Element("accessor", index as u64))
}
