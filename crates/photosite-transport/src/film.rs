//! Film: accumulated samples of an image while light is traced.
//!
//! In: spectral irradiance samples, W·m⁻²·nm⁻¹. Out: for each of a list of response functions R, the mean over the
//! pixel and over the samples of ∫ R(λ)·E(λ) dλ, and the variance of that mean. With R a sensor's response
//! (e⁻·s⁻¹ per W·m⁻²·nm⁻¹) that is an electron rate without any binning of wavelengths; with R = 1/Δλ on a band it is
//! the mean spectral irradiance in the band. Pixels may hold different numbers of samples.
//!
//! A film holds 32 bytes for each channel of a pixel, so that one of a large image with many bands does not fit into
//! memory: it may be of a strip of the image's rows.

mod landing;

use std::ops::Range;

use glam::Vec4;

use photosite_core::image::{Channel, Estimate, Planes};
use photosite_core::math::double_double::{DoubleDouble, DoubleDoubles};
use photosite_core::spectrum::{LANES, SampledSpectrum, Spectrum, TABLE_LEN, Wavelengths};

pub use landing::{LandingRow, OneWavelength};

/// A response function with the name of the plane that it fills.
#[derive(Clone, Debug)]
pub struct Response {
    /// Name of the plane.
    pub name: String,
    /// Response R(λ).
    pub spectrum: Spectrum,
    /// Whether wavelengths are drawn for the response only where the other responses of the image leave room; see
    /// [`integrator`](crate::integrator).
    pub is_secondary: bool,
}

impl Response {
    /// A response that wavelengths are drawn for.
    pub fn new(name: impl Into<String>, spectrum: Spectrum) -> Self {
        Self { name: name.into(), spectrum, is_secondary: false }
    }
}

/// The response that averages spectral irradiance over a band between whole or half nanometres, named by its centre
/// (`"550"`). It is secondary: an image does not get noisier because bands are stored beside it.
pub fn band_response([low_nm, high_nm]: [f64; 2]) -> Response {
    // A table is linear between whole nanometres: half a value on either edge gives it the weight of the band alone.
    let inside = |l: f64| {
        if l > low_nm && l < high_nm {
            1.0
        } else if l == low_nm || l == high_nm {
            0.5
        } else {
            0.0
        }
    };
    let spectrum = Spectrum::from_fn(inside);
    let name = format!("{}", 0.5 * (low_nm + high_nm));
    Response { is_secondary: true, ..Response::new(name, spectrum.scale(1.0 / spectrum.integral())) }
}

/// Response functions laid out for accumulation: wavelength by wavelength, all channels side by side, four at a time.
#[derive(Clone, Debug)]
pub struct FilmResponses {
    names: Vec<String>,
    /// Values of the responses, table[entry · groups + group], where each group is of four channels and the last is
    /// filled up with zeros.
    table: Vec<Vec4>,
}

impl FilmResponses {
    /// Lays out at least one response.
    pub fn new(responses: &[Response]) -> Self {
        let group = |i: usize, four: &[Response]| {
            Vec4::from_array(std::array::from_fn(|k| four.get(k).map_or(0.0, |r| r.spectrum.values()[i])))
        };
        let entry = |i: usize| responses.chunks(4).map(move |four| group(i, four));
        Self {
            names: responses.iter().map(|r| r.name.clone()).collect(),
            table: (0..TABLE_LEN).flat_map(entry).collect(),
        }
    }

    /// Values by entry of a spectral table and group of four channels.
    pub(crate) fn table(&self) -> &[Vec4] {
        &self.table
    }

    /// Names of the channels.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// Number of channels.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Whether there are no channels.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// Number of groups of four channels.
    pub(crate) fn groups(&self) -> usize {
        self.len().div_ceil(4)
    }

    /// Values that one spectral sample gives to each channel.
    pub(crate) fn values(&self, irradiance: SampledSpectrum, wavelengths: &Wavelengths) -> impl Iterator<Item = f32> {
        let mut values = vec![Vec4::ZERO; self.groups()];
        self.respond(irradiance, wavelengths, &mut values);
        values.into_iter().flat_map(|four| four.to_array()).take(self.len())
    }

