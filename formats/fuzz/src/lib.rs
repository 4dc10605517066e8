//! What the fuzzers share with the tests of the readers.

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
