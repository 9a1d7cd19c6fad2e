//! From light to pictures: exposes, reads out, develops, and keeps what the next request is likely to need.

use std::sync::{Arc, Mutex};
use std::time::Instant;

use hyper::StatusCode;
use rayon::ThreadPool;
use serde_json::{Map, Value, json};

use super::answer::Failure;
use super::picture::Picture;
use super::plane::{Plane, no_plane};
use super::query::{F_NUMBER, Query};
use super::recent::Recent;
use super::settings::{of_development, of_exposure};
use super::source::{Lit, OpenFile, Ready, Source};
use crate::develop::{DevelopSettings, EncodedPicture};
use crate::image::Planes;
use crate::io::developable::Developable;
use crate::locked::locked;
use crate::pipeline::{Light, Prepared, Shot, StoredRender};
use crate::raw::RawImage;
use crate::sensor::{NoiseMap, Stage, presets};
use crate::{Error, Result};

/// Pictures that stay in memory: two that are looked at side by side.
const PICTURES: usize = 2;
/// Settings that are kept: of each of these with and without the newest change.
const SETTINGS: usize = 4;

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
    /// Planes of light and of ground truth.
    planes: Recent<(OfLight, Plane), Arc<Planes>>,
    /// The names of those that a folder holds.
    beside: Recent<(usize, u32), Vec<Plane>>,
    /// Light through another opening.
    levels: Recent<(usize, u64, u64), Arc<Light>>,
    /// The presets that light tells of.
    sensors: Recent<(usize, u64), Arc<Vec<&'static str>>>,
}

/// A sensor that light falls on, and how its pictures are developed.
struct Exposable {
    ready: Ready,
    key: OfLight,
    trace: u64,
    develop: Arc<DevelopSettings>,
    sensors: Arc<Vec<&'static str>>,
    /// Keys for which light has to be traced anew.
    anew: Vec<&'static str>,
}

