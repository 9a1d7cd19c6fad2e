//! Cards that this process has open: whoever asks for one again gets it with the kernels that it has compiled.

use std::sync::{Arc, Mutex};

use crate::adapters::{Card, open};

/// Open cards of a process by their numbers.
type OpenCards = Vec<(usize, Arc<Card>)>;

/// Open cards, and the process that has opened them. Nobody waits for them: in a forked child they may be locked for
/// ever, by a thread of its parent.
static OPEN: Mutex<Option<(u32, OpenCards)>> = Mutex::new(None);

/// Card of that number, opened for this process unless it is open and works.
///
/// # Errors
///
/// Words on why it cannot be used.
pub fn shared(number: usize) -> Result<Arc<Card>, String> {
    if let Some(card) = kept(number) {
        return Ok(card);
    }
    let card = Arc::new(open(number)?);
    keep(number, &card);
    Ok(card)
}

/// Card of that number that this process has open, if its driver has found no fault.
fn kept(number: usize) -> Option<Arc<Card>> {
    let mut open = OPEN.try_lock().ok()?;
    if let Some((_, of_parent)) = open.take_if(|(owner, _)| *owner != std::process::id()) {
        // Closing them would wait for threads of drivers that are not in this process.
        std::mem::forget(of_parent);
    }
    let (_, cards) = open.as_mut()?;
    cards.retain(|(_, card)| card.works());
    cards.iter().find(|(of, _)| *of == number).map(|(_, card)| Arc::clone(card))
}

fn keep(number: usize, card: &Arc<Card>) {
    let Ok(mut open) = OPEN.try_lock() else { return };
    let (owner, cards) = open.get_or_insert_with(|| (std::process::id(), Vec::new()));
    if *owner == std::process::id() {
        cards.push((number, Arc::clone(card)));
    }
}
