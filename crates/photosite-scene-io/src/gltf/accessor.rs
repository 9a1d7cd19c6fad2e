//! Typed reading of accessors. Every index, offset and count is checked against the bytes that are there before
//! anything is allocated.

use gltf::json::accessor::{ComponentType, GenericComponentType, IndexComponentType, Type, sparse};
use gltf::json::validation::{Checked, USize64};
use gltf::json::{Accessor, Root};

use super::buffers::{Buffers, out_of_range};
use super::unpacked::Unpacked;
use photosite_core::Invalid;

/// Largest accessor without bytes of its own (all zeros but for its sparse part). Such an accessor costs memory that
/// the file does not back, so its size is bounded.
pub(super) const MAX_ZEROS: usize = 1 << 24;

/// Reader of a document's accessors.
#[derive(Clone, Copy)]
pub(super) struct Accessors<'a> {
    pub(super) root: &'a Root,
    pub(super) buffers: &'a Buffers,
    /// Values unpacked from a Draco stream, which replace those of a primitive's accessors.
    pub(super) unpacked: Option<&'a Unpacked>,
}

/// Kind of an accessor's values.
pub(super) struct Kind {
    /// Number of components of an element.
    pub(super) width: usize,
    /// Divisor of a normalised integer.
    pub(super) largest: Option<f32>,
    pub(super) count: u64,
}

/// Elements of one kind, evenly spaced in bytes that hold them all.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
    component: ComponentType,
    normalized: bool,
}

impl Elements<'_> {
    fn component(&self, element: usize, component: usize) -> &[u8] {
        &self.bytes[element * self.stride + component * self.component.size()..]
    }

    /// A component as a real number; normalised integers are converted as in §3.6.2.2 of the specification.
    fn float(&self, element: usize, component: usize) -> f32 {
        let b = self.component(element, component);
        let value = match self.component {
            ComponentType::I8 => f32::from(b[0] as i8),
            ComponentType::U8 => f32::from(b[0]),
            ComponentType::I16 => f32::from(i16::from_le_bytes([b[0], b[1]])),
            ComponentType::U16 => f32::from(u16::from_le_bytes([b[0], b[1]])),
            ComponentType::U32 => u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32,
            ComponentType::F32 => f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        };
        match largest(self.component).filter(|_| self.normalized) {
            Some(largest) => (value / largest).max(-1.0),
            None => value,
        }
    }

    fn index(&self, element: usize) -> u32 {
        let b = self.component(element, 0);
        match self.component {
            ComponentType::I8 | ComponentType::U8 => u32::from(b[0]),
            ComponentType::I16 | ComponentType::U16 => u32::from(u16::from_le_bytes([b[0], b[1]])),
            ComponentType::U32 | ComponentType::F32 => u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        }
    }
}

impl<'a> Accessors<'a> {
    /// Reads vectors of `N` real numbers. `key` names what refers to the accessor.
    pub(super) fn floats<const N: usize>(&self, index: usize, key: &str) -> Result<Vec<[f32; N]>, Invalid> {
        let (accessor, accessor_key) = self.find(index, key)?;
        let (component, kind) = types(accessor, &accessor_key)?;
        if kind.multiplicity() != N || matches!(kind, Type::Mat2) || component == ComponentType::U32 {
            let wanted = match N {
                1 => "SCALAR",
                2 => "VEC2",
                3 => "VEC3",
                4 => "VEC4",
                _ => "MAT4",
            };
            let message =
                format!("{key} needs {wanted} of floats or of 8- or 16-bit integers, found {kind:?} of {component:?}");
            return Err(Invalid::new(accessor_key, message));
        }
        if let Some(values) = self.unpacked.and_then(|unpacked| unpacked.values(index)) {
            return Ok(values);
        }
        let read = |elements: &Elements<'_>, i| std::array::from_fn(|c| elements.float(i, c));
        let mut values = match self.elements(accessor, N, component, &accessor_key)? {
            Some(elements) => (0..elements.count).map(|i| read(&elements, i)).collect(),
            None => vec![[0.0; N]; zeros(accessor, &accessor_key)?],
        };
        if let Some(sparse) = &accessor.sparse {
            self.apply_sparse(sparse, N, component, accessor.normalized, &accessor_key, &mut values, read)?;
        }
        Ok(values)
    }

    /// Kind of an accessor's values.
    pub(super) fn kind(&self, index: usize, key: &str) -> Result<Kind, Invalid> {
        let (accessor, accessor_key) = self.find(index, key)?;
        let (component, kind) = types(accessor, &accessor_key)?;
        let largest = largest(component).filter(|_| accessor.normalized);
        Ok(Kind { width: kind.multiplicity(), largest, count: accessor.count.0 })
    }

