//! Exposer, from light to images: exposes, reads out, develops, and keeps what the next request is likely to need.

use std::sync::{Arc, Mutex};
use std::time::Instant;

use hyper::StatusCode;
use rayon::ThreadPool;
use serde_json::{Map, Value, json};

use super::answer::Failure;
use super::plane::{Plane, no_plane};
use super::query::{F_NUMBER, Query};
use super::recent::Recent;
use super::sent_image::SentImage;
use super::settings::{of_development, of_exposure};
use super::source::{ImageSource, NumberedLight, OpenFile};
use photosite_core::image::Planes;
use photosite_core::locked::locked;
use photosite_core::{Error, Result};
use photosite_develop::{DevelopSettings, EncodedImage};
use photosite_files::developable::Developable;
use photosite_pipeline::{Light, LightPlane, SensorCard, Shot};
use photosite_raw::RawImage;
use photosite_sensor::{NoiseMap, Stage, presets};

/// Number of images that stay in memory: two that are looked at side by side.
const IMAGES: usize = 2;
/// Number of settings that are kept: of each of these with and without the newest change.
const SETTINGS: usize = 4;

/// Key of results for an input: input, trace, changes to keys.
type OfTrace = (usize, u64, Vec<String>);
/// Key of results for a light: input, light, frame, changes to keys, noise map.
type OfLight = (usize, u64, u32, Vec<String>, Option<NoiseMap>);

/// Exposer that makes images, one at a time, on threads that do nothing else: those that trace may be waiting.
pub(super) struct Exposer {
    threads: ThreadPool,
    kept: Mutex<Kept>,
}

/// Results that the next request is likely to need.
struct Kept {
    /// Card that exposes and develops; `None` for the processor.
    card: Option<Arc<SensorCard>>,
    /// Light with changes to its sensor, which take longest, and with all.
    lights: Recent<OfTrace, Light>,
    develop: Recent<OfTrace, Arc<DevelopSettings>>,
    shots: Recent<OfLight, Arc<Shot>>,
    developed: Recent<(OfLight, Vec<String>), Arc<EncodedImage>>,
    /// Planes of light and of ground truth.
    planes: Recent<(OfLight, Plane), Arc<Planes>>,
    /// Names of the planes that there are; files are looked into once.
    beside: Recent<(usize, u64, u32), Vec<LightPlane>>,
    /// The presets that light tells of.
    sensors: Recent<(usize, u64), Arc<Vec<&'static str>>>,
}

/// Light on the sensor that is asked for, with the settings of its development.
struct Exposable {
    light: Light,
    key: OfLight,
    trace: u64,
    develop: Arc<DevelopSettings>,
    sensors: Arc<Vec<&'static str>>,
    /// Keys for which light has to be traced anew.
    anew: Vec<&'static str>,
}

/// Shot, and the light that it is made of.
struct ExposedShot {
    of: Exposable,
    shot: Arc<Shot>,
}

impl Exposer {
    /// Exposer with as many threads as the rest of the program has.
    pub(super) fn new(card: Option<Arc<SensorCard>>) -> Result<Self> {
        let threads = rayon::ThreadPoolBuilder::new().num_threads(rayon::current_num_threads()).build();
        let threads = threads.map_err(|reason| Error::Resources {
            message: format!("cannot start threads: {reason}"),
            help: Some("lower --threads".into()),
        })?;
        let kept = Kept {
            card,
            lights: Recent::new(SETTINGS),
            develop: Recent::new(SETTINGS),
            shots: Recent::new(IMAGES),
            developed: Recent::new(IMAGES),
            planes: Recent::new(IMAGES),
            beside: Recent::new(SETTINGS),
            sensors: Recent::new(SETTINGS),
        };
        Ok(Self { threads, kept: Mutex::new(kept) })
    }

    /// Bytes of the image that is asked for.
    pub(super) fn image(&self, source: &ImageSource, query: &Query) -> Result<Vec<u8>, Failure> {
        let start = Instant::now();
        let kept = &mut *locked(&self.kept);
        self.threads.install(|| {
            let plane = Plane::parse(&query.plane)?;
            let (image, facts) = match source {
                ImageSource::File(file) => of_file(file, &plane, query)?,
                ImageSource::Light(lit) => {
                    let made = kept.shot(lit, query, plane.map())?;
                    let beside = kept.beside(&made)?;
                    (kept.plane(&made, &plane, query)?, made.facts(beside))
                }
            };
            let (image, place) = query.window.of(image, plane.is_numbered())?;
            let took = json!({ "plane": plane.name(), "seconds": start.elapsed().as_secs_f64() });
            Ok(image.bytes([json!(place), facts, took]))
        })
    }

