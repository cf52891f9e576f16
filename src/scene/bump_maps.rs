//! The two built-in bump maps: scratched steel and water.

use super::bump::BumpMap;

/// Texels along a side of both maps.
pub const SIZE: usize = 1024;

/// placeholder
#[must_use]
pub fn scratches() -> BumpMap {
    waves()
}

/// placeholder
#[must_use]
pub fn waves() -> BumpMap {
    let values = vec![[0.0; 2]; SIZE * SIZE];
    BumpMap::from_offsets(SIZE, SIZE, &values).expect("complete")
}
