//! Random damage to a file.

/// Marsaglia's xorshift64.
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % end.max(1) as u64) as usize
    }
}

/// Bytes that have a meaning in some format.
const TELLING: &[u8] = b"\0\x01\x7f\x80\xff\n\r \t-+.0159eEvf/#\\\"{}[],:";

/// Damages a file in one to five places.
pub fn damage(file: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..=random.below(4) {
        let at = random.below(file.len());
        let byte = TELLING[random.below(TELLING.len())];
        match (random.below(6), file.get_mut(at)) {
            (0, Some(old)) => *old ^= 1 << random.below(8),
            (1 | 2, Some(old)) => *old = byte,
            (3, Some(_)) => drop(file.remove(at)),
            (4, _) => file.insert(at, byte),
            (_, Some(_)) if random.below(4) == 0 => file.truncate(at),
            // A part of the file is repeated elsewhere.
            _ => {
                let end = file.len().min(at + random.below(24));
                let piece = file[at..end].to_vec();
                let to = random.below(file.len());
                file.splice(to..to, piece);
            }
        }
    }
}