    /// Adds to `values`, one for each group, what one spectral sample gives to each channel: Σᵢ wᵢ·R(λᵢ)·E(λᵢ),
    /// wᵢ = 1/(4·p(λᵢ)).
    #[inline]
    fn respond(&self, irradiance: SampledSpectrum, wavelengths: &Wavelengths, values: &mut [Vec4]) {
        let weighted = irradiance * wavelengths.weights();
        let groups = values.len();
        for (group, value) in values.iter_mut().enumerate() {
            // In a register until all wavelengths are in it.
            let mut sum = *value;
            for lane in 0..LANES {
                let (entry, t) = wavelengths.place_in_table(lane);
                let [low, high] = [entry, entry + 1].map(|entry| self.table[entry * groups + group]);
                sum += weighted[lane] * (low + (high - low) * t);
            }
            *value = sum;
        }
    }
}

/// Sums of one channel of one pixel, over its samples v. They are exact but for samples that differ by many orders of
/// magnitude, so that parts of a render that are added later give what one render gives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// Sum Σ v.
    pub sum: DoubleDouble,
    /// Sum of squares Σ v².
    pub squares: DoubleDouble,
}

impl Sums {
    /// Variance of the mean of n samples, (Σ v² − (Σ v)²/n) / (n·(n − 1)); 0 where one sample tells nothing of it.
    fn variance_of_mean(&self, n: f64) -> f64 {
        if n < 2.0 {
            return 0.0;
        }
        (self.squares.times(n).minus(self.sum.squared())).max(0.0) / (n * n * (n - 1.0))
    }
}

/// Accumulated samples of an image, or of some of its rows.
#[derive(Clone, Debug)]
pub struct Film {
    width: usize,
    /// Rows of the image that the film holds.
    rows: Range<usize>,
    responses: FilmResponses,
    /// Sums of all pixels, sums[(row · width + column) · channels + channel].
    sums: Vec<Sums>,
    /// Samples of each pixel, row by row.
    counts: Vec<u32>,
}

/// Band: some rows of the film, owned by one thread while it adds samples.
pub struct FilmBand<'a> {
    responses: &'a FilmResponses,
    sums: &'a mut [Sums],
    counts: &'a mut [u32],
    /// Results of the groups of channels for each of several samples.
    scratch: Vec<Vec4>,
}

impl Film {
    /// An empty film of a whole image.
    pub fn new(width: usize, height: usize, responses: FilmResponses) -> Self {
        Self::of_rows(width, 0..height, responses)
    }

    /// An empty film of some rows of an image.
    pub fn of_rows(width: usize, rows: Range<usize>, responses: FilmResponses) -> Self {
        let pixels = width * rows.len();
        let sums = vec![Sums::default(); pixels * responses.len()];
        Self { width, rows, responses, sums, counts: vec![0; pixels] }
    }

    /// Memory for each pixel of a film of `channels` channels, bytes.
    pub fn bytes_per_pixel(channels: usize) -> usize {
        channels * size_of::<Sums>() + size_of::<u32>()
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows that the film holds.
    pub fn height(&self) -> usize {
        self.rows.len()
    }

    /// Range of the rows of the image that the film holds.
    pub fn image_rows(&self) -> Range<usize> {
        self.rows.clone()
    }

    /// Number of samples that every pixel has received at least.
    pub fn samples(&self) -> u32 {
        self.counts.iter().copied().min().unwrap_or(0)
    }

    /// Numbers of samples of each pixel, row by row.
    pub fn counts(&self) -> &[u32] {
        &self.counts
    }

    /// Number of samples of all pixels together.
    pub fn total(&self) -> u64 {
        self.counts.iter().map(|&count| u64::from(count)).sum()
    }

    /// Bands of `rows` rows each, top first, to be filled side by side by several threads. The last may have fewer.
    pub fn bands(&mut self, rows: usize) -> Vec<FilmBand<'_>> {
        let (responses, pixels) = (&self.responses, rows * self.width);
        let sums = self.sums.chunks_mut(pixels * responses.len());
        let band = |(sums, counts)| FilmBand { responses, sums, counts, scratch: vec![Vec4::ZERO; responses.groups()] };
        sums.zip(self.counts.chunks_mut(pixels)).map(band).collect()
    }