    /// Noise of light over that of the sensor, at the exposure that is asked for; `null` where it is not known.
    pub(super) fn noise(&self, source: &ImageSource, query: &Query) -> Result<Value, Failure> {
        let kept = &mut *locked(&self.kept);
        self.threads.install(|| match source {
            ImageSource::File(_) => Ok(Value::Null),
            ImageSource::Light(lit) => Ok(json!(kept.exposable(lit, query)?.light.noise_ratio())),
        })
    }

    /// Facts of a pixel of the sensor: electrons, digital numbers, codes of the developed image.
    pub(super) fn pixel(&self, source: &ImageSource, query: &Query, at: [usize; 2]) -> Result<Value, Failure> {
        let kept = &mut *locked(&self.kept);
        self.threads.install(|| {
            let of_image = |image: &SentImage| {
                image.at(at).map(|values| values.into_iter().map(|(name, value)| json!([name, value])).collect())
            };
            let (raw, developed, electrons): (Option<Arc<RawImage>>, _, Vec<Value>) = match source {
                ImageSource::File(file) => {
                    let raw = match file.holds() {
                        Developable::Raw(raw) => Some(Arc::clone(raw)),
                        Developable::Light(_) => None,
                    };
                    (raw, Arc::new(file.develop(&query.develop)?.0), Vec::new())
                }
                ImageSource::Light(lit) => {
                    let made = kept.shot(lit, query, None)?;
                    let electrons = electrons_at(&made.shot, at);
                    let developed = kept.developed(&made, query)?;
                    (Some(Arc::new(made.shot.raw.clone())), developed, electrons)
                }
            };
            let raw = raw.as_deref().and_then(|raw| raw_at(raw, at));
            let developed = SentImage::of_codes(EncodedImage::clone(&developed));
            let developed: Option<Vec<Value>> = of_image(&developed);
            Ok(json!({ "x": at[0], "y": at[1], "electrons": electrons, "raw": raw, "developed": developed }))
        })
    }
}

/// Mean electrons of each channel, and the standard deviation that light transport leaves of them.
fn electrons_at(shot: &Shot, [x, y]: [usize; 2]) -> Vec<Value> {
    let mean = &shot.electrons.mean;
    if x >= mean.width() || y >= mean.height() {
        return Vec::new();
    }
    let pixel = y * mean.width() + x;
    let of_channel = |channel: &photosite_core::image::Channel| {
        let variance = shot.electrons.variance.plane(&channel.name).map(|plane| f64::from(plane[pixel]));
        json!([channel.name, channel.data[pixel], variance.map(f64::sqrt)])
    };
    mean.channels().iter().map(of_channel).collect()
}

/// Digital numbers of a pixel that sees light, each with its channel.
fn raw_at(raw: &RawImage, [x, y]: [usize; 2]) -> Option<Vec<Value>> {
    let area = raw.active();
    if x >= area.width || y >= area.height {
        return None;
    }
    let (column, row) = (area.x + x, area.y + y);
    let numbers = raw.cfa.samples_per_pixel();
    let first = (row * raw.width + column) * numbers;
    let names = raw.cfa.channels();
    let name = |i: usize| if numbers == 1 { &names[raw.cfa.channel_at(column, row)] } else { &names[i] };
    Some((0..numbers).map(|i| json!([name(i), raw.data[first + i]])).collect())
}

