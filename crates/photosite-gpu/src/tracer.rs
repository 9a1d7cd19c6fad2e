//! A scene on a card, and batches of paths through it.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use photosite_core::Invalid;
use photosite_transport::integrator::PathLimits;
use photosite_transport::sampler::SamplerKind;
use photosite_transport::scene::packed::PackedScene;
use wgpu::util::DeviceExt;

use crate::adapters::Card;
use crate::buffers::{Layouts, bind, in_room, largest_table, scene_buffers};
use crate::kernels::Kernels;
use crate::params;
use crate::shaders::{START_WORDS, STATE_WORDS, WORKGROUP_SIZE};

/// Paths in a batch at most: enough to keep a large card busy, 240 MB of states.
const LARGEST_BATCH: u64 = 1 << 20;
/// Paths in a batch of software, which has no room for more at once.
const SOFTWARE_BATCH: u64 = 1 << 16;
/// Batches on a card at once: one is traced while another goes to and fro.
const BATCHES: usize = 2;
/// Segments that are traced between two looks at whether any path goes on.
const SEGMENTS_TOGETHER: u32 = 16;
/// Count of the numbers in `control`, see `wgsl/path.wgsl`, and the places of three of them.
const CONTROL: u64 = 9;
const ACTIVE: usize = 1;
const SURFACE_RAYS: usize = 6;
const LIGHT_RAYS: usize = 7;
/// Numbers in `control`.
pub(crate) type Control = [u32; CONTROL as usize];

/// A scene on a card, with the kernels that trace paths through it.
pub(crate) struct Tracer {
    pub(crate) device: wgpu::Device,
    queue: wgpu::Queue,
    fault: Arc<Mutex<Option<String>>>,
    pub(crate) kernels: Arc<Kernels>,
    scene: wgpu::BindGroup,
    pub(crate) max_depth: u32,
    pub(crate) capacity: u32,
    /// Batches that no thread uses, and the signal that there is one.
    idle: Mutex<Vec<Batch>>,
    is_idle: Condvar,
    pub(crate) rays: [AtomicU64; 2],
}

/// Buffers of paths that are traced together.
pub(crate) struct Batch {
    starts: wgpu::Buffer,
    control: wgpu::Buffer,
    arrivals: wgpu::Buffer,
    /// Results that come back: arrivals, then the numbers in `control`.
    returned: wgpu::Buffer,
    workgroups: wgpu::Buffer,
    paths: wgpu::BindGroup,
    counted: wgpu::BindGroup,
    /// Bytes of starts before they are sent.
    pub(crate) words: Vec<[u32; 4]>,
}

/// Kernels that paths start and end with.
pub(crate) struct Ends<'a> {
    pub(crate) first: &'a wgpu::ComputePipeline,
    pub(crate) last: &'a wgpu::ComputePipeline,
    /// Film that they read.
    pub(crate) film: Option<&'a wgpu::BindGroup>,
    /// Numbers of threads of the first and the last.
    pub(crate) threads: [u32; 2],
    /// Number of results, of 16 bytes each.
    pub(crate) results: u32,
}

impl Ends<'_> {
    fn bytes(&self) -> u64 {
        u64::from(self.results) * 16
    }
}

fn unlocked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Batch {
    fn new(device: &wgpu::Device, layouts: &Layouts, capacity: u64) -> Self {
        use wgpu::BufferUsages as Usage;
        let buffer = |bytes: u64, usage: Usage| {
            device.create_buffer(&wgpu::BufferDescriptor { label: None, size: bytes, usage, mapped_at_creation: false })
        };
        let state = buffer(capacity * 16 * u64::from(STATE_WORDS), Usage::STORAGE);
        let lists = buffer(capacity * 4 * 3, Usage::STORAGE);
        let control = buffer(CONTROL * 4, Usage::STORAGE | Usage::COPY_DST | Usage::COPY_SRC);
        let starts = buffer(capacity * 16 * u64::from(START_WORDS), Usage::STORAGE | Usage::COPY_DST);
        let arrivals = buffer(capacity * 16, Usage::STORAGE | Usage::COPY_SRC);
        let workgroups = buffer(6 * 4, Usage::STORAGE | Usage::INDIRECT | Usage::COPY_DST);
        Self {
            returned: buffer(capacity * 16 + CONTROL * 4, Usage::COPY_DST | Usage::MAP_READ),
            paths: bind(device, &layouts.paths, &[&state, &lists, &control, &starts, &arrivals]),
            counted: bind(device, &layouts.counted, &[&workgroups]),
            starts,
            control,
            arrivals,
            workgroups,
            words: Vec::new(),
        }
    }
}

