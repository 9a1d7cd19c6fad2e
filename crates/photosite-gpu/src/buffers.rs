//! Tables of a scene on a card, and how kernels find them.

use photosite_core::Invalid;
use photosite_transport::scene::packed::PackedScene;
use wgpu::util::DeviceExt;

/// Layout of tables that kernels read or write, from the number 0 on.
pub(crate) fn layout(device: &wgpu::Device, tables: &[wgpu::BufferBindingType]) -> wgpu::BindGroupLayout {
    let entry = |(binding, &ty): (u32, &wgpu::BufferBindingType)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    };
    let entries: Vec<_> = (0..).zip(tables).map(entry).collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries })
}

pub(crate) fn bind(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    buffers: &[&wgpu::Buffer],
) -> wgpu::BindGroup {
    let bindings = buffers.iter().map(|buffer| buffer.as_entire_binding());
    let entries: Vec<_> =
        (0..).zip(bindings).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

pub(crate) const READ: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: true };
pub(crate) const WRITE: wgpu::BufferBindingType = wgpu::BufferBindingType::Storage { read_only: false };

/// Layouts of the groups: the scene, the paths, the workgroups that are counted, the film.
pub(crate) struct Layouts {
    pub(crate) scene: wgpu::BindGroupLayout,
    pub(crate) paths: wgpu::BindGroupLayout,
    pub(crate) counted: wgpu::BindGroupLayout,
    pub(crate) film: wgpu::BindGroupLayout,
}

impl Layouts {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        Self {
            scene: layout(device, &[wgpu::BufferBindingType::Uniform, READ, READ, READ, READ, READ, READ]),
            paths: layout(device, &[WRITE, WRITE, WRITE, READ, WRITE]),
            counted: layout(device, &[WRITE]),
            film: layout(device, &[wgpu::BufferBindingType::Uniform, READ]),
        }
    }
}

/// Largest table that kernels of a device read or write, bytes.
pub(crate) fn largest_table(limits: &wgpu::Limits) -> u64 {
    limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
}

/// Makes buffers, and groups of them, where the device has room for them.
///
/// # Errors
///
/// Words of the driver on why it has none.
pub(crate) fn in_room<T>(device: &wgpu::Device, make: impl FnOnce() -> T) -> Result<T, String> {
    // A buffer for which there is no memory is no valid part of a group either.
    let scopes = [wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Validation].map(|of| device.push_error_scope(of));
    let made = make();
    let [memory, validity] = scopes;
    // The last scope ends first
    let [invalid, missing] = [validity, memory].map(|scope| pollster::block_on(scope.pop()));
    missing.or(invalid).map_or(Ok(made), |error| Err(error.to_string()))
}

/// Tables of a scene on the card, each with a word at least, since none may be empty.
pub(crate) fn scene_buffers(
    device: &wgpu::Device,
    scene: &PackedScene,
    limits: &wgpu::Limits,
) -> Result<Vec<wgpu::Buffer>, Invalid> {
    let tables: [(&str, &[u8]); 6] = [
        ("nodes of its hierarchy", bytemuck::cast_slice(&scene.nodes)),
        ("triangles", bytemuck::cast_slice(&scene.triangles)),
        ("tables", bytemuck::cast_slice(&scene.tables)),
        ("vertices", bytemuck::cast_slice(&scene.attributes)),
        ("spectra", bytemuck::cast_slice(&scene.spectra)),
        ("textures", bytemuck::cast_slice(&scene.texels)),
    ];
    let most = largest_table(limits);
    let buffer = |(what, bytes): (&str, &[u8])| {
        if bytes.len() as u64 > most {
            let message = format!("its {what} take {} bytes, and {most} are the most on this device", bytes.len());
            return Err(Invalid::new("scene", message).help("render with --device cpu"));
        }
        let contents = if bytes.is_empty() { &[0; 16] } else { bytes };
        let usage = wgpu::BufferUsages::STORAGE;
        Ok(device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(what), contents, usage }))
    };
    tables.into_iter().map(buffer).collect()
}