/// Plane of a file, with facts about it.
fn of_file(file: &OpenFile, plane: &Plane, query: &Query) -> Result<(SentImage, Value), Failure> {
    if !query.sensor.is_empty()
        || !query.exposure.is_empty()
        || query.f_number.is_some()
        || query.frame.unwrap_or(0) > 0
    {
        let failure = Failure::new(StatusCode::CONFLICT, "a raw file is exposed already");
        return Err(failure.help("change how it is developed, or view the folder of a render with its light"));
    }
    let (image, warnings) = match (plane, file.holds()) {
        (Plane::Developed, _) => {
            let (image, warnings) = file.develop(&query.develop)?;
            (SentImage::of_codes(image), warnings)
        }
        (Plane::Raw, Developable::Raw(raw)) => (SentImage::of_raw(raw), Vec::new()),
        (Plane::Raw, Developable::Light(light)) => (SentImage::of_planes(&light.planes, ""), Vec::new()),
        (Plane::OfLight(of_light), _) => {
            let planes = file.beside().read(of_light, 0)?.ok_or_else(|| no_plane(&plane.name()))?;
            (SentImage::of_planes(&planes, plane.unit()), Vec::new())
        }
        (Plane::Electrons(_) | Plane::Sigma(_) | Plane::Noise(_), _) => return Err(no_plane(&plane.name())),
    };
    let beside = file.beside().planes(0)?.into_iter().map(Plane::OfLight);
    let planes: Vec<String> = [Plane::Developed, Plane::Raw].into_iter().chain(beside).map(|p| p.name()).collect();
    let settings = of_development(&file.settings(&query.develop)?);
    let raw = match file.holds() {
        Developable::Raw(raw) => Some(levels(raw)),
        Developable::Light(_) => None,
    };
    let facts = json!({ "light": 1, "planes": planes, "settings": settings, "raw": raw, "warnings": warnings });
    Ok((image, facts))
}

/// Levels and layout of a raw image for the page.
fn levels(raw: &RawImage) -> Value {
    let area = raw.active();
    let (columns, rows) = raw.cfa.tile_size();
    let names = raw.cfa.channels();
    let tile: Vec<Vec<&str>> =
        (0..rows).map(|y| (0..columns).map(|x| names[raw.cfa.channel_at(x, y)].as_str()).collect()).collect();
    json!({
        "black_dn": raw.black_level_dn.mean(),
        "white_dn": raw.white_level_dn,
        "bits": raw.bits,
        "active": [area.x, area.y, area.width, area.height],
        "tile": if raw.cfa.samples_per_pixel() == 1 { tile } else { Vec::new() },
    })
}

impl ExposedShot {
    /// Facts of an image for the page.
    fn facts(&self, beside: Vec<LightPlane>) -> Value {
        let Exposable { light, develop, sensors, key: (_, number, ..), anew, .. } = &self.of;
        let mut settings: Map<String, Value> = of_exposure(light, &self.shot.exposure);
        settings.extend(of_development(develop));
        let warnings = [light.warnings(), &self.shot.warnings].concat();
        let sensor = light.settings().sensor;
        let stages: Vec<Stage> = Stage::ALL.into_iter().filter(|&stage| sensor.has_stage(stage)).collect();
        json!({
            "light": number,
            "planes": Plane::all(&self.shot, sensor, beside),
            "settings": settings,
            "stages": stages,
            "sensors": **sensors,
            "anew": anew,
            "raw": levels(&self.shot.raw),
            "warnings": warnings,
        })
    }
}