impl Tracer {
    /// Loads a scene onto a card.
    ///
    /// # Errors
    ///
    /// Tables that the card has no room for; kernels that its driver refuses.
    pub(crate) fn new(
        card: &Card,
        scene: &PackedScene,
        limits: PathLimits,
        sampler: SamplerKind,
    ) -> Result<Self, Invalid> {
        let (device, queue) = (card.device().clone(), card.queue().clone());
        let kernels = card.kernels(scene.features)?;
        let of_device = device.limits();
        let bytes = largest_table(&of_device);
        let most = if card.adapter().is_software { SOFTWARE_BATCH } else { LARGEST_BATCH };
        let capacity = most.min(bytes / (16 * u64::from(STATE_WORDS))) as u32;
        let numbers = params::values(&params::Row { scene, limits, sampler, capacity });
        let loaded = in_room(&device, || {
            let numbers = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("params"),
                contents: bytemuck::cast_slice(&numbers),
                usage: wgpu::BufferUsages::UNIFORM,
            });
            let tables = scene_buffers(&device, scene, &of_device)?;
            let buffers: Vec<&wgpu::Buffer> = std::iter::once(&numbers).chain(&tables).collect();
            let scene = bind(&device, &kernels.layouts.scene, &buffers);
            let idle = (0..BATCHES).map(|_| Batch::new(&device, &kernels.layouts, u64::from(capacity))).collect();
            Ok((scene, idle))
        });
        let (scene, idle) = loaded.unwrap_or_else(|words| {
            let message = format!("it cannot be loaded onto {}: {words}", card.adapter());
            Err(Invalid::new("scene", message).help("render with --device cpu"))
        })?;
        Ok(Self {
            device,
            queue,
            fault: card.fault(),
            kernels,
            scene,
            max_depth: limits.max_depth,
            capacity,
            idle: Mutex::new(idle),
            is_idle: Condvar::new(),
            rays: [AtomicU64::new(0), AtomicU64::new(0)],
        })
    }

    /// Takes a batch that no other thread uses, and waits for one if need be.
    pub(crate) fn take(&self) -> Batch {
        let mut idle = unlocked(&self.idle);
        loop {
            match idle.pop() {
                Some(batch) => return batch,
                None => idle = self.is_idle.wait(idle).unwrap_or_else(PoisonError::into_inner),
            }
        }
    }

    pub(crate) fn give_back(&self, batch: Batch) {
        unlocked(&self.idle).push(batch);
        self.is_idle.notify_one();
    }

    /// Sends words of a batch and the numbers of its kernels, traces until no path goes on, and hands over the bytes of
    /// the results.
    pub(crate) fn trace_words(
        &self,
        batch: &Batch,
        control: Control,
        ends: &Ends<'_>,
        take: impl FnOnce(&[u8]),
    ) -> Result<(), String> {
        // Send the starts, and the numbers of the first kernels
        self.queue.write_buffer(&batch.starts, 0, bytemuck::cast_slice(&batch.words));
        self.queue.write_buffer(&batch.control, 0, bytemuck::cast_slice(&control));
        let groups = ends.threads[0].div_ceil(WORKGROUP_SIZE);
        self.queue.write_buffer(&batch.workgroups, 0, bytemuck::cast_slice(&[groups, 1, 1, 0, 1, 1]));

        // Trace segment by segment until no path goes on
        let mut depth = 0;
        loop {
            let segments = SEGMENTS_TOGETHER.min(self.max_depth - depth);
            let is_first = depth == 0;
            depth += segments;
            let control = self.trace_segments(batch, ends, segments, is_first)?;
            if control[ACTIVE] == 0 || depth >= self.max_depth {
                self.rays[0].fetch_add(u64::from(control[SURFACE_RAYS]), Ordering::Relaxed);
                self.rays[1].fetch_add(u64::from(control[LIGHT_RAYS]), Ordering::Relaxed);
                break;
            }
            batch.returned.unmap();
        }

        // Take what has arrived
        let view = batch.returned.get_mapped_range(0..ends.bytes()).map_err(|error| error.to_string())?;
        take(view.as_ref());
        drop(view);
        batch.returned.unmap();
        Ok(())
    }

    /// Traces some segments of all paths that go on. Returns the numbers of `control`, and leaves the results mapped.
    fn trace_segments(&self, batch: &Batch, ends: &Ends<'_>, segments: u32, is_first: bool) -> Result<Control, String> {
        let groups = ends.threads.map(|count| count.div_ceil(WORKGROUP_SIZE));
        let mut encoder = self.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_bind_group(0, &self.scene, &[]);
            pass.set_bind_group(1, &batch.paths, &[]);
            if let Some(film) = ends.film {
                pass.set_bind_group(3, film, &[]);
            }
            if is_first {
                pass.set_pipeline(ends.first);
                pass.dispatch_workgroups(groups[0], 1, 1);
            }
            for _ in 0..segments {
                for kernel in [&self.kernels.extend, &self.kernels.shade] {
                    pass.set_pipeline(kernel);
                    pass.dispatch_workgroups_indirect(&batch.workgroups, 0);
                }
                pass.set_pipeline(&self.kernels.count);
                pass.set_bind_group(2, &batch.counted, &[]);
                pass.dispatch_workgroups(1, 1, 1);
                pass.set_pipeline(&self.kernels.shadow);
                pass.dispatch_workgroups_indirect(&batch.workgroups, 12);
            }
            pass.set_pipeline(ends.last);
            if let Some(film) = ends.film {
                pass.set_bind_group(3, film, &[]);
            }
            pass.dispatch_workgroups(groups[1], 1, 1);
        }
        let bytes = ends.bytes();
        encoder.copy_buffer_to_buffer(&batch.arrivals, 0, &batch.returned, 0, bytes);
        encoder.copy_buffer_to_buffer(&batch.control, 0, &batch.returned, bytes, CONTROL * 4);
        let submission = self.queue.submit([encoder.finish()]);

        // Wait, and read how far it has come
        let all = 0..bytes + CONTROL * 4;
        batch.returned.map_async(wgpu::MapMode::Read, all, |_| {});
        let waited = self.device.poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout: None });
        waited.map_err(|error| error.to_string())?;
        if let Some(fault) = unlocked(&self.fault).clone() {
            return Err(fault);
        }
        let view = batch.returned.get_mapped_range(bytes..bytes + CONTROL * 4).map_err(|error| error.to_string())?;
        let mut control = [0; CONTROL as usize];
        for (number, bytes) in control.iter_mut().zip(view.as_ref().chunks_exact(4)) {
            *number = word(bytes);
        }
        drop(view);
        Ok(control)
    }
}

/// Number of 32 bits.
pub(crate) fn word(bytes: &[u8]) -> u32 {
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}
