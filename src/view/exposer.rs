//! From light to pictures: exposes, reads out, develops, and keeps what the next request is likely to need.

use std::sync::{Arc, Mutex};
use std::time::Instant;

use hyper::StatusCode;
use serde_json::json;

use super::answer::Failure;
use super::picture::Picture;
use super::query::Query;
use super::source::{Lit, Source};
use crate::develop::{EncodedPicture, develop};
use crate::locked::locked;
use crate::pipeline::{Prepared, Shot};
use crate::{Error, Result};

/// Exposures and sensors that are kept: two pictures may be looked at side by side.
const KEPT: usize = 4;

/// The most recently used of few values, by their keys.
struct Recent<K, V> {
    values: Vec<(K, V)>,
}

impl<K: PartialEq, V: Clone> Recent<K, V> {
    const fn new() -> Self {
        Self { values: Vec::new() }
    }

    /// The value of a key, made where it is not kept.
    fn get_or_make<E>(&mut self, key: K, make: impl FnOnce() -> Result<V, E>) -> Result<V, E> {
        let value = match self.values.iter().position(|(known, _)| *known == key) {
            Some(place) => self.values.remove(place).1,
            None => make()?,
        };
        self.values.truncate(KEPT - 1);
        self.values.insert(0, (key, value.clone()));
        Ok(value)
    }
}

/// What a sensor is made ready of: the number of the trace, and changes to keys.
type OfTrace = (usize, u64, Vec<String>);
/// What a shot is made of: the number of the light, the frame, and changes to keys.
type OfLight = (usize, u64, u32, Vec<String>);

/// Makes pictures, one at a time.
pub(super) struct Exposer {
    kept: Mutex<Kept>,
}

struct Kept {
    prepared: Recent<OfTrace, Arc<Prepared>>,
    shots: Recent<OfLight, Arc<Shot>>,
}

impl Exposer {
    pub(super) fn new() -> Self {
        Self { kept: Mutex::new(Kept { prepared: Recent::new(), shots: Recent::new() }) }
    }

    /// The bytes of the picture that is asked for.
    pub(super) fn picture(&self, source: &Source, query: &Query) -> Result<Vec<u8>, Failure> {
        let start = Instant::now();
        let kept = &mut *locked(&self.kept);
        match source {
            Source::Traced(lit) => {
                let prepared = kept.prepared(lit, query)?;
                let changes = [&query.sensor[..], &query.exposure].concat();
                let key = (query.input, lit.number, query.frame, changes);
                let shot = kept.shots.get_or_make(key, || prepared.expose(&lit.light, query.frame).map(Arc::new))?;
                let picture = of_shot(&shot, query, |shot| {
                    let develop_settings = &prepared.capture().develop;
                    let source = &prepared.capture().source;
                    develop(&shot.raw, develop_settings).map_err(|invalid| source.error(invalid.within("develop")))
                })?;
                let exposure = &shot.exposure;
                Ok(picture.bytes(json!({
                    "plane": query.plane,
                    "light": lit.number,
                    "exposure": {
                        "time_s": exposure.time.0,
                        "gain_db": exposure.gain.0,
                        "digital_gain_db": exposure.digital_gain.0,
                        "temperature_c": exposure.temperature.0,
                    },
                    "warnings": shot.warnings,
                    "seconds": start.elapsed().as_secs_f64(),
                })))
            }
            Source::Stored(_) | Source::File(_) => {
                Err(Failure::new(StatusCode::NOT_IMPLEMENTED, "files cannot be viewed yet"))
            }
        }
    }
}

impl Kept {
    /// A capture with the changes of a query.
    fn prepared(&mut self, lit: &Lit, query: &Query) -> Result<Arc<Prepared>, Failure> {
        let changed = |base: &Prepared, changes: &[String]| base.for_light(&lit.light, changes).map(Arc::new);
        let key = |changes| (query.input, lit.trace, changes);
        let sensor = self
            .prepared
            .get_or_make(key(query.sensor.clone()), || changed(&lit.prepared, &query.sensor))
            .map_err(|error| Failure::from(error).needing_trace())?;
        let rest = [&query.exposure[..], &query.develop].concat();
        let all = [&query.sensor[..], &rest].concat();
        self.prepared.get_or_make(key(all), || changed(&sensor, &rest)).map_err(Failure::from)
    }
}

/// A plane of a shot.
fn of_shot(
    shot: &Shot,
    query: &Query,
    develop: impl FnOnce(&Shot) -> Result<EncodedPicture, Error>,
) -> Result<Picture, Failure> {
    let electrons = &shot.electrons;
    let size = [electrons.mean.width(), electrons.mean.height()];
    match query.plane.split_once(':') {
        None if query.plane == "developed" => Ok(Picture::of_codes(develop(shot)?)),
        None if query.plane == "raw" => Ok(Picture::of_raw(&shot.raw)),
        Some(("electrons", name)) => {
            let channel = electrons.mean.channels().iter().find(|channel| channel.name == name);
            channel.map(|channel| Picture::of_plane(size, channel, "e⁻")).ok_or_else(|| no_plane(&query.plane))
        }
        Some(_) | None => Err(no_plane(&query.plane)),
    }
}

fn no_plane(name: &str) -> Failure {
    Failure::new(StatusCode::NOT_FOUND, format!("there is no plane {name:?}"))
}
