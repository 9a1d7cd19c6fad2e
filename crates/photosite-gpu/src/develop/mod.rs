//! Development on cards: raw numbers to the codes of an image, by kernels that follow the steps of
//! [`develop`](photosite_develop::develop).
//!
//! In: a raw image and its development as plain data
//! ([`photosite_develop::packed`]), which refuses by key what a card does not have. Out: an image of 8 or 16 bits.
//!
//! | file | holds |
//! |---|---|
//! | `strips` | rows that are developed together |
//! | `tables`, `params` | the development as words |
//! | `room` | buffers of strips |
//! | `kernels` | kernels, and their order |
//!
//! Codes differ from the processor's by 1 where rounding decides, and near pixels for which Menon's method finds both
//! directions equally smooth but for rounding. On one card and driver the same image brings the same bytes.

pub(crate) mod kernels;
pub(crate) mod params;
pub(crate) mod room;
pub mod shaders;
pub(crate) mod strips;
pub(crate) mod tables;

use std::sync::PoisonError;

use photosite_core::Invalid;
use photosite_develop::packed::PackedDevelopment;
use photosite_develop::{Codes, EncodedImage};
use photosite_raw::RawImage;
use wgpu::util::DeviceExt;

use crate::adapters::Card;
use crate::buffers::{bind, in_room, largest_table};
use kernels::DevelopKernels;
use room::{Room, SLOTS, Slot, code_bytes};
use strips::{Strip, strips};

/// Pixels of a strip at most, with its margin: enough to keep a large card busy for a millisecond.
const STRIP_PIXELS: usize = 1 << 22;

fn refused(message: String) -> Invalid {
    Invalid::new("develop", message).help("develop with --device cpu")
}

impl Card {
    /// Develops a raw image for display as [`develop`](photosite_develop::develop) does; `development` is that of this
    /// image or of one that differs from it in its numbers alone. Kernels are compiled at the first call. The card
    /// keeps buffers of 240 MB at most for the next.
    ///
    /// # Errors
    ///
    /// A raw image of another size than the development's, rows that are too long for the tables of the card, and
    /// words of its driver.
    pub fn develop(&self, raw: &RawImage, development: &PackedDevelopment) -> Result<EncodedImage, Invalid> {
        raw.validate()?;
        let (size, samples) = ([raw.width, raw.height], raw.cfa.samples_per_pixel());
        if (size, samples) != (development.stored_px, development.samples) {
            let [[columns, rows], [width, height]] = [size, development.stored_px];
            let message = format!("{columns} × {rows} pixels of {samples} values are developed as {width} × {height}");
            return Err(Invalid::new("", message).help("pack the development of this image"));
        }
        self.develop_numbers(&raw.data, development, STRIP_PIXELS)
    }

    /// Develops raw numbers in strips of so many pixels at most.
    pub(crate) fn develop_numbers(
        &self,
        numbers: &[u16],
        of: &PackedDevelopment,
        strip_pixels: usize,
    ) -> Result<EncodedImage, Invalid> {
        let [width, height] = of.image_px();
        let count = width * height * of.components();
        let mut codes = if of.bits == 8 { Codes::U8(vec![0; count]) } else { Codes::U16(vec![0; count]) };
        if count > 0 {
            self.fill(&mut codes, numbers, of, strip_pixels)?;
        }
        Ok(EncodedImage {
            width,
            height,
            components: of.components(),
            codes,
            colour_space: of.colour_space,
            transfer: of.transfer,
            pixel_aspect: of.pixel_aspect,
        })
    }

