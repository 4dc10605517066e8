//! Checking and writing of solids with analytic surfaces.

use formats::brep::ShellId;

use crate::exact::all_exact;

#[test]
fn they_are_sound_and_have_their_volume() {
    for (brep, volume) in all_exact() {
        assert_eq!(brep.check(), Ok(()), "{}", brep.name);
        let found: f64 = (0..brep.shells.len()).map(|shell| brep.volume(ShellId(shell))).sum();
        let off = (found - volume).abs() / volume;
        assert!(off < 1e-10, "{}: {found} of {volume}, {off:.1e}", brep.name);
    }
}
