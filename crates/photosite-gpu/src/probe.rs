//! Kernels of one's own on the tables of a scene: what tests ask of the functions that the wavefront is made of.

use photosite_core::Invalid;
use photosite_develop::EncodedImage;
use photosite_develop::packed::PackedDevelopment;
use photosite_sensor::packed::{PackedExposure, PackedLight};
use photosite_transport::integrator::PathLimits;
use photosite_transport::sampler::SamplerKind;
use photosite_transport::scene::packed::PackedScene;
use wgpu::util::DeviceExt;

use crate::adapters::Card;
use crate::buffers::{Layouts, READ, WRITE, bind, layout, scene_buffers};
use crate::expose::kernel::{facts_layout, random_tables_buffer};
use crate::expose::shaders as exposure_shaders;
use crate::params;
use crate::shaders::functions;

/// Runs the WGSL function `answer(words: array<vec4<u32>, IN>) -> array<vec4<u32>, OUT>` for each of some inputs, on the
/// tables of a scene.
///
/// # Errors
///
/// Tables that the card has no room for, and words of the driver on the text.
pub fn answers<const IN: usize, const OUT: usize>(
    card: &Card,
    scene: &PackedScene,
    sampler: SamplerKind,
    text: &str,
    inputs: &[[[u32; 4]; IN]],
) -> Result<Vec<[[u32; 4]; OUT]>, Invalid> {
    let device = card.device();
    let limits = PathLimits { max_depth: 1, roulette_depth: 1, splitting: 1 };
    let numbers = params::values(&params::Row { scene, limits, sampler, capacity: 1 });
    let numbers = filled(device, bytemuck::cast_slice(&numbers), wgpu::BufferUsages::UNIFORM);
    let tables = scene_buffers(device, scene, &device.limits())?;
    let of_scene: Vec<&wgpu::Buffer> = std::iter::once(&numbers).chain(&tables).collect();
    let scene_layout = Layouts::new(device).scene;
    let of_scene = bind(device, &scene_layout, &of_scene);
    ask(card, &(functions(scene.features) + text), (&scene_layout, &of_scene), inputs)
}

/// Runs such a function with the facts of an exposure and its light.
///
/// # Errors
///
/// Words of the driver on the text.
pub fn exposure_answers<const IN: usize, const OUT: usize>(
    card: &Card,
    exposure: &PackedExposure<'_>,
    light: &PackedLight,
    text: &str,
    inputs: &[[[u32; 4]; IN]],
) -> Result<Vec<[[u32; 4]; OUT]>, Invalid> {
    let device = card.device();
    let storage = |words: &[u32]| {
        filled(device, bytemuck::cast_slice(if words.is_empty() { &[0] } else { words }), wgpu::BufferUsages::STORAGE)
    };
    let electrons: Vec<u32> = light.electrons().iter().map(|e| e.to_bits()).collect();
    let facts = [exposure.words(), exposure.tables(), &electrons].map(storage);
    let facts_layout = facts_layout(device);
    let facts = bind(device, &facts_layout, &[&facts[0], &facts[1], &random_tables_buffer(device), &facts[2]]);
    ask(card, &(exposure_shaders::functions() + text), (&facts_layout, &facts), inputs)
}

fn filled(device: &wgpu::Device, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
}

/// Runs the function `answer` of a text with these facts.
fn ask<const IN: usize, const OUT: usize>(
    card: &Card,
    text: &str,
    (facts_layout, facts): (&wgpu::BindGroupLayout, &wgpu::BindGroup),
    inputs: &[[[u32; 4]; IN]],
) -> Result<Vec<[[u32; 4]; OUT]>, Invalid> {
    let (device, queue) = (card.device(), card.queue());
    let text = format!(
        "{text}
        @group(1) @binding(0) var<storage, read> inputs: array<array<vec4<u32>, {IN}>>;
        @group(1) @binding(1) var<storage, read_write> outputs: array<array<vec4<u32>, {OUT}>>;
        @compute @workgroup_size(64) fn ask(@builtin(global_invocation_id) id: vec3<u32>) {{
            if (id.x < arrayLength(&inputs)) {{ outputs[id.x] = answer(inputs[id.x]); }}
        }}"
    );
    let own = layout(device, &[READ, WRITE]);
    let asked = filled(device, bytemuck::cast_slice(inputs), wgpu::BufferUsages::STORAGE);
    let bytes = (inputs.len() * OUT * 16) as u64;
    let buffer = |usage: wgpu::BufferUsages| {
        device.create_buffer(&wgpu::BufferDescriptor { label: None, size: bytes, usage, mapped_at_creation: false })
    };
    let answered = buffer(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
    let returned = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
    let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(text.into()),
    });
    let groups = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(facts_layout), Some(&own)],
        immediate_size: 0,
    });
    let kernel = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: Some(&groups),
        module: &module,
        entry_point: Some("ask"),
        compilation_options: Default::default(),
        cache: None,
    });
    if let Some(error) = pollster::block_on(scope.pop()) {
        return Err(Invalid::new("", error.to_string()));
    }
    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&kernel);
        pass.set_bind_group(0, facts, &[]);
        pass.set_bind_group(1, &bind(device, &own, &[&asked, &answered]), &[]);
        pass.dispatch_workgroups((inputs.len() as u32).div_ceil(64), 1, 1);
    }
    encoder.copy_buffer_to_buffer(&answered, 0, &returned, 0, bytes);
    queue.submit([encoder.finish()]);
    returned.map_async(wgpu::MapMode::Read, .., |_| {});
    let failed = |words: String| Invalid::new("", words);
    device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| failed(error.to_string()))?;
    let view = returned.get_mapped_range(..).map_err(|error| failed(error.to_string()))?;
    Ok(bytemuck::pod_collect_to_vec(view.as_ref()))
}

/// Develops raw numbers in strips of so many pixels at most.
///
/// # Errors
///
/// Errors of [`Card::develop`].
pub fn develop_in_strips(
    card: &Card,
    numbers: &[u16],
    development: &PackedDevelopment,
    strip_pixels: usize,
) -> Result<EncodedImage, Invalid> {
    card.develop_numbers(numbers, development, strip_pixels)
}
