//! The floor of the back end: block set-up, addresses and one read of 16 bytes a row, without the filter's arithmetic.

use lanes::{Simd, Task};
use rtl_model::Texture;
use rtl_model::stages::filter;
use rtl_model::texture::Texels;

/// Footprints that are addressed at a time.
const WIDTH: usize = 8;

/// A fragment's probe line in the default unit's formats.
pub(crate) struct Request {
    face: usize,
    center: [i64; 2],
    step: [i64; 2],
    /// Probes.
    pub(crate) count: i64,
    lod: i64,
}

impl Request {
    /// From the unit's own request.
    pub(crate) fn new(r: &filter::In) -> Self {
        let line = &r.line;
        Self {
            face: line.face,
            center: line.center,
            step: line.step,
            count: line.count,
            lod: r.lod,
        }
    }
}

/// Reads what requests read and folds it together.
pub(crate) struct Floor<'a> {
    /// Packed halves.
    pub(crate) texture: &'a Texture,
    /// The requests, one after the other.
    pub(crate) requests: &'a [Request],
}

impl Task for Floor<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> u64 {
        let Texels::Half(texels) = &self.texture.texels else { return 0 };
        let levels = &self.texture.levels;
        let last = levels.len() - 1;
        let mut fold = [0u64; 2];
        for r in self.requests {
            let first = ((r.lod >> 8) as usize).min(last);
            let two = usize::from(r.lod & 255 != 0 && first < last);
            let pair = [&levels[first], &levels[first + two]];
            let size = [pair[0].size[0] as u64, pair[1].size[0] as u64];
            let stride = [pair[0].stride as u64, pair[1].stride as u64];
            let base = [pair[0].index(r.face, 0, 0) as u64, pair[1].index(r.face, 0, 0) as u64];
            let mut start = [0; 2];
            for i in 0..2 {
                start[i] = r.center[i] + (1 << 24) - (r.count - 1) * r.step[i];
            }
            let mut k = 0;
            while k < r.count {
                let mut at = [0u64; WIDTH];
                for lane in 0..WIDTH {
                    let (probe, level) = (k + (lane >> two) as i64, lane & two);
                    // u + 1 and v + 1, kept on the face; a texel coordinate of the bordered face from them.
                    let mut st = [0; 2];
                    for i in 0..2 {
                        let uv = (start[i] + 2 * probe * r.step[i]).clamp(0, 2 << 24) as u64;
                        st[i] = (uv * size[level] + (1 << 24)) >> 25;
                    }
                    at[lane] = base[level] + st[1] * stride[level] + st[0];
                }
                let used = (((r.count - k) as usize) << two).min(WIDTH);
                for lane in 0..used {
                    for row in [0, stride[lane & two]] {
                        let row = (at[lane] + row) as usize;
                        if let Some([a, b]) = texels.get(row..).and_then(|t| t.first_chunk()) {
                            fold[0] ^= a;
                            fold[1] ^= b;
                        }
                    }
                }
                k += (WIDTH >> two) as i64;
            }
        }
        fold[0] ^ fold[1]
    }
}
