//! Store of the point spreads of lenses from prescriptions, kept from camera to camera and, where a program has a shelf
//! for them, from run to run.
//!
//! A node of a [`WaveSpread`] takes tens of milliseconds to work out, and an image needs a thousand of them. Frames of
//! a data set and moves of a view share those in memory.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use photosite_lens::wave::WaveSpread;

pub use photosite_lens::wave::Shelf;

/// Number of lenses whose point spreads stay in memory, the last used ones: some hundred MB each.
const IN_MEMORY: usize = 2;

/// Function that gives the shelf of a key; `None` where there is none.
pub type ShelfOf = Box<dyn Fn(&str) -> Option<Arc<dyn Shelf>> + Send + Sync>;

static SHELVES: OnceLock<ShelfOf> = OnceLock::new();
static RECENT: Mutex<Vec<(String, Arc<WaveSpread>)>> = Mutex::new(Vec::new());

/// Keeps point spreads of lenses on shelves from now on; the first call counts. Until then they are kept in memory
/// alone.
pub fn keep_point_spreads(shelves: ShelfOf) {
    // A second call is of the same program.
    let _ = SHELVES.set(shelves);
}

/// Returns the point spread that is known already, or this one.
pub(super) fn known(wave: WaveSpread) -> Arc<WaveSpread> {
    let key = wave.key();
    let mut recent = RECENT.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(place) = recent.iter().position(|(known, _)| *known == key) {
        let found = recent.remove(place);
        recent.push(found.clone());
        return found.1;
    }
    let wave = Arc::new(match SHELVES.get().and_then(|shelves| shelves(&key)) {
        Some(shelf) => wave.with_shelf(shelf),
        None => wave,
    });
    if recent.len() == IN_MEMORY {
        recent.remove(0);
    }
    recent.push((key, wave.clone()));
    wave
}
