//! Colours of bodies for which a scene names none.

use jounce::BodyKind;

const DYNAMIC: [u32; 10] =
    [0xE76F51, 0x2A9D8F, 0xE9C46A, 0x4A7FB5, 0xB56576, 0x8AB17D, 0xF4A261, 0x6D83C4, 0x5FB3B3, 0xC98BB9];

/// Colour number `n` of a kind, sRGB in 0…1.
pub(crate) fn of(kind: BodyKind, n: usize) -> [f32; 3] {
    let hex = match kind {
        BodyKind::Fixed => 0xB8BCC4,
        BodyKind::Kinematic => 0x7A8899,
        BodyKind::Dynamic => DYNAMIC[n % DYNAMIC.len()],
    };
    [16, 8, 0].map(|shift| ((hex >> shift) & 0xFF) as f32 / 255.0)
}