/// A shot, and what it is made of.
struct Made {
    of: Exposable,
    shot: Arc<Shot>,
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
            prepared: Recent::new(SETTINGS),
            stored: Recent::new(SETTINGS),
            ready: Recent::new(PICTURES),
            develop: Recent::new(SETTINGS),
            shots: Recent::new(PICTURES),
            developed: Recent::new(PICTURES),
            planes: Recent::new(PICTURES),
            beside: Recent::new(SETTINGS),
            levels: Recent::new(PICTURES),
            sensors: Recent::new(SETTINGS),
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
                Source::Traced(_) | Source::Stored(..) => {
                    let made = kept.shot(source, query, plane.map())?;
                    let beside = kept.beside(&made)?;
                    (kept.plane(&made, &plane, query)?, made.facts(beside))
                }
            };
            let (picture, place) = query.window.of(picture, plane.is_numbered())?;
            let took = json!({ "plane": plane.name(), "seconds": start.elapsed().as_secs_f64() });
            Ok(picture.bytes([json!(place), facts, took]))
        })
    }

    /// Noise of light over that of the sensor, at the exposure that is asked for; `null` where it is not known.
    pub(super) fn noise(&self, source: &Source, query: &Query) -> Result<Value, Failure> {
        let kept = &mut *locked(&self.kept);
        self.threads.install(|| match source {
            Source::File(_) => Ok(Value::Null),
            Source::Traced(_) | Source::Stored(..) => Ok(json!(kept.ready(source, query)?.ready.noise_ratio())),
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
                Source::Traced(_) | Source::Stored(..) => {
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
    if !query.sensor.is_empty()
        || !query.exposure.is_empty()
        || query.f_number.is_some()
        || query.frame.unwrap_or(0) > 0
    {
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
        (Plane::Irradiance(_) | Plane::Ideal | Plane::Truth(_), _) => {
            let planes = file.beside().read(plane, 0)?.ok_or_else(|| no_plane(&plane.name()))?;
            (Picture::of_planes(&planes, plane.unit()), Vec::new())
        }
        (Plane::Electrons(_) | Plane::Sigma(_) | Plane::Noise(_), _) => return Err(no_plane(&plane.name())),
    };
    let beside = file.beside().planes(0)?.into_iter();
    let planes: Vec<String> = [Plane::Developed, Plane::Raw].into_iter().chain(beside).map(|p| p.name()).collect();
    let settings = of_development(&file.settings(&query.develop)?);
    let raw = match file.holds() {
        Developable::Raw(raw) => Some(levels(raw)),
        Developable::Light(_) => None,
    };
    let facts = json!({ "light": 1, "planes": planes, "settings": settings, "raw": raw, "warnings": warnings });
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
    fn facts(&self, beside: Vec<Plane>) -> Value {
        let Exposable { ready, develop, sensors, key: (_, light, ..), anew, .. } = &self.of;
        let mut settings: Map<String, Value> = of_exposure(ready, &self.shot.exposure);
        settings.extend(of_development(develop));
        let warnings = [ready.warnings(), &self.shot.warnings].concat();
        let (sensor, ..) = ready.settings();
        let stages: Vec<Stage> = Stage::ALL.into_iter().filter(|&stage| sensor.has_stage(stage)).collect();
        json!({
            "light": light,
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
    /// The sensor that is asked for, ready to be read out.
    fn ready(&mut self, source: &Source, query: &Query) -> Result<Exposable, Failure> {
        let resolution = match source {
            Source::Traced(lit) => lit.prepared.resolution().map(|n| n as usize),
            Source::Stored(render, _) => render.sensor().resolution,
            Source::File(_) => return Err(no_plane(&query.plane)),
        };
        let sensor = query.sensor_of(resolution);
        let lens: Vec<String> = query.f_number.iter().map(|n| format!("{F_NUMBER}={n:?}")).collect();
        let all = [&lens[..], &sensor, &query.exposure].concat();
        let input = query.input;
        let needs = |failure: Failure| Failure { needs_trace: true, ..failure };
        let anew = |error: Error| needs(Failure::of(error, StatusCode::CONFLICT));
        let mut frame = query.frame.unwrap_or(0);
        let mut keys_anew = Vec::new();
        let (ready, light, trace) = match source {
            Source::Traced(lit) => {
                let trace = lit.trace;
                self.prepared.retain(|(of, number, _)| *of != input || *number == trace);
                self.shots.retain(|(of, number, ..)| *of != input || *number == lit.number);
                if lit.prepared.capture().recording.is_some() {
                    frame = lit.prepared.frame();
                    if query.frame.is_some_and(|asked| asked != frame) {
                        let message = format!("things move, and light is traced for frame {frame}");
                        return Err(needs(Failure::new(StatusCode::CONFLICT, message)));
                    }
                }
                if !lit.prepared.is_f_number_open() {
                    keys_anew.push(F_NUMBER);
                }
                let (prepared, light) = self.through(input, lit, query.f_number)?;
                let changed = |base: &Prepared, changes: &[String]| base.for_light(&light, changes).map(Arc::new);
                let of_sensor = [&lens[..], &sensor].concat();
                let base = self
                    .prepared
                    .get_or_make((input, trace, of_sensor), || changed(&prepared, &sensor).map_err(anew))?;
                let prepared = self.prepared.get_or_make((input, trace, all.clone()), || {
                    changed(&base, &query.exposure).map_err(Failure::from)
                })?;
                if !light.tells_of(&prepared.capture().sensor) {
                    let message = "this sensor responds to light differently from the one that it was traced for";
                    let failure = needs(Failure::new(StatusCode::CONFLICT, message));
                    return Err(
                        failure.help("trace again for this sensor, or keep the spectrum, which serves all sensors")
                    );
                }
                (Ready::Traced(prepared, light), lit.number, trace)
            }
            Source::Stored(render, beside) => {
                if query.f_number.is_some() {
                    let failure =
                        Failure::new(StatusCode::CONFLICT, "the light in this folder has already passed the lens");
                    return Err(failure.help("view the capture, whose light is traced, to change its f-number"));
                }
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
                    Ok::<_, Failure>(Ready::Stored(Arc::new(exposed), changed, beside.clone()))
                })?;
                (ready, 1, 1)
            }
            Source::File(_) => return Err(no_plane(&query.plane)),
        };
        let develop = self.develop.get_or_make((input, trace, [&all[..], &query.develop].concat()), || {
            ready.develop_settings(&query.develop).map(Arc::new)
        })?;
        let sensors = self.sensors.get_or_make((input, trace), || {
            let is_told = |name: &&str| presets::model(name).is_some_and(|sensor| ready.tells_of(&sensor));
            Ok::<_, Failure>(Arc::new(presets::names().filter(is_told).collect()))
        })?;
        Ok(Exposable { ready, key: (input, light, frame, all, None), trace, develop, sensors, anew: keys_anew })
    }

    /// A scene and its light at that f-number.
    fn through(
        &mut self,
        input: usize,
        lit: &Lit,
        f_number: Option<f64>,
    ) -> Result<(Arc<Prepared>, Arc<Light>), Failure> {
        let Some(f_number) = f_number else { return Ok((Arc::clone(&lit.prepared), Arc::clone(&lit.light))) };
        let key = (input, lit.trace, vec![format!("{F_NUMBER} {f_number}")]);
        let prepared = self.prepared.get_or_make(key, || {
            let prepared = lit.prepared.at_f_number(f_number)?;
            prepared.map(Arc::new).ok_or_else(|| {
                let message = "light takes other paths through this lens at another f-number";
                let failure = Failure::new(StatusCode::CONFLICT, message).help("trace again for this f-number");
                Failure { needs_trace: true, ..failure }
            })
        })?;
        let key = (input, lit.number, f_number.to_bits());
        let light = self.levels.get_or_make(key, || Ok::<_, Failure>(prepared.at_level(&lit.light)))?;
        Ok((prepared, light))
    }

    /// The shot that is asked for.
    fn shot(&mut self, source: &Source, query: &Query, map: Option<NoiseMap>) -> Result<Made, Failure> {
        let mut of = self.ready(source, query)?;
        of.key.4 = map;
        let shot = self.shots.get_or_make(of.key.clone(), || {
            let maps: Vec<NoiseMap> = map.into_iter().collect();
            of.ready.expose(of.key.2, &maps).map(Arc::new)
        })?;
        Ok(Made { of, shot })
    }

    /// The planes of light and ground truth that there are.
    fn beside(&mut self, made: &Made) -> Result<Vec<Plane>, Failure> {
        let (input, _, frame, ..) = made.of.key;
        match &made.of.ready {
            Ready::Traced(..) => Ok(made.of.ready.planes(frame)?),
            // Files are looked into once.
            Ready::Stored(..) => Ok(self.beside.get_or_make((input, frame), || made.of.ready.planes(frame))?),
        }
    }

    /// It, developed.
    fn developed(&mut self, made: &Made, query: &Query) -> Result<Arc<EncodedPicture>, Failure> {
        let Exposable { ready, key, develop, .. } = &made.of;
        let key = (key.clone(), query.develop.clone());
        let developed = self.developed.get_or_make(key, || ready.develop(&made.shot, develop).map(Arc::new));
        developed.map_err(Failure::from)
    }

    fn plane(&mut self, made: &Made, plane: &Plane, query: &Query) -> Result<Picture, Failure> {
        match plane {
            Plane::Developed => Ok(Picture::of_codes(EncodedPicture::clone(&*self.developed(made, query)?))),
            Plane::Truth(_) | Plane::Irradiance(_) | Plane::Ideal => {
                let Exposable { ready, key, trace, .. } = &made.of;
                let is_fixed = matches!((ready, plane), (Ready::Stored(..), _) | (_, Plane::Truth(_)));
                let of = if is_fixed { (key.0, *trace, key.2, Vec::new(), None) } else { key.clone() };
                let planes = self.planes.get_or_make((of, plane.clone()), || {
                    let found = ready.plane(plane, key.2, &made.shot.exposure).map_err(Failure::from)?;
                    found.map(Arc::new).ok_or_else(|| no_plane(&plane.name()))
                })?;
                Ok(Picture::of_planes(&planes, plane.unit()))
            }
            Plane::Raw | Plane::Electrons(_) | Plane::Sigma(_) | Plane::Noise(_) => plane.of_shot(&made.shot),
        }
    }
}
