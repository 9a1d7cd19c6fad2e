//! Kernels of development, compiled once for a card.

use photosite_develop::packed::{Demosaicking, PackedDevelopment};

use super::shaders::{DEVELOP_TILE, development};
use super::strips::Strip;
use crate::buffers::{READ, WRITE, layout};
use crate::shaders::WORKGROUP_SIZE;

/// Kernels of development, and the layout of what they read and write.
pub(crate) struct DevelopKernels {
    pub(crate) layout: wgpu::BindGroupLayout,
    signal: wgpu::ComputePipeline,
    bilinear: wgpu::ComputePipeline,
    malvar: wgpu::ComputePipeline,
    /// Steps of Menon's method in their order.
    menon: [wgpu::ComputePipeline; 7],
    encode: wgpu::ComputePipeline,
}

impl DevelopKernels {
    /// Compiles the kernels, which takes a driver a second or so.
    ///
    /// # Errors
    ///
    /// Words of the driver on kernels that it refuses.
    pub(crate) fn new(device: &wgpu::Device) -> Result<Self, String> {
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let uniform = wgpu::BufferBindingType::Uniform;
        let layout = layout(device, &[uniform, READ, READ, WRITE, WRITE, WRITE, WRITE, WRITE]);
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("development"),
            source: wgpu::ShaderSource::Wgsl(development().into()),
        });
        let groups = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let kernel = |name: &str| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(&groups),
                module: &module,
                entry_point: Some(name),
                compilation_options: Default::default(),
                cache: None,
            })
        };
        let menon = [
            "interpolate_green",
            "choose_directions",
            "chroma_at_green",
            "other_colour",
            "green_again",
            "chroma_again",
            "other_again",
        ];
        let kernels = Self {
            signal: kernel("signal"),
            bilinear: kernel("bilinear"),
            malvar: kernel("malvar"),
            menon: menon.map(kernel),
            encode: kernel("encode"),
            layout,
        };
        pollster::block_on(scope.pop()).map_or(Ok(kernels), |error| Err(error.to_string()))
    }

    /// Develops a strip of an image.
    pub(crate) fn run(&self, pass: &mut wgpu::ComputePass<'_>, strip: &Strip, of: &PackedDevelopment) {
        let [columns, rows] = strip.padded;
        let mut run = |kernel: &wgpu::ComputePipeline, threads: [usize; 2]| {
            let [x, y] = threads.map(|n| (n as u32).div_ceil(DEVELOP_TILE));
            pass.set_pipeline(kernel);
            pass.dispatch_workgroups(x, y, 1);
        };
        run(&self.signal, [columns * of.samples, rows]);
        match of.demosaicking {
            Demosaicking::Apart => {}
            Demosaicking::Bilinear(_) => run(&self.bilinear, [of.active.width, strip.rows]),
            Demosaicking::Malvar => run(&self.malvar, [of.active.width, strip.rows]),
            // Every other pixel of a row
            Demosaicking::Menon { .. } => self.menon.iter().for_each(|kernel| run(kernel, [columns.div_ceil(2), rows])),
        }
        // Four pixels each
        let quads = (strip.turned[0] * strip.turned[1]).div_ceil(4) as u32;
        pass.set_pipeline(&self.encode);
        pass.dispatch_workgroups(quads.div_ceil(WORKGROUP_SIZE), 1, 1);
    }
}