impl Kept {
    /// Light on the sensor that is asked for.
    fn exposable(&mut self, lit: &NumberedLight, query: &Query) -> Result<Exposable, Failure> {
        let &NumberedLight { ref light, number, trace } = lit;
        let newest = &light.clone().on_card(self.card.clone());
        let input = query.input;
        self.lights.retain(|(of, kept, _)| *of != input || *kept == trace);
        self.lights.each(|(of, ..), light| {
            if *of == input {
                *light = light.lit_as(newest);
            }
        });
        self.shots.retain(|(of, kept, ..)| *of != input || *kept == number);
        // Light that was read cannot be traced anew.
        let can_trace = newest.prepared().is_some();
        let needs = |failure: Failure| Failure { needs_trace: can_trace, ..failure };
        let conflict = |message: &str, help: &str| Failure::new(StatusCode::CONFLICT, message).help(help);
        let frame = newest.only_frame().unwrap_or(query.frame.unwrap_or(0));
        if query.frame.is_some_and(|asked| asked != frame) {
            let message = format!("things move, and light is traced for frame {frame}");
            return Err(needs(Failure::new(StatusCode::CONFLICT, message)));
        }
        let sensor = query.sensor_of(newest.settings().sensor.resolution);
        let lens: Vec<String> = query.f_number.iter().map(|n| format!("{F_NUMBER}={n:?}")).collect();
        let all = [&lens[..], &sensor, &query.exposure].concat();
        let through = match query.f_number.map(|f_number| newest.at_f_number(f_number)).transpose()? {
            None => newest.clone(),
            Some(Some(changed)) => changed,
            Some(None) if can_trace => {
                let message = "light takes other paths through this lens at another f-number";
                return Err(needs(conflict(message, "trace again for this f-number")));
            }
            Some(None) => {
                let message = "the light in this folder has already passed the lens";
                return Err(conflict(message, "view the capture, whose light is traced, to change its f-number"));
            }
        };
        let of_sensor = [&lens[..], &sensor].concat();
        let base = self.lights.get_or_make((input, trace, of_sensor), || {
            through.with(&sensor).map_err(|error| needs(Failure::of(error, StatusCode::CONFLICT)))
        })?;
        let light = self.lights.get_or_make((input, trace, all.clone()), || base.with(&query.exposure))?;
        if !light.tells_of(light.settings().sensor) {
            let message = "this sensor responds to light differently from the one that it was traced for";
            let help = "trace again for this sensor, or keep the spectrum, which serves all sensors";
            return Err(needs(conflict(message, help)));
        }
        let develop = self.develop.get_or_make((input, trace, [&all[..], &query.develop].concat()), || {
            Ok::<_, Failure>(Arc::new(light.with(&query.develop)?.settings().develop.clone()))
        })?;
        let sensors = self.sensors.get_or_make((input, trace), || {
            let is_told = |name: &&str| presets::model(name).is_some_and(|sensor| light.tells_of(&sensor));
            Ok::<_, Failure>(Arc::new(presets::names().filter(is_told).collect()))
        })?;
        let anew = if can_trace && !light.f_number_is_open() { vec![F_NUMBER] } else { Vec::new() };
        Ok(Exposable { light, key: (input, number, frame, all, None), trace, develop, sensors, anew })
    }

    /// The shot that is asked for.
    fn shot(&mut self, lit: &NumberedLight, query: &Query, map: Option<NoiseMap>) -> Result<ExposedShot, Failure> {
        let mut of = self.exposable(lit, query)?;
        of.key.4 = map;
        let shot = self.shots.get_or_make(of.key.clone(), || {
            let maps: Vec<NoiseMap> = map.into_iter().collect();
            of.light.frame(of.key.2, &maps).map(Arc::new)
        })?;
        Ok(ExposedShot { of, shot })
    }

    /// The planes of light and ground truth that there are.
    fn beside(&mut self, made: &ExposedShot) -> Result<Vec<LightPlane>, Failure> {
        let Exposable { light, key: (input, _, frame, ..), trace, .. } = &made.of;
        Ok(self.beside.get_or_make((*input, *trace, *frame), || light.planes(*frame))?)
    }

    /// Developed image of a shot.
    fn developed(&mut self, made: &ExposedShot, query: &Query) -> Result<Arc<EncodedImage>, Failure> {
        let Exposable { light, key, develop: settings, .. } = &made.of;
        let key = (key.clone(), query.develop.clone());
        let developed = self.developed.get_or_make(key, || light.develop(&made.shot.raw, settings).map(Arc::new));
        developed.map_err(Failure::from)
    }

    fn plane(&mut self, made: &ExposedShot, plane: &Plane, query: &Query) -> Result<SentImage, Failure> {
        match plane {
            Plane::Developed => Ok(SentImage::of_codes(EncodedImage::clone(&*self.developed(made, query)?))),
            Plane::OfLight(of_light) => {
                let Exposable { light, key, trace, .. } = &made.of;
                let of = match of_light {
                    LightPlane::Truth(_) => (key.0, *trace, key.2, Vec::new(), None),
                    LightPlane::Irradiance(_) | LightPlane::Ideal => key.clone(),
                };
                let planes = self.planes.get_or_make((of, plane.clone()), || {
                    let found = light.plane(of_light, key.2, &made.shot.exposure).map_err(Failure::from)?;
                    found.map(Arc::new).ok_or_else(|| no_plane(&plane.name()))
                })?;
                Ok(SentImage::of_planes(&planes, plane.unit()))
            }
            Plane::Raw | Plane::Electrons(_) | Plane::Sigma(_) | Plane::Noise(_) => plane.of_shot(&made.shot),
        }
    }
}
