//! Kernels of the wavefront, compiled for what the materials of a scene have.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use crate::buffers::Layouts;
use crate::shaders::wavefront;

/// Kernels for scenes of some features, once they are compiled.
type Compiled = Arc<OnceLock<Result<Arc<Kernels>, String>>>;

/// Kernels of a device by the features of scenes ([`flag`](photosite_transport::scene::packed::layers::flag)).
#[derive(Default)]
pub(crate) struct KernelCache(Mutex<HashMap<u32, Compiled>>);

impl KernelCache {
    /// Kernels for scenes of these features; they are compiled once, which takes a driver seconds.
    ///
    /// # Errors
    ///
    /// Words of the driver on kernels that it refuses.
    pub(crate) fn get(&self, device: &wgpu::Device, features: u32) -> Result<Arc<Kernels>, String> {
        let compiled = {
            let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            Arc::clone(all.entry(features).or_default())
        };
        let compile = || {
            let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
            let kernels = Arc::new(Kernels::new(device, features));
            pollster::block_on(scope.pop()).map_or(Ok(kernels), |error| Err(error.to_string()))
        };
        // Others may compile for other features meanwhile.
        compiled.get_or_init(compile).clone()
    }
}

/// Kernels of the wavefront, and the layouts of what they read and write.
pub(crate) struct Kernels {
    pub(crate) layouts: Layouts,
    pub(crate) generate: wgpu::ComputePipeline,
    pub(crate) generate_camera_rays: wgpu::ComputePipeline,
    pub(crate) extend: wgpu::ComputePipeline,
    pub(crate) shade: wgpu::ComputePipeline,
    pub(crate) shadow: wgpu::ComputePipeline,
    pub(crate) count: wgpu::ComputePipeline,
    pub(crate) arrive: wgpu::ComputePipeline,
    pub(crate) update_film: wgpu::ComputePipeline,
}

impl Kernels {
    fn new(device: &wgpu::Device, features: u32) -> Self {
        let layouts = Layouts::new(device);
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("wavefront"),
            source: wgpu::ShaderSource::Wgsl(wavefront(features).into()),
        });
        let kernel = |name: &str, groups: &[Option<&wgpu::BindGroupLayout>]| {
            let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: groups,
                immediate_size: 0,
            });
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(&layout),
                module: &module,
                entry_point: Some(name),
                compilation_options: Default::default(),
                cache: None,
            })
        };
        let of_paths = [Some(&layouts.scene), Some(&layouts.paths)];
        let of_film = [Some(&layouts.scene), Some(&layouts.paths), None, Some(&layouts.film)];
        Self {
            generate: kernel("generate", &of_paths),
            generate_camera_rays: kernel("generate_camera_rays", &of_film),
            extend: kernel("extend", &of_paths),
            shade: kernel("shade", &of_paths),
            shadow: kernel("shadow", &of_paths),
            count: kernel("count", &[Some(&layouts.scene), Some(&layouts.paths), Some(&layouts.counted)]),
            arrive: kernel("arrive", &of_paths),
            update_film: kernel("update_film", &of_film),
            layouts,
        }
    }
}
