//! Hashes that name the exact content of a picture, a unit or a text: FNV-1a, 64 bits.
//!
//! They tell versions apart; they do not resist somebody who looks for collisions.
//! Source: Fowler, Noll, Vo, draft-eastlake-fnv; offset 0xcbf29ce484222325, prime 0x100000001b3.

/// A running FNV-1a hash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fnv64(u64);

impl Default for Fnv64 {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv64 {
    /// Takes in bytes.
    #[must_use]
    pub fn write(mut self, bytes: &[u8]) -> Self {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
        self
    }

    /// The hash of everything taken in so far.
    #[must_use]
    pub const fn finish(self) -> u64 {
        self.0
    }
}

/// Hash of a text, byte by byte.
#[must_use]
pub fn text_hash(text: &str) -> u64 {
    Fnv64::default().write(text.as_bytes()).finish()
}

/// The way in which hashes are printed and committed: 16 lower-case hexadecimal digits.
#[must_use]
pub fn hash_text(hash: u64) -> String {
    format!("{hash:016x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_published_vectors_of_fnv_1a() {
        for (text, hash) in [
            ("", 0xcbf2_9ce4_8422_2325),
            ("a", 0xaf63_dc4c_8601_ec8c),
            ("foobar", 0x8594_4171_f739_67e8),
        ] {
            assert_eq!(text_hash(text), hash, "{text:?}");
        }
    }

    #[test]
    fn prints_leading_zeros() {
        assert_eq!(hash_text(0xab), "00000000000000ab");
    }
}
