//! The hash that names a picture's exact content.

use crate::base::hash::Fnv64;
use crate::base::num;
use crate::picture::Picture;

/// Hash of a picture's exact content: size, mask and the bits of every double.
///
/// Width and height as 64-bit little-endian words, then per pixel one byte of mask (0 or 1) and
/// three doubles, little-endian. −0 and +0 differ; every NaN counts as the same one, because its
/// payload is the processor's choice.
#[must_use]
pub fn picture_hash(picture: &Picture) -> u64 {
    let mut hash = Fnv64::default();
    for extent in [picture.width, picture.height] {
        let extent = num::u64(extent);
        hash = hash.write(&extent.to_le_bytes());
    }
    for (rgb, &covered) in picture.rgb.iter().zip(&picture.covered) {
        hash = hash.write(&[u8::from(covered)]);
        for &channel in rgb {
            let value =
                if channel.is_nan() { f64::from_bits(0x7ff8_0000_0000_0000) } else { channel };
            hash = hash.write(&value.to_bits().to_le_bytes());
        }
    }
    hash.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_with_every_part_of_a_picture() {
        let mut base = Picture::new(2, 3);
        base.rgb[4] = [0.25, 0.5, 1.0];
        base.covered[4] = true;
        let mut others = vec![Picture::new(2, 3), Picture::new(3, 2)];
        for change in [
            |p: &mut Picture| p.rgb[4][1] = 0.5f64.next_up(),
            |p: &mut Picture| p.rgb[0][0] = -0.0,
            |p: &mut Picture| p.covered[4] = false,
            |p: &mut Picture| p.rgb.swap(4, 5),
        ] {
            let mut other = base.clone();
            change(&mut other);
            others.push(other);
        }
        let mut seen = vec![picture_hash(&base)];
        for other in &others {
            let hash = picture_hash(other);
            assert!(!seen.contains(&hash), "{other:?}");
            seen.push(hash);
        }
    }

    #[test]
    fn every_nan_counts_as_the_same_one() {
        let [mut a, mut b] = [Picture::new(1, 1), Picture::new(1, 1)];
        a.rgb[0][0] = f64::from_bits(0x7ff8_0000_0000_0001);
        b.rgb[0][0] = f64::from_bits(0xfff8_0000_0000_0000);
        assert_eq!(picture_hash(&a), picture_hash(&b));
    }
}
