//! The numbers of glTF accessors: dense or sparse, floats or integers, every range checked.

use std::borrow::Cow;
use std::cell::Cell;

use gltf::accessor::sparse::IndexType;
use gltf::accessor::{DataType, Dimensions};

use super::MAX_TRIANGLES;
use crate::base::num;
use crate::error::InputError;

/// Most vertices of a file, instances repeated.
pub(super) const MAX_VERTICES: usize = 3 * MAX_TRIANGLES;

/// Most entries that are read, so that a small file cannot ask for hours.
const MAX_ENTRIES: usize = 16 * MAX_VERTICES;

/// The buffers of a file and its name.
pub(super) struct Reader<'a> {
    pub(super) subject: &'a str,
    pub(super) buffers: Vec<Cow<'a, [u8]>>,
    /// Entries read so far.
    pub(super) read: Cell<usize>,
}

impl Reader<'_> {
    pub(super) fn error(&self, place: String, expected: &str, found: String) -> InputError {
        InputError::new(self.subject, expected, found, "export the mesh again").at(place)
    }

    /// So many entries of `size` bytes in a view.
    fn slice(
        &self,
        view: &gltf::buffer::View<'_>,
        offset: usize,
        [count, size, stride]: [usize; 3],
    ) -> Option<&[u8]> {
        if stride < size || count == 0 {
            return None;
        }
        let data = self.buffers.get(view.buffer().index())?;
        let inside = (count - 1).checked_mul(stride)?.checked_add(size)?;
        if offset.checked_add(inside)? > view.length()
            || view.offset().checked_add(view.length())? > data.len()
        {
            return None;
        }
        let start = view.offset().checked_add(offset)?;
        data.get(start..start.checked_add(inside)?)
    }

    /// The bytes of all entries, `size` bytes each.
    fn bytes(
        &self,
        accessor: &gltf::Accessor<'_>,
        size: usize,
        place: &str,
    ) -> Result<Vec<u8>, InputError> {
        let place = format!("{place} (accessors[{}])", accessor.index());
        let count = accessor.count();
        let read = self.read.get().saturating_add(count);
        self.read.set(read);
        let outside = |view: &gltf::buffer::View<'_>, count: usize, offset: usize| {
            let buffer = self.buffers.get(view.buffer().index()).map_or(0, |b| b.len());
            let found = format!(
                "{count} entries at {offset} in a view of {} at {} of {buffer} bytes",
                view.length(),
                view.offset(),
            );
            self.error(place.clone(), "entries inside the buffer", found)
        };
        let mut out = match accessor.view() {
            Some(view) => {
                let shape = [count, size, view.stride().unwrap_or(size)];
                let bytes = self
                    .slice(&view, accessor.offset(), shape)
                    .ok_or_else(|| outside(&view, count, accessor.offset()))?;
                if read > MAX_ENTRIES {
                    let expected = format!("at most {MAX_ENTRIES} entries in all");
                    return Err(self.error(place, &expected, "more".into()));
                }
                bytes.chunks(shape[2]).flat_map(|chunk| &chunk[..size]).copied().collect()
            }
            // A sparse accessor may start from zeros.
            None if accessor.sparse().is_some() && count <= MAX_VERTICES && read <= MAX_ENTRIES => {
                vec![0; count * size]
            }
            None => {
                let found = "none (compressed data has none)".into();
                return Err(self.error(place, "a bufferView", found));
            }
        };
        let Some(sparse) = accessor.sparse() else { return Ok(out) };
        let (indices, values, number) = (sparse.indices(), sparse.values(), sparse.count());
        let width = match indices.index_type() {
            IndexType::U8 => 1,
            IndexType::U16 => 2,
            IndexType::U32 => 4,
        };
        let at = self
            .slice(&indices.view(), indices.offset(), [number, width, width])
            .ok_or_else(|| outside(&indices.view(), number, indices.offset()))?;
        let new = self
            .slice(&values.view(), values.offset(), [number, size, size])
            .ok_or_else(|| outside(&values.view(), number, values.offset()))?;
        for (at, new) in at.chunks_exact(width).zip(new.chunks_exact(size)) {
            let index = unsigned(at) as usize;
            let slot = index.checked_mul(size).and_then(|from| out.get_mut(from..from + size));
            let Some(slot) = slot else {
                let expected = format!("sparse indices below {count}");
                return Err(self.error(place, &expected, index.to_string()));
            };
            slot.copy_from_slice(new);
        }
        Ok(out)
    }

    /// Vectors of floats, or of integers: normalised where the accessor says so.
    pub(super) fn floats<const N: usize>(
        &self,
        accessor: &gltf::Accessor<'_>,
        place: &str,
    ) -> Result<Vec<[f64; N]>, InputError> {
        let dimensions = match N {
            2 => Dimensions::Vec2,
            3 => Dimensions::Vec3,
            4 => Dimensions::Vec4,
            _ => Dimensions::Mat4,
        };
        let kind = accessor.data_type();
        let width = kind.size();
        if kind == DataType::U32 || accessor.dimensions() != dimensions {
            let found = format!("{:?} of {:?}", accessor.dimensions(), kind);
            return Err(self.error(place.to_string(), &format!("{dimensions:?} of floats"), found));
        }
        let scale = |most: f64| if accessor.normalized() { most } else { 1.0 };
        // The lowest code stands for −1, too.
        let signed = |n: i16, most: f64| {
            if accessor.normalized() { (f64::from(n) / most).max(-1.0) } else { f64::from(n) }
        };
        let number = |b: &[u8]| match (kind, b) {
            (DataType::F32, [a, b, c, d]) => f64::from(f32::from_le_bytes([*a, *b, *c, *d])),
            (DataType::U16, [a, b]) => f64::from(u16::from_le_bytes([*a, *b])) / scale(65535.0),
            (DataType::I16, [a, b]) => signed(i16::from_le_bytes([*a, *b]), 32767.0),
            (DataType::U8, [a]) => f64::from(*a) / scale(255.0),
            (DataType::I8, [a]) => signed(i16::from(i8::from_le_bytes([*a])), 127.0),
            _ => f64::NAN,
        };
        let bytes = self.bytes(accessor, N * width, place)?;
        Ok(bytes
            .chunks_exact(N * width)
            .map(|entry| std::array::from_fn(|i| number(&entry[i * width..(i + 1) * width])))
            .collect())
    }

    /// Unsigned integers, `N` an entry.
    pub(super) fn unsigned<const N: usize>(
        &self,
        accessor: &gltf::Accessor<'_>,
        place: &str,
    ) -> Result<Vec<[u32; N]>, InputError> {
        let dimensions = if N == 1 { Dimensions::Scalar } else { Dimensions::Vec4 };
        let kind = accessor.data_type();
        let whole = matches!(kind, DataType::U8 | DataType::U16 | DataType::U32);
        if !whole || accessor.dimensions() != dimensions {
            let found = format!("{:?} of {:?}", accessor.dimensions(), kind);
            return Err(self.error(place.to_string(), "unsigned integers", found));
        }
        let width = kind.size();
        let bytes = self.bytes(accessor, N * width, place)?;
        Ok(bytes
            .chunks_exact(N * width)
            .map(|entry| std::array::from_fn(|i| unsigned(&entry[i * width..(i + 1) * width])))
            .collect())
    }
}

/// A little-endian number of one, two or four bytes.
fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |sum, b| sum << 8 | num::u32(*b))
}