    /// Responses of the channels.
    pub(crate) fn responses(&self) -> &FilmResponses {
        &self.responses
    }

    /// Names of the channels.
    pub fn channels(&self) -> &[String] {
        &self.responses.names
    }

    /// Sums of all pixels, row by row, in each pixel channel by channel.
    pub fn sums(&self) -> &[Sums] {
        &self.sums
    }

    /// Adds the sums of other samples, in the order of [`Self::sums`], and the number of samples in each pixel.
    pub fn add(&mut self, sums: impl IntoIterator<Item = Sums>, counts: impl IntoIterator<Item = u32>) {
        self.counts.iter_mut().zip(counts).for_each(|(here, there)| *here += there);
        for (here, there) in self.sums.iter_mut().zip(sums) {
            here.sum.add_sum(there.sum);
            here.squares.add_sum(there.squares);
        }
    }

    /// Removes all samples.
    pub fn clear(&mut self) {
        self.sums.fill(Sums::default());
        self.counts.fill(0);
    }

    /// The planes `names` as means with the variance of the mean. Names that the film lacks are left out.
    pub fn estimate<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> Estimate {
        let indices: Vec<_> =
            names.into_iter().filter_map(|name| self.responses.names.iter().position(|n| n == name)).collect();
        let pixels = 0..self.counts.len();
        let planes = |plane: &dyn Fn(usize) -> Vec<f32>| {
            let channel = |&index: &usize| Channel { name: self.responses.names[index].clone(), data: plane(index) };
            Planes::new(self.width, self.height(), indices.iter().map(channel).collect())
                .expect("every plane has one value per pixel")
        };
        Estimate {
            mean: planes(&|channel| self.means(channel, pixels.clone()).collect()),
            variance: planes(&|channel| self.variances(channel, pixels.clone()).collect()),
        }
    }

    /// Means of a channel in some pixels.
    pub fn means(&self, channel: usize, pixels: Range<usize>) -> impl Iterator<Item = f32> {
        self.values(channel, pixels, |sums, n| sums.sum.high / n)
    }

    /// Variances of the means of a channel in some pixels.
    pub fn variances(&self, channel: usize, pixels: Range<usize>) -> impl Iterator<Item = f32> {
        self.values(channel, pixels, Sums::variance_of_mean)
    }

    fn values(
        &self,
        channel: usize,
        pixels: Range<usize>,
        value: impl Fn(&Sums, f64) -> f64,
    ) -> impl Iterator<Item = f32> {
        let channels = self.responses.len();
        let sums = self.sums[pixels.start * channels..pixels.end * channels].iter().skip(channel).step_by(channels);
        let counts = &self.counts[pixels];
        sums.zip(counts).map(move |(sums, &count)| value(sums, f64::from(count.max(1))) as f32)
    }
}

impl FilmBand<'_> {
    /// Number of pixels of the band. They are numbered row by row.
    pub fn pixels(&self) -> usize {
        self.counts.len()
    }

    /// Number of samples that a pixel holds.
    pub fn samples(&self, pixel: usize) -> u32 {
        self.counts[pixel]
    }

    /// Adds samples to a pixel, each the sum of spectral irradiances at wavelengths of their own.
    #[inline]
    pub fn add<'b, S>(&mut self, pixel: usize, samples: impl IntoIterator<Item = S>)
    where
        S: IntoIterator<Item = (SampledSpectrum, &'b Wavelengths)>,
    {
        let (channels, groups) = (self.responses.len(), self.responses.groups());
        self.scratch.clear();
        for irradiances in samples {
            let start = self.scratch.len();
            self.scratch.resize(start + groups, Vec4::ZERO);
            for (irradiance, wavelengths) in irradiances {
                self.responses.respond(irradiance, wavelengths, &mut self.scratch[start..]);
            }
            self.counts[pixel] += 1;
        }
        add_values(&mut self.sums[pixel * channels..(pixel + 1) * channels], groups, &self.scratch);
    }
}