    /// Reads vertex indices.
    pub(super) fn indices(&self, index: usize, key: &str) -> Result<Vec<u32>, Invalid> {
        let (accessor, accessor_key) = self.find(index, key)?;
        let (component, kind) = types(accessor, &accessor_key)?;
        let unsigned = matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32);
        if kind != Type::Scalar || !unsigned {
            let message = format!("{key} needs SCALAR of unsigned integers, found {kind:?} of {component:?}");
            return Err(Invalid::new(accessor_key, message));
        }
        let read = |elements: &Elements<'_>, i| elements.index(i);
        let mut values = match self.elements(accessor, 1, component, &accessor_key)? {
            Some(elements) => (0..elements.count).map(|i| read(&elements, i)).collect(),
            None => vec![0; zeros(accessor, &accessor_key)?],
        };
        if let Some(sparse) = &accessor.sparse {
            self.apply_sparse(sparse, 1, component, false, &accessor_key, &mut values, read)?;
        }
        Ok(values)
    }

    fn find(&self, index: usize, key: &str) -> Result<(&'a Accessor, String), Invalid> {
        let all = &self.root.accessors;
        let accessor = all.get(index).ok_or_else(|| out_of_range(key, "accessors", index, all.len()))?;
        Ok((accessor, format!("accessors[{index}]")))
    }

    /// The elements of an accessor that has bytes.
    fn elements(
        &self,
        accessor: &Accessor,
        width: usize,
        component: ComponentType,
        key: &str,
    ) -> Result<Option<Elements<'a>>, Invalid> {
        let Some(view) = accessor.buffer_view else { return Ok(None) };
        let (bytes, view) = self.buffers.view(self.root, view.value(), &format!("{key}.bufferView"))?;
        let stride = view.byte_stride.map_or(width * component.size(), |s| s.0);
        let offset = accessor.byte_offset.unwrap_or_default();
        let (bytes, count) = slice(bytes, offset, accessor.count, stride, width * component.size(), key)?;
        Ok(Some(Elements { bytes, stride, count, component, normalized: accessor.normalized }))
    }

    /// Replaces the elements that the sparse part of an accessor gives.
    #[allow(clippy::too_many_arguments, reason = "where the indices and the values lie, each with its type and name")]
    fn apply_sparse<T>(
        &self,
        sparse: &sparse::Sparse,
        width: usize,
        component: ComponentType,
        normalized: bool,
        key: &str,
        values: &mut [T],
        read: impl Fn(&Elements<'_>, usize) -> T,
    ) -> Result<(), Invalid> {
        let indices_key = format!("{key}.sparse.indices");
        let Checked::Valid(IndexComponentType(index_component)) = sparse.indices.component_type else {
            return Err(Invalid::new(format!("{indices_key}.componentType"), "is not an unsigned integer type"));
        };
        let (bytes, _) = self.buffers.view(self.root, sparse.indices.buffer_view.value(), &indices_key)?;
        let size = index_component.size();
        let (bytes, count) = slice(bytes, sparse.indices.byte_offset, sparse.count, size, size, &indices_key)?;
        let targets = Elements { bytes, stride: size, count, component: index_component, normalized: false };

        let values_key = format!("{key}.sparse.values");
        let (bytes, _) = self.buffers.view(self.root, sparse.values.buffer_view.value(), &values_key)?;
        let size = width * component.size();
        let (bytes, _) = slice(bytes, sparse.values.byte_offset, sparse.count, size, size, &values_key)?;
        let replacements = Elements { bytes, stride: size, count, component, normalized };

        let len = values.len();
        for i in 0..count {
            let target = targets.index(i);
            let place = values.get_mut(target as usize).ok_or_else(|| {
                Invalid::new(&*indices_key, format!("entry {i} replaces element {target} of only {len}"))
            })?;
            *place = read(&replacements, i);
        }
        Ok(())
    }
}

/// Divisor of a normalised integer; `None` of real numbers.
fn largest(component: ComponentType) -> Option<f32> {
    match component {
        ComponentType::I8 => Some(127.0),
        ComponentType::U8 => Some(255.0),
        ComponentType::I16 => Some(32767.0),
        ComponentType::U16 => Some(65535.0),
        ComponentType::U32 => Some(u32::MAX as f32),
        ComponentType::F32 => None,
    }
}

/// Component and element type, both checked.
fn types(accessor: &Accessor, key: &str) -> Result<(ComponentType, Type), Invalid> {
    let Checked::Valid(GenericComponentType(component)) = accessor.component_type else {
        return Err(Invalid::new(format!("{key}.componentType"), "is unknown")
            .help("write 5120, 5121, 5122, 5123, 5125 or 5126"));
    };
    let Checked::Valid(kind) = accessor.type_ else {
        return Err(Invalid::new(format!("{key}.type"), "is unknown")
            .help("write SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4"));
    };
    Ok((component, kind))
}

/// Number of elements of an accessor without bytes.
fn zeros(accessor: &Accessor, key: &str) -> Result<usize, Invalid> {
    usize::try_from(accessor.count.0).ok().filter(|&n| n <= MAX_ZEROS).ok_or_else(|| {
        Invalid::new(format!("{key}.count"), format!("{} elements without a bufferView are too many", accessor.count.0))
            .help(format!("at most {MAX_ZEROS} can be left to be zero"))
    })
}

/// Part of `bytes` from `offset` on, checked to hold `count` elements of `size` bytes, `stride` bytes apart.
fn slice<'a>(
    bytes: &'a [u8],
    offset: USize64,
    count: USize64,
    stride: usize,
    size: usize,
    key: &str,
) -> Result<(&'a [u8], usize), Invalid> {
    if stride < size {
        let message = format!("elements of {size} bytes are stored {stride} bytes apart, so they overlap");
        return Err(Invalid::new(key, message));
    }
    let needed = match count.0 {
        0 => Some(0),
        n => (n - 1).checked_mul(stride as u64).and_then(|b| b.checked_add(size as u64)),
    };
    let end = needed.and_then(|needed| needed.checked_add(offset.0));
    match end {
        Some(end) if end <= bytes.len() as u64 => Ok((&bytes[offset.0 as usize..], count.0 as usize)),
        Some(_) | None => {
            let message = format!(
                "{} elements of {size} bytes, {stride} bytes apart, from byte {} reach beyond the {} bytes of the buffer view",
                count.0,
                offset.0,
                bytes.len()
            );
            Err(Invalid::new(key, message))
        }
    }
}
