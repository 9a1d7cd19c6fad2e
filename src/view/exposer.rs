//! From light to pictures: exposes, reads out, develops, and keeps what the next request is likely to need.

use std::sync::{Arc, Mutex};
use std::time::Instant;

use hyper::StatusCode;
use rayon::ThreadPool;
use serde_json::{Map, Value, json};

use super::answer::Failure;
use super::picture::Picture;
use super::plane::{Plane, no_plane, unit_of};
use super::query::Query;
use super::recent::Recent;
use super::settings::{of_development, of_exposure};
use super::source::{OpenFile, Ready, Source};
use crate::calibration::truth::TruthLayer;
use crate::develop::{DevelopSettings, EncodedPicture};
use crate::image::Planes;
use crate::io::developable::Developable;
use crate::locked::locked;
use crate::pipeline::{Prepared, Shot, StoredRender};
use crate::raw::RawImage;
use crate::sensor::{NoiseMap, presets};
use crate::{Error, Result};

/// What is made of an input in a trace, by changes to keys.
type OfTrace = (usize, u64, Vec<String>);
/// What is made of a light: a frame, by changes to keys, with a noise map.
type OfLight = (usize, u64, u32, Vec<String>, Option<NoiseMap>);

/// Makes pictures, one at a time, on threads that do nothing else: those that trace may be waiting.
pub(super) struct Exposer {
    threads: ThreadPool,
    kept: Mutex<Kept>,
}

/// What the next request is likely to need.
struct Kept {
    /// A capture whose sensor is changed, which takes longest.
    prepared: Recent<OfTrace, Arc<Prepared>>,
    stored: Recent<OfTrace, Arc<StoredRender>>,
    ready: Recent<(usize, u64, Vec<String>), Ready>,
    develop: Recent<OfTrace, Arc<DevelopSettings>>,
    shots: Recent<OfLight, Arc<Shot>>,
    developed: Recent<(OfLight, Vec<String>), Arc<EncodedPicture>>,
    truth: Recent<(usize, u64, TruthLayer), Arc<Planes>>,
    /// The presets that light tells of.
    sensors: Recent<(usize, u64), Arc<Vec<&'static str>>>,
}

/// A shot, and what it is made of.
struct Made {
    ready: Ready,
    shot: Arc<Shot>,
    key: OfLight,
    trace: u64,
    develop: Arc<DevelopSettings>,
    sensors: Arc<Vec<&'static str>>,
}

impl Exposer {
    /// With as many threads as others have.
    pub(super) fn new() -> Result<Self> {
        let threads = rayon::ThreadPoolBuilder::new().num_threads(rayon::current_num_threads()).build();
        let threads = threads.map_err(|reason| Error::Resources {
            message: format!("cannot start threads: {reason}"),
            help: Some("lower --threads".into()),
        })?;
        let kept = Kept {
            prepared: Recent::new(),
            stored: Recent::new(),
            ready: Recent::new(),
            develop: Recent::new(),
            shots: Recent::new(),
            developed: Recent::new(),
            truth: Recent::new(),
            sensors: Recent::new(),
        };
        Ok(Self { threads, kept: Mutex::new(kept) })
    }

    /// The bytes of the picture that is asked for.
    pub(super) fn picture(&self, source: &Source, query: &Query) -> Result<Vec<u8>, Failure> {
        let start = Instant::now();
        let kept = &mut *locked(&self.kept);
        self.threads.install(|| {
            let plane = Plane::parse(&query.plane)?;
            let (picture, facts) = match source {
                Source::File(file) => of_file(file, &plane, query)?,
                Source::Traced(_) | Source::Stored(_) => {
                    let made = kept.shot(source, query, plane.map())?;
                    (kept.plane(&made, &plane, query)?, made.facts())
                }
            };
            let took = json!({ "plane": plane.name(), "seconds": start.elapsed().as_secs_f64() });
            Ok(picture.bytes([facts, took]))
        })
    }