impl FilmBand<'_> {
    /// Adds samples to a pixel, of each its values group by group of four channels.
    pub fn add_values(&mut self, pixel: usize, values: &[Vec4]) {
        let (channels, groups) = (self.responses.len(), self.responses.groups());
        add_values(&mut self.sums[pixel * channels..(pixel + 1) * channels], groups, values);
        self.counts[pixel] += (values.len() / groups) as u32;
    }
}

/// Adds values of several samples, group by group, to the sums of the channels: four channels side by side.
fn add_values(sums: &mut [Sums], groups: usize, values: &[Vec4]) {
    for (group, sums) in sums.chunks_mut(4).enumerate() {
        let mut all = [Sums::default(); 4];
        all[..sums.len()].copy_from_slice(sums);
        let (mut sum, mut squares) = (DoubleDoubles::default(), DoubleDoubles::default());
        for (channel, sums) in all.iter().enumerate() {
            sum.set(channel, sums.sum);
            squares.set(channel, sums.squares);
        }
        for four in values.iter().skip(group).step_by(groups) {
            let four = four.to_array();
            let (mut terms, mut squared) = ([0.0; 4], [0.0; 4]);
            for channel in 0..4 {
                terms[channel] = f64::from(four[channel]);
                squared[channel] = terms[channel] * terms[channel];
            }
            sum.add(terms);
            squares.add(squared);
        }
        for (channel, sums) in sums.iter_mut().enumerate() {
            *sums = Sums { sum: sum.get(channel), squares: squares.get(channel) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::math::statistics::Moments;
    use photosite_core::spectrum::WavelengthSampler;

    #[test]
    fn bands_average_and_are_named_by_their_centres() {
        for (edges, name) in [([400.0, 420.0], "410"), ([300.0, 305.0], "302.5"), ([1095.0, 1100.0], "1097.5")] {
            let band = band_response(edges);
            assert_eq!(band.name, name);
            assert!((band.spectrum.integral() - 1.0).abs() < 1e-6, "{name}");
        }
    }

    #[test]
    fn the_mean_is_the_integral_and_the_variance_that_of_the_mean() {
        let response = Spectrum::from_fn(|l| (-((l - 550.0) / 80.0).powi(2)).exp());
        let responses = [Response::new("Y", response.clone())];
        let mut film = Film::new(2, 1, FilmResponses::new(&responses));
        let sampler = WavelengthSampler::new(&Spectrum::constant(1.0));
        let n = 1000;
        for row in &mut film.bands(1) {
            for i in 0..n {
                let w = sampler.sample((i as f32 + 0.5) / n as f32);
                row.add(1, [[(SampledSpectrum::splat(2.0), &w)]]);
            }
        }
        let estimate = film.estimate(["Y", "absent"]);
        assert_eq!(estimate.mean.channels().len(), 1);
        let mean = f64::from(estimate.mean.channels()[0].data[1]);
        // 4000 equally spaced wavelengths over a smooth function.
        assert!((mean / (2.0 * response.integral()) - 1.0).abs() < 1e-4, "{mean}");
        // Independent route: the variance over u of the sum of four values a quarter of the range apart.
        let values: Moments = (0..800)
            .map(|i| {
                (0..4).map(|k| response.eval(300.0 + ((i + 200 * k) % 800) as f32 + 0.5)).map(f64::from).sum::<f64>()
                    * 400.0
            })
            .collect();
        let expected = values.variance() / f64::from(n);
        assert!((f64::from(estimate.variance.channels()[0].data[1]) / expected - 1.0).abs() < 0.01);
        assert_eq!(estimate.mean.channels()[0].data[0], 0.0);
        assert_eq!((film.counts(), film.samples(), film.total()), (&[0, n][..], 0, u64::from(n)));
    }
}
