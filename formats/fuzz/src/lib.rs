//! What the fuzzers share with the tests of the readers.

#[path = "../../tests/points/seeds.rs"]
pub mod cloud_seeds;
#[path = "../../tests/memory/peak.rs"]
mod peak;
#[path = "../../tests/read/seeds.rs"]
pub mod seeds;

/// Reads `content` as the file `name`.
///
/// # Panics
/// The reader panics, breaks what a soup promises, or takes memory out of all
/// proportion.
pub fn check(name: &str, content: &[u8]) {
    let (peak, read) = peak::of(|| seeds::read_soundly(name, content));
    drop(read);
    assert!(peak <= (64 << 20) + 16 * content.len(), "takes {peak} bytes of memory");
}

/// Reads a 3MF file whose model is `content`. In a package its checksum would hide it from the search.
///
/// # Panics
/// Those of [`check`].
pub fn check_model(content: &[u8]) {
    let relationships = seeds::RELATIONSHIPS.as_bytes();
    let part = seeds::PART.as_bytes();
    check(
        "parts.3mf",
        &seeds::zip(&[
            ("_rels/.rels", relationships),
            ("3D/3dmodel.model", content),
            ("3D/b.model", part),
        ]),
    );
}

/// Reads `content` as the cloud of points `name`.
///
/// # Panics
/// The reader panics, breaks what a cloud promises, or takes memory out of all
/// proportion.
pub fn check_points(name: &str, content: &[u8]) {
    let (peak, read) = peak::of(|| cloud_seeds::read_soundly(name, content));
    drop(read);
    // Packed points of PCD may be 88 times as large as their file. Each byte of E57 and LAZ may
    // hold eight points.
    let is_dense = ["pcd", "e57", "laz"].iter().any(|end| name.ends_with(end));
    let per_byte = if is_dense { 400 } else { 16 };
    assert!(peak <= (64 << 20) + per_byte * content.len(), "takes {peak} bytes of memory");
}

/// Lets panics of the crate `laz` unwind, where libFuzzer would end the search. Its arithmetic
/// overflows and its assertions fail only in builds for debugging, and the reader makes errors of
/// them. A panic that the reader lets through still ends the search.
pub fn let_laz_panic() {
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let is_of_laz = panic.location().is_some_and(|place| place.file().contains("/laz-"));
        if !is_of_laz {
            hook(panic);
        }
    }));
}