    /// What is known of a pixel of the sensor: electrons, digital numbers, codes of the developed picture.
    pub(super) fn pixel(&self, source: &Source, query: &Query, at: [usize; 2]) -> Result<Value, Failure> {
        let kept = &mut *locked(&self.kept);
        self.threads.install(|| {
            let of_picture = |picture: &Picture| {
                picture.at(at).map(|values| values.into_iter().map(|(name, value)| json!([name, value])).collect())
            };
            let (raw, developed, electrons): (Option<Arc<RawImage>>, _, Vec<Value>) = match source {
                Source::File(file) => {
                    let raw = match file.holds() {
                        Developable::Raw(raw) => Some(Arc::clone(raw)),
                        Developable::Light(_) => None,
                    };
                    (raw, Arc::new(file.develop(&query.develop)?.0), Vec::new())
                }
                Source::Traced(_) | Source::Stored(_) => {
                    let made = kept.shot(source, query, None)?;
                    let electrons = electrons_at(&made.shot, at);
                    let developed = kept.developed(&made, query)?;
                    (Some(Arc::new(made.shot.raw.clone())), developed, electrons)
                }
            };
            let raw = raw.as_deref().and_then(|raw| raw_at(raw, at));
            let developed = Picture::of_codes(EncodedPicture::clone(&developed));
            let developed: Option<Vec<Value>> = of_picture(&developed);
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
    let of_channel = |channel: &crate::image::Channel| {
        let variance = shot.electrons.variance.plane(&channel.name).map(|plane| f64::from(plane[pixel]));
        json!([channel.name, channel.data[pixel], variance.map(f64::sqrt)])
    };
    mean.channels().iter().map(of_channel).collect()
}

/// Digital numbers of a pixel that sees light, each with the channel that it is of.
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

/// A plane of a file, and what is to be said of it.
fn of_file(file: &OpenFile, plane: &Plane, query: &Query) -> Result<(Picture, Value), Failure> {
    if !query.sensor.is_empty() || !query.exposure.is_empty() || query.frame > 0 {
        let failure = Failure::new(StatusCode::CONFLICT, "a raw file is exposed already");
        return Err(failure.help("change how it is developed, or view the folder of a render with its light"));
    }
    let (picture, warnings) = match (plane, file.holds()) {
        (Plane::Developed, _) => {
            let (picture, warnings) = file.develop(&query.develop)?;
            (Picture::of_codes(picture), warnings)
        }
        (Plane::Raw, Developable::Raw(raw)) => (Picture::of_raw(raw), Vec::new()),
        (Plane::Raw, Developable::Light(light)) => (Picture::of_planes(&light.planes, ""), Vec::new()),
        (
            Plane::Electrons(_)
            | Plane::Sigma(_)
            | Plane::Noise(_)
            | Plane::Irradiance(_)
            | Plane::Ideal
            | Plane::Truth(_),
            _,
        ) => return Err(no_plane(&plane.name())),
    };
    let settings = of_development(&file.settings(&query.develop)?);
    let raw = match file.holds() {
        Developable::Raw(raw) => Some(levels(raw)),
        Developable::Light(_) => None,
    };
    let facts =
        json!({ "light": 1, "planes": ["developed", "raw"], "settings": settings, "raw": raw, "warnings": warnings });
    Ok((picture, facts))
}

/// What the page shows of digital numbers.
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

impl Made {
    /// What is said of a picture.
    fn facts(&self) -> Value {
        let mut settings: Map<String, Value> = of_exposure(&self.ready, &self.shot.exposure);
        settings.extend(of_development(&self.develop));
        let warnings = [self.ready.warnings(), &self.shot.warnings].concat();
        json!({
            "light": self.key.1,
            "planes": Plane::all(&self.ready, &self.shot),
            "settings": settings,
            "sensors": *self.sensors,
            "raw": levels(&self.shot.raw),
            "warnings": warnings,
        })
    }
}

impl Kept {
    /// The shot that is asked for.
    fn shot(&mut self, source: &Source, query: &Query, map: Option<NoiseMap>) -> Result<Made, Failure> {
        let resolution = match source {
            Source::Traced(lit) => lit.prepared.resolution().map(|n| n as usize),
            Source::Stored(render) => render.sensor().resolution,
            Source::File(_) => return Err(no_plane(&query.plane)),
        };
        // Another sensor has the pixels that light was traced for.
        let pixels = (!query.sensor.is_empty()).then(|| format!("sensor.resolution_px={resolution:?}"));
        let sensor: Vec<String> = query.sensor.iter().cloned().chain(pixels).collect();
        let all = [&sensor[..], &query.exposure].concat();
        let input = query.input;
        let anew = |error: Error| Failure { needs_trace: true, ..Failure::of(error, StatusCode::CONFLICT) };
        let (ready, light, trace) = match source {
            Source::Traced(lit) => {
                let (trace, light) = (lit.trace, &lit.light);
                self.prepared.retain(|(of, number, _)| *of != input || *number == trace);
                self.shots.retain(|(of, number, ..)| *of != input || *number == lit.number);
                let changed = |base: &Prepared, changes: &[String]| base.for_light(light, changes).map(Arc::new);
                let base = self
                    .prepared
                    .get_or_make((input, trace, sensor.clone()), || changed(&lit.prepared, &sensor).map_err(anew))?;
                let prepared = self.prepared.get_or_make((input, trace, all.clone()), || {
                    changed(&base, &query.exposure).map_err(Failure::from)
                })?;
                if !light.tells_of(&prepared.capture().sensor) {
                    let message = "this sensor sees light in another way than the one that it was traced for";
                    let failure = Failure { needs_trace: true, ..Failure::new(StatusCode::CONFLICT, message) };
                    return Err(failure.help("trace again for this sensor, or keep the spectrum, which serves all"));
                }
                (Ready::Traced(prepared, Arc::clone(light)), lit.number, trace)
            }
            Source::Stored(render) => {
                let base = self.stored.get_or_make((input, 1, sensor.clone()), || {
                    let changed =
                        if sensor.is_empty() { Ok(StoredRender::clone(render)) } else { render.with(&sensor) };
                    changed.map(Arc::new).map_err(|error| Failure::of(error, StatusCode::CONFLICT))
                })?;
                let ready = self.ready.get_or_make((input, 1, all.clone()), || {
                    let changed = match query.exposure.is_empty() {
                        true => Arc::clone(&base),
                        false => Arc::new(base.with(&query.exposure)?),
                    };
                    let exposed = StoredRender::clone(&changed).expose()?;
                    Ok::<_, Failure>(Ready::Stored(Arc::new(exposed), changed))
                })?;
                (ready, 1, 1)
            }
            Source::File(_) => return Err(no_plane(&query.plane)),
        };
        if query.frame > 0 && ready.has_first_frame_alone() {
            let failure =
                Failure::new(StatusCode::CONFLICT, "things move, and the light of the first frame is traced alone");
            return Err(failure.help("photosite render takes all frames"));
        }
        let develop = self.develop.get_or_make((input, trace, [&all[..], &query.develop].concat()), || {
            ready.develop_settings(&query.develop).map(Arc::new)
        })?;
        let sensors = self.sensors.get_or_make((input, trace), || {
            let is_told = |name: &&str| presets::model(name).is_some_and(|sensor| ready.tells_of(&sensor));
            Ok::<_, Failure>(Arc::new(presets::names().filter(is_told).collect()))
        })?;
        let key = (input, light, query.frame, all, map);
        let shot = self.shots.get_or_make(key.clone(), || {
            let maps: Vec<NoiseMap> = map.into_iter().collect();
            ready.expose(query.frame, &maps).map(Arc::new)
        })?;
        Ok(Made { ready, shot, key, trace, develop, sensors })
    }

    /// It, developed.
    fn developed(&mut self, made: &Made, query: &Query) -> Result<Arc<EncodedPicture>, Failure> {
        let key = (made.key.clone(), query.develop.clone());
        let developed = self.developed.get_or_make(key, || made.ready.develop(&made.shot, &made.develop).map(Arc::new));
        developed.map_err(Failure::from)
    }

    fn plane(&mut self, made: &Made, plane: &Plane, query: &Query) -> Result<Picture, Failure> {
        match plane {
            Plane::Developed => Ok(Picture::of_codes(EncodedPicture::clone(&*self.developed(made, query)?))),
            Plane::Truth(layer) => {
                let key = (made.key.0, made.trace, *layer);
                let planes = self.truth.get_or_make(key, || {
                    let found = made.ready.truth(*layer).map_err(Failure::from)?;
                    found.map(Arc::new).ok_or_else(|| no_plane(&plane.name()))
                })?;
                Ok(Picture::of_planes(&planes, unit_of(*layer)))
            }
            Plane::Raw
            | Plane::Electrons(_)
            | Plane::Sigma(_)
            | Plane::Noise(_)
            | Plane::Irradiance(_)
            | Plane::Ideal => plane.of_shot(&made.ready, &made.shot),
        }
    }
}
