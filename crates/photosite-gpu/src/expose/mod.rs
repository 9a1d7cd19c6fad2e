//! Exposure on a card: light that stays there, and digital numbers that come back.

pub(crate) mod kernel;
pub mod shaders;

use std::sync::{Arc, Mutex, PoisonError};

use photosite_core::Invalid;
use photosite_core::image::Planes;
use photosite_raw::RawImage;
use photosite_sensor::packed::{LightLayout, PackedExposure, PackedLight};
use photosite_sensor::{Exposure, NoiseKey, SensorModel, Stages};
use wgpu::util::DeviceExt;

use crate::adapters::Card;
use crate::buffers::{bind, in_room, largest_table};
use crate::expose::kernel::ExposureKernel;
use crate::shaders::WORKGROUP_SIZE;

/// Values that are exposed by one submission: some milliseconds of a card, and some tens of a small one, so that
/// others, a desktop among them, have their turns.
const STRIP_VALUES: usize = 1 << 22;
/// Values of a submission of software, which takes as long for them.
const SOFTWARE_STRIP_VALUES: usize = 1 << 14;

impl Card {
    /// Exposes a sensor as [`photosite_sensor::expose`] does, with the same random numbers, each operation in the same
    /// order and rounded alike. Digital numbers are the same, but for two kinds of exceptions: of ten million counts of
    /// electrons one or a few are drawn otherwise, where single precision decides whether a candidate is taken; and
    /// where amplifiers or converters bend, signals within their rounding of a threshold differ by 1 DN.
    ///
    /// For several exposures of the same light see [`Self::hold_light`].
    ///
    /// # Errors
    ///
    /// What [`photosite_sensor::expose`] refuses; by its key the first fact that a card does not have
    /// ([`PackedExposure::new`]); images that the card has no room for; words of its driver.
    pub fn expose(
        &self,
        mean_electrons: &Planes,
        sensor: &SensorModel,
        exposure: &Exposure,
        stages: Stages,
        key: NoiseKey,
    ) -> Result<RawImage, Invalid> {
        let image = [mean_electrons.width(), mean_electrons.height()];
        let exposure = PackedExposure::new(image, sensor, exposure, stages, key)?;
        self.hold_light(&PackedLight::new(mean_electrons, sensor)?)?.expose(&exposure)
    }

    /// Loads light onto the card, where it stays for any number of exposures.
    ///
    /// # Errors
    ///
    /// Images that the card has no room for, and words of its driver.
    pub fn hold_light(&self, light: &PackedLight) -> Result<HeldLight, Invalid> {
        let device = self.device().clone();
        let kernel = self
            .exposure_kernel()
            .get(&device)
            .map_err(|words| refused(format!("{} does not take the kernel of an exposure: {words}", self.adapter())))?;
        let on_card = Buffers { device, name: self.adapter().to_string() };
        let contents = bytemuck::cast_slice(light.electrons());
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let light_buffer = on_card.filled("light", contents, usage)?;
        Ok(HeldLight {
            on_card,
            queue: self.queue().clone(),
            fault: self.fault(),
            kernel,
            strip_values: if self.adapter().is_software { SOFTWARE_STRIP_VALUES } else { STRIP_VALUES },
            layout: light.layout().clone(),
            light: light_buffer,
            numbers: None,
        })
    }
}

/// Light on a card, of which exposures are made one after the other.
pub struct HeldLight {
    on_card: Buffers,
    queue: wgpu::Queue,
    fault: Arc<Mutex<Option<String>>>,
    kernel: Arc<ExposureKernel>,
    /// Values that one submission exposes.
    strip_values: usize,
    layout: LightLayout,
    light: wgpu::Buffer,
    /// Buffers of the last exposure, which serve the next one of the same size.
    numbers: Option<Numbers>,
}

/// Digital numbers, two to a word, on the card and on their way back.
struct Numbers {
    bytes: u64,
    on_card: wgpu::Buffer,
    returned: wgpu::Buffer,
}

impl HeldLight {
    /// Puts other light of the same layout in the place of this, such as that of the next image of a live view.
    ///
    /// # Errors
    ///
    /// Light of another layout.
    pub fn replace(&mut self, light: &PackedLight) -> Result<(), Invalid> {
        self.suits(light.layout())?;
        self.queue.write_buffer(&self.light, 0, bytemuck::cast_slice(light.electrons()));
        Ok(())
    }

    /// Refuses another layout than that of the light.
    ///
    /// # Errors
    ///
    /// Another size, or a sensor with other colour filters or another image circle.
    pub fn suits(&self, layout: &LightLayout) -> Result<(), Invalid> {
        if *layout == self.layout {
            return Ok(());
        }
        let [[columns, rows], [width, height]] = [layout, &self.layout].map(LightLayout::image);
        let message = format!(
            "{columns} × {rows} pixels do not suit the light of {width} × {height} on the card, or the sensor has other \
             colour filters or another image circle"
        );
        Err(Invalid::new("", message).help("hold the light anew"))
    }

