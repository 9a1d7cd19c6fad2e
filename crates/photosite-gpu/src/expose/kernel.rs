//! The kernel of an exposure, compiled once for a card.

use std::sync::{Arc, OnceLock};

use photosite_sensor::packed::random_tables;
use wgpu::util::DeviceExt;

use crate::buffers::{READ, WRITE, layout};
use crate::expose::shaders::exposure;

/// Kernel of a device, once it is compiled, or the words of a driver that refuses it.
#[derive(Default)]
pub(crate) struct ExposureCache(OnceLock<Result<Arc<ExposureKernel>, String>>);

impl ExposureCache {
    /// The kernel; it is compiled once.
    ///
    /// # Errors
    ///
    /// Words of the driver on a kernel that it refuses.
    pub(crate) fn get(&self, device: &wgpu::Device) -> Result<Arc<ExposureKernel>, String> {
        let compile = || {
            let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
            let kernel = Arc::new(ExposureKernel::new(device));
            pollster::block_on(scope.pop()).map_or(Ok(kernel), |error| Err(error.to_string()))
        };
        self.0.get_or_init(compile).clone()
    }
}

/// The kernel, the layouts of what it reads and writes, and the tables of its random numbers.
pub(crate) struct ExposureKernel {
    /// Words and tables of an exposure, tables of random numbers, light.
    pub(crate) facts: wgpu::BindGroupLayout,
    /// Digital numbers, and the strip of rows.
    pub(crate) rows: wgpu::BindGroupLayout,
    pub(crate) random_tables: wgpu::Buffer,
    pub(crate) pipeline: wgpu::ComputePipeline,
}

/// Layout of the facts of an exposure.
pub(crate) fn facts_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    layout(device, &[READ; 4])
}

/// Tables of random numbers on a card.
pub(crate) fn random_tables_buffer(device: &wgpu::Device) -> wgpu::Buffer {
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("random tables"),
        contents: bytemuck::cast_slice(&random_tables()),
        usage: wgpu::BufferUsages::STORAGE,
    })
}

impl ExposureKernel {
    fn new(device: &wgpu::Device) -> Self {
        let facts = facts_layout(device);
        let rows = layout(device, &[WRITE, wgpu::BufferBindingType::Uniform]);
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("exposure"),
            source: wgpu::ShaderSource::Wgsl(exposure().into()),
        });
        let groups = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&facts), Some(&rows)],
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("expose"),
            layout: Some(&groups),
            module: &module,
            entry_point: Some("expose"),
            compilation_options: Default::default(),
            cache: None,
        });
        Self { facts, rows, random_tables: random_tables_buffer(device), pipeline }
    }
}
