//! Cards of this machine, and the one that is opened.

use std::fmt;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use photosite_core::Invalid;

use crate::develop::kernels::DevelopKernels;
use crate::develop::room::Room;
use crate::expose::kernel::ExposureCache;
use crate::kernels::{KernelCache, Kernels};

/// Card, or software that stands for one, as its driver describes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Adapter {
    /// Name of the card.
    pub name: String,
    /// Interface that it is used through: "vulkan", "metal", "dx12".
    pub interface: String,
    /// Driver with its version.
    pub driver: String,
    /// Kind of card: "discrete", "integrated", "virtual", "software", "unknown".
    pub kind: &'static str,
    /// Largest table of a scene, bytes.
    pub largest_binding: u64,
    /// Whether the processor does the work, so that it is used only where it is asked for by name.
    pub is_software: bool,
    /// Why no scene can be rendered on it; `None` where it serves.
    pub refusal: Option<String>,
}

/// Number of tables that a kernel reads and writes at once.
const STORAGE_BUFFERS: u32 = 12;

impl Adapter {
    fn of(adapter: &wgpu::Adapter) -> Self {
        let (info, limits) = (adapter.get_info(), adapter.limits());
        let kind = match info.device_type {
            wgpu::DeviceType::DiscreteGpu => "discrete",
            wgpu::DeviceType::IntegratedGpu => "integrated",
            wgpu::DeviceType::VirtualGpu => "virtual",
            wgpu::DeviceType::Cpu => "software",
            wgpu::DeviceType::Other => "unknown",
        };
        let buffers = limits.max_storage_buffers_per_shader_stage;
        let refusal = if buffers < STORAGE_BUFFERS {
            Some(format!("it gives a kernel {buffers} tables of {STORAGE_BUFFERS}"))
        } else if !adapter.get_downlevel_capabilities().flags.contains(wgpu::DownlevelFlags::INDIRECT_EXECUTION) {
            Some("it starts no kernels by what others have counted".to_owned())
        } else {
            None
        };
        Self {
            name: info.name,
            interface: info.backend.to_str().to_owned(),
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
            kind,
            largest_binding: limits.max_storage_buffer_binding_size,
            is_software: info.device_type == wgpu::DeviceType::Cpu,
            refusal,
        }
    }
}

impl fmt::Display for Adapter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({}, {})", self.name, self.interface, self.driver)
    }
}

fn all() -> Vec<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::PRIMARY,
        // Numbers of workgroups are counted by a kernel of this crate: another one that checks them would cost as much
        // as those that it starts.
        flags: wgpu::InstanceFlags::empty(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY))
}

/// Cards of this machine in the order of their numbers; software comes last.
pub fn adapters() -> Vec<Adapter> {
    sorted().into_iter().map(|(adapter, _)| adapter).collect()
}

fn sorted() -> Vec<(Adapter, wgpu::Adapter)> {
    let mut all: Vec<_> = all().into_iter().map(|adapter| (Adapter::of(&adapter), adapter)).collect();
    let rank = |adapter: &Adapter| match adapter.kind {
        "discrete" => 0,
        "integrated" => 1,
        "software" => 3,
        _ => 2,
    };
    all.sort_by_key(|(adapter, _)| rank(adapter));
    all
}

/// A card that is open.
pub struct Card {
    adapter: Adapter,
    device: wgpu::Device,
    queue: wgpu::Queue,
    /// Error of the driver that no call returned.
    fault: Arc<Mutex<Option<String>>>,
    kernels: KernelCache,
    /// Kernels of development, once they are compiled.
    develop_kernels: OnceLock<Result<DevelopKernels, String>>,
    /// Buffers of the image that was developed last.
    room: Mutex<Option<Room>>,
    exposure: ExposureCache,
}

/// Number of the first card that is no software; `None` where there is none.
pub fn first() -> Option<usize> {
    adapters().iter().position(|adapter| !adapter.is_software && adapter.refusal.is_none())
}

/// Opens the card of that number.
///
/// # Errors
///
/// Words on why it cannot be used.
pub fn open(number: usize) -> Result<Card, String> {
    let mut all = sorted();
    let count = all.len();
    if number >= count {
        return Err(format!("there is no device of the number {number}: there are {count}"));
    }
    let (description, adapter) = all.swap_remove(number);
    if let Some(refusal) = &description.refusal {
        return Err(format!("{description} cannot be used: {refusal}"));
    }
    let wanted = wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..Default::default() };
    let opened = pollster::block_on(adapter.request_device(&wanted));
    let (device, queue) = opened.map_err(|error| format!("{description} cannot be opened: {error}"))?;
    let fault = Arc::new(Mutex::new(None));
    let said = |fault: &Arc<Mutex<Option<String>>>| {
        let fault = Arc::clone(fault);
        move |words: String| {
            fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(words);
        }
    };
    let on_error = said(&fault);
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| on_error(error.to_string())));
    let on_loss = said(&fault);
    device.set_device_lost_callback(move |reason, words| on_loss(format!("the device is lost ({reason:?}): {words}")));
    Ok(Card {
        adapter: description,
        device,
        queue,
        fault,
        kernels: KernelCache::default(),
        develop_kernels: OnceLock::new(),
        room: Mutex::new(None),
        exposure: ExposureCache::default(),
    })
}

impl fmt::Debug for Card {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Card").field(&self.adapter).finish()
    }
}

impl Card {
    /// Description of the card.
    pub fn adapter(&self) -> &Adapter {
        &self.adapter
    }

    pub(crate) fn device(&self) -> &wgpu::Device {
        &self.device
    }

    pub(crate) fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Kernels for scenes of these features.
    ///
    /// # Errors
    ///
    /// Kernels that the driver refuses.
    pub(crate) fn kernels(&self, features: u32) -> Result<Arc<Kernels>, Invalid> {
        self.kernels.get(&self.device, features).map_err(|words| {
            let message = format!("{} does not take the kernels: {words}", self.adapter);
            Invalid::new("scene", message).help("render with --device cpu")
        })
    }

    /// Whether the driver has found no fault so far.
    pub(crate) fn works(&self) -> bool {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner).is_none()
    }

    /// Kernels of development; they are compiled once.
    ///
    /// # Errors
    ///
    /// Kernels that the driver refuses.
    pub(crate) fn develop_kernels(&self) -> Result<&DevelopKernels, Invalid> {
        self.develop_kernels.get_or_init(|| DevelopKernels::new(&self.device)).as_ref().map_err(|words| {
            let message = format!("{} does not take the kernels: {words}", self.adapter);
            Invalid::new("develop", message).help("develop with --device cpu")
        })
    }

    /// Buffers of the image that was developed last, while no other one is.
    pub(crate) fn room(&self) -> &Mutex<Option<Room>> {
        &self.room
    }

    /// Kernel of exposures.
    pub(crate) fn exposure_kernel(&self) -> &ExposureCache {
        &self.exposure
    }

    /// The last error of the driver that no call returned.
    pub(crate) fn fault(&self) -> Arc<Mutex<Option<String>>> {
        Arc::clone(&self.fault)
    }
}