    /// Exposes the light once.
    ///
    /// # Errors
    ///
    /// Exposures of another layout of light, in size, colour filter array or image circle; images that the card has no
    /// room for; words of its driver, such as that the device is lost.
    pub fn expose(&mut self, exposure: &PackedExposure<'_>) -> Result<RawImage, Invalid> {
        self.suits(exposure.layout())?;
        let [width, height] = exposure.size();
        let words_of_row = width.div_ceil(2);
        let numbers = match self.numbers.take() {
            Some(numbers) if numbers.bytes == (4 * words_of_row * height) as u64 => numbers,
            _ => self.on_card.numbers((4 * words_of_row * height) as u64)?,
        };
        let last = self.run(exposure, &numbers)?;
        let read = self.read(&numbers, width, last);
        let data = read.map_err(|words| refused(format!("{} has failed: {words}", self.on_card.name)))?;
        self.numbers = Some(numbers);
        Ok(exposure.raw_image(data))
    }

    /// Starts the kernel for all strips of rows, and brings the numbers on their way. Returns the last submission.
    fn run(&self, exposure: &PackedExposure<'_>, numbers: &Numbers) -> Result<Option<wgpu::SubmissionIndex>, Invalid> {
        let device = &self.on_card.device;
        let storage = wgpu::BufferUsages::STORAGE;
        let fact = |what, words: &[u32]| {
            let words = if words.is_empty() { &[0] } else { words };
            self.on_card.filled(what, bytemuck::cast_slice(words), storage)
        };
        let words = fact("words of its stages", exposure.words())?;
        let tables = fact("patterns and defective pixels", exposure.tables())?;
        let facts = bind(device, &self.kernel.facts, &[&words, &tables, &self.kernel.random_tables, &self.light]);
        let [width, height] = exposure.size();
        let mut last = None;
        // Cards start no more workgroups along an axis.
        let strip = (self.strip_values / width).clamp(1, 65_535);
        for first in (0..height).step_by(strip) {
            let place = [first as u32, 0, 0, 0];
            let place =
                self.on_card.filled("place of rows", bytemuck::cast_slice(&place), wgpu::BufferUsages::UNIFORM)?;
            let rows = bind(device, &self.kernel.rows, &[&numbers.on_card, &place]);
            let mut encoder = device.create_command_encoder(&Default::default());
            {
                let mut pass = encoder.begin_compute_pass(&Default::default());
                pass.set_pipeline(&self.kernel.pipeline);
                pass.set_bind_group(0, &facts, &[]);
                pass.set_bind_group(1, &rows, &[]);
                let groups = (width.div_ceil(2) as u32).div_ceil(WORKGROUP_SIZE);
                pass.dispatch_workgroups(groups, strip.min(height - first) as u32, 1);
            }
            if first + strip >= height {
                encoder.copy_buffer_to_buffer(&numbers.on_card, 0, &numbers.returned, 0, numbers.bytes);
            }
            last = Some(self.queue.submit([encoder.finish()]));
        }
        Ok(last)
    }

    /// Waits for the numbers, and takes those of each row, whose words may hold one more.
    fn read(&self, numbers: &Numbers, width: usize, last: Option<wgpu::SubmissionIndex>) -> Result<Vec<u16>, String> {
        numbers.returned.map_async(wgpu::MapMode::Read, .., |_| {});
        let waited = self.on_card.device.poll(wgpu::PollType::Wait { submission_index: last, timeout: None });
        waited.map_err(|error| error.to_string())?;
        if let Some(fault) = self.fault.lock().unwrap_or_else(PoisonError::into_inner).clone() {
            return Err(fault);
        }
        let view = numbers.returned.get_mapped_range(..).map_err(|error| error.to_string())?;
        let mut data: Vec<u16> = bytemuck::pod_collect_to_vec(view.as_ref());
        drop(view);
        numbers.returned.unmap();
        if !width.is_multiple_of(2) {
            data = data.chunks_exact(width + 1).flat_map(|row| &row[..width]).copied().collect();
        }
        Ok(data)
    }
}

/// Device whose buffers are no larger than it takes.
struct Buffers {
    device: wgpu::Device,
    /// Name of the card.
    name: String,
}

impl Buffers {
    /// Creates buffers of so many bytes each, or refuses what the device has no room for.
    fn with_room<T>(&self, what: &str, bytes: u64, create: impl FnOnce() -> T) -> Result<T, Invalid> {
        let most = largest_table(&self.device.limits());
        if bytes > most {
            return Err(refused(format!("the {what} take {bytes} bytes, and {most} are the most on {}", self.name)));
        }
        let no_room = |words| refused(format!("{} has no room for the {what}: {words}", self.name));
        in_room(&self.device, create).map_err(no_room)
    }

    fn filled(&self, what: &str, contents: &[u8], usage: wgpu::BufferUsages) -> Result<wgpu::Buffer, Invalid> {
        let label = Some(what);
        let create = || self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label, contents, usage });
        self.with_room(what, contents.len() as u64, create)
    }

    /// Buffers of digital numbers.
    fn numbers(&self, bytes: u64) -> Result<Numbers, Invalid> {
        use wgpu::BufferUsages as Usage;
        let what = "digital numbers";
        let buffer = |usage| {
            let of = wgpu::BufferDescriptor { label: Some(what), size: bytes, usage, mapped_at_creation: false };
            self.device.create_buffer(&of)
        };
        self.with_room(what, bytes, || Numbers {
            bytes,
            on_card: buffer(Usage::STORAGE | Usage::COPY_SRC),
            returned: buffer(Usage::MAP_READ | Usage::COPY_DST),
        })
    }
}

/// Refusal of an exposure that the processor can make.
fn refused(message: String) -> Invalid {
    Invalid::new("", message).help("expose with --device cpu")
}
