//! The numbers that a glTF file's accessors point at: floats and whole numbers of 8 and 16 bits (`KHR_mesh_quantization`),
//! dense or sparse.

use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::View;
use gltf::{Accessor, accessor::sparse::IndexType};

/// The buffers of a file.
#[derive(Clone, Copy)]
pub struct Numbers<'a> {
    buffers: &'a [Vec<u8>],
    /// Bytes in all of them.
    held: usize,
}

impl<'a> Numbers<'a> {
    pub fn of(buffers: &'a [Vec<u8>]) -> Numbers<'a> {
        Numbers { buffers, held: buffers.iter().map(Vec::len).sum() }
    }

    /// Vectors of `N` numbers: floats, or whole numbers as they are or as shares of their largest.
    pub fn floats<const N: usize>(self, accessor: &Accessor<'_>, what: &str) -> Result<Vec<[f32; N]>, String> {
        let wanted = if N == 2 { Dimensions::Vec2 } else { Dimensions::Vec3 };
        if accessor.dimensions() != wanted {
            return Err(format!("its {what} are not {N} numbers each (accessor {})", accessor.index()));
        }
        let read = component(accessor.data_type(), accessor.normalized())
            .ok_or_else(|| format!("its {what} are neither floats nor whole numbers of 8 or 16 bits"))?;
        let size = accessor.data_type().size();
        self.elements(accessor, [0.0; N], |bytes| std::array::from_fn(|k| read(&bytes[k * size..])))
    }

    /// Places of vertices.
    pub fn indices(self, accessor: &Accessor<'_>) -> Result<Vec<u32>, String> {
        let read = match (accessor.dimensions(), accessor.data_type()) {
            (Dimensions::Scalar, DataType::U8) => whole::<1>,
            (Dimensions::Scalar, DataType::U16) => whole::<2>,
            (Dimensions::Scalar, DataType::U32) => whole::<4>,
            _ => return Err("its indices are no whole numbers of 8, 16 or 32 bits without a sign".into()),
        };
        self.elements(accessor, 0, read)
    }

    /// What an accessor holds, element by element; `nothing` where it has no view and no sparse value says otherwise.
    fn elements<T: Copy>(
        self,
        accessor: &Accessor<'_>,
        nothing: T,
        read: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, String> {
        let (at, count, size) = (accessor.index(), accessor.count(), accessor.size());
        if count == 0 {
            return Err(format!("accessor {at} has no elements"));
        }
        let mut all: Vec<T> = match accessor.view() {
            Some(view) => {
                let stride = view.stride().unwrap_or(size);
                if stride < size {
                    return Err(format!("accessor {at} has elements of {size} bytes every {stride} bytes"));
                }
                let bytes = self.run(&view, accessor.offset(), (count, stride, size), &format!("accessor {at}"))?;
                (0..count).map(|k| read(&bytes[k * stride..])).collect()
            }
            None if accessor.sparse().is_none() => return Err(format!("accessor {at} has no buffer view")),
            // All of it zero but for what follows: no larger than the file.
            None if count > self.held => {
                return Err(format!("accessor {at} has {count} elements, and the file {} bytes", self.held));
            }
            None => vec![nothing; count],
        };
        let Some(sparse) = accessor.sparse() else { return Ok(all) };
        let (places, values, changed) = (sparse.indices(), sparse.values(), sparse.count());
        let (place, width): (fn(&[u8]) -> u32, usize) = match places.index_type() {
            IndexType::U8 => (whole::<1>, 1),
            IndexType::U16 => (whole::<2>, 2),
            IndexType::U32 => (whole::<4>, 4),
        };
        if changed == 0 || changed > count {
            return Err(format!("accessor {at} has {changed} sparse values of {count}"));
        }
        let named = format!("the sparse part of accessor {at}");
        let where_to = self.run(&places.view(), places.offset(), (changed, width, width), &named)?;
        let what = self.run(&values.view(), values.offset(), (changed, size, size), &named)?;
        for k in 0..changed {
            let place = place(&where_to[k * width..]) as usize;
            *all.get_mut(place).ok_or_else(|| format!("{named} changes element {place} of {count}"))? =
                read(&what[k * size..]);
        }
        Ok(all)
    }

    /// The bytes of `count` elements of `size` bytes every `stride`, if they lie within the view, and the view in its buffer.
    fn run(
        self,
        view: &View<'_>,
        offset: usize,
        (count, stride, size): (usize, usize, usize),
        named: &str,
    ) -> Result<&'a [u8], String> {
        let end = offset as u128 + stride as u128 * (count as u128 - 1) + size as u128;
        if end > view.length() as u128 {
            return Err(format!("{named} needs {end} bytes of a buffer view that has {}", view.length()));
        }
        let buffer = self.buffers.get(view.buffer().index()).map_or(&[][..], Vec::as_slice);
        view.offset()
            .checked_add(view.length())
            .and_then(|to| buffer.get(view.offset()..to))
            .map(|bytes| &bytes[offset..end as usize])
            .ok_or_else(|| format!("buffer view {} ends beyond its buffer of {} bytes", view.index(), buffer.len()))
    }
}

/// A whole number of `N` bytes without a sign.
fn whole<const N: usize>(bytes: &[u8]) -> u32 {
    bytes[..N].iter().rev().fold(0, |number, &byte| number << 8 | u32::from(byte))
}

/// How one number of a vector is read. Shares of the largest whole number follow glTF 2.0, section 3.6.2.2.
fn component(kind: DataType, is_share: bool) -> Option<fn(&[u8]) -> f32> {
    Some(match (kind, is_share) {
        (DataType::F32, _) => |bytes| f32::from_bits(whole::<4>(bytes)),
        (DataType::I8, false) => |bytes| f32::from(bytes[0] as i8),
        (DataType::U8, false) => |bytes| f32::from(bytes[0]),
        (DataType::I16, false) => |bytes| f32::from(whole::<2>(bytes) as i16),
        (DataType::U16, false) => |bytes| whole::<2>(bytes) as f32,
        (DataType::I8, true) => |bytes| (f32::from(bytes[0] as i8) / 127.0).max(-1.0),
        (DataType::U8, true) => |bytes| f32::from(bytes[0]) / 255.0,
        (DataType::I16, true) => |bytes| (f32::from(whole::<2>(bytes) as i16) / 32_767.0).max(-1.0),
        (DataType::U16, true) => |bytes| whole::<2>(bytes) as f32 / 65_535.0,
        (DataType::U32, _) => return None,
    })
}