    fn fill(
        &self,
        codes: &mut Codes,
        numbers: &[u16],
        of: &PackedDevelopment,
        strip_pixels: usize,
    ) -> Result<(), Invalid> {
        let device = self.device();
        let kernels = self.develop_kernels()?;
        let most = largest_table(&device.limits());
        let strips = strips(of, most, strip_pixels)?;
        let (words, sections) = tables::words(of);
        if words.len() as u64 * 4 > most {
            let bytes = words.len() * 4;
            return Err(refused(format!("a table takes {bytes} bytes, and {most} are the most on this device")));
        }

        // Make room
        let kept = self.room().lock().unwrap_or_else(PoisonError::into_inner).take();
        let made = in_room(device, || {
            let room = Room::fitting(kept, device, of, &strips);
            let tables = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("development"),
                contents: bytemuck::cast_slice(&words),
                usage: wgpu::BufferUsages::STORAGE,
            });
            let group = |slot: &Slot| {
                let Room { mosaic, planes, differences, along_row, .. } = &room;
                let all = [&slot.params, &slot.numbers, &tables, mosaic, planes, differences, along_row, &slot.codes];
                bind(device, &kernels.layout, &all)
            };
            let groups = room.slots.each_ref().map(group);
            (room, groups)
        });
        let (room, groups) = made.map_err(|words| refused(format!("it has no room on {}: {words}", self.adapter())))?;

        // Send each strip while the card develops the one before
        let mut sent: [Option<wgpu::SubmissionIndex>; SLOTS] = Default::default();
        for i in 0..strips.len() + SLOTS {
            let slot = &room.slots[i % SLOTS];
            if let Some(submission) = sent[i % SLOTS].take() {
                self.take_codes(slot, submission, &strips[i - SLOTS], of, codes).map_err(refused)?;
            }
            if let Some(strip) = strips.get(i) {
                let params = params::values(&params::Row { of, strip, sections: &sections });
                self.queue().write_buffer(&slot.params, 0, bytemuck::cast_slice(&params));
                send(self.queue(), &slot.numbers, &numbers[strip.numbers.clone()]);
                sent[i % SLOTS] = Some(self.develop_strip(kernels, slot, &groups[i % SLOTS], strip, of));
            }
        }
        *self.room().lock().unwrap_or_else(PoisonError::into_inner) = Some(room);
        Ok(())
    }

    /// Starts the kernels of a strip, and the way back of its codes.
    fn develop_strip(
        &self,
        kernels: &DevelopKernels,
        slot: &Slot,
        group: &wgpu::BindGroup,
        strip: &Strip,
        of: &PackedDevelopment,
    ) -> wgpu::SubmissionIndex {
        let mut encoder = self.device().create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_bind_group(0, group, &[]);
            kernels.run(&mut pass, strip, of);
        }
        let bytes = code_bytes(of, strip);
        encoder.copy_buffer_to_buffer(&slot.codes, 0, &slot.returned, 0, bytes);
        let submission = self.queue().submit([encoder.finish()]);
        slot.returned.map_async(wgpu::MapMode::Read, 0..bytes, |_| {});
        submission
    }

    /// Waits for the codes of a strip, and puts them in their places.
    fn take_codes(
        &self,
        slot: &Slot,
        submission: wgpu::SubmissionIndex,
        strip: &Strip,
        of: &PackedDevelopment,
        codes: &mut Codes,
    ) -> Result<(), String> {
        let waited = self.device().poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout: None });
        waited.map_err(|error| error.to_string())?;
        if let Some(fault) = self.fault().lock().unwrap_or_else(PoisonError::into_inner).clone() {
            return Err(fault);
        }
        let view = slot.returned.get_mapped_range(0..code_bytes(of, strip)).map_err(|error| error.to_string())?;
        let codes: &mut [u8] = match codes {
            Codes::U8(codes) => codes,
            Codes::U16(codes) => bytemuck::cast_slice_mut(codes),
        };
        let bytes = of.components() * usize::from(of.bits / 8);
        let [row, row_of_strip] = [of.image_px()[0], strip.turned[0]].map(|columns| columns * bytes);
        let from = view.as_ref().chunks_exact(row_of_strip).take(strip.turned[1]);
        let to = codes.chunks_exact_mut(row).skip(strip.corner[1]);
        from.zip(to).for_each(|(from, to)| to[strip.corner[0] * bytes..][..row_of_strip].copy_from_slice(from));
        drop(view);
        slot.returned.unmap();
        Ok(())
    }
}

/// Sends raw numbers, two in a word.
fn send(queue: &wgpu::Queue, buffer: &wgpu::Buffer, numbers: &[u16]) {
    let (pairs, rest) = numbers.split_at(numbers.len() / 2 * 2);
    queue.write_buffer(buffer, 0, bytemuck::cast_slice(pairs));
    if let [last] = rest {
        queue.write_buffer(buffer, pairs.len() as u64 * 2, &u32::from(*last).to_le_bytes());
    }
}
